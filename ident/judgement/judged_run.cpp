#include "ident/judgement/judged_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dsp/values/constants.hpp"

namespace ident {
namespace {

/// The training rows, as signals are known beside the test rows: as the sensors leave them.
std::vector<Course> training_courses(const RangeRows& rows, const std::vector<Course>& test,
                                     const std::vector<Columns>& recordings) {
  std::vector<Course> training = courses_of(rows.train, rows.usable, recordings);
  std::erase_if(training, [&](Course& course) {
    const auto tested =
        std::find_if(test.begin(), test.end(), [&](const Course& one) { return one.recording == course.recording; });
    if (tested != test.end()) course.signals = tested->signals;
    return tested == test.end();
  });
  return training;
}

FreeRun free_run_through(const Model& model, const RangeRows& rows, const std::vector<Course>& test,
                         const std::vector<Columns>& recordings, const Poll& poll) {
  const FreeRunOptions options{.periods_alone = periods_of_phase, .poll = poll};
  FreeRun run = restarted_run(model, test, options).run;
  if (!run.reason.empty()) return run;
  if (!run.alone) return run;
  const FreeRun training = free_run(model, training_courses(rows, test, recordings), options);
  run.nmse_training = training.diverged_after_s > 0.0 ? std::numeric_limits<double>::infinity() : training.nmse_centred;
  run.mean_square_training = training.mean_square;
  return run;
}

}  // namespace

FreeRun judged_run(const JudgedFit& judged, const RangeResult& result, const RangeData& range,
                   const std::vector<Course>& courses, const std::vector<Columns>& recordings,
                   const IdentifyOptions& options) {
  const std::vector<JudgedFit>& earlier = result.fits;
  const auto twin = std::find_if(earlier.begin(), earlier.end(),
                                 [&](const JudgedFit& other) { return same_equation(other.model, judged.model); });
  FreeRun run;
  run.nmse = dsp::nan;
  if (!options.free_run)
    run.reason = "the rows of a table are no time response";
  else if (range.test.size() == 0)
    run.reason = "no test rows";
  else if (twin != earlier.end()) {
    run = twin->free_run;
    run.series.clear();
  } else {
    run = free_run_through(judged.model, result.rows, courses, recordings, options.poll);
  }
  run.applies = options.free_run && (options.target == "a" || options.target == "ddy");  // else no equation of motion
  return run;
}

}  // namespace ident
