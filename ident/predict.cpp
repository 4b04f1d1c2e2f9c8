#include "ident/validate/predict.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dsp/filter/strongest_line.hpp"
#include "dsp/values/constants.hpp"
#include "ident/equation/percent.hpp"
#include "ident/identify.hpp"
#include "ident/library/library.hpp"
#include "ident/regression/methods.hpp"
#include "ident/sensors/channel_noise.hpp"
#include "ident/validate/free_run.hpp"
#include "ident/validate/metrics.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

using dsp::nan;

/// Every sample that may be used.
Course whole_course(const dsp::Motion& motion) {
  const Index n = motion.num_samples();
  Course course{&motion, {}, std::vector<unsigned char>(static_cast<std::size_t>(n), 0)};
  Index previous = -2;
  for (Index i = motion.edge_samples; i < n - motion.edge_samples; ++i) {
    if (!motion.excluded.empty() && motion.excluded[static_cast<std::size_t>(i)] != 0) continue;
    if (i != previous + 1) course.ranges.push_back({i, i});
    course.ranges.back().last = i + 1;
    course.scored[static_cast<std::size_t>(i)] = 1;
    previous = i;
  }
  return course;
}

struct Errors {
  Figure nmse, rms;
};

/// Over the samples with a prediction, whose measured values are `x`.
Errors errors_of(const VectorXd& x, const VectorXd& predicted, const std::string& reason) {
  std::vector<Index> there;
  for (Index i = 0; i < predicted.size(); ++i)
    if (std::isfinite(predicted(i))) there.push_back(i);
  if (!reason.empty() || there.empty()) {
    const Figure none{nan, reason.empty() ? "nothing was run" : reason};
    return {none, none};
  }
  const VectorXd measured = x(there), run = predicted(there);
  const double nmse = nmse_centred(run, measured);
  const double rms = (run - measured).stableNorm() / std::sqrt(static_cast<double>(there.size()));
  return {std::isfinite(nmse) ? Figure{nmse, {}} : Figure{nan, "x does not move"}, {rms, {}}};
}

/// The payload at rest in space, as far as the base's motion tells; x itself at rest where there is no base.
VectorXd still_body(const dsp::Motion& motion, const VectorXd& predicted) {
  VectorXd still = motion.find("r") != nullptr ? (-motion.at("r").array() + motion.at("r").mean()).matrix().eval()
                                               : VectorXd::Zero(predicted.size()).eval();
  for (Index i = 0; i < still.size(); ++i)
    if (!std::isfinite(predicted(i))) still(i) = nan;
  return still;
}

/// Fits the equation's own terms to the recording.
std::vector<CarryOver> carried_over(const Model& model, const Record& record, const PredictOptions& options) {
  LibraryOptions terms{.order = 0};
  for (const ModelTerm& term : model.terms) terms.terms.push_back(term.name);
  // A zero that is off by little beside its motion is a constant beside the terms.
  if (std::find(terms.terms.begin(), terms.terms.end(), "1") == terms.terms.end()) terms.terms.emplace_back("1");
  const CandidateLibrary library = record_library(terms, model.target, record.prepared);
  std::vector<Columns> columns;
  columns.push_back(record_columns(library, model.target, record, dsp::StreamOptions{}.max_memory_bytes, options.poll));
  Range all;
  all.recording = 1;
  all.spec.name = record.prepared.name;
  all.spec.where = options.where;
  all.spec.place = record.prepared.name;
  all.train_fraction = 1.0;
  const RangeResult result = identify(all, columns, library,
                                      {.target = model.target,
                                       .target_unit = model.target_unit,
                                       .methods = {FastRvmOptions{}},
                                       .num_threads = options.num_threads,
                                       .free_run = false,
                                       .poll = options.poll});
  std::vector<CarryOver> coefficients;
  for (const ModelTerm& term : model.terms) {
    CarryOver one{term.name, term.mean, term.std, nan, nan, {}};
    for (const ModelTerm& here : result.fits.front().model.terms) {
      if (here.name != term.name) continue;
      one.here = here.mean, one.here_std = here.std;
      constexpr double apart = 3.0;  // standard deviations
      const double std = std::hypot(one.here_std, one.identified_std);
      if (std::isfinite(std)) one.carries = std::abs(one.here - one.identified) <= apart * std;
    }
    coefficients.push_back(std::move(one));
  }
  return coefficients;
}

/// The number (1-based) of a recording among those the equation was fitted to; 0: it is another.
int number_of(const Model& model, const std::string& fitted_as) {
  for (const ModelTerm& term : model.terms)
    if (term.recording > 0 && term.recording_name == fitted_as) return term.recording;
  return 0;
}

Model equation_for(const Model& model, const std::string& fitted_as) {
  return equation_of(model, number_of(model, fitted_as));
}

