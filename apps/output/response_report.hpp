#pragma once
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "apps/text/svg_plot.hpp"
#include "ident/equation/response_draws.hpp"
#include "sim/ode/frequency_response.hpp"

namespace apps {

/// A frequency response with what is known of its uncertainty; bands may be empty.
struct ReportedResponse {
  sim::FrequencyResponse response;
  ident::ResponseBand up, down;
  std::string x_unit = "m";
  bool has_base = true;  ///< else y is x
};

/// What an amplitude is shown in: rad of an angle, else mm.
struct ShownUnit {
  double factor = 1e3;
  const char* name = "mm";
};
[[nodiscard]] ShownUnit shown_unit(std::string_view x_unit);

/// What can happen on the way, with its name in documents and in a sentence.
struct ResponseEvent {
  const char *way, *key, *sentence;
  double sim::ResponseJumps::*frequency_hz;
  bool needs_friction = false;
};
[[nodiscard]] const std::array<ResponseEvent, 6>& response_events();

/// frc.csv: direction, f_hz, amplitude_m (of x), mode (locked, stick-slip, slip), payload_amplitude_m, phase_deg of x
/// after r (empty where locked), stuck_share; with bands also amplitude_std_m, amplitude_low_m, amplitude_high_m.
[[nodiscard]] std::string response_csv(const ReportedResponse& reported);

/// {"up": {unlock_hz, jump_hz, fall_hz, peak}, "down": {jump_hz, fall_hz, lock_hz, peak}}; what does not happen is
/// null.
[[nodiscard]] nlohmann::ordered_json response_json(const sim::FrequencyResponse& response);

/// One line for each thing that happens on the way.
[[nodiscard]] std::string response_text(const sim::FrequencyResponse& response);

/// Amplitude of relative motion, and of the payload where there is a base, against frequency, as in Fig. 11 of
/// [QZS23].
[[nodiscard]] PlotFigure response_figure(const ReportedResponse& reported, std::string_view title);

/// Sets one of from_hz, to_hz, step_hz, dwell_s, transition_s, amplitude_mm; false for any other name.
[[nodiscard]] bool set_sweep_option(sim::FrequencyResponseOptions& options, std::string_view name, double value);
/// The same as a document: from_hz ... amplitude_m.
[[nodiscard]] nlohmann::ordered_json sweep_json(const sim::FrequencyResponseOptions& options);
/// Those names, for messages.
[[nodiscard]] std::string_view sweep_option_names();

}  // namespace apps
