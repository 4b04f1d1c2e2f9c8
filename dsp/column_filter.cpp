#include "dsp/column_filter.hpp"

#include <complex>
#include <stdexcept>

namespace dsp {

struct ColumnFilter::Impl {
  double input_rate_hz = 0.0, output_rate_hz = 0.0, edge_s = 0.0;
  SpectralBand band;
  std::vector<double> highpass_hz;
  double lowest_hz = 0.0;

  [[nodiscard]] std::complex<double> highpass(double f) const {
    if (highpass_hz.empty()) return 1.0;
    if (f < lowest_hz) return 0.0;
    std::complex<double> response = 1.0;
    for (const double corner_hz : highpass_hz)
      response *= std::complex<double>(0.0, f) / std::complex<double>(corner_hz, f);
    return response;
  }
};

ColumnFilter ColumnFilter::taper(double sample_rate_hz, const SpectralBand& band) {
  if (!(band.rolloff_hz > 0.0) || !(band.cutoff_hz > band.rolloff_hz) || !(band.cutoff_hz <= sample_rate_hz / 2.0))
    throw std::invalid_argument("ColumnFilter: 0 < rolloff_hz < cutoff_hz <= half the sample rate is required");
  Impl impl{.input_rate_hz = sample_rate_hz, .output_rate_hz = sample_rate_hz, .band = band};
  impl.edge_s = 1.0 / (band.cutoff_hz - band.rolloff_hz);
  ColumnFilter filter;
  filter.impl_ = std::make_shared<const Impl>(std::move(impl));
  return filter;
}

ColumnFilter ColumnFilter::with_highpass(const std::vector<double>& corners_hz, double lowest_hz) const {
  for (const double corner_hz : corners_hz)
    if (!(corner_hz > 0.0)) throw std::invalid_argument("ColumnFilter::with_highpass: corners must be positive");
  Impl impl = *impl_;
  impl.highpass_hz = corners_hz;
  impl.lowest_hz = lowest_hz;
  ColumnFilter filter;
  filter.impl_ = std::make_shared<const Impl>(std::move(impl));
  return filter;
}

Eigen::VectorXd ColumnFilter::apply(const Eigen::Ref<const Eigen::VectorXd>& bus_signal) const {
  return ExtendedSpectrum(bus_signal, impl_->input_rate_hz).filtered([this](double f) {
    return impl_->band.gain(f) * impl_->highpass(f);
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

}  // namespace dsp
