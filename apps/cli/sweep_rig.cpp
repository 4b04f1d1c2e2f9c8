#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/cli/simulate_jobs.hpp"
#include "apps/config/parameter_settings.hpp"
#include "apps/output/response_report.hpp"
#include "apps/output/truth_json.hpp"
#include "apps/text/json_parts.hpp"

namespace apps {

using nlohmann::ordered_json;

std::vector<std::string> sweep_rig(const SimulateArguments& arguments, const OutputFolder& folder, Console& console,
                                   ordered_json& truth) {
  if (arguments.raw || arguments.sensors || arguments.container || arguments.from_s || arguments.rate_hz ||
      arguments.duration_s || arguments.programme || arguments.noise)
    throw dsp::Fault(dsp::FaultKind::usage, "sim.option",
                     "sim qzs --frc: computes steady responses without sensors; --raw, --programme, --duration, "
                     "--noise and options that need them cannot be used with it");
  const std::string twin = arguments.twin.value_or("T0");
  try {
    sim::FrequencyResponseOptions options{.poll = shown_poll(console, "sweeping")};
    auto settings = parse_settings(arguments.set);
    std::erase_if(settings,
                  [&](const auto& setting) { return set_sweep_option(options, setting.first, setting.second); });
    auto parameters = sim::qzs_twin(twin);
    sim::set_parameters(parameters, settings, "of the sweep", sweep_option_names());
    console.step(fmt::format("sweeping {} mm up and down, {} to {} Hz", 1e3 * options.amplitude_m, options.from_hz,
                             options.to_hz));
    const ReportedResponse reported{sim::frequency_response(parameters, options), {}, {}};
    truth["twin"] = twin;
    put_equation(truth, sim::parameter_values(parameters), sim::true_terms(parameters));
    truth["sweep"] = sweep_json(options);
    truth["frequency_response"] = response_json(reported.response);
    folder.write("frc.csv", response_csv(reported));
    folder.write("frc.json",
                 text_of(ordered_json{{"sweep", truth["sweep"]}, {"frequency_response", truth["frequency_response"]}}));
    folder.write("frc.svg", to_svg(response_figure(reported, fmt::format("Twin {}, base motion of {:g} mm", twin,
                                                                         1e3 * options.amplitude_m))));
    if (!console.json()) console.result(response_text(reported.response));
    return {"frc.csv", "frc.json", "frc.svg"};
  } catch (const std::invalid_argument& error) {
    throw refused_by_rig(error);
  }
}

}  // namespace apps
