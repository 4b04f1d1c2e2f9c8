#include "ident/bodies/bodies.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "dsp/values/constants.hpp"
#include "ident/bodies/choice.hpp"
#include "ident/bodies/loop.hpp"
#include "ident/bodies/statement.hpp"
#include "ident/equation/percent.hpp"
#include "ident/state_space/select.hpp"
#include "ident/state_space/start.hpp"
#include "ident/validate/free_run.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using std::size_t;

/// Of one state of a fit, over all records.
double rms_of(const Choice& choice, int state) {
  const state_space::Fit& fit = choice.selection.fit;
  const auto num_states = static_cast<Index>(fit.noise.process.size());
  double sum = 0.0, count = 0.0;
  for (const std::vector<double>& record : fit.point.states)
    for (Index at = state; at < std::ssize(record); at += num_states, ++count)
      sum += record[static_cast<size_t>(at)] * record[static_cast<size_t>(at)];
  return std::sqrt(sum / count);
}

/// Where a search for terms begins, and takes up what else there is: what springs and dampers are made of, then every
/// candidate, none of which are named. With a z, whose terms are not linear in it, from less: a hysteretic force beside
/// inputs and a spring [Wen76], then without that; with z itself, by which fades what soft steps have gathered in it.
std::vector<std::vector<int>> first_terms(const BodiesLayout& layout, const std::vector<BodyTerm>& candidates) {
  constexpr int usual_of_z = 3;  // v, z|v| and |z|v stand before its others
  std::vector<int> usual, sprung, driven;
  int of_z = 0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const auto& [body, name] = candidates[i];
    const bool drives = std::find(layout.inputs.begin(), layout.inputs.end(), name) != layout.inputs.end() ||
                        name == "z" || (body > layout.num_bodies && of_z++ < usual_of_z);
    if (drives) driven.push_back(static_cast<int>(i));
    if (drives || name == layout.position(1)) sprung.push_back(static_cast<int>(i));
    const std::string own = layout.position(body);
    bool is_usual = drives || name == own || name == own + "^3" || name == layout.speed(body);
    for (int lower = std::max(1, body - 1); lower <= std::min(body, layout.num_bodies - 1); ++lower)
      is_usual = is_usual || name == BodiesLayout::stretch(lower) || name == BodiesLayout::stretch(lower) + "^3" ||
                 name == BodiesLayout::stretch_rate(lower);
    if (is_usual) usual.push_back(static_cast<int>(i));
  }
  if (layout.inner == Inner::hysteresis) return {sprung, driven};
  return {usual, {}};
}

/// What a search with an inner state begins with.
struct InnerStart {
  Inner inner = Inner::none;
  std::string lagging = {};
  double lag_s = 0.0;
};

/// An input as an actuator of first order passes it on, from where it is at first.
VectorXd lagged(const VectorXd& input, double sample_rate_hz, double lag_s) {
  const double stays = std::exp(-1.0 / (sample_rate_hz * lag_s));
  VectorXd z = input;
  for (Index k = 1; k < z.size(); ++k) z(k) = stays * z(k - 1) + (1.0 - stays) * 0.5 * (input(k - 1) + input(k));
  return z;
}

/// Of each record, where an input lags z; where the sensor of x does, x and v as they are from what it shows, and that.
std::vector<Eigen::MatrixXd> first_states(const Choice& choice, const InnerStart& start) {
  const state_space::Problem& problem = choice.statement.problem;
  const double rate_hz = problem.sample_rate_hz;
  const std::vector<std::string>& inputs = choice.layout.inputs;
  const Index of_lagging = std::find(inputs.begin(), inputs.end(), start.lagging) - inputs.begin();
  const double noise_std = state_space::noise_floors(problem).front();
  std::vector<Eigen::MatrixXd> states;
  for (const state_space::Record& record : problem.records) {
    if (!choice.layout.sensor_lags()) {
      states.emplace_back(lagged(record.inputs.col(of_lagging), rate_hz, start.lag_s));
      continue;
    }
    const VectorXd shown = state_space::filled(record.channels.col(0));
    const double to_hz = state_space::cutoff_hz(shown, rate_hz, noise_std);
    const auto rate_of = [&](int order) { return derived(shown, rate_hz, order, to_hz); };
    states.emplace_back(shown.size(), 3);
    states.back() << rate_of(0) + start.lag_s * rate_of(1), rate_of(1) + start.lag_s * rate_of(2), rate_of(0);
  }
  return states;
}

