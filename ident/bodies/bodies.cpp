#include "ident/bodies/bodies.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dsp/constants.hpp"
#include "ident/bodies/loop.hpp"
#include "ident/bodies/statement.hpp"
#include "ident/equation/percent.hpp"
#include "ident/likelihood.hpp"
#include "ident/state_space/select.hpp"
#include "ident/validate/free_run.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using std::size_t;

/// A record in a frame, and what its likelihood chose there.
struct Choice {
  BodiesRecord record;
  BodiesLayout layout = {};
  std::vector<BodyTerm> candidates = {};
  BodiesStatement statement = {};
  state_space::Selection selection = {};
  /// Nothing is left that the equations do not explain.
  [[nodiscard]] bool is_complete() const {
    return selection.fit.converged() && selection.fit.gain_of_process_noise < Likelihood::beyond_doubt;
  }
};

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
/// inputs and a spring [Wen76], then without that.
std::vector<std::vector<int>> first_terms(const BodiesLayout& layout, const std::vector<BodyTerm>& candidates) {
  constexpr int usual_of_z = 3;  // v, z|v| and |z|v stand before its others
  std::vector<int> usual, sprung, driven;
  int of_z = 0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const auto& [body, name] = candidates[i];
    const bool drives = std::find(layout.inputs.begin(), layout.inputs.end(), name) != layout.inputs.end() ||
                        (body > layout.num_bodies && of_z++ < usual_of_z);
    if (drives) driven.push_back(static_cast<int>(i));
    if (drives || name == layout.position(1)) sprung.push_back(static_cast<int>(i));
    const std::string own = layout.position(body);
    bool is_usual = drives || name == own || name == own + "^3" || name == layout.speed(body);
    for (int lower = std::max(1, body - 1); lower <= std::min(body, layout.num_bodies - 1); ++lower)
      is_usual = is_usual || name == BodiesLayout::stretch(lower) || name == BodiesLayout::stretch(lower) + "^3" ||
                 name == BodiesLayout::stretch_rate(lower);
    if (is_usual) usual.push_back(static_cast<int>(i));
  }
  if (layout.inner == Inner::none) return {usual, {}};
  return {sprung, driven};
}

Choice choose(const BodiesRecord& given, Frame frame, Inner inner, const BodiesOptions& options,
              dsp::IndexRange train) {
  Choice choice{.record = in_frame(given, frame)};
  choice.layout = {given.num_bodies, frame, choice.record.inputs, inner};
  choice.candidates = candidates_of(choice.layout, options.library);
  choice.statement = statement_of(choice.record, choice.layout, choice.candidates, {}, train, 0);
  if (choice.statement.problem.records.empty())
    throw dsp::Fault(
        dsp::FaultKind::input, "bodies.short",
        fmt::format("{}: {} samples to be fitted are too few. Record longer", given.name, train.last - train.first));
  for (const std::vector<int>& first : first_terms(choice.layout, choice.candidates)) {
    choice.selection =
        state_space::select(choice.statement.problem, {.fit = {.terms = first, .num_threads = options.num_threads}});
    if (choice.selection.fit.converged()) break;
  }
  return choice;
}

/// -2 log likelihood with the price of the terms; where there is a z, with that of its state, and with a first value in
/// each record that is of the size of its values.
double score_of(const Choice& choice) {
  const state_space::Fit& fit = choice.selection.fit;
  if (!fit.converged()) return std::numeric_limits<double>::infinity();
  double score = fit.J;
  for (const int i : fit.parameters)
    if (std::cmp_less(i, choice.candidates.size())) score += choice.selection.price;
  if (choice.layout.inner == Inner::none) return score;
  const double size = rms_of(choice, choice.layout.num_states() - 1);
  const bool moves = std::any_of(fit.parameters.begin(), fit.parameters.end(), [&](int i) {
    return std::cmp_less(i, choice.candidates.size()) &&
           choice.candidates[static_cast<size_t>(i)].body > choice.layout.num_bodies;
  });
  if (!moves || !(size > 0.0)) return std::numeric_limits<double>::infinity();
  return score + choice.selection.price + 2.0 * static_cast<double>(fit.point.states.size()) * std::log(size);
}

/// With z, where that is more likely than without by more than its price.
Choice with_memory(Choice without, const BodiesRecord& record, const BodiesOptions& options, BodiesResult& result) {
  result.sought_memory = true;
  Choice with = choose(record, without.layout.frame, options.inner, options, result.train);
  result.gain_of_memory = score_of(without) - score_of(with);
  return result.gain_of_memory > 0.0 ? std::move(with) : std::move(without);
}

