#include "ident/evidence/statement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "dsp/values/constants.hpp"
#include "ident/evidence/range_data.hpp"
#include "ident/ranges/pieces.hpp"
#include "ident/records/record.hpp"
#include "ident/state_space/start.hpp"
#include "ident/state_space/thin.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using std::size_t;

constexpr Index most_samples = 10'000;  // of all pieces together: 20 ms for an iteration, of which there are 40 to 200

/// One input is known without gaps or not at all; where there is none, samples that must not be used are missing ones.
bool may_have_gaps(const Range& range, const std::vector<std::string>& inputs) {
  return inputs.empty() && range.regime.any();
}

/// A recorded channel of the body, as the likelihood has it.
struct Output {
  Index column;
  int order;
  state_space::Channel channel;
};

std::vector<Output> outputs_of(const Columns& columns) {
  const dsp::Prepared& prepared = *columns.prepared;
  const dsp::Recording& recorded = *prepared.recorded;
  const auto parameter = [&](std::string_view source) -> const SensorParameter* {
    const auto found = std::find_if(columns.sensors.begin(), columns.sensors.end(),
                                    [&](const SensorParameter& one) { return one.source == source; });
    return found == columns.sensors.end() ? nullptr : &*found;
  };
  std::vector<Output> outputs;
  for (Index j = 0; j < std::ssize(recorded.channels); ++j) {
    const dsp::Channel& channel = recorded.channels[static_cast<size_t>(j)];
    const int order = dsp::info_of(channel.role).order;
    state_space::Channel output{.name = channel.name, .state = order == 0 ? 0 : 1, .rate = order == 2};
    outputs.push_back({j, order, output});
  }
  std::stable_sort(outputs.begin(), outputs.end(), [](const Output& a, const Output& b) { return a.order < b.order; });
  const SensorParameter* const of_force = parameter("lag of f");
  for (Output& output : outputs) {
    const dsp::Channel& channel = recorded.channels[static_cast<size_t>(output.column)];
    if (of_force != nullptr) output.channel.lag_s = {0.0, of_force->std};
    if (output.order == 0) {
      if (const SensorParameter* zero = parameter("zero of x")) output.channel.offset = {0.0, zero->std};
    } else {
      output.channel.offset = {0.0, state_space::unknown};
    }
    for (const double corner : channel.highpass_hz) {
      constexpr double of_corner = 0.05;  // a maker's usual
      const double mean = dsp::two_pi * corner;
      output.channel.corner_rad_s = {mean, of_corner * mean};
    }
    if (&output == &outputs.front()) continue;  // the first is the measure of the others
    const dsp::Channel& first = recorded.channels[static_cast<size_t>(outputs.front().column)];
    output.channel.gain = {1.0, std::hypot(channel.sensitivity_uncertainty, first.sensitivity_uncertainty)};
  }
  return outputs;
}

/// Up to where the channels are as their sensors gave them.
double flat_to_hz(const dsp::Prepared& prepared) {
  const bool decimated =
      prepared.decimation && !prepared.decimation->stages.empty() &&
      prepared.decimation->stages.front().input_rate_hz > prepared.intermediate.sample_rate_hz * (1.0 + 1e-9);
  return decimated ? prepared.options.state_cutoff_hz : std::numeric_limits<double>::infinity();
}

/// Why the likelihood does not apply to a recording; empty: it does.
std::string obstacle(const Columns& columns) {
  if (columns.prepared == nullptr) return "the rows of a table are no time response";
  const dsp::Prepared& prepared = *columns.prepared;
  if (prepared.recorded == nullptr)
    return prepared.x_is_difference ? "x is the difference of two channels" : "x was formed of filtered channels";
  for (const dsp::Channel& channel : prepared.recorded->channels) {
    if (channel.highpass_hz.size() > 1) return fmt::format("{} has two couplings", channel.name);
    if (channel.hold_samples > 1)
      return fmt::format("{} holds each of its values for {} samples", channel.name, channel.hold_samples);
  }
  if (!std::all_of(prepared.relations.begin(), prepared.relations.end(), dsp::can_be_corrected))
    return "two channels of one motion contradict each other";
  return {};
}