/// The shift of x with which the equation's target is closest to the recorded one on these samples, by Gauss and
/// Newton, and its standard deviation by the residual as if it were white.
struct Shift {
  double value = 0.0, std = 0.0;
};
Shift closest_shift(const Model& model, const dsp::Motion& motion, const std::vector<Index>& samples) {
  constexpr int most_steps = 8;        // a step is exact where the terms are of first degree in x
  constexpr double small_step = 1e-3;  // of a standard deviation
  Shift shift;
  for (int step = 0; step < most_steps; ++step) {
    const dsp::Motion moved = in_coordinates(motion, shift.value, 0.0);
    VectorXd residual = motion.at(model.target)(samples), slope = VectorXd::Zero(residual.size());
    for (const ModelTerm& term : model.terms) {
      const Expression expression(term.name);
      residual -= term.mean * expression.evaluate(moved)(samples);
      slope += term.mean * expression.derivative("x").evaluate(moved)(samples);
    }
    const double curvature = slope.squaredNorm();
    if (!(curvature > 0.0) || !residual.allFinite()) return {};
    const double by = -slope.dot(residual) / curvature;
    shift.value += by;
    shift.std = residual.stableNorm() / std::sqrt(static_cast<double>(residual.size()) * curvature);
    if (std::abs(by) <= small_step * shift.std) break;
  }
  return shift;
}

/// Of the recording: as the equation has them where it was fitted to it; else f as there, and a zero of its own.
Coordinates coordinates_for(const Model& model, const Record& record, const Course& course,
                            const std::string& fitted_as) {
  const dsp::Signal* x = record.prepared.signals.find("x");
  Coordinates result{.recording = record.prepared.name,
                     .of = record.prepared.x_is_difference ? "y - r" : "the displacement",
                     .unit = x == nullptr ? "" : x->unit,
                     .zero = record.zero,
                     .prepared_zero = record.zero};
  if (model.coordinates.empty()) return result;
  const auto own = std::find_if(model.coordinates.begin(), model.coordinates.end(),
                                [&](const Coordinates& one) { return one.recording == fitted_as; });
  if (own != model.coordinates.end()) {
    result = *own;
    result.prepared_zero = record.zero;
    return result;
  }
  result.lead_s = model.coordinates.front().lead_s, result.lead_std_s = model.coordinates.front().lead_std_s;
  if (record.zero_is_known) return result;
  std::vector<Index> samples;
  for (const dsp::IndexRange& range : course.ranges)
    for (Index i = range.first; i < range.last; ++i) samples.push_back(i);
  const Shift shift = closest_shift(model, in_coordinates(record.prepared.signals, 0.0, result.lead_s), samples);
  result.zero += shift.value, result.zero_std = shift.std;
  return result;
}

/// A sentence where the samples that are run through are beyond those of the fit. Of two records of one motion either
/// has the greatest value, by a few samples: only more than those count.
std::string beyond_the_fit(const Model& model, const dsp::Motion& motion, const Course& course) {
  constexpr double few = 0.01;
  std::vector<std::string> parts;
  for (const Extent& extent : model.extents) {
    const dsp::Signal* signal = motion.find(extent.signal);
    if (signal == nullptr) continue;
    double lowest = extent.lowest, highest = extent.highest, count = 0.0, beyond = 0.0;
    for (const dsp::IndexRange& range : course.ranges)
      for (Index i = range.first; i < range.last; ++i) {
        const double value = signal->values(i);
        count += 1.0, beyond += value < extent.lowest || value > extent.highest ? 1.0 : 0.0;
        lowest = std::min(lowest, value), highest = std::max(highest, value);
      }
    if (beyond > few * count)
      parts.push_back(fmt::format("{} in {} of the samples ({:.3g} to {:.3g} {} here, {:.3g} to {:.3g} in the fit)",
                                  extent.signal, percent(beyond / count), lowest, highest, signal->unit, extent.lowest,
                                  extent.highest));
  }
  return parts.empty() ? "" : fmt::format("beyond the fitted range: {}", fmt::join(parts, ", "));
}

/// A sentence where no interval is long enough to show errors that grow slowly.
std::string few_periods(const dsp::Motion& motion, const Course& course) {
  constexpr double enough = 5.0;
  if (course.ranges.empty()) return {};
  const auto length = [](const dsp::IndexRange& range) { return range.last - range.first; };
  const dsp::IndexRange& longest = *std::max_element(
      course.ranges.begin(), course.ranges.end(), [&](const auto& a, const auto& b) { return length(a) < length(b); });
  if (length(longest) < 2) return {};
  const double line_hz =
      dsp::strongest_line(motion.at("x").segment(longest.first, length(longest)), motion.sample_rate_hz).frequency_hz;
  const double periods = line_hz * static_cast<double>(length(longest)) / motion.sample_rate_hz;
  if (periods >= enough) return {};
  return fmt::format(
      "the longest interval without a gap holds {:.2g} periods of the motion: errors that grow slowly do not show",
      periods);
}