/// Of the samples that may be used, from the first on.
dsp::IndexRange train_of(const BodiesRecord& record, double fraction) {
  if (record.usable.empty())
    throw dsp::Fault(dsp::FaultKind::input, "bodies.short",
                     fmt::format("{}: no sample is without a fault", record.name));
  const Index first = record.usable.front().first, last = record.usable.back().last;
  return {first, first + static_cast<Index>(fraction * static_cast<double>(last - first))};
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
  bool has_force = choice.layout.inner == Inner::none;
  const auto take_force = [&] {
    if (!std::exchange(has_force, true)) take(inner_force(), -1, -1.0, {dsp::nan, 1.0});
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
  return loop_of(model, by_sample.topRows(model.layout.num_states()), record, problem.sample_rate_hz,
                 choice.selection.fit.noise.channel.front());
}

/// From the last state that training samples gave.
BodiesRun run_behind(const Choice& choice, const BodiesModel& model, const VectorXd& noise_std, dsp::IndexRange train) {
  const BodiesRecord& record = choice.record;
  const Index begin = choice.statement.last_sample, end = record.samples.rows();
  const auto& states = choice.selection.fit.point.states.back();
  const auto num_states = static_cast<size_t>(choice.selection.fit.noise.process.size());
  const std::vector<double> state(states.end() - static_cast<std::ptrdiff_t>(num_states),
                                  states.end() - static_cast<std::ptrdiff_t>(num_states) + model.layout.num_states());
  const Index n = record.num_bodies;
  const double scale = record.samples.leftCols(n).cwiseAbs().maxCoeff();
  const Eigen::MatrixXd positions =
      run_free(model, record.input_samples.middleRows(begin, end - begin), record.sample_rate_hz, state, scale);
  BodiesRun run{.samples = {train.last, end}, .positions = positions.bottomRows(end - train.last)};
  const RunErrors errors = errors_of_run(record, run.positions, train.last, train.last);
  run.nmse = errors.nmse;
  run.noise = noise_std.head(n).cwiseAbs2().cwiseQuotient(errors.variance);
  return run;
}

std::string in_words(const BodiesRun& run, const BodiesLayout& layout) {
  std::vector<std::string> parts;
  for (Index body = 0; body < run.nmse.size(); ++body) {
    const double one = run.nmse(body);
    const std::string x = layout.named('x', static_cast<int>(body) + 1);
    parts.push_back(std::isfinite(one) ? fmt::format("{} with NMSE {:.2g}, an error of {} of its rms (noise: {})", x,
                                                     one, percent(std::sqrt(one)), percent(std::sqrt(run.noise(body))))
                                       : x + " runs away");
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

/// As for one body: 1 % of the power beyond noise describes, 10 % in part; what is there beyond doubt and not in the
/// equations takes it down.
void judge(BodiesResult& result, double sample_rate_hz) {
  const BodiesRun& run = result.run;
  double worst = 0.0;
  for (Index body = 0; body < run.nmse.size(); ++body) {
    const double beyond = run.nmse(body) - run.noise(body);
    worst = std::isfinite(beyond) ? std::max(worst, beyond) : 2.0;
  }
  result.verdict = worst <= follows           ? Verdict::describes
                   : worst <= follows_in_part ? Verdict::in_part
                                              : Verdict::does_not;
  const bool lacks = result.gain_of_process_noise > Likelihood::beyond_doubt;
  if (lacks && result.verdict == Verdict::describes) result.verdict = Verdict::in_part;
  const char* words = result.verdict == Verdict::describes ? "These equations describe the record"
                      : result.verdict == Verdict::in_part ? "These equations describe the record in part"
                                                           : "These equations do not describe the record";
  result.sentence = fmt::format(
      "{}: run free over {:.3g} s that were not fitted, {}; {}.", words,
      static_cast<double>(run.samples.last - run.samples.first) / sample_rate_hz, in_words(run, result.model.layout),
      lacks ? "the recorded samples have something that no candidate explains (odds of 20,000 and more)"
            : "the recorded samples have nothing that they do not explain");
}

}  // namespace

BodiesResult identify_bodies(const BodiesRecord& record, const BodiesOptions& options) {
  if (record.samples.rows() < least_samples)
    throw dsp::Fault(dsp::FaultKind::input, "bodies.short",
                     fmt::format("{}: {} samples are too few, want {} at least. Record longer", record.name,
                                 record.samples.rows(), least_samples));
  const dsp::IndexRange train = train_of(record, options.train_fraction);
  BodiesResult result{.train = train};
  Choice best = choose(record, record.frame.value_or(Frame::absolute), Inner::none, options, train);
  // In the wrong frame the base acts by terms that are no candidates: it is as good as impossible that nothing is left.
  if (!record.frame && !best.is_complete())
    if (Choice other = choose(record, Frame::base, Inner::none, options, train);
        other.is_complete() || !best.selection.fit.converged())
      best = std::move(other);
  if (options.inner != Inner::none) best = with_memory(std::move(best), record, options, result);
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
  result.modes = modes_of(result.model.layout, result.model.terms, result.model.mean, result.model.covariance);
  result.couplings = couplings_of(result.model.layout, result.model.terms, result.model.mean, result.model.covariance);
  if (result.model.layout.inner != Inner::none) result.loop = longest_loop(best, result.model);
  result.run = run_behind(best, result.model, result.noise_std, train);
  judge(result, record.sample_rate_hz);
  return result;
}

}  // namespace ident
