#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dsp/decimate.hpp"
#include "dsp/motion.hpp"
#include "dsp/recording.hpp"

namespace dsp {

enum class Recipe {
  matched,  ///< columns are formed first, on wide-band signals, and filtered after, each by the filter of the target
  paper,    ///< signals are filtered first and columns formed from them, as in [QZS23]
};

struct PrepareOptions {
  Recipe recipe = Recipe::matched;
  double rate_hz = 0.0;           ///< regression rate; 0: the record's own
  double cutoff_hz = 0.0;         ///< columns go to zero here; 0: 0.4 x regression rate
  double rolloff_hz = 0.0;        ///< where the taper begins; 0: 0.78125 x cutoff (8 of 10.24)
  double state_cutoff_hz = 0.0;   ///< band in which states are formed before their columns are filtered; 0: 20/10.24 x
  double state_rolloff_hz = 0.0;  ///< cutoff, as far as the bus rate allows (0.49 x); roll-off 0.64 x state cut-off
  double bus_rate_hz = 0.0;       ///< rate at which columns are formed when decimating; 0: 10 x regression rate
  AccelerationSource acceleration = AccelerationSource::automatic;
};

/// The one linear filter that the target and every column pass on their way to the regression: from samples on the bus
/// to samples at the regression rate. Zero phase; output n is centred on time n / output_rate_hz.
class ColumnFilter {
 public:
  /// Raised-cosine low-pass in the frequency domain, same rate in and out.
  [[nodiscard]] static ColumnFilter taper(double sample_rate_hz, const SpectralBand& band);
  /// FIR decimation from the bus to the regression rate.
  [[nodiscard]] static ColumnFilter decimation(double input_rate_hz, const DecimateOptions& options);
  /// The same filter followed by one-pole high-passes (AC coupling shared by all columns); DC goes to zero.
  [[nodiscard]] ColumnFilter with_highpass(const std::vector<double>& corners_hz) const;
  [[nodiscard]] Eigen::VectorXd apply(const Eigen::Ref<const Eigen::VectorXd>& bus_signal) const;
  [[nodiscard]] double input_rate_hz() const;
  [[nodiscard]] double output_rate_hz() const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

/// A recording ready for regression.
struct Prepared {
  std::string name;
  PrepareOptions options;          ///< with every default filled in
  Motion bus;                      ///< wide-band signals at the bus rate: columns are formed from these ("matched")
  Motion signals;                  ///< the same signals after the column filter, at the regression rate: prepared.csv,
                                   ///< conditions, predictions, free run; columns of recipe "paper"
  ColumnFilter filter;             ///< from bus to regression rate
  std::optional<FilterSheet> decimation;
  std::vector<Interval> excluded;  ///< with margins and reasons; marked in both motions
  std::vector<Check> checks;
};

/// Subtracts `zero_m` from x, before and after the column filter alike (a laser's zero means nothing).
void set_displacement_zero(Prepared& prepared, double zero_m);

}  // namespace dsp