Choice choose(const BodiesRecord& given, Frame frame, const InnerStart& start, const BodiesOptions& options,
              const std::vector<dsp::IndexRange>& train) {
  Choice choice{.record = in_frame(given, frame)};
  choice.layout = {given.num_bodies, frame, choice.record.inputs, start.inner, start.lagging};
  choice.candidates = candidates_of(choice.layout, options.library);
  choice.statement = statement_of(choice.record, choice.layout, choice.candidates, {}, train, 0);
  if (choice.statement.problem.records.empty())
    throw dsp::Fault(
        dsp::FaultKind::input, "bodies.short",
        fmt::format("{}: {} samples to be fitted are too few. Record longer", given.name,
                    std::accumulate(train.begin(), train.end(), Index{0},
                                    [](Index sum, const dsp::IndexRange& one) { return sum + one.last - one.first; })));
  for (size_t part = 0; part < train.size(); ++part)
    if (std::none_of(choice.statement.origins.begin(), choice.statement.origins.end(),
                     [&](const BodiesStatement::Origin& one) { return one.range == part; }))
      throw dsp::Fault(
          dsp::FaultKind::input, "bodies.short",
          fmt::format("{}: {} samples to be fitted are too few beside the other recordings. Leave this one "
                      "out, or record longer",
                      given.parts[part].name, train[part].last - train[part].first));
  state_space::SelectOptions search{.fit = {.num_threads = options.num_threads}};
  if (start.inner == Inner::lag) search.fit.last_states = first_states(choice, start);
  for (const std::vector<int>& first : first_terms(choice.layout, choice.candidates)) {
    search.fit.terms = first;
    choice.selection = state_space::select(choice.statement.problem, search);
    if (choice.selection.fit.converged()) break;
  }
  return choice;
}

/// Selected, of all equations.
std::ptrdiff_t num_terms(const Choice& choice) {
  const std::vector<int>& parameters = choice.selection.fit.parameters;
  return std::count_if(parameters.begin(), parameters.end(),
                       [&](int i) { return std::cmp_less(i, choice.candidates.size()); });
}

/// -2 log likelihood with the price of the terms; where there is a z, with that of its state, and with a first value in
/// each record that is of the size of its values.
double score_of(const Choice& choice) {
  const state_space::Fit& fit = choice.selection.fit;
  if (!fit.converged()) return std::numeric_limits<double>::infinity();
  const double score = fit.J + choice.selection.price * static_cast<double>(num_terms(choice));
  if (choice.layout.inner == Inner::none) return score;
  const double size = rms_of(choice, choice.layout.num_states() - 1);
  const bool moves = std::any_of(fit.parameters.begin(), fit.parameters.end(), [&](int i) {
    return std::cmp_less(i, choice.candidates.size()) &&
           choice.candidates[static_cast<size_t>(i)].body > choice.layout.num_bodies &&
           (choice.layout.inner != Inner::lag || fit.point.parameters[static_cast<size_t>(i)] > 0.0);
  });
  if (!moves || !(size > 0.0)) return std::numeric_limits<double>::infinity();
  return score + choice.selection.price + 2.0 * static_cast<double>(fit.point.states.size()) * std::log(size);
}

/// Inputs that are candidates by themselves.
std::vector<std::string> inputs_that_may_lag(const BodiesLayout& layout, const BodyLibrary& library) {
  const std::vector<BodyTerm> candidates = candidates_of(layout, library);
  std::vector<std::string> inputs = layout.inputs;
  std::erase_if(inputs, [&](const std::string& input) {
    return std::find(candidates.begin(), candidates.end(), BodyTerm{1, input}) == candidates.end();
  });
  return inputs;
}

