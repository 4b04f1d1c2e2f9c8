#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

namespace dsp {

/// Samples of several channels, one frame a row, as they come from a file.
using FrameBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct DecimateOptions {
  double output_rate_hz = 0.0;     ///< required; at most the input rate, any ratio
  double passband_end_hz = 0.0;    ///< required: flat within passband_ripple_db up to here
  double stopband_start_hz = 0.0;  ///< 0: output_rate_hz / 2; attenuated from here on
  double passband_ripple_db = 1e-3;
  double stopband_attenuation_db = 120.0;
};

struct FilterStage {
  int up = 1, down = 1;
  double input_rate_hz = 0.0;
  Eigen::VectorXd taps;  ///< odd count, symmetric, sum = up
};

/// Measured on the taps, not merely asked for.
struct FilterSheet {
  std::vector<FilterStage> stages;
  double passband_ripple_db = 0.0;  ///< largest |gain| in dB up to passband_end_hz
  double alias_rejection_db = 0.0;  ///< smallest attenuation of anything that folds below stopband_start_hz
  double delay_s = 0.0;             ///< of the causal filter; already removed from the output
  double edge_s = 0.0;              ///< at either end outputs lean on extrapolated samples for this long
};

/// Zero-phase multistage FIR rate change of simultaneous channels, block by block: output n is centred on time
/// n / output_rate_hz. Each output sample is one fixed-order sum, so block sizes cannot change a bit of it.
class Decimator {
 public:
  /// Throws std::invalid_argument if the pass band does not fit below the output's Nyquist frequency.
  Decimator(double input_rate_hz, Eigen::Index num_channels, const DecimateOptions& options);
  ~Decimator();
  Decimator(Decimator&&) noexcept;
  Decimator& operator=(Decimator&&) noexcept;
  /// Any number of frames, num_channels columns. Returns the output frames that became complete.
  [[nodiscard]] FrameBlock push(const Eigen::Ref<const FrameBlock>& frames);
  /// No more input: the remaining output frames. Throws std::invalid_argument if the record is shorter than the filter.
  [[nodiscard]] FrameBlock finish();
  [[nodiscard]] const FilterSheet& sheet() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// One-shot form for a signal in memory: column by column, the same numbers as the stream.
[[nodiscard]] Eigen::MatrixXd decimate(const Eigen::Ref<const Eigen::MatrixXd>& samples, double sample_rate_hz,
                                       const DecimateOptions& options, FilterSheet* sheet = nullptr);

}  // namespace dsp
