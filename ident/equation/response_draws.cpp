#include "ident/equation/response_draws.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dsp/values/constants.hpp"
#include "dsp/values/for_each_index.hpp"
#include "dsp/values/order_statistics.hpp"
#include "ident/equation/equation_oscillator.hpp"
#include "sim/noise.hpp"

namespace ident {
namespace {

using dsp::nan;

ResponseBand band_of(const std::vector<sim::SteadyResponse>& draws,
                     std::vector<sim::ResponsePoint> sim::FrequencyResponse::*way, std::size_t num_points) {
  ResponseBand band;
  for (std::size_t k = 0; k < num_points; ++k) {  // a draw that ran away has fewer
    std::vector<double> x, y;
    for (const auto& draw : draws)
      if (k < (draw.response.*way).size()) {
        x.push_back((draw.response.*way)[k].x_m);
        y.push_back((draw.response.*way)[k].y_m);
      }
    std::sort(x.begin(), x.end());
    std::sort(y.begin(), y.end());
    const bool enough = x.size() >= 2;
    band.x_std_m.push_back(drawn_figure(x).std);
    band.x_low_m.push_back(enough ? dsp::interpolated_quantile(x, 0.025) : nan);
    band.x_high_m.push_back(enough ? dsp::interpolated_quantile(x, 0.975) : nan);
    band.y_low_m.push_back(enough ? dsp::interpolated_quantile(y, 0.025) : nan);
    band.y_high_m.push_back(enough ? dsp::interpolated_quantile(y, 0.975) : nan);
  }
  return band;
}

}  // namespace

DrawnFigure drawn_figure(const std::vector<double>& values) {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (const double value : values)
    if (std::isfinite(value)) sum += value, ++count;
  const double mean = sum / count;
  for (const double value : values)
    if (std::isfinite(value)) squares += (value - mean) * (value - mean);
  return {.mean = count > 0 ? mean : nan,
          .std = count > 1 ? std::sqrt(squares / (count - 1)) : nan,
          .fraction = values.empty() ? 0.0 : count / static_cast<double>(values.size())};
}

ResponseDraws response_draws(const sim::FrequencyResponseOptions& sweep, const DrawOptions& options,
                             const std::function<DrawnSystem(std::size_t draw)>& drawn) {
  std::vector<sim::SteadyResponse> responses(static_cast<std::size_t>(options.num_draws));
  dsp::for_each_index(responses.size(), options.num_threads, [&](std::size_t k) {
    const DrawnSystem one = drawn(k);
    sim::FrequencyResponseOptions swept = sweep;
    swept.amplitude_m *= one.amplitude;
    responses[k] = sim::steady_response(one.driven, swept, options.steady);
    for (auto* way : {&responses[k].response.up, &responses[k].response.down})
      for (sim::ResponsePoint& point : *way) point.x_m /= one.length, point.y_m /= one.length;
  });
  ResponseDraws draws;
  const std::size_t num_points = sim::sweep_frequencies(sweep).size();
  draws.up = band_of(responses, &sim::FrequencyResponse::up, num_points);
  draws.down = band_of(responses, &sim::FrequencyResponse::down, num_points);
  for (const auto& response : responses) {
    draws.located.push_back(response.located);
    draws.num_diverged += std::isfinite(response.diverged_hz);
    draws.peak_up_m.push_back(response.response.up.empty() ? nan : sim::peak(response.response.up).x_m);
    draws.peak_down_m.push_back(response.response.down.empty() ? nan : sim::peak(response.response.down).x_m);
  }
  return draws;
}

ResponseDraws response_draws(const IdentifiedEquation& equation, const sim::FrequencyResponseOptions& sweep,
                             const DrawOptions& options) {
  return response_draws(sweep, options, [&](std::size_t k) {
    auto driven =
        equation_oscillator(equation, drawn_coefficients(equation.mean, equation.covariance, options.seed, k));
    const auto behind_coefficients = static_cast<std::uint64_t>(equation.mean.size());
    const sim::Noise noise(options.seed, k);
    const double length = std::exp(equation.displacement_std * noise.normal(behind_coefficients));
    const double force = std::exp(equation.force_std * noise.normal(behind_coefficients + 1));
    driven.oscillator.static_friction = options.static_friction * length;
    const double drive = driven.drive == DriveKind::base ? length : force;
    return DrawnSystem{.driven = sim::driven_system(std::move(driven.oscillator)),
                       .length = length,
                       .amplitude = options.amplitude_measured ? 1.0 : drive};
  });
}

}  // namespace ident