void require_input(const BodiesRecord& record) {
  const Frame frame = record.frame.value_or(Frame::absolute);
  if (in_frame(record, frame).inputs.empty())
    throw dsp::Fault(
        dsp::FaultKind::input, "bodies.lag",
        fmt::format("{}: [library] inner = \"lag\" is of a recorded force, or of the sensor under one or on a moving "
                    "base, and there is neither. Give the channel of the force role = \"f\", or leave `inner` out",
                    record.name));
}

/// Lags to begin with: a period of the motion over 2 pi, a third of it and three times as long.
std::vector<double> lags_of(const Choice& without) {
  const state_space::Problem& problem = without.statement.problem;
  const Eigen::MatrixXd& channels =
      std::max_element(problem.records.begin(), problem.records.end(), [](const auto& a, const auto& b) {
        return a.channels.rows() < b.channels.rows();
      })->channels;
  VectorXd x = channels.col(0).unaryExpr([](double value) { return std::isfinite(value) ? value : 0.0; });
  x.array() -= x.mean();
  const double rate_hz = problem.sample_rate_hz,
               to_hz = state_space::cutoff_hz(x, rate_hz, without.selection.fit.floors.front()),
               rad_s = derived(x, rate_hz, 1, to_hz).norm() / x.norm();
  // Where nothing is left that a lag could explain, one start is enough.
  if (without.is_complete()) return {1.0 / rad_s};
  return {1.0 / rad_s, 0.3 / rad_s, 3.0 / rad_s};
}

/// Of every input until one leaves nothing unexplained, then of the sensor of x, for which more terms can stand in:
/// what explains by no more than the input, a damper and a spring of two terms leaves little for it.
Choice with_lag(const Choice& without, const BodiesRecord& record, const BodiesOptions& options,
                const BodiesResult& result) {
  constexpr std::ptrdiff_t few_terms = 5;  // that of z among them
  const std::vector<double> lags = lags_of(without);
  std::optional<Choice> best;
  bool explains = false;
  const auto try_each = [&](const std::string& late, const std::vector<double>& lags_s) {
    explains = false;
    for (size_t i = 0; i < lags_s.size() && !explains; ++i) {
      Choice with = choose(record, without.layout.frame, {Inner::lag, late, lags_s[i]}, options, result.train);
      explains = with.is_complete() && std::isfinite(score_of(with));
      if (!best || score_of(with) < score_of(*best) || !best->selection.fit.converged()) best = std::move(with);
    }
  };
  for (const std::string& input : inputs_that_may_lag(without.layout, options.library))
    if (!explains) try_each(input, lags);
  if (explains && num_terms(*best) <= few_terms) return std::move(*best);
  const double found_rate = explains ? best->selection.fit.point.parameters[best->candidates.size() - 1] : 0.0;
  try_each(without.layout.named('x', 1), explains ? std::vector{1.0 / found_rate} : lags);
  return std::move(*best);
}

/// With z, where that is more likely than without by more than its price.
Choice with_inner(Choice without, const BodiesRecord& record, const BodiesOptions& options, BodiesResult& result) {
  result.sought = options.inner;
  Choice with = options.inner == Inner::lag
                    ? with_lag(without, record, options, result)
                    : choose(record, without.layout.frame, {options.inner}, options, result.train);
  result.gain_of_inner = score_of(without) - score_of(with);
  if (!with.selection.fit.converged()) result.gain_of_inner = dsp::nan;
  return result.gain_of_inner > 0.0 ? std::move(with) : std::move(without);
}

/// Of the samples of each part that may be used, from the first on.
std::vector<dsp::IndexRange> train_of(const BodiesRecord& record, double fraction) {
  if (record.usable.empty())
    throw dsp::Fault(dsp::FaultKind::input, "bodies.short",
                     fmt::format("{}: no sample is without a fault", record.name));
  std::vector<dsp::IndexRange> train;
  for (const BodiesPart& part : record.parts) {
    Index first = part.rows.last, last = part.rows.first;
    for (const dsp::IndexRange& usable : record.usable)
      if (part.holds(usable)) first = std::min(first, usable.first), last = std::max(last, usable.last);
    train.push_back(
        {first, first + static_cast<Index>(fraction * static_cast<double>(std::max<Index>(last - first, 0)))});
  }
  return train;
}

