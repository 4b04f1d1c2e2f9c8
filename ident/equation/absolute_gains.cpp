#include "ident/equation/absolute_gains.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "dsp/sensors/sensor_consistency.hpp"

namespace ident {
namespace {

using dsp::Body;
using Eigen::VectorXd;

constexpr std::array quantities{"displacements", "velocities", "accelerations"};  // by order

/// By a channel of its own, or of the payload where its motion is that relative to the base.
bool is_measured(const dsp::Prepared& prepared, const dsp::SignalInfo& info) {
  const auto has_channel = [&](Body body) {
    return prepared.channel(dsp::motion_signal(body, info.order).role) != nullptr;
  };
  if (!has_channel(info.body) && !(info.body == Body::relative && has_channel(Body::payload))) return false;
  const dsp::Motion& motion = prepared.intermediate.num_samples() > 0 ? prepared.intermediate : prepared.signals;
  const dsp::Signal* signal = motion.find(info.name);
  return signal != nullptr && std::isinf(signal->flat_to_hz);
}

/// Whether displacement and accelerometer of a body, or of the payload where its motion is a difference, have one
/// scale.
bool agrees(const dsp::Prepared& prepared, const dsp::SignalInfo& info) {
  if (!prepared.equalised() || (info.body == Body::relative && prepared.channel(info.role) != nullptr)) return false;
  const char* body = info.body == Body::base ? "r " : "y ";
  return std::any_of(prepared.relations.begin(), prepared.relations.end(), [&](const dsp::SensorRelation& relation) {
    return relation.name.starts_with(body) && dsp::can_be_corrected(relation) && dsp::gain_is_plausible(relation);
  });
}

/// The order of the quantity whose calibration a signal of motion rests on: that of the nearest one below, which it is
/// a derivative of, else above, whose integral it is.
int scaled_by(const dsp::Prepared& prepared, const dsp::SignalInfo& info) {
  const auto measured = [&](int order) { return is_measured(prepared, dsp::motion_signal(info.body, order)); };
  int order = info.order;
  while (order > 0 && !measured(order)) --order;
  int above = order;
  while (above < 2 && !measured(above)) ++above;
  if (measured(above)) order = above;  // else it is a sum or a difference of displacements
  if (!agrees(prepared, info) || order == 1) return order;
  return prepared.options.scale == dsp::ScaleReference::displacement ? 0 : 2;
}

}  // namespace

bool AbsoluteGain::scales(const std::string& signal) const {
  return std::find(signals.begin(), signals.end(), signal) != signals.end();
}

std::vector<AbsoluteGain> absolute_gains(const dsp::Prepared& prepared) {
  std::vector<AbsoluteGain> gains;
  for (int order = 0; order < 3; ++order)
    for (const Body body : {Body::payload, Body::relative, Body::base})
      if (const dsp::Channel* channel = prepared.channel(dsp::motion_signal(body, order).role)) {
        AbsoluteGain gain{quantities[static_cast<std::size_t>(order)], channel->sensitivity_uncertainty, {}};
        for (const dsp::SignalInfo& info : dsp::signal_table())
          if (info.order >= 0 && scaled_by(prepared, info) == order) gain.signals.emplace_back(info.name);
        gains.push_back(std::move(gain));
        break;
      }
  for (const dsp::Channel& channel : prepared.channels) {
    if (dsp::info_of(channel.role).order >= 0 || channel.role == dsp::Role::t) continue;
    const std::string signal =
        channel.role == dsp::Role::other ? channel.name : std::string(dsp::to_string(channel.role));
    gains.push_back({signal, channel.sensitivity_uncertainty, {signal}});
  }
  return gains;
}

double gain_exponent(const Expression& term, const std::string& target, const AbsoluteGain& gain,
                     const dsp::Motion& motion) {
  const VectorXd values = term.evaluate(motion);
  VectorXd change = VectorXd::Zero(values.size());
  for (const std::string& signal : term.signals())
    if (gain.scales(signal)) change += motion.at(signal).cwiseProduct(term.derivative(signal).evaluate(motion));
  const double norm = values.stableNorm();
  const double degree = (values / norm).dot(change / norm);
  constexpr double rounding = 1e-9;
  const double whole = std::round(degree);
  return (gain.scales(target) ? 1.0 : 0.0) - (std::abs(degree - whole) <= rounding ? whole : degree);
}

void set_calibration(Model& model, const CandidateLibrary& library, const std::vector<AbsoluteGain>& gains,
                     const dsp::Motion& motion) {
  model.calibration.clear();
  for (ModelTerm& term : model.terms) {
    const Expression& expression = library.terms[static_cast<std::size_t>(term.column)].expression;
    term.gain_exponents.clear();
    for (const AbsoluteGain& gain : gains)
      if (const double exponent = gain_exponent(expression, model.target, gain, motion); exponent != 0.0)
        term.gain_exponents.emplace_back(gain.name, exponent);
  }
  for (const AbsoluteGain& gain : gains)
    if (std::any_of(model.terms.begin(), model.terms.end(), [&](const ModelTerm& term) {
          return std::any_of(term.gain_exponents.begin(), term.gain_exponents.end(),
                             [&](const auto& one) { return one.first == gain.name; });
        }))
      model.calibration.emplace_back(gain.name, gain.std);
}

}  // namespace ident
