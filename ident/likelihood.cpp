#include "ident/likelihood.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "dsp/constants.hpp"
#include "ident/identify.hpp"
#include "ident/library/collinearity.hpp"
#include "ident/methods.hpp"
#include "ident/range_data.hpp"
#include "ident/record.hpp"
#include "ident/state_space/select.hpp"
#include "ident/state_space/start.hpp"
#include "ident/state_space/thin.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::size_t;

/// Samples [first, last) of a recording at the rate of its intermediate signals.
struct Piece {
  size_t recording;
  Index first, last;
  [[nodiscard]] Index size() const { return last - first; }
};

constexpr Index least_samples = 32;     // of a piece: less says nothing but where it begins
constexpr Index most_samples = 10'000;  // of all pieces together: 20 ms for an iteration, of which there are 40 to 200

/// One input is known without gaps or not at all; where there is none, samples that must not be used are missing ones.
bool may_have_gaps(const Range& range, const std::vector<std::string>& inputs) {
  return inputs.empty() && range.regime.any();
}

/// Rows as they were recorded, and where they begin or end with the record, the rest of it: what filters
/// spoil there is not spoilt.
std::vector<Piece> pieces_of(const Range& range, const std::vector<Row>& rows, bool are_last,
                             const std::vector<Columns>& recordings, bool with_gaps) {
  std::vector<Piece> pieces;
  const auto end = static_cast<Index>(rows.size());
  for (Index first = 0; first < end;) {
    const Index behind = end_of_stretch(rows, first, end);
    const Row &from = rows[static_cast<size_t>(first)], &to = rows[static_cast<size_t>(behind - 1)];
    const dsp::Prepared& prepared = *recordings[from.recording].prepared;
    const double samples_a_row = prepared.intermediate.sample_rate_hz / prepared.signals.sample_rate_hz;
    const auto sample = [&](Index row) { return std::lround(static_cast<double>(row) * samples_a_row); };
    const Index num_rows = prepared.signals.num_samples(), edge = prepared.signals.edge_samples;
    Piece piece{from.recording, sample(from.sample), sample(to.sample) + 1};
    if (from.sample <= edge && range.spec.from_s <= 0.0) piece.first = 0;
    if (to.sample + 1 >= num_rows - edge && are_last) piece.last = prepared.intermediate.num_samples();
    if (with_gaps && !pieces.empty() && pieces.back().recording == piece.recording)
      pieces.back().last = piece.last;
    else
      pieces.push_back(piece);
    first = behind;
  }
  std::erase_if(pieces, [](const Piece& piece) { return piece.size() < least_samples; });
  return pieces;
}

Index num_samples(const std::vector<Piece>& pieces) {
  return std::accumulate(pieces.begin(), pieces.end(), Index{0},
                         [](Index sum, const Piece& piece) { return sum + piece.size(); });
}

/// So much of each, from its middle, that all together are not more than `most`.
std::vector<Piece> shortened(const std::vector<Piece>& pieces, Index most) {
  const Index all = num_samples(pieces);
  if (all <= most) return pieces;
  constexpr Index most_parts = 8;  // of a long record, spread over it
  std::vector<Piece> shorter;
  for (const Piece& piece : pieces) {
    const auto size =
        static_cast<Index>(static_cast<double>(piece.size()) * static_cast<double>(most) / static_cast<double>(all));
    const Index parts = std::clamp<Index>(piece.size() / (16 * least_samples), 1, most_parts);
    const Index each = std::max(size / parts, std::min(piece.size() / parts, 16 * least_samples));
    for (Index i = 0; i < parts; ++i) {
      const Index first = piece.first + i * piece.size() / parts + (piece.size() / parts - each) / 2;
      shorter.push_back({piece.recording, first, first + each});
    }
  }
  return shorter;
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
  for (const dsp::Channel& channel : prepared.recorded->channels)
    if (channel.highpass_hz.size() > 1) return fmt::format("{} has two couplings", channel.name);
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
  return record;
}

bool same_outputs(const std::vector<Output>& a, const std::vector<Output>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Output& one, const Output& other) { return one.order == other.order; });
}

/// What springs, dampers and friction are commonly made of.
constexpr std::array usual_forms{"x", "v", "sgn(v)", "x^2", "x*v", "v^2", "x^3", "x^2*v", "x*v^2", "v^3", "abs(v)*v"};

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
  return true;
}

/// A problem, the candidates ahead of what is no candidate; or why there is none.
struct Statement {
  state_space::Problem problem;
  std::vector<Explanation> outside = {};
  std::string obstacle = {};
  double thinned_by = 1.0;
};

/// `are_last`: of the range, no others come behind them.
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

/// With all candidates where they are few, from which the search does best; else with those of the regression.
std::vector<int> first_terms(const RangeData& data) {
  constexpr size_t few = 24;
  std::vector<int> terms;
  if (data.terms.size() > few && data.evidence.terms)
    for (const Index position : *data.evidence.terms) terms.push_back(static_cast<int>(position));
  return terms;
}