void take_terms(BodiesResult& result, const Choice& choice) {
  const state_space::Fit& fit = choice.selection.fit;
  const bool lacks = fit.gain_of_process_noise > Likelihood::beyond_doubt;
  const std::vector<double> covariance = lacks ? fit.wider() : fit.covariance;
  BodiesModel& model = result.model;
  model.layout = choice.layout;
  std::vector<Index> places;  // among the parameters of the fit; -1: known
  std::vector<double> mean;
  std::vector<unsigned char> taken(choice.candidates.size(), 0);
  const auto take = [&](const BodyTerm& term, Index place, double value, const state_space::Score& score) {
    places.push_back(place), mean.push_back(value);
    model.terms.push_back(term);
    result.gain.push_back(score.gain), result.probability.push_back(score.probability);
  };
  bool has_force = choice.layout.inner != Inner::hysteresis;
  const auto take_force = [&] {
    if (!std::exchange(has_force, true))
      take(inner_force(), -1, inner_force_coefficient(model.layout), {dsp::nan, 1.0});
  };
  for (size_t i = 0; i < fit.parameters.size(); ++i) {
    const auto term = static_cast<size_t>(fit.parameters[i]);
    if (term >= choice.candidates.size()) continue;
    if (choice.candidates[term].body > choice.layout.num_bodies) take_force();  // behind those of its body
    taken[term] = 1;
    take(choice.candidates[term], static_cast<Index>(i), fit.point.parameters[term], choice.selection.scores[term]);
  }
  take_force();
  const auto k = std::ssize(places);
  model.mean = VectorXd::Map(mean.data(), k);
  model.covariance = Eigen::MatrixXd::Zero(k, k);
  for (Index i = 0; i < k; ++i)
    for (Index j = 0; j < k; ++j) {
      const Index a = places[static_cast<size_t>(i)], b = places[static_cast<size_t>(j)];
      if (a >= 0 && b >= 0)
        model.covariance(i, j) = covariance[static_cast<size_t>(a * std::ssize(fit.parameters) + b)];
    }
  for (size_t i = 0; i < taken.size(); ++i)
    if (taken[i] == 0) result.rejected.push_back(choice.candidates[i]);
}

/// The last coefficient is its reciprocal.
void take_lag(BodiesResult& result) {
  const Index last = result.model.mean.size() - 1;
  const double rate = result.model.mean(last);
  result.lag_s = 1.0 / rate, result.lag_std_s = result.model.std(last) / (rate * rate);
}

/// The longest of the fitted pieces.
Loop longest_loop(const Choice& choice, const BodiesModel& model) {
  const state_space::Problem& problem = choice.statement.problem;
  size_t longest = 0;
  for (size_t r = 0; r < problem.records.size(); ++r)
    if (problem.records[r].channels.rows() > problem.records[longest].channels.rows()) longest = r;
  const state_space::Record& record = problem.records[longest];
  const std::vector<double>& states = choice.selection.fit.point.states[longest];
  const auto num_states = static_cast<Index>(choice.selection.fit.noise.process.size());
  const Eigen::MatrixXd by_sample =
      Eigen::Map<const Eigen::MatrixXd>(states.data(), num_states, record.channels.rows());
  if (model.layout.imposed) {
    const auto x = std::find(model.layout.inputs.begin(), model.layout.inputs.end(), "x") - model.layout.inputs.begin();
    const std::vector<double> first(states.begin(), states.begin() + num_states);
    const Eigen::MatrixXd run = run_free(model, record.inputs, problem.sample_rate_hz, first, 1.0, record.begin_s);
    return {problem.sample_rate_hz, record.inputs.col(x),
            responses_of(model, run, record.inputs, problem.sample_rate_hz, record.begin_s).col(0),
            record.channels.col(0)};
  }
  return loop_of(model, by_sample.topRows(model.layout.num_states()), record, problem.sample_rate_hz,
                 choice.selection.fit.noise.channel.front());
}