/// A sentence where coefficients that differ by recording are not known for this one.
std::string means_taken(const Model& model, const std::string& fitted_as) {
  if (!differs_by_recording(model) || number_of(model, fitted_as) > 0) return {};
  std::vector<std::string> terms;
  for (const ModelTerm& term : model.terms)
    if (term.recording > 0 && std::find(terms.begin(), terms.end(), term.name) == terms.end())
      terms.push_back(term.name);
  return fmt::format(
      "the coefficient{} of {} differ{} between the recordings of the fit and {} not known for this one: "
      "the mean of theirs was taken",
      terms.size() > 1 ? "s" : "", fmt::join(terms, ", "), terms.size() > 1 ? "" : "s",
      terms.size() > 1 ? "are" : "is");
}

/// A signal of the equation that the recording does not have; empty: it has all.
std::string lacking_signal(const Model& model, const Record& record) {
  for (const ModelTerm& term : model.terms) {
    const Expression expression(term.name);
    for (const std::string& signal : expression.signals())
      if (record.prepared.signals.find(signal) == nullptr) return signal;
  }
  return {};
}

/// Throws Fault (input) predict.input.
void require_signals(const Model& model, const Record& record) {
  const std::string lacking = lacking_signal(model, record);
  if (lacking.empty()) return;
  std::vector<std::string> names;
  for (const dsp::Signal& signal : record.prepared.signals.signals)
    if (signal.name != "t") names.push_back(signal.name);
  throw dsp::Fault(dsp::FaultKind::input, "predict.input",
                   fmt::format("{}: no {}, which the equation has; there are {}. Want a recording of the same "
                               "channels; one that is called otherwise is named in its sidecar",
                               record.prepared.name, lacking, fmt::join(names, ", ")));
}

}  // namespace

RecordPrediction predict(const Model& joint, const Model& joint_linear, const Record& record,
                         const PredictOptions& options) {
  const Model model = equation_for(joint, options.fitted_as);
  Model linear = equation_for(joint_linear, options.fitted_as);
  require_signals(model, record);
  if (!lacking_signal(linear, record).empty())
    linear.terms.clear();  // it has all candidates: then nothing is to be beaten
  const Course course = whole_course(record.prepared.signals);
  RecordPrediction result;
  result.coordinates = coordinates_for(model, record, course, options.fitted_as);
  const dsp::Motion motion =
      in_coordinates(record.prepared.signals, result.coordinates.zero - record.zero, result.coordinates.lead_s);
  result.recording = record.prepared.name;
  result.unit = motion.find("x") != nullptr ? motion.find("x")->unit : "";
  result.time_s = motion.at("t");
  result.x = motion.at("x");
  const FreeRunOptions run_options{.keep_series = true, .poll = options.poll};
  const auto [run, courses] = restarted_run(model, {whole_course(motion)}, run_options);
  const FreeRun linear_run = free_run(linear, courses, run_options);  // from the same states
  const auto predicted_by = [&](const FreeRun& one) -> VectorXd {
    return one.series.empty() ? VectorXd::Constant(motion.num_samples(), nan) : one.series.front().predicted;
  };
  result.predicted = predicted_by(run);
  result.linear_predicted = predicted_by(linear_run);
  const Errors errors = errors_of(result.x, result.predicted, run.reason);
  result.nmse = result.unaided = errors.nmse, result.rms = errors.rms;
  result.num_restarts = run.num_restarts;
  if (run.num_restarts > 0) {
    const FreeRun unaided = free_run(model, {whole_course(motion)}, run_options);
    result.unaided = errors_of(result.x, predicted_by(unaided), unaided.reason).nmse;
  }
  result.linear = errors_of(result.x, result.linear_predicted, linear_run.reason).nmse;
  for (const dsp::IndexRange& range : courses.front().ranges)
    if (result.predicted.segment(range.first, range.last - range.first).array().isFinite().any())
      result.stretches.push_back({static_cast<double>(range.first) / motion.sample_rate_hz,
                                  static_cast<double>(range.last) / motion.sample_rate_hz,
                                  {}});
  const double noise = std::sqrt(ChannelNoise(record.prepared, "x").covariance("x", "x"));
  result.noise_floor = noise > 0.0 ? Figure{noise, {}} : Figure{nan, "too few samples"};
  const bool diverged = !run.reason.empty() && !run.series.empty();  // which says nothing of a body at rest
  result.still = errors_of(result.x, still_body(motion, diverged ? result.x : result.predicted),
                           diverged ? std::string() : run.reason)
                     .nmse;
  std::vector<std::string> remarks{means_taken(joint, options.fitted_as)};
  if (result.coordinates.zero_std > 0.0 && options.fitted_as.empty())
    remarks.emplace_back(
        "the zero of x is not stated for this recording: it is the one with which the equation is closest to it; "
        "prepare.zero states another");
  remarks.push_back(few_periods(motion, course));
  remarks.push_back(beyond_the_fit(model, motion, course));
  if (!model.terms.empty()) try {
      result.coefficients = carried_over(model, record, options);
    } catch (const dsp::Fault& fault) {
      remarks.push_back(fmt::format("the coefficients could not be compared: {}", fault.what()));
    }
  std::erase(remarks, "");
  result.remark = fmt::format("{}", fmt::join(remarks, "; "));
  return result;
}

}  // namespace ident
