#include "ident/bodies/bodies.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dsp/constants.hpp"
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

/// What springs and dampers are made of: a search from there is short, and takes up what else there is.
std::vector<int> first_terms(const BodiesLayout& layout, const std::vector<BodyTerm>& candidates) {
  std::vector<int> first;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const auto& [body, name] = candidates[i];
    const std::string own = layout.position(body);
    const bool is_input = std::find(layout.inputs.begin(), layout.inputs.end(), name) != layout.inputs.end();
    bool is_usual = is_input || name == own || name == own + "^3" || name == layout.speed(body);
    for (int lower = std::max(1, body - 1); lower <= std::min(body, layout.num_bodies - 1); ++lower)
      is_usual = is_usual || name == BodiesLayout::stretch(lower) || name == BodiesLayout::stretch(lower) + "^3" ||
                 name == BodiesLayout::stretch_rate(lower);
    if (is_usual) first.push_back(static_cast<int>(i));
  }
  return first;
}

Choice choose(const BodiesRecord& given, Frame frame, const BodiesOptions& options, dsp::IndexRange train) {
  Choice choice{.record = in_frame(given, frame)};
  choice.layout = {given.num_bodies, frame, choice.record.inputs};
  choice.candidates = candidates_of(choice.layout, options.library);
  choice.statement = statement_of(choice.record, choice.candidates, {}, train, 0);
  if (choice.statement.problem.records.empty())
    throw dsp::Fault(
        dsp::FaultKind::input, "bodies.short",
        fmt::format("{}: {} samples to be fitted are too few. Record longer", given.name, train.last - train.first));
  const auto select = [&](const std::vector<int>& first) {
    return state_space::select(choice.statement.problem, {.fit = {.terms = first, .num_threads = options.num_threads}});
  };
  choice.selection = select(first_terms(choice.layout, choice.candidates));
  if (!choice.selection.fit.converged()) choice.selection = select({});
  return choice;
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
  std::vector<size_t> places;
  for (size_t i = 0; i < fit.parameters.size(); ++i)
    if (std::cmp_less(fit.parameters[i], choice.candidates.size())) places.push_back(i);
  const bool lacks = fit.gain_of_process_noise > Likelihood::beyond_doubt;
  const std::vector<double> covariance = lacks ? fit.wider() : fit.covariance;
  BodiesModel& model = result.model;
  model.layout = choice.layout;
  const auto k = std::ssize(places);
  model.mean.resize(k), model.covariance.resize(k, k);
  std::vector<unsigned char> taken(choice.candidates.size(), 0);
  for (Index i = 0; i < k; ++i) {
    const size_t at = places[static_cast<size_t>(i)];
    const auto term = static_cast<size_t>(fit.parameters[at]);
    taken[term] = 1;
    model.terms.push_back(choice.candidates[term]);
    model.mean(i) = fit.point.parameters[term];
    result.gain.push_back(choice.selection.scores[term].gain);
    result.probability.push_back(choice.selection.scores[term].probability);
    for (Index j = 0; j < k; ++j)
      model.covariance(i, j) = covariance[at * fit.parameters.size() + places[static_cast<size_t>(j)]];
  }
  for (size_t i = 0; i < taken.size(); ++i)
    if (taken[i] == 0) result.rejected.push_back(choice.candidates[i]);
}

/// From the last state that training samples gave.
BodiesRun run_behind(const Choice& choice, const BodiesModel& model, const VectorXd& noise_std, dsp::IndexRange train) {
  const BodiesRecord& record = choice.record;
  const Index begin = choice.statement.last_sample, end = record.samples.rows();
  const auto& states = choice.selection.fit.point.states.back();
  const auto num_states = static_cast<size_t>(choice.selection.fit.noise.process.size());
  const std::vector<double> state(states.end() - static_cast<std::ptrdiff_t>(num_states),
                                  states.end() - static_cast<std::ptrdiff_t>(num_states) + 2 * record.num_bodies);
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

std::string in_words(const BodiesRun& run) {
  std::vector<std::string> parts;
  for (Index body = 0; body < run.nmse.size(); ++body) {
    const double one = run.nmse(body);
    parts.push_back(std::isfinite(one)
                        ? fmt::format("x{} with NMSE {:.2g}, an error of {} of its rms (noise: {})", body + 1, one,
                                      percent(std::sqrt(one)), percent(std::sqrt(run.noise(body))))
                        : fmt::format("x{} runs away", body + 1));
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
  result.sentence =
      fmt::format("{}: run free over {:.3g} s that were not fitted, {}; {}.", words,
                  static_cast<double>(run.samples.last - run.samples.first) / sample_rate_hz, in_words(run),
                  lacks ? "the recorded samples have something that no candidate explains (odds of 20,000 and more)"
                        : "the recorded samples have nothing that they do not explain");
}

}  // namespace

BodiesResult identify_bodies(const BodiesRecord& record, const BodiesOptions& options) {
  const dsp::IndexRange train = train_of(record, options.train_fraction);
  BodiesResult result{.train = train};
  Choice best = choose(record, record.frame.value_or(Frame::absolute), options, train);
  // In the wrong frame the base acts by terms that are no candidates: it is as good as impossible that nothing is left.
  if (!record.frame && !best.is_complete())
    if (Choice other = choose(record, Frame::base, options, train);
        other.is_complete() || !best.selection.fit.converged())
      best = std::move(other);
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
  result.run = run_behind(best, result.model, result.noise_std, train);
  judge(result, record.sample_rate_hz);
  return result;
}

}  // namespace ident