/// Of a part, from the last state that its training samples gave; nothing where there is none, or nothing behind it.
std::optional<BodiesRun> run_behind(const Choice& choice, const BodiesModel& model, size_t part, Index behind) {
  const BodiesRecord& record = choice.record;
  const std::vector<BodiesStatement::Origin>& origins = choice.statement.origins;
  const auto last = std::find_if(origins.rbegin(), origins.rend(),
                                 [&](const BodiesStatement::Origin& one) { return one.range == part; });
  const Index end = record.parts[part].rows.last;
  if (last == origins.rend() || behind >= end) return std::nullopt;
  const Index begin = last->last_sample;
  const auto& states = choice.selection.fit.point.states[static_cast<size_t>(origins.rend() - last) - 1];
  const auto num_states = static_cast<size_t>(choice.selection.fit.noise.process.size());
  const std::vector<double> state(states.end() - static_cast<std::ptrdiff_t>(num_states),
                                  states.end() - static_cast<std::ptrdiff_t>(num_states) + model.layout.num_states());
  const Index n = record.num_bodies;
  const double scale = record.samples.leftCols(n).cwiseAbs().maxCoeff();
  const double begin_s = static_cast<double>(begin - record.parts[part].rows.first) / record.sample_rate_hz;
  const Eigen::MatrixXd inputs = record.input_samples.middleRows(begin, end - begin),
                        run_states = run_free(model, inputs, record.sample_rate_hz, state, scale, begin_s);
  BodiesRun run{.part = part, .samples = {behind, end}};
  const VectorXd first = run_states.row(behind - begin);
  run.state.assign(first.begin(), first.end());
  run.positions = responses_of(model, run_states, inputs, record.sample_rate_hz, begin_s).bottomRows(end - behind);
  run.errors = errors_of_run(record, run.positions, behind, behind);
  return run;
}

/// Of all parts together.
void run_all(BodiesResult& result, const Choice& choice) {
  const Index n = choice.record.num_bodies;
  VectorXd missed = VectorXd::Zero(n), squares = VectorXd::Zero(n), counts = VectorXd::Zero(n);
  for (size_t part = 0; part < choice.record.parts.size(); ++part) {
    std::optional<BodiesRun> run = run_behind(choice, result.model, part, result.train[part].last);
    if (!run || run->errors.count == 0.0) continue;
    for (Index body = 0; body < n; ++body) {
      const double nmse = run->errors.nmse(body);
      if (!std::isfinite(nmse) && run->positions.col(body).allFinite()) continue;  // it stands still
      missed(body) += nmse * run->errors.squares(body), squares(body) += run->errors.squares(body);
      counts(body) += run->errors.count;
    }
    result.runs.push_back(std::move(*run));
  }
  result.run_nmse = missed.cwiseQuotient(squares);
  result.run_noise = counts.cwiseProduct(result.noise_std.head(n).cwiseAbs2()).cwiseQuotient(squares);
}