/// The signals that candidates look at beside the state; nothing for a candidate of another motion.
std::optional<std::vector<std::string>> inputs_of(const RangeData& data, const dsp::Motion& signals) {
  std::vector<std::string> inputs;
  for (const Index j : data.terms) {
    const Expression& term = data.library.terms[static_cast<size_t>(j)].expression;
    for (const std::string& name : term.signals()) {
      if (name == "x" || name == "v" || name == "t") continue;
      const dsp::SignalInfo* const info = dsp::find_signal(name);
      const bool is_motion = info != nullptr && (info->body == dsp::Body::payload || info->body == dsp::Body::relative);
      if (is_motion || name == "z" || signals.find(name) == nullptr) return std::nullopt;
      if (std::find(inputs.begin(), inputs.end(), name) == inputs.end()) inputs.push_back(name);
    }
  }
  return inputs;
}

void set_missing(Eigen::MatrixXd& channels, const Piece& piece, const dsp::Recording& recorded) {
  for (const dsp::Interval& bad : recorded.bad) {
    const auto from = static_cast<Index>(std::floor(bad.from_s * recorded.sample_rate_hz)),
               to = static_cast<Index>(std::ceil(bad.to_s * recorded.sample_rate_hz)) + 1;
    const Index first = std::max(from, piece.first), last = std::min(to, piece.last);
    if (first < last) channels.middleRows(first - piece.first, last - first).setConstant(dsp::nan);
  }
}

state_space::Record record_of(const Piece& piece, const Columns& columns, const std::vector<Output>& outputs,
                              const std::vector<Eigen::VectorXd>& inputs) {
  const dsp::Recording& recorded = *columns.prepared->recorded;
  state_space::Record record{Eigen::MatrixXd(piece.size(), std::ssize(outputs)),
                             Eigen::MatrixXd(piece.size(), std::ssize(inputs))};
  for (Index j = 0; j < std::ssize(outputs); ++j) {
    const Output& output = outputs[static_cast<size_t>(j)];
    record.channels.col(j) = recorded.samples.col(output.column).segment(piece.first, piece.size());
    if (output.order == 0) record.channels.col(j).array() -= columns.zero;
  }
  for (Index j = 0; j < std::ssize(inputs); ++j) record.inputs.col(j) = inputs[static_cast<size_t>(j)];
  set_missing(record.channels, piece, recorded);
  record.begin_s = static_cast<double>(piece.first) / recorded.sample_rate_hz;
  return record;
}

bool same_outputs(const std::vector<Output>& a, const std::vector<Output>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Output& one, const Output& other) { return one.order == other.order; });
}

/// What springs, dampers and friction are commonly made of, and springs and dampers that change with time.
constexpr std::array usual_forms{"x",     "v",   "sgn(v)",   "x^2",    "x*v",      "v^2", "x^3", "x^2*v",
                                 "x*v^2", "v^3", "abs(v)*v", "abs(x)", "abs(x)*x", "x^5", "t*x", "t*v"};

/// What is no candidate and may be missing: usual forms, and signals that act from outside.
std::vector<Explanation> outsiders(const RangeData& data, const dsp::Motion& signals) {
  std::vector<std::string> candidates;
  for (const Index j : data.terms) candidates.push_back(data.library.terms[static_cast<size_t>(j)].expression.text());
  std::vector<Explanation> result;
  const auto add = [&](const std::string& text, Cause cause, bool is_recorded) {
    const Expression expression(text);
    const std::string& name = expression.text();
    if (std::find(candidates.begin(), candidates.end(), name) == candidates.end())
      result.push_back({.what = name, .cause = cause, .is_recorded = is_recorded});
  };
  for (const char* form : usual_forms) add(form, Cause::missing_term, false);
  if (const dsp::Signal* x = signals.find("x"); x != nullptr && x->unit == "rad")
    for (const char* form : {"sin(x)", "cos(x)"}) add(form, Cause::missing_term, false);
  for (const dsp::Signal& signal : signals.signals)
    if (acts_from_outside(signal)) add(signal.name, Cause::missing_input, true);
  return result;
}

/// As it was recorded where the signals of the motion are without what is slow.
std::optional<VectorXd> input_of(const Columns& columns, const std::string& name, const Piece& piece) {
  const dsp::Prepared& prepared = *columns.prepared;
  if (const dsp::Recording* beside = prepared.recorded_beside.get())
    for (Index j = 0; j < std::ssize(beside->channels); ++j) {
      const dsp::Channel& channel = beside->channels[static_cast<size_t>(j)];
      if (name == (channel.role == dsp::Role::other ? channel.name : dsp::info_of(channel.role).name))
        return beside->samples.col(j).segment(piece.first, piece.size());
    }
  const dsp::Signal* const signal = prepared.intermediate.find(name);
  if (signal == nullptr) return std::nullopt;
  return signal->values.segment(piece.first, piece.size());
}