/// What the fit makes of the parameters of the channels.
void take_sensors(Likelihood& result, const state_space::Problem& problem, const state_space::Fit& fit, int num_terms) {
  struct Kind {
    std::string_view name, unit;
    const state_space::Prior state_space::Channel::*prior;
    double of_unit = 1.0;
  };
  static constexpr std::array<Kind, 4> kinds{{{"gain", "1", &state_space::Channel::gain},
                                              {"zero", "", &state_space::Channel::offset},
                                              {"lag", "s", &state_space::Channel::lag_s},
                                              {"coupling", "Hz", &state_space::Channel::corner_rad_s, dsp::two_pi}}};
  for (size_t i = 0; i < fit.parameters.size(); ++i) {
    const int at = fit.parameters[i] - num_terms;
    if (at < 0 || static_cast<size_t>(at) >= kinds.size() * problem.channels.size()) continue;
    const state_space::Channel& channel = problem.channels[static_cast<size_t>(at) / kinds.size()];
    const Kind& kind = kinds[static_cast<size_t>(at) % kinds.size()];
    const state_space::Prior& prior = channel.*kind.prior;
    const double value = fit.point.parameters[static_cast<size_t>(fit.parameters[i])] - prior.mean;
    const bool of_x = channel.state == 0 && !channel.rate;
    result.sensors.push_back(
        {.name = of_x && kind.name == "zero" ? "zero of x" : fmt::format("{} of {}", kind.name, channel.name),
         .unit = std::string(kind.unit),
         .prior_std = prior.std / kind.of_unit,
         .mean = (of_x && kind.name == "zero" ? -value : value) / kind.of_unit,
         .std = fit.std(i) / kind.of_unit});
    if (of_x && kind.name == "zero") result.zero = {value, fit.std(i)};
    if (at < static_cast<int>(kinds.size()) && kind.name == "lag") result.lag_s = {value, fit.std(i)};
  }
}

std::optional<Explanation> missing_of(const state_space::Selection& selection, const Statement& statement,
                                      const RangeData& data) {
  const auto found_outside =
      std::find_if(selection.outside.begin(), selection.outside.end(), [&](const state_space::Outside& one) {
        return std::cmp_greater_equal(one.term, data.terms.size()) && one.gain > undecided_evidence;
      });
  if (found_outside == selection.outside.end()) return std::nullopt;
  const state_space::Outside& best = *found_outside;
  Explanation found = statement.outside[static_cast<size_t>(best.term) - data.terms.size()];
  found.fraction = best.gain / std::max(best.gain, selection.fit.gain_of_process_noise);
  for (const int term : best.instead_of)
    found.instead_of.push_back(data.library.terms[static_cast<size_t>(data.terms[static_cast<size_t>(term)])].name);
  return found;
}

/// As Likelihood::unexplained_std.
double unexplained_of(const state_space::Fit& fit, const state_space::Problem& problem, const Columns& columns) {
  return fit.noise.process.at(1) * std::sqrt(2.0 * problem.sample_rate_hz * columns.band_hz);
}

/// Among these candidates, positions in data.terms.
Likelihood selected(const Statement& statement, const std::vector<int>& among, const std::vector<int>& first,
                    const RangeRows& rows, const RangeData& data, const std::vector<Columns>& recordings,
                    int num_threads) {
  Likelihood result;
  const state_space::Problem& problem = statement.problem;
  const auto num_terms = static_cast<Index>(data.terms.size());
  std::vector<int> barred;
  for (int i = 0; i < num_terms + std::ssize(statement.outside); ++i)
    if (std::find(among.begin(), among.end(), i) == among.end()) barred.push_back(i);
  const state_space::Selection selection =
      state_space::select(problem, {.fit = {.terms = first, .num_threads = num_threads}, .barred = barred});
  const state_space::Fit& fit = selection.fit;
  if (!fit.converged()) {
    result.silent_because =
        fit.settled ? "its fit did not come down to the noise of the channels" : "its fit did not come to rest";
    return result;
  }
  std::vector<size_t> places;
  for (size_t i = 0; i < fit.parameters.size(); ++i)
    if (fit.parameters[i] < num_terms) {
      places.push_back(i);
      result.terms.push_back(data.terms[static_cast<size_t>(fit.parameters[i])]);
    }
  if (places.empty()) result.silent_because = "it keeps no term";
  const auto k = std::ssize(places);
  result.mean.resize(k), result.covariance.resize(k, k);
  for (Index i = 0; i < k; ++i) {
    const size_t at = places[static_cast<size_t>(i)];
    result.mean(i) = fit.point.parameters[static_cast<size_t>(fit.parameters[at])];
    for (Index j = 0; j < k; ++j)
      result.covariance(i, j) = fit.covariance[at * fit.parameters.size() + places[static_cast<size_t>(j)]];
  }
  result.gain = Eigen::VectorXd::Constant(std::ssize(data.library.terms), dsp::nan);
  for (Index j = 0; j < num_terms; ++j)
    result.gain(data.terms[static_cast<size_t>(j)]) = selection.scores[static_cast<size_t>(j)].gain;
  take_sensors(result, problem, fit, static_cast<int>(problem.equations.terms.size()) - 1);
  result.missing = missing_of(selection, statement, data);
  for (const state_space::Record& record : problem.records)
    result.num_samples += statement.thinned_by * static_cast<double>((!record.channels.array().isNaN()).count());
  result.price = selection.price;
  result.gain_of_process_noise = fit.gain_of_process_noise;
  result.unexplained_std = unexplained_of(fit, problem, recordings[rows.train.front().recording]);
  return result;
}

