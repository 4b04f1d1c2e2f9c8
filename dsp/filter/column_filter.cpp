#include "dsp/filter/column_filter.hpp"

#include <complex>
#include <optional>
#include <stdexcept>

namespace dsp {

using Eigen::Index;

struct ColumnFilter::Impl {
  double input_rate_hz = 0.0, output_rate_hz = 0.0, edge_s = 0.0, stop_hz = 0.0;
  std::optional<SpectralBand> band;  ///< of a taper
  FilterSheet sheet;                 ///< of a decimation otherwise
  std::vector<double> highpass_hz;
};

ColumnFilter ColumnFilter::taper(double sample_rate_hz, const SpectralBand& band) {
  if (!(band.rolloff_hz > 0.0) || !(band.cutoff_hz > band.rolloff_hz) || !(band.cutoff_hz <= sample_rate_hz / 2.0))
    throw std::invalid_argument("ColumnFilter: 0 < rolloff_hz < cutoff_hz <= half the sample rate is required");
  Impl impl{.input_rate_hz = sample_rate_hz, .output_rate_hz = sample_rate_hz, .band = band};
  impl.edge_s = 1.0 / (band.cutoff_hz - band.rolloff_hz);
  impl.stop_hz = band.cutoff_hz;
  ColumnFilter filter;
  filter.impl_ = std::make_shared<const Impl>(std::move(impl));
  return filter;
}

ColumnFilter ColumnFilter::decimation(double input_rate_hz, const DecimateOptions& options) {
  Impl impl{.input_rate_hz = input_rate_hz, .output_rate_hz = options.output_rate_hz};
  const Decimator decimator(input_rate_hz, 1, options);
  impl.sheet = decimator.sheet();
  impl.edge_s = impl.sheet.edge_s;
  impl.stop_hz = options.stopband_start_hz > 0.0 ? options.stopband_start_hz : 0.5 * options.output_rate_hz;
  ColumnFilter filter;
  filter.impl_ = std::make_shared<const Impl>(std::move(impl));
  return filter;
}

ColumnFilter ColumnFilter::with_highpass(const std::vector<double>& cutoffs_hz) const {
  for (const double cutoff_hz : cutoffs_hz)
    if (!(cutoff_hz > 0.0)) throw std::invalid_argument("ColumnFilter::with_highpass: cut-offs must be positive");
  Impl impl = *impl_;
  impl.highpass_hz = cutoffs_hz;
  ColumnFilter filter;
  filter.impl_ = std::make_shared<const Impl>(std::move(impl));
  return filter;
}

Eigen::VectorXd ColumnFilter::apply(const Eigen::Ref<const Eigen::VectorXd>& intermediate_signal) const {
  return apply(intermediate_signal.size(), 1,
               [&](Index first, Index count) -> Eigen::MatrixXd { return intermediate_signal.segment(first, count); });
}

Eigen::MatrixXd ColumnFilter::apply(Index num_samples, Index num_signals,
                                    const std::function<Eigen::MatrixXd(Index first, Index count)>& read) const {
  // The high-pass is linear and time-invariant, so it may as well come after the decimation, where it is cheap.
  Eigen::MatrixXd signals = impl_->band ? read(0, num_samples) : decimate(num_samples, num_signals, read, impl_->sheet);
  for (Index c = 0; c < signals.cols(); ++c)
    if (impl_->band)
      signals.col(c) = ExtendedSpectrum(signals.col(c), impl_->output_rate_hz).filtered([this](double f) {
        return impl_->band->gain(f) * highpass_response(impl_->highpass_hz, f);
      });
    else
      signals.col(c) = high_passed(signals.col(c));
  return signals;
}

Eigen::VectorXd ColumnFilter::high_passed(const Eigen::Ref<const Eigen::VectorXd>& signal) const {
  if (impl_->highpass_hz.empty()) return signal;
  return ExtendedSpectrum(signal, impl_->output_rate_hz).filtered([this](double f) {
    return highpass_response(impl_->highpass_hz, f);
  });
}

double ColumnFilter::input_rate_hz() const {
  return impl_->input_rate_hz;
}
double ColumnFilter::output_rate_hz() const {
  return impl_->output_rate_hz;
}
double ColumnFilter::edge_s() const {
  return impl_->edge_s;
}
double ColumnFilter::stop_hz() const {
  return impl_->stop_hz;
}
const FilterSheet& ColumnFilter::sheet() const& {
  return impl_->sheet;
}

}  // namespace dsp
