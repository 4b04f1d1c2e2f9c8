#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "dsp/values/recording.hpp"
#include "ident/bodies/candidates.hpp"
#include "ident/bodies/couplings.hpp"
#include "ident/bodies/modes.hpp"
#include "ident/equation/verdict.hpp"

namespace ident {

/// One recording of a record.
struct BodiesPart {
  std::string name;
  dsp::IndexRange rows;
  Eigen::VectorXd zeros;   ///< of each channel, subtracted: the mean where x is far from zero
  double zero_of_r = 0.0;  ///< the same of the base, or of an imposed displacement
  [[nodiscard]] bool holds(const dsp::IndexRange& range) const {
    return range.first >= rows.first && range.last <= rows.last;
  }
};

/// Motions of several bodies recorded together, ready for their likelihood: one recording, or several end to end.
struct BodiesRecord {
  std::string name;
  double sample_rate_hz = 0.0;
  std::string length = "m";  ///< SI unit of the displacements
  int num_bodies = 0;
  bool imposed = false;                     ///< the motion: x and v are inputs, and f is recorded as that of one body
  std::vector<dsp::Channel> channels = {};  ///< of bodies; the displacements of 1 to n first
  Eigen::MatrixXd samples = {};             ///< of these
  std::vector<BodiesPart> parts = {};       ///< one, or several that were joined
  std::vector<std::string> inputs = {};     ///< recorded, as terms call them
  Eigen::MatrixXd input_samples = {};
  std::vector<double> input_noise_std = {};  ///< white, of a sample; empty: not looked at
  std::vector<std::string> unused = {};      ///< channels that are neither
  std::vector<dsp::IndexRange> usable = {};  ///< samples without a fault, ascending
  std::optional<Frame> frame = {};           ///< what the channels' roles say; nothing where they leave it open
};

/// Of a recording without bodies inputs alone; with `one_body` its motion is that of body 1. Throws dsp::Fault (input,
/// "bodies.*") where a body has no displacement, one number is missing or a channel holds its values, and what to do.
[[nodiscard]] BodiesRecord bodies_record(const dsp::Recording& recording, bool one_body = false);

/// Of a recording of an imposed displacement x (or y, from r where the base moves) and the force f that it takes; v is
/// derived where it was not recorded. Without f inputs alone. Throws dsp::Fault (input, "bodies.imposed") where x is
/// missing, and what to do; "bodies.held" as above.
[[nodiscard]] BodiesRecord imposed_record(const dsp::Recording& recording);

/// Recordings of the same system with the same channels and inputs as one record, with one zero of each displacement.
/// Throws dsp::Fault (input, "bodies.recordings") where they are not the same, or a sensor seems to have been moved.
[[nodiscard]] BodiesRecord joined(const std::vector<BodiesRecord>& records);

struct BodiesOptions {
  BodyLibrary library = {};
  Inner inner = Inner::none;    ///< tried, and kept where the samples ask for it
  double train_fraction = 0.6;  ///< of each recording; 1: none is left for a free run
  int num_threads = 1;
};

/// One equation for each body: its acceleration is the sum of its terms; then that of the rate of z.
struct BodiesModel {
  BodiesLayout layout = {};
  std::vector<BodyTerm> terms = {};  ///< body after body, those of z, and inner_force
  Eigen::VectorXd mean = {};
  Eigen::MatrixXd covariance = {};
  [[nodiscard]] double std(Eigen::Index term) const { return std::sqrt(covariance(term, term)); }
};

/// What a run misses of each displacement of a record, at usable samples.
struct RunErrors {
  double count = 0.0;         ///< of samples
  Eigen::VectorXd nmse = {},  ///< NaN: it runs away, or nothing was recorded
      squares = {};           ///< of each displacement there about its mean: the sum
};

/// The equations on their own from a state that training samples alone gave, driven by the inputs: displacements, or
/// the force on an imposed motion, over the samples of a part behind its training ones.
struct BodiesRun {
  std::size_t part = 0;
  dsp::IndexRange samples = {};    ///< of the record
  std::vector<double> state = {};  ///< at the first of these
  Eigen::MatrixXd positions = {};  ///< samples x bodies; NaN from where they run away
  RunErrors errors = {};
};

/// The force per mass that an inner state stands for, along the fitted samples; of an imposed motion the whole force.
struct Loop {
  double sample_rate_hz = 0.0;
  Eigen::VectorXd position = {}, force = {};
  Eigen::VectorXd measured = {};  ///< what the other terms leave of the derived acceleration; f as recorded
};

struct BodiesResult {
  BodiesModel model = {};
  std::vector<double> gain = {}, probability = {};  ///< of each of these terms: as of state_space::Score
  std::vector<BodyTerm> rejected = {};              ///< candidates that were not taken
  std::vector<dsp::IndexRange> train = {};          ///< of each part
  double num_samples = 0.0;                         ///< that the likelihood is of
  double thinned_by = 1.0;
  Eigen::VectorXd noise_std = {};      ///< of each channel of the record
  double gain_of_process_noise = 0.0;  ///< as of Likelihood
  bool frame_was_open = false;         ///< the samples decided it
  Inner sought = Inner::none;
  double gain_of_inner = 0.0;  ///< of -2 log likelihood by z, beyond the price of its terms and of itself; NaN: no
                               ///< fit with it came to rest; infinite: none without it; -infinite: it does not move
  Loop loop = {};              ///< empty where there is no hysteretic z
  double lag_s = 0.0, lag_std_s = 0.0;  ///< of z behind layout.lagging; zero where there is none
  std::vector<Mode> modes = {};
  std::vector<Coupling> couplings = {};
  std::vector<BodiesRun> runs = {};  ///< of the parts that have samples left for one
  /// Of each body over its variance in all runs: what they miss, and the channel's noise.
  Eigen::VectorXd run_nmse = {},
                  run_noise =
                      {};  ///< of each body over its variance in all runs: what they miss, and the channel's noise
  Verdict verdict = Verdict::undecided;
  std::string sentence = {};        ///< the verdict and what it rests on
  std::string silent_because = {};  ///< not empty: there is no equation
};

/// One selection over the equations of all bodies, from the samples as they were recorded; of an imposed motion one
/// force, with a hysteretic part or without. Throws dsp::Fault (usage,
/// "term.*") for terms that cannot be read, (input, "bodies.short") for fewer samples than say anything, (input,
/// "bodies.lag") for a lag where no input was recorded.
[[nodiscard]] BodiesResult identify_bodies(const BodiesRecord& record, const BodiesOptions& options);

/// Equations run free over samples of inputs from a state (x1, v1, x2, v2 ... z, or impulse and z, of sample `first`):
/// states of first, first + 1 ..., NaN from where a displacement leaves 1e6 times `scale`. `begin_s`: t of the first.
[[nodiscard]] Eigen::MatrixXd run_free(const BodiesModel& model, const Eigen::MatrixXd& inputs, double sample_rate_hz,
                                       const std::vector<double>& state, double scale, double begin_s = 0.0);

/// What such states are compared in: displacements, samples x bodies; of an imposed motion the force beside these
/// inputs.
[[nodiscard]] Eigen::MatrixXd responses_of(const BodiesModel& model, const Eigen::MatrixXd& states,
                                           const Eigen::MatrixXd& inputs, double sample_rate_hz, double begin_s = 0.0);

/// Of a run from sample `first` at the usable samples from `from` on.
[[nodiscard]] RunErrors errors_of_run(const BodiesRecord& record, const Eigen::MatrixXd& positions, Eigen::Index first,
                                      Eigen::Index from);

/// As the equations want them: displacements in their frame, base motion they lack derived, of each part by itself.
[[nodiscard]] BodiesRecord in_frame(BodiesRecord record, Frame frame);

/// The state in which the equations, as they are, begin these samples: of most likelihood over them. Nothing where it
/// cannot be found.
[[nodiscard]] std::optional<std::vector<double>> first_state(const BodiesModel& model, const BodiesRecord& record,
                                                             dsp::IndexRange over, int num_threads);

}  // namespace ident
