#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

namespace dsp {

/// Samples of several channels, one frame a row, as they come from a file.
using FrameBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct DecimateOptions {
  double output_rate_hz = 0.0;     ///< required; at most the input rate, any ratio that is a fraction of whole numbers
  double passband_end_hz = 0.0;    ///< required: flat within passband_ripple_db up to here
  double stopband_start_hz = 0.0;  ///< 0: output_rate_hz / 2. Attenuated from here on; up to output_rate_hz -
                                   ///< passband_end_hz, when only the pass band must be free of aliases
  double passband_ripple_db = 1e-3;
  double stopband_attenuation_db = 120.0;
  bool operator==(const DecimateOptions&) const = default;
};

/// One stage: output n is centred on input time n down / up. Column p of `taps` is the filter of the outputs that lie
/// p / up of a sample behind an input sample; each has unit sum. Whole-number ratios have up = 1.
struct FilterStage {
  int up = 1, down = 1;
  double input_rate_hz = 0.0;
  Eigen::MatrixXd taps;  ///< taps per output x up, tap i at offset i - (rows - 1) / 2 samples (rows odd)
};

/// Measured on the taps, not merely asked for.
struct FilterSheet {
  std::vector<FilterStage> stages;
  double passband_ripple_db = 0.0;  ///< largest |gain| up to passband_end_hz
  double alias_rejection_db = 0.0;  ///< smallest attenuation of anything that folds into the band kept free of aliases
  double delay_s = 0.0;             ///< of the causal filter; already removed from the output
  double edge_s = 0.0;              ///< outputs this close to either end lean on samples beyond it
  double multiplications_per_input = 0.0;
};

/// Zero-phase multistage FIR rate change of simultaneous channels, block by block: output n is centred on time
/// n / output_rate_hz. Each output sample is one fixed-order sum, so block sizes cannot change a bit of it. Beyond its
/// ends each stage sees the record's continuation by linear prediction (Burg, from 4096 samples at that end).
class Decimator {
 public:
  /// Throws std::invalid_argument if the pass band does not fit below the output's Nyquist frequency, or for a ratio
  /// that is not is_designable (filter_design.hpp).
  Decimator(double input_rate_hz, Eigen::Index num_channels, const DecimateOptions& options);
  /// The filter of another one again, without designing it anew.
  Decimator(const FilterSheet& design, Eigen::Index num_channels);
  ~Decimator();
  Decimator(Decimator&&) noexcept;
  Decimator& operator=(Decimator&&) noexcept;
  /// Any number of frames, num_channels columns. Returns the output frames that became complete.
  [[nodiscard]] FrameBlock push(const Eigen::Ref<const FrameBlock>& frames);
  /// No more input: the remaining output frames. Throws std::invalid_argument if the record is shorter than the filter.
  [[nodiscard]] FrameBlock finish();
  [[nodiscard]] const FilterSheet& sheet() const&;
  void sheet() const&& = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// One-shot form for a signal in memory: column by column, the same numbers as the stream.
[[nodiscard]] Eigen::MatrixXd decimate(const Eigen::Ref<const Eigen::MatrixXd>& samples, double sample_rate_hz,
                                       const DecimateOptions& options, FilterSheet* sheet = nullptr);
/// The same by a filter that is designed already. Throws std::invalid_argument for fewer samples than it is long. The
/// second form asks for samples [first, first + count) of all channels, in order.
[[nodiscard]] Eigen::MatrixXd decimate(const Eigen::Ref<const Eigen::MatrixXd>& samples, const FilterSheet& design);
[[nodiscard]] Eigen::MatrixXd decimate(
    Eigen::Index num_samples, Eigen::Index num_channels,
    const std::function<Eigen::MatrixXd(Eigen::Index first, Eigen::Index count)>& read, const FilterSheet& design);

}  // namespace dsp
