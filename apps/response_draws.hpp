#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "apps/identified_equation.hpp"
#include "apps/output/response_report.hpp"
#include "sim/ode/steady_response.hpp"

namespace apps {

/// A figure over the draws in which it exists.
struct DrawnFigure {
  double mean = 0.0, std = 0.0;  ///< NaN where too few draws have it
  double fraction = 0.0;         ///< of the draws that have it
};
[[nodiscard]] DrawnFigure drawn_figure(const std::vector<double>& values);  ///< NaN: it does not exist in that draw

/// What draws of the coefficients make of a frequency response.
struct ResponseDraws {
  ResponseBand up, down;                    ///< for every frequency of the sweep
  std::vector<sim::ResponseJumps> located;  ///< of each draw
  std::vector<double> peak_up_m, peak_down_m;
  int num_diverged = 0;
};

struct DrawOptions {
  int num_draws = 40;
  std::uint64_t seed = 1;
  int num_threads = 1;
  double static_friction = 0.0;
  sim::SteadyOptions steady;
};

/// Draw k is the same for any number of draws and threads. Throws as equation_oscillator.
[[nodiscard]] ResponseDraws response_draws(const IdentifiedEquation& equation,
                                           const sim::FrequencyResponseOptions& sweep, const DrawOptions& options);

}  // namespace apps
