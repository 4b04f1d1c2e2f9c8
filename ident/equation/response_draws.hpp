#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "ident/equation/identified_equation.hpp"
#include "sim/ode/frequency_response.hpp"
#include "sim/ode/steady_response.hpp"

namespace ident {

/// How far coefficients drawn from their posterior spread the amplitudes of one sweep; one entry for each point.
struct ResponseBand {
  std::vector<double> x_std_m, x_low_m, x_high_m, y_low_m, y_high_m;  ///< low, high: 2.5 and 97.5 %
};

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
  double static_friction = 0.0;     ///< m/s^2, as it is
  bool amplitude_measured = false;  ///< of the drive, by the sensors of the equation, whose calibration it shares
  sim::SteadyOptions steady = {};   ///< its poll is called from every thread
};

/// One draw of what is driven; its lengths, and the amplitude of its drive, over what is stated.
struct DrawnSystem {
  sim::DrivenSystem driven;
  double length = 1.0, amplitude = 1.0;
};
/// Draw k is the same for any number of draws and threads, as far as `drawn` is; which is called from every thread.
[[nodiscard]] ResponseDraws response_draws(const sim::FrequencyResponseOptions& sweep, const DrawOptions& options,
                                           const std::function<DrawnSystem(std::size_t draw)>& drawn);

/// Calibration that all coefficients share is drawn with them: lengths and forces of the equation, over what
/// they are. Frequencies of what the sensors measured do not depend on it; its amplitudes do, and frequencies of what
/// is given as it is: static friction, the amplitude of a drive. Throws as equation_oscillator.
[[nodiscard]] ResponseDraws response_draws(const IdentifiedEquation& equation,
                                           const sim::FrequencyResponseOptions& sweep, const DrawOptions& options);

}  // namespace ident
