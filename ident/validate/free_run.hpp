#pragma once
#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "dsp/sensors/motion.hpp"
#include "ident/equation/model.hpp"

namespace ident {

/// Free-run error of x about its mean, beyond what its noise makes, as a fraction of its power: a tenth of its
/// amplitude, and three tenths.
inline constexpr double follows = 0.01, follows_in_part = 0.1;

/// Of a self-excited or free motion only the course is the equation's, not the phase after more periods than these.
inline constexpr double periods_of_phase = 10.0;

/// Where to run an equation through one recording: ranges of samples [first, last) without an excluded gap, and the
/// samples that count.
struct Course {
  const dsp::Motion* signals = nullptr;  ///< not owned
  std::vector<dsp::IndexRange> ranges;
  std::vector<unsigned char> scored;  ///< per sample of `signals`
  std::size_t recording = 0;          ///< whose signals they are (0-based): terms of one recording are those of this
  /// Samples at which an equation with inputs is set to the measured state; ascending.
  std::vector<Eigen::Index> restarts = {};
};

/// x of one course, a value per sample of its signals.
struct FreeRunSeries {
  std::size_t recording = 0;  ///< of the course
  Eigen::VectorXd predicted;  ///< NaN: nothing was run there
  Eigen::VectorXd measured;   ///< x of the course's signals, which the prediction is compared with
};

/// Where the equation was set to the measured state.
struct FreeRunStart {
  std::size_t recording = 0;        ///< of the course
  double time_s = 0.0, to_s = 0.0;  ///< and up to where it ran from there
};

/// What an identified equation by itself predicts of x, against what was measured.
struct FreeRun {
  double nmse = 0.0;                                               ///< of x over the scored samples
  double nmse_centred = std::numeric_limits<double>::quiet_NaN();  ///< about the mean of x in each range; NaN where
                                                                   ///< there is no figure
  bool alone = false;                                              ///< nothing measured drives the equation
  /// Of an equation alone, on the training rows: as nmse_centred, infinity where it diverged; as mean_square.
  double nmse_training = std::numeric_limits<double>::quiet_NaN(), mean_square_training = 0.0;
  double mean_square = 0.0;  ///< of x about its mean, m^2
  int num_restarts = 0;      ///< of an equation with inputs: how often it was set to the measured state within a range
  std::string reason;        ///< not empty: there is no figure, and why: too short, no equation of motion, diverged
  double diverged_after_s = 0.0;  ///< from the start of its range; 0: it did not
  int num_ranges = 0;
  bool sticks = false;                ///< it came to rest on a switch at least once
  bool applies = true;                ///< false: the rows are no time response, and none was to be expected
  std::vector<FreeRunStart> starts;   ///< in the order of the courses
  std::vector<FreeRunSeries> series;  ///< with keep_series: of each course
  /// The larger of nmse_centred and nmse_training; NaN: there is neither.
  [[nodiscard]] double larger_nmse() const { return std::fmax(nmse_centred, nmse_training); }
};

struct FreeRunOptions {
  double min_periods = 1.0;  ///< of the dominant frequency of x; shorter ranges tell nothing and are left out
  double periods_alone =
      std::numeric_limits<double>::infinity();  ///< an equation without inputs is set to the measured state again after
                                                ///< so many: nothing else holds its phase
  double start_error = 0.0;                     ///< added to the position at each start: of its largest in the range
  double relative_tolerance = 1e-7;  ///< of a step; ten times less moves the NMSE by under a thousandth of itself
  double divergence_factor = 100.0;  ///< a state beyond this many times its largest measured magnitude has diverged
  bool keep_series = false;          ///< fills in FreeRun::series
  std::function<void()> poll = {};   ///< called now and then; may throw to end the run
};

/// Integrates `model` (target a, the relative, or ddy, the absolute acceleration) over each range from its measured
/// state; base motion, force and other measured inputs are interpolated through the record's own samples
/// (band-limited). Every sgn(g) in the kept terms is a switch, located as a root; where both sides of g = v or g = dy
/// push back, it slides there (stick, Filippov). x is compared on the scored samples of the ranges.
[[nodiscard]] FreeRun free_run(const Model& model, const std::vector<Course>& courses,
                               const FreeRunOptions& options = {});

/// A free run, and the courses it ran, with their restarts.
struct RestartedRun {
  FreeRun run;
  std::vector<Course> courses;
};

/// The free run that equations are judged by, with its series; `options`: with periods_alone. Where one with inputs
/// misses x by more than `follows` it begins again before an error of its last start has grown tenfold (rms over a
/// period, beside the first), as it does near a fold of the response and in chaos: coefficients that are known to a
/// hundredth let x be followed to a tenth no further, however right the equation. Where no error grows so much, and
/// where it diverges in spite of that, it is the free run of the courses as they are.
[[nodiscard]] RestartedRun restarted_run(const Model& model, std::vector<Course> courses, FreeRunOptions options);

}  // namespace ident