std::string in_words(const BodiesResult& result) {
  std::vector<std::string> parts;
  for (Index body = 0; body < result.run_nmse.size(); ++body) {
    const double one = result.run_nmse(body);
    const std::string x = result.model.layout.response(static_cast<int>(body) + 1);
    parts.push_back(std::isfinite(one)
                        ? fmt::format("{} with NMSE {:.2g}, an error of {} of its rms (noise: {})", x, one,
                                      percent(std::sqrt(one)), percent(std::sqrt(result.run_noise(body))))
                        : x + " runs away");
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

/// Of the power; NaN where a body stands still, 2 where it runs away.
double error_beyond_noise(const BodiesRun& run, Index body, double noise_std) {
  if (!run.positions.col(body).allFinite()) return 2.0;
  return run.errors.nmse(body) - run.errors.count * noise_std * noise_std / run.errors.squares(body);
}

/// As for one body: 1 % of the power beyond noise describes, 10 % in part; what is there beyond doubt and not in the
/// equations takes it down.
void judge(BodiesResult& result, const BodiesRecord& record) {
  const bool lacks = result.gain_of_process_noise > Likelihood::beyond_doubt;
  const char* left_over =
      lacks ? "the recorded samples have something that no candidate explains (odds of 20,000 and more)"
            : "the recorded samples have nothing that they do not explain";
  if (result.runs.empty()) {
    result.sentence = fmt::format("Nothing was left to run these equations over; {}.", left_over);
    return;
  }
  double worst = -std::numeric_limits<double>::infinity(), samples = 0.0;
  const BodiesRun* worst_run = nullptr;
  for (const BodiesRun& run : result.runs) {
    samples += static_cast<double>(run.samples.last - run.samples.first);
    for (Index body = 0; body < run.errors.nmse.size(); ++body)
      if (const double beyond = error_beyond_noise(run, body, result.noise_std(body)); beyond > worst)
        worst = beyond, worst_run = &run;
  }
  if (worst_run == nullptr) {
    result.sentence = fmt::format("Nothing moves where these equations could be run; {}.", left_over);
    return;
  }
  result.verdict = worst <= follows           ? Verdict::describes
                   : worst <= follows_in_part ? Verdict::in_part
                                              : Verdict::does_not;
  if (lacks && result.verdict == Verdict::describes) result.verdict = Verdict::in_part;
  const char* words = result.verdict == Verdict::describes ? "These equations describe the record"
                      : result.verdict == Verdict::in_part ? "These equations describe the record in part"
                                                           : "These equations do not describe the record";
  const std::string followed_least =
      record.parts.size() > 1 ? fmt::format("; least follows {}", record.parts[worst_run->part].name) : "";
  result.sentence = fmt::format("{}: run free over {:.3g} s that were not fitted, {}{}; {}.", words,
                                samples / record.sample_rate_hz, in_words(result), followed_least, left_over);
}

}  // namespace

BodiesResult identify_bodies(const BodiesRecord& record, const BodiesOptions& options) {
  if (record.samples.rows() < least_samples)
    throw dsp::Fault(dsp::FaultKind::input, "bodies.short",
                     fmt::format("{}: {} samples are too few, want {} at least. Record longer", record.name,
                                 record.samples.rows(), least_samples));
  if (options.inner == Inner::lag && !record.imposed) require_input(record);
  const std::vector<dsp::IndexRange> train = train_of(record, options.train_fraction);
  BodiesResult result{.train = train};
  Choice best = record.imposed ? choose_force(record, options, result)
                               : choose(record, record.frame.value_or(Frame::absolute), {}, options, train);
  // In the wrong frame the base acts by terms that are no candidates: it is as good as impossible that nothing is left.
  if (!record.frame && !best.is_complete())
    if (Choice other = choose(record, Frame::base, {}, options, train);
        other.is_complete() || !best.selection.fit.converged())
      best = std::move(other);
  if (options.inner != Inner::none && !record.imposed) best = with_inner(std::move(best), record, options, result);
  result.frame_was_open = !record.frame;
  const state_space::Fit& fit = best.selection.fit;
  result.model.layout = best.layout;
  result.noise_std =
      std::sqrt(best.statement.thinned_by) * VectorXd::Map(fit.noise.channel.data(), std::ssize(record.channels));
  result.gain_of_process_noise = fit.gain_of_process_noise;
  result.thinned_by = best.statement.thinned_by;
  for (const state_space::Record& one : best.statement.problem.records)
    result.num_samples += result.thinned_by * static_cast<double>(one.channels.size());
  if (!fit.converged()) {
    result.silent_because = best.selection.hopeless ? "with all candidates the fit stays far above the noise"
                            : fit.settled           ? "the fit did not come down to the noise of the channels"
                                                    : "the fit did not come to rest";
    return result;
  }
  take_terms(result, best);
  if (result.model.terms.empty()) {
    result.silent_because = "no candidate is more than noise";
    return result;
  }
  if (!record.imposed)
    result.modes = modes_of(result.model.layout, result.model.terms, result.model.mean, result.model.covariance);
  result.couplings = couplings_of(result.model.layout, result.model.terms, result.model.mean, result.model.covariance);
  if (result.model.layout.inner == Inner::hysteresis) result.loop = longest_loop(best, result.model);
  if (result.model.layout.inner == Inner::lag) take_lag(result);
  run_all(result, best);
  judge(result, record);
  return result;
}

}  // namespace ident