/// Whether the recordings have all inputs.
bool take_pieces(state_space::Problem& problem, const std::vector<Piece>& pieces,
                 const std::vector<Columns>& recordings, const std::vector<std::string>& inputs) {
  problem.input_noise_std.assign(inputs.size(), 0.0);
  problem.records.clear();
  for (const Piece& piece : pieces) {
    const Columns& columns = recordings[piece.recording];
    std::vector<VectorXd> signals;  // on the piece alone: a long record has more than is taken
    for (const std::string& name : inputs) {
      const std::optional<VectorXd> recorded = input_of(columns, name, piece);
      if (!recorded) return false;
      state_space::Input input = state_space::without_noise(*recorded, problem.sample_rate_hz);
      double& noise_std = problem.input_noise_std[signals.size()];
      noise_std = std::max(noise_std, input.noise_std);
      signals.push_back(std::move(input.signal));
    }
    problem.records.push_back(record_of(piece, columns, outputs_of(columns), signals));
  }
  std::vector<size_t> recording_of;
  for (const Piece& piece : pieces) recording_of.push_back(piece.recording);
  state_space::tell_noise_apart(problem, recording_of);
  return true;
}

}  // namespace

Statement statement_of(const Range& range, const std::vector<Row>& rows, bool are_last, const RangeData& data,
                       const std::vector<Columns>& recordings) {
  Statement result;
  std::vector<size_t> covered;
  for (size_t r = 0; r < recordings.size() && result.obstacle.empty(); ++r)
    if (range.covers(r)) covered.push_back(r), result.obstacle = obstacle(recordings[r]);
  if (!result.obstacle.empty()) return result;
  const auto refuse = [&](std::string why) { return Statement{.obstacle = std::move(why)}; };
  if (!range.spec.where.empty()) return refuse("the range has a condition on its rows");
  if (std::any_of(data.terms.begin(), data.terms.end(),
                  [&](Index j) { return data.library.terms[static_cast<size_t>(j)].recording > 0; }))
    return refuse("coefficients differ between the recordings");
  const Columns& first = recordings[covered.front()];
  auto inputs = inputs_of(data, first.prepared->intermediate);
  if (!inputs) return refuse("a candidate looks at another motion than x and v");
  std::vector<std::string> terms;
  for (const Index j : data.terms) terms.push_back(data.library.terms[static_cast<size_t>(j)].name);
  result.outside = outsiders(data, first.prepared->intermediate);
  for (const Explanation& one : result.outside) {
    terms.push_back(one.what);
    if (one.is_recorded && std::find(inputs->begin(), inputs->end(), one.what) == inputs->end())
      inputs->push_back(one.what);
  }
  const std::vector<Output> outputs = outputs_of(first);
  state_space::Problem& problem = result.problem;
  problem.equations = state_space::oscillator(terms, *inputs);
  problem.sample_rate_hz = first.prepared->intermediate.sample_rate_hz;
  problem.flat_to_hz = flat_to_hz(*first.prepared);
  for (const Output& output : outputs) problem.channels.push_back(output.channel);
  for (const size_t r : covered) {
    const Columns& columns = recordings[r];
    if (columns.prepared->intermediate.sample_rate_hz != problem.sample_rate_hz ||
        !same_outputs(outputs_of(columns), outputs))
      return refuse("the recordings have other channels or rates");
    if (covered.size() > 1 && outputs.front().channel.offset.std > 0.0 && outputs.front().order == 0)
      return refuse("the recordings have zeros of their own");
  }
  const std::vector<Piece> pieces = pieces_of(range, rows, are_last, recordings, may_have_gaps(range, *inputs));
  if (pieces.empty()) return refuse("there is no interval of rows long enough");
  const auto take = [&](const std::vector<Piece>& from) { return take_pieces(problem, from, recordings, *inputs); };
  if (!take(shortened(pieces, most_samples))) return refuse("the recordings have other channels or rates");
  if (const Index factor = state_space::thinning(problem); factor > 1) {
    if (num_samples(pieces) > most_samples) (void)take(shortened(pieces, factor * most_samples));
    problem = state_space::thinned(std::move(problem), factor);
    result.thinned_by = static_cast<double>(factor);
  }
  return result;
}

}  // namespace ident
