#include "ident/switches/held_by_ground.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "dsp/values/order_statistics.hpp"

namespace ident {
namespace {

/// The payload's signals, by their names in its own motion and beside its base.
constexpr std::array<std::array<const char*, 2>, 3> own_signals{{{"x", "y"}, {"v", "dy"}, {"a", "ddy"}}};

bool has_own_motion(const dsp::Motion& motion) {
  return motion.find("r") != nullptr && motion.find("y") != nullptr;
}

/// Speed of the payload that most rows of the regression reach only farther than half a wave of its low-pass from where
/// the payload is held: slower ones hold some of the rest, and of the friction that holds.
double clear_of_rest_m_per_s(const dsp::Prepared& prepared, const std::vector<bool>& held) {
  constexpr double waves = 0.5, most = 0.95;
  const dsp::Motion &motion = prepared.intermediate, &signals = prepared.signals;
  const double ratio = motion.sample_rate_hz / signals.sample_rate_hz, cutoff_hz = prepared.options.cutoff_hz,
               reach = cutoff_hz > 0.0 ? waves / cutoff_hz * motion.sample_rate_hz : 0.0;
  const Eigen::VectorXd& dy = signals.at("dy");
  std::vector<double> speeds;
  for (Eigen::Index row = signals.edge_samples; row < dy.size() - signals.edge_samples; ++row) {
    const double at = static_cast<double>(row) * ratio;
    const auto first = held.begin() + std::max<std::ptrdiff_t>(0, std::lround(at - reach)),
               last = held.begin() + std::min<std::ptrdiff_t>(std::ssize(held), std::lround(at + reach) + 1);
    if (first < last && std::find(first, last, true) != last && !*(first + (last - first) / 2))
      speeds.push_back(std::abs(dy(row)));
  }
  return dsp::quantile(std::move(speeds), most);
}

/// Samples at which the payload stands still while its base moves; none where that is seldom.
std::vector<bool> held_samples(const dsp::Motion& motion, const dsp::Segmentation& absolute) {
  const double still_m_per_s = absolute.options.stick_speed_m_per_s;
  const Eigen::VectorXd &dy = motion.at("dy"), &dr = motion.at("dr");
  std::vector<bool> held(static_cast<std::size_t>(motion.num_samples()), false);
  for (const dsp::Segment& segment : absolute.segments)
    for (Eigen::Index i = segment.first; i < segment.last && segment.regime == dsp::Regime::stick; ++i)
      held[static_cast<std::size_t>(i)] = std::abs(dy(i)) < still_m_per_s && std::abs(dr(i)) > still_m_per_s;
  return held;
}

constexpr double least_held_fraction = 0.05;  // of the time

double fraction_of(const std::vector<bool>& held) {
  return static_cast<double>(std::count(held.begin(), held.end(), true)) / static_cast<double>(held.size());
}

/// Where the speed, carried on beyond the fast sample at this end of a slip as it changed over the half wave of the
/// states before (`inwards`: 1 where the slip follows, -1 where it came before), is zero, in samples.
double end_of_slip(const Eigen::VectorXd& dy, Eigen::Index fast, Eigen::Index inwards, Eigen::Index half_wave) {
  const Eigen::Index inside = fast + inwards * half_wave;
  const double at = static_cast<double>(fast), out = -static_cast<double>(inwards);
  if (inside < 0 || inside >= dy.size()) return at + 0.5 * out;
  const double speed = std::abs(dy(fast)), fall = (std::abs(dy(inside)) - speed) / static_cast<double>(half_wave);
  return fall > 0.0 ? at + out * speed / fall : at + 0.5 * out;
}

}  // namespace

std::optional<dsp::Segmentation> absolute_regimes(const dsp::Motion& motion) {
  if (!has_own_motion(motion)) return std::nullopt;
  dsp::Motion own{.sample_rate_hz = motion.sample_rate_hz, .excluded = motion.excluded};
  for (const auto& [name, beside_base] : own_signals) {
    (void)motion.at(beside_base);
    own.signals.push_back(*motion.find(beside_base));
    own.signals.back().name = name;
  }
  return dsp::segment_regimes(own);
}

std::optional<dsp::Segmentation> absolute_regimes_in_place(dsp::Motion& motion) {
  if (!has_own_motion(motion)) return std::nullopt;
  dsp::Motion own{.sample_rate_hz = motion.sample_rate_hz, .excluded = motion.excluded};
  std::vector<dsp::Signal*> lent;
  for (const auto& [name, beside_base] : own_signals) {
    const auto found = std::find_if(motion.signals.begin(), motion.signals.end(),
                                    [&, wanted = beside_base](const dsp::Signal& one) { return one.name == wanted; });
    lent.push_back(&*found);
    own.signals.push_back({name, found->unit, {}, found->flat_to_hz});
  }
  const auto exchange = [&] {
    for (std::size_t i = 0; i < lent.size(); ++i) lent[i]->values.swap(own.signals[i].values);
  };
  exchange();
  try {
    dsp::Segmentation found = dsp::segment_regimes(own);
    exchange();
    return found;
  } catch (...) {
    exchange();
    throw;
  }
}

std::optional<dsp::Check> held_by_ground(const dsp::Prepared& prepared, const dsp::Segmentation& absolute) {
  const double still_m_per_s = absolute.options.stick_speed_m_per_s;
  const std::vector<bool> held = held_samples(prepared.intermediate, absolute);
  const double fraction = fraction_of(held);
  if (fraction < least_held_fraction) return std::nullopt;
  const double clear_m_per_s = std::max(still_m_per_s, clear_of_rest_m_per_s(prepared, held));
  return dsp::Check{.name = "regime.ground",
                    .status = dsp::CheckStatus::warning,
                    .value = fraction,
                    .limit = least_held_fraction,
                    .message = fmt::format(
                        "for {:.0f} % of the time the payload stands still on the ground while its base moves: its "
                        "friction is that of dy, and an equation holds only while it slips. Try target = "
                        "\"ddy\" in [fit], only = [\"x\", \"v\", \"sgn(dy)\"] in [library], and a [[range]] with "
                        "name = \"slip\" and where = \"abs(dy) > {:.2g}\"",
                        100.0 * fraction, clear_m_per_s)};
}

Eigen::VectorXd slipping_fraction(const dsp::Prepared& prepared) {
  const dsp::Motion& motion = prepared.intermediate;
  const std::optional<dsp::Segmentation> absolute = absolute_regimes(motion);
  if (!absolute) return {};
  const std::vector<bool> held = held_samples(motion, *absolute);
  if (fraction_of(held) < least_held_fraction) return {};
  const Eigen::VectorXd& dy = motion.at("dy");
  const auto slow = [&](Eigen::Index i) { return std::abs(dy(i)) < absolute->options.stick_speed_m_per_s; };
  const auto half_wave =
      std::max<Eigen::Index>(1, std::lround(0.5 * motion.sample_rate_hz / prepared.options.state_cutoff_hz));
  Eigen::VectorXd slipping = Eigen::VectorXd::Ones(dy.size());
  for (Eigen::Index first = 0, next = 0; first < dy.size(); first = next) {
    next = first + 1;
    if (!slow(first)) continue;
    while (next < dy.size() && slow(next)) ++next;
    if (std::find(held.begin() + first, held.begin() + next, true) == held.begin() + next) continue;
    const double from = end_of_slip(dy, first - 1, -1, half_wave), to = end_of_slip(dy, next, 1, half_wave);
    for (Eigen::Index i = first > 0 ? first - 1 : first; i < next; ++i) {
      const auto at = static_cast<double>(i);
      slipping(i) -= std::max(0.0, std::min(at + 0.5, to) - std::max(at - 0.5, from));
    }
  }
  return slipping;
}

}  // namespace ident
