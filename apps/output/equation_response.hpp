#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "apps/output/steps_table.hpp"
#include "apps/text/svg_plot.hpp"
#include "ident/equation/equation_oscillator.hpp"
#include "ident/equation/identified_equation.hpp"
#include "ident/equation/response_draws.hpp"
#include "sim/ode/steady_response.hpp"

namespace apps {

/// Whose response it is.
struct RespondingEquation {
  std::string of;                                         ///< "range mixed by fast_rvm", "x2 driven by f1"
  std::string title;                                      ///< of its figure
  std::vector<std::pair<std::string, std::string>> keys;  ///< the same in a document
  std::string text, coordinates;
  std::string x_unit = "m";
  ident::Verdict verdict = ident::Verdict::undecided;
  double largest_x = 0.0;  ///< over the training rows; 0: not known
  bool takes_static_friction = true;
};
[[nodiscard]] RespondingEquation responding(const ident::IdentifiedEquation& equation);

/// All there is to say of one equation's response.
struct EquationResponse {
  RespondingEquation equation;
  ident::DriveKind drive = ident::DriveKind::base;
  std::string input = "f";  ///< that drives where it is a force
  bool has_friction = false;
  double static_friction = 0.0;
  sim::FrequencyResponseOptions sweep;
  sim::SteadyResponse steady;
  ident::ResponseDraws draws;
  int num_draws = 0;
  double amplitude_std = 0.0;  ///< relative, of the drive's, where it was measured
  std::uint64_t seed = 1;
  std::vector<StepPoint> steps;  ///< what the record itself came to
};

/// The table of jumps with their spread, the distance from the record's steps, and remarks, for a terminal.
[[nodiscard]] std::string response_text(const EquationResponse& result);

/// frc.json.
[[nodiscard]] std::string response_document(const EquationResponse& result);

/// frc.csv, with the draws' bands.
[[nodiscard]] std::string response_csv(const EquationResponse& result);

/// frc.svg: amplitudes of payload and relative motion, with the record's own end results, as Fig. 11 of [QZS23].
[[nodiscard]] PlotFigure response_figure(const EquationResponse& result);

}  // namespace apps
