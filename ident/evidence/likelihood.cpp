#include "ident/evidence/likelihood.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "dsp/values/constants.hpp"
#include "ident/evidence/range_data.hpp"
#include "ident/evidence/statement.hpp"
#include "ident/regression/collinearity.hpp"
#include "ident/regression/methods.hpp"
#include "ident/state_space/select.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::size_t;

std::vector<int> as_terms(const std::vector<Index>& positions) {
  return {positions.begin(), positions.end()};
}

/// Those of the regression.
std::vector<int> terms_of_rows(const RangeData& data) {
  return data.evidence.terms ? as_terms(*data.evidence.terms) : std::vector<int>{};
}

/// With all candidates (none named) where they are few, from which the search does best.
std::vector<int> first_terms(const RangeData& data) {
  constexpr size_t few = 24;
  return data.terms.size() > few ? terms_of_rows(data) : std::vector<int>{};
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

void take_wanders(Likelihood& result, const state_space::Problem& problem, const state_space::Fit& fit,
                  const dsp::Recording& recorded) {
  constexpr double at_bound = 1.5;
  constexpr double most = 0.2;  // of the motion: a zero that goes farther is no sensor's but what drives the motion
  const size_t num_of_equations = problem.equations.states.size();
  size_t num_states = num_of_equations;
  for (const state_space::Channel& channel : problem.channels) num_states += channel.has_own_state() ? 1 : 0;
  for (size_t j = 0, state = num_of_equations; j < problem.channels.size(); ++j) {
    const state_space::Channel& channel = problem.channels[j];
    if (!channel.has_own_state()) continue;
    const size_t own = state++;
    if (!channel.wanders || fit.noise.process[own] < at_bound * state_space::least_wander * fit.floors[j]) continue;
    const auto of = std::find_if(recorded.channels.begin(), recorded.channels.end(),
                                 [](const dsp::Channel& one) { return dsp::info_of(one.role).order == 0; });
    double sum = 0.0, squares = 0.0, of_motion = 0.0, count = 0.0;
    for (const std::vector<double>& states : fit.point.states)
      for (size_t k = 0; k < states.size(); k += num_states) {
        const double x = states[k + static_cast<size_t>(channel.state)], off = states[k + own] - x;
        sum += off, squares += off * off, of_motion += x * x, ++count;
      }
    const double mean = sum / count, square = std::max(0.0, squares / count - mean * mean);
    if (square > most * most * of_motion / count) continue;
    result.zero = {mean, std::sqrt(square)};
    result.wanders.push_back({channel.name, of == recorded.channels.end() ? "" : of->unit,
                              fit.noise.process[own] * std::sqrt(problem.sample_rate_hz)});
  }
}

/// Mean time of the samples, s.
double middle_of(const state_space::Problem& problem) {
  double sum = 0.0, count = 0.0;
  for (const state_space::Record& record : problem.records) {
    const auto rows = static_cast<double>(record.channels.rows());
    sum += rows * (record.begin_s + 0.5 * rows / problem.sample_rate_hz), count += rows;
  }
  return sum / count;
}

/// A barred term that is missing, and how coefficients, at these places of those sought, move with it.
void take_missing(Likelihood& result, const state_space::Selection& selection, const std::vector<size_t>& places,
                  const Statement& statement, const RangeData& data) {
  constexpr double hardly_any = 0.1;  // of what is left over: another law for that may be as good
  const auto found_outside =
      std::find_if(selection.outside.begin(), selection.outside.end(), [&](const state_space::Outside& one) {
        return std::cmp_greater_equal(one.term, data.terms.size()) && one.gain > undecided_evidence &&
               one.explains > hardly_any;
      });
  if (found_outside == selection.outside.end()) return;
  const state_space::Outside& best = *found_outside;
  Explanation& found = result.missing.emplace(statement.outside[static_cast<size_t>(best.term) - data.terms.size()]);
  found.fraction = best.explains;
  for (const int term : best.instead_of)
    found.instead_of.push_back(data.library.terms[static_cast<size_t>(data.terms[static_cast<size_t>(term)])].name);
  // What changes with time, t times another term, has that term's coefficient as it is at the middle of the samples.
  const bool changes = found.what.starts_with("t*");
  const double middle_s = changes ? middle_of(statement.problem) : 0.0;
  result.moved = -result.mean;
  for (size_t i = 0; i < places.size(); ++i) {
    double& moved = result.moved(static_cast<Index>(i));
    moved += best.parameters[static_cast<size_t>(selection.fit.parameters[places[i]])];
    if (changes && found.what.substr(2) == data.library.terms[static_cast<size_t>(result.terms[i])].name)
      moved += middle_s * best.parameters[static_cast<size_t>(best.term)];
  }
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
  const auto num_priced =
      std::count_if(fit.parameters.begin(), fit.parameters.end(), [&](int at) { return at < num_terms; }) +
      std::count_if(problem.channels.begin(), problem.channels.end(),
                    [](const state_space::Channel& channel) { return channel.wanders; });
  result.price = selection.price;
  result.cost = fit.J + selection.price * static_cast<double>(num_priced);
  if (selection.hopeless) result.cost = std::numeric_limits<double>::infinity();
  if (!std::isfinite(fit.residual_std.front())) result.cost = dsp::nan;
  if (!fit.converged()) {
    result.is_restless = !fit.settled && !selection.hopeless;
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
  const std::vector<double> covariance =
      fit.gain_of_process_noise > Likelihood::beyond_doubt ? fit.wider() : fit.covariance;
  result.mean.resize(k), result.covariance.resize(k, k);
  for (Index i = 0; i < k; ++i) {
    const size_t at = places[static_cast<size_t>(i)];
    result.mean(i) = fit.point.parameters[static_cast<size_t>(fit.parameters[at])];
    for (Index j = 0; j < k; ++j)
      result.covariance(i, j) = covariance[at * fit.parameters.size() + places[static_cast<size_t>(j)]];
  }
  result.gain = Eigen::VectorXd::Constant(std::ssize(data.library.terms), dsp::nan);
  for (Index j = 0; j < num_terms; ++j)
    result.gain(data.terms[static_cast<size_t>(j)]) = selection.scores[static_cast<size_t>(j)].gain;
  take_sensors(result, problem, fit, static_cast<int>(problem.equations.terms.size()) - 1);
  take_missing(result, selection, places, statement, data);
  for (const state_space::Record& record : problem.records)
    result.num_samples += statement.thinned_by * static_cast<double>((!record.channels.array().isNaN()).count());
  result.gain_of_process_noise = fit.gain_of_process_noise;
  result.unexplained_std = unexplained_of(fit, problem, recordings[rows.train.front().recording]);
  take_wanders(result, problem, fit, *recordings[rows.train.front().recording].prepared->recorded);
  return result;
}

/// Zeros of displacements wander in the place of constant ones, by steps of this size (0: estimated). Whether there is
/// a displacement.
bool let_wander(state_space::Problem& problem, double step_std) {
  bool any = false;
  for (state_space::Channel& channel : problem.channels) {
    if (channel.state != 0 || channel.rate || channel.has_own_state()) continue;
    channel.wanders = any = true;
    channel.wander_std = step_std;
    channel.offset = {};
  }
  return any;
}

/// These positions, and those of x and v, which slow noise hides first.
std::vector<int> with_spring_and_damper(std::vector<int> positions, const RangeData& data) {
  for (size_t i = 0; i < data.terms.size(); ++i) {
    const std::string& name = data.library.terms[static_cast<size_t>(data.terms[i])].name;
    if (name == "x" || name == "v") positions.push_back(static_cast<int>(i));
  }
  std::sort(positions.begin(), positions.end());
  positions.erase(std::unique(positions.begin(), positions.end()), positions.end());
  return positions;
}

/// Anything does where there is no cost.
bool costs_less(double cost, const Likelihood& than) {
  return std::isnan(than.cost) || cost < than.cost;
}

/// Whether it is worth a search: with these terms it is likelier than what was found.
bool is_likelier(const Statement& wandering, const std::vector<int>& terms, const Likelihood& found, int num_threads) {
  constexpr int enough = 120;  // driven oscillators whose sensor was drawn to wander took 45 to 95
  const state_space::Fit fit =
      state_space::fit(wandering.problem, {.terms = terms, .num_threads = num_threads, .most_linearised = enough});
  return fit.converged() && costs_less(fit.J + found.price * static_cast<double>(terms.size() + 1), found);
}

struct Worth {
  VectorXd variance;
  double price;  ///< of a term, by which its square over its variance is weighed
};

/// No smaller than that of a regression on the same terms, positions in data.terms, and by its price, where its rows do
/// not count in full: what comes back with the state counts there once, however many rows show it. Otherwise a
/// regression knows but how noisy derivatives are.
Worth with_returns(const Worth& own, const std::vector<Index>& positions, const RangeData& data,
                   const IdentifyOptions& options) {
  if (data.evidence.as_they_are()) return own;
  const auto method = std::find_if(options.methods.begin(), options.methods.end(), weighs_rows);
  const Fit of_rows = fit_on_terms(data.evidence.data, positions, *method, options.poll);
  if (of_rows.relevant != positions) return own;
  return {own.variance.cwiseMax(of_rows.interval_covariance().diagonal()), of_rows.tau};
}

/// Where something is unexplained.
void widen(Likelihood& likelihood, const RangeData& data, const IdentifyOptions& options) {
  const VectorXd own = likelihood.covariance.diagonal();
  const Worth worth = with_returns({own, likelihood.price}, positions_in(data, likelihood.terms), data, options);
  const VectorXd by = worth.variance.cwiseQuotient(own).cwiseSqrt();
  likelihood.covariance = by.asDiagonal() * likelihood.covariance * by.asDiagonal();
}

/// Without those whose square over such a variance is below such a price, the weakest first; the others as the
/// covariance has them where one is zero. Positions in data.terms.
std::vector<int> worth_their_price(const Likelihood& likelihood, const RangeData& data,
                                   const IdentifyOptions& options) {
  std::vector<Index> positions = positions_in(data, likelihood.terms);
  VectorXd mean = likelihood.mean;
  MatrixXd covariance = likelihood.covariance;
  while (positions.size() > 1) {
    const Worth worth = with_returns({covariance.diagonal(), likelihood.price}, positions, data, options);
    Index weakest = 0;
    if (mean.cwiseAbs2().cwiseQuotient(worth.variance).minCoeff(&weakest) >= worth.price) break;
    const VectorXd column = covariance.col(weakest) / covariance(weakest, weakest);
    mean -= column * mean(weakest);
    covariance -= covariance(weakest, weakest) * column * column.transpose();
    std::vector<Index> others(positions.size());
    std::iota(others.begin(), others.end(), Index{0});
    others.erase(others.begin() + weakest), positions.erase(positions.begin() + weakest);
    mean = VectorXd(mean(others)), covariance = MatrixXd(covariance(others, others));
  }
  return as_terms(positions);
}

/// Its covariance does not know yet what comes back with the state or is missing.
Likelihood found_by(const Range& range, const RangeRows& rows, const RangeData& data,
                    const std::vector<Columns>& recordings, const IdentifyOptions& options) {
  Statement statement = statement_of(range, rows.train, rows.test.empty(), data, recordings);
  if (!statement.obstacle.empty()) return {.silent_because = statement.obstacle};
  std::vector<int> among(data.terms.size());
  std::iota(among.begin(), among.end(), 0);
  const auto select = [&](const std::vector<int>& candidates, const std::vector<int>& first) {
    return selected(statement, candidates, first, rows, data, recordings, options.num_threads);
  };
  const std::vector<int> first = first_terms(data);
  Likelihood result = select(among, first);
  if (result.is_restless && first.empty()) result = select(among, terms_of_rows(data));
  // A recorded force that is missing comes first.
  const bool may_wander =
      (!result.speaks() || result.has_unexplained()) && !(result.missing && result.missing->is_recorded);
  if (Statement wandering = may_wander ? statement : Statement{}; may_wander && let_wander(wandering.problem, 0.0)) {
    const std::vector<int> found = result.speaks()
                                       ? with_spring_and_damper(as_terms(positions_in(data, result.terms)), data)
                                   : std::isnan(result.cost) ? with_spring_and_damper(terms_of_rows(data), data)
                                   : first.empty()           ? among
                                                             : first;
    if (is_likelier(wandering, found, result, options.num_threads)) {
      std::swap(statement, wandering);
      Likelihood other = select(among, found);
      const bool explains = std::isfinite(result.cost) || !other.has_unexplained();
      if (other.speaks() && !other.wanders.empty() && costs_less(other.cost, result) && explains)
        result = std::move(other);
      else
        std::swap(statement, wandering);
    }
  }
  // With a form that explains most of the rest all of this is another fit, in which terms are worth something else.
  constexpr double most = 0.5;
  if (!result.speaks() || !result.has_unexplained() || (result.missing && result.missing->fraction > most))
    return result;
  const std::vector<int> worth = worth_their_price(result, data, options);
  if (worth.size() == result.terms.size()) return result;
  Likelihood of_worth = select(worth, worth);
  return of_worth.speaks() && of_worth.wanders.empty() == result.wanders.empty() ? of_worth : result;
}

}  // namespace

Likelihood likelihood_of(const Range& range, const RangeRows& rows, const RangeData& data,
                         const std::vector<Columns>& recordings, const IdentifyOptions& options) {
  Likelihood result = found_by(range, rows, data, recordings, options);
  if (result.speaks() && result.has_unexplained()) widen(result, data, options);
  if (result.missing) result.covariance += result.moved * result.moved.transpose();
  return result;
}

std::optional<RecordedRun> run_through(const Likelihood& likelihood, const Range& range, const std::vector<Row>& rows,
                                       const RangeData& data, const std::vector<Columns>& recordings, int num_threads) {
  Statement statement = statement_of(range, rows, true, data, recordings);
  if (!statement.obstacle.empty()) return std::nullopt;
  state_space::Problem& problem = statement.problem;
  if (!likelihood.wanders.empty())
    (void)let_wander(problem, likelihood.wanders.front().std / std::sqrt(problem.sample_rate_hz));
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