/// Without those whose square over the wider variance of a regression on the same terms is below its price there, the
/// weakest first; the others as the covariance has them where one is zero. Positions in data.terms.
std::vector<int> worth_their_price(const Likelihood& likelihood, const RangeData& data,
                                   const IdentifyOptions& options) {
  const auto method = std::find_if(options.methods.begin(), options.methods.end(), weighs_rows);
  const RFactor& rows = data.evidence.as_they_are() ? data.data : data.evidence.data;
  std::vector<Index> positions = positions_in(data, likelihood.terms);
  VectorXd mean = likelihood.mean;
  MatrixXd covariance = likelihood.covariance;
  while (positions.size() > 1) {
    const Fit of_rows = fit_on_terms(rows, positions, *method, options.poll);
    if (of_rows.relevant != positions) break;
    const VectorXd wider = of_rows.interval_covariance().diagonal().cwiseMax(covariance.diagonal());
    Index weakest = 0;
    if (mean.cwiseAbs2().cwiseQuotient(wider).minCoeff(&weakest) >= of_rows.tau) break;
    const VectorXd column = covariance.col(weakest) / covariance(weakest, weakest);
    mean -= column * mean(weakest);
    covariance -= covariance(weakest, weakest) * column * column.transpose();
    std::vector<Index> others(positions.size());
    std::iota(others.begin(), others.end(), Index{0});
    others.erase(others.begin() + weakest), positions.erase(positions.begin() + weakest);
    mean = VectorXd(mean(others)), covariance = MatrixXd(covariance(others, others));
  }
  return {positions.begin(), positions.end()};
}

}  // namespace

Likelihood likelihood_of(const Range& range, const RangeRows& rows, const RangeData& data,
                         const std::vector<Columns>& recordings, const IdentifyOptions& options) {
  const Statement statement = statement_of(range, rows.train, rows.test.empty(), data, recordings);
  if (!statement.obstacle.empty()) return {.silent_because = statement.obstacle};
  std::vector<int> among(data.terms.size());
  std::iota(among.begin(), among.end(), 0);
  const auto select = [&](const std::vector<int>& candidates, const std::vector<int>& first) {
    return selected(statement, candidates, first, rows, data, recordings, options.num_threads);
  };
  Likelihood result = select(among, first_terms(data));
  if (!result.speaks() || !result.has_unexplained()) return result;
  const std::vector<int> worth = worth_their_price(result, data, options);
  return worth.size() == result.terms.size() ? result : select(worth, worth);
}

std::optional<RecordedRun> run_through(const Likelihood& likelihood, const Range& range, const std::vector<Row>& rows,
                                       const RangeData& data, const std::vector<Columns>& recordings, int num_threads) {
  Statement statement = statement_of(range, rows, true, data, recordings);
  if (!statement.obstacle.empty()) return std::nullopt;
  state_space::Problem& problem = statement.problem;
  std::vector<state_space::Term>& terms = problem.equations.terms;
  std::erase_if(terms, [](const state_space::Term& term) { return !term.known.has_value(); });
  for (size_t i = 0; i < likelihood.terms.size(); ++i)
    terms.push_back({.text = data.library.terms[static_cast<size_t>(likelihood.terms[i])].name,
                     .known = likelihood.mean(static_cast<Index>(i))});
  const state_space::Fit fit = state_space::fit(problem, {.num_threads = num_threads});
  if (!fit.converged()) return std::nullopt;
  double square = 0.0, samples = 0.0;
  for (const state_space::Record& record : problem.records) {
    std::vector<double> values;
    for (const double value : record.channels.col(0))
      if (!std::isnan(value)) values.push_back(value);
    const auto all = VectorXd::Map(values.data(), std::ssize(values));
    square += (all.array() - all.mean()).square().sum(), samples += static_cast<double>(all.size());
  }
  const double power = square / samples;
  return RecordedRun{.channel = problem.channels.front().name,
                     .nmse = std::pow(fit.residual_std.front(), 2) / power,
                     .noise = std::pow(fit.floors.front(), 2) / power,
                     .gain_of_process_noise = fit.gain_of_process_noise,
                     .unexplained_std = unexplained_of(fit, problem, recordings[rows.front().recording])};
}

}  // namespace ident
