#include "apps/cli/response_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <stdexcept>
#include <utility>

#include "apps/cli/command.hpp"
#include "apps/cli/sweep_settings.hpp"
#include "apps/output/bodies_file.hpp"
#include "apps/output/equation_file.hpp"
#include "apps/output/equation_response.hpp"
#include "apps/output/finished_run.hpp"
#include "apps/output/output_folder.hpp"
#include "apps/page/outcome_pages.hpp"
#include "apps/process/path.hpp"
#include "apps/process/printable.hpp"
#include "ident/bodies/driven_bodies.hpp"
#include "ident/bodies/modes.hpp"

namespace apps {
namespace {

/// Of which the free vibration, the response itself and its draws are those of an equation.
struct Responding {
  SweptEquation swept;
  sim::DrivenSystem driven;
  std::function<ident::ResponseDraws(const sim::FrequencyResponseOptions& sweep, const ident::DrawOptions& options)>
      draws;
  double calibration_std = 0.0;  ///< of the drive
};

Responding one_body(const ResponseArguments& arguments, EquationResponse& result) {
  const ident::IdentifiedEquation equation = read_equation(arguments.run, arguments.range, arguments.method);
  auto [oscillator, drive, has_friction] = ident::equation_oscillator(equation, equation.mean);
  result.equation = responding(equation);
  result.has_friction = has_friction;
  result.static_friction = arguments.static_friction.value_or(0.0);
  if (!(result.static_friction >= 0.0) || (arguments.static_friction && !has_friction))
    refuse_sweep("--static-friction must not be negative, and needs an equation with sgn(v)");
  if (arguments.body > 1 || !arguments.input.empty())
    refuse_sweep("--body and --input choose among several bodies and inputs: this run has one of each");
  oscillator.static_friction = result.static_friction;
  result.steps = read_final_steps(arguments.run);
  const bool is_base = drive == ident::DriveKind::base;
  return {.swept = {.drive = drive,
                    .free_hz = ident::free_frequencies_hz(oscillator, equation.largest_x),
                    .none_because = equation.largest_x > 0.0 ? "nothing in the equation pulls x back"
                                                             : "how far x went is not known"},
          .driven = sim::driven_system(std::move(oscillator)),
          .draws = [equation](const auto& sweep,
                              const auto& options) { return ident::response_draws(equation, sweep, options); },
          .calibration_std = is_base ? equation.displacement_std : equation.force_std};
}

std::string chosen_input(const ResponseArguments& arguments, const ident::BodiesLayout& layout) {
  const std::vector<std::string> drives = ident::drives_of(layout);
  const std::string listed = fmt::format("{}", fmt::join(drives, ", "));
  if (drives.empty()) refuse_sweep("nothing drives the bodies: no base and no force was recorded");
  if (arguments.input.empty() && drives.size() > 1)
    refuse_sweep(fmt::format("there are several inputs, {}: choose one with --input", listed));
  if (arguments.input.empty()) return drives.front();
  if (std::find(drives.begin(), drives.end(), arguments.input) == drives.end())
    refuse_sweep(fmt::format("no input \"{}\"; there is {}", printable(arguments.input), listed));
  return arguments.input;
}

/// What its x is.
std::string coordinates_of(const ident::BodiesLayout& layout, const std::string& response) {
  if (layout.sensor_lags()) return "x is the motion itself, of which the sensor shows z.";
  if (layout.frame == ident::Frame::ground) return {};
  return fmt::format("In the equations displacements are {}. Below, x is that of {} against the base, y absolute.",
                     layout.frame == ident::Frame::base ? "relative to the base" : "absolute, r the base's", response);
}

Responding several_bodies(const ResponseArguments& arguments, EquationResponse& result) {
  if (arguments.static_friction || !arguments.range.empty() || !arguments.method.empty())
    refuse_sweep(
        "a run with several bodies or an inner state has one set of equations and no static friction: leave "
        "--range, --method and --static-friction out");
  const FinishedBodies found = read_bodies(arguments.run);
  const ident::BodiesModel& model = found.model;
  const std::string input = chosen_input(arguments, model.layout);
  const int body = std::max(1, arguments.body);
  if (body > model.layout.num_bodies)
    refuse_sweep(fmt::format("there are bodies 1 to {}, got --body {}", model.layout.num_bodies, body));
  if (arguments.num_draws > 0 && !model.covariance.allFinite())
    refuse_sweep("how uncertain the coefficients are is not known: --draws 0");
  const std::string response = model.layout.response(body);
  result.has_friction = std::any_of(model.terms.begin(), model.terms.end(), [](const ident::BodyTerm& term) {
    return term.name.find("sgn(") != std::string::npos;
  });
  result.equation = {.of = fmt::format("{} driven by {}", response, input),
                     .title = fmt::format("Response of {} to {}", response, input),
                     .keys = {{"of", response}, {"input", input}},
                     .text = {},
                     .coordinates = coordinates_of(model.layout, response),
                     .x_unit = found.length,
                     .verdict = ident::verdict_from_string(found.verdict).value_or(ident::Verdict::undecided),
                     .largest_x = found.largest[static_cast<std::size_t>(body) - 1],
                     .takes_static_friction = false};
  for (const ident::Model& one : models_of(model, found.length))
    result.equation.text += (result.equation.text.empty() ? "" : "; ") + to_text(one);
  Responding responding;  // not as an aggregate: where a member throws, g++ 12 destroys those before it twice
  responding.driven = ident::driven_bodies(model, input, body);
  responding.draws = [=](const auto& sweep, const auto& options) {
    return ident::response_draws(sweep, options, [&](std::size_t k) {
      ident::BodiesModel drawn = model;
      drawn.mean = ident::drawn_coefficients(model.mean, model.covariance, options.seed, k);
      return ident::DrawnSystem{.driven = ident::driven_bodies(drawn, input, body)};
    });
  };
  responding.swept.drive = ident::kind_of_drive(input);
  responding.swept.input = input;
  responding.swept.none_because = "at rest no mode swings";
  for (const ident::Mode& mode : ident::modes_of(model.layout, model.terms, model.mean, model.covariance)) {
    auto& hz = responding.swept.free_hz;
    hz = {hz ? hz->first : mode.frequency_hz, mode.frequency_hz};  // slowest first
  }
  return responding;
}

EquationResponse respond(const ResponseArguments& arguments, Console& console) try {
  const auto poll = shown_poll(console, "computing the frequency response");
  EquationResponse result;
  const Responding responding =
      is_bodies_run(arguments.run) ? several_bodies(arguments, result) : one_body(arguments, result);
  const auto [sweep, amplitude_measured] = sweep_of(arguments.set, responding.swept, result.steps);
  result.drive = responding.swept.drive;
  result.input = responding.swept.input;
  result.sweep = sweep;
  result.num_draws = arguments.num_draws;
  if (amplitude_measured) result.amplitude_std = responding.calibration_std;
  result.seed = arguments.seed;
  result.steady = sim::steady_response(responding.driven, result.sweep, {.poll = poll});
  if (result.steady.response.up.empty() || result.steady.response.down.empty())
    throw dsp::Fault(dsp::FaultKind::numerics, "frc.diverged",
                     fmt::format("frc: the motion runs away at {:.5g} Hz, where the sweep begins. Begin at another "
                                 "frequency or lower the amplitude",
                                 result.steady.diverged_hz));
  if (arguments.num_draws > 0)
    result.draws = responding.draws(result.sweep, {.num_draws = arguments.num_draws,
                                                   .seed = arguments.seed,
                                                   .num_threads = arguments.num_threads,
                                                   .static_friction = result.static_friction,
                                                   .amplitude_measured = amplitude_measured,
                                                   .steady = {.poll = poll}});
  return result;
} catch (const std::invalid_argument& error) {
  refuse_sweep(error.what());
}

}  // namespace

void run_response(const ResponseArguments& arguments, Console& console) {
  const std::filesystem::path equation = arguments.run / "equation.json";
  const std::filesystem::path destination =
      arguments.folder.empty() ? named_path(arguments.run).concat("-frc") : arguments.folder;
  check_finished_run(arguments.run, arguments.strict, console);
  require_apart(destination, {equation});
  OutputFolder folder(destination, arguments.force);
  Manifest manifest = begin_manifest("frc", arguments.command_line, arguments.seed, folder.destination());
  const EquationResponse result = respond(arguments, console);
  const std::string document = response_document(result);
  folder.write("frc.csv", response_csv(result));
  folder.write("frc.svg", to_svg(response_figure(result)));
  folder.write("frc.html", response_page(result));
  folder.write("frc.json", document);
  add_input(manifest, equation, folder.destination());
  manifest.warnings = console.warnings();
  folder.commit(std::move(manifest));
  console.result(console.json()
                     ? document
                     : response_text(result) + fmt::format("\nresults are in {}\n", folder.destination().string()));
}

Command response_command() {
  const auto typed = std::make_shared<ResponseArguments>();
  return {
      .name = "frc",
      .help = "Frequency response of an identified equation, with its uncertainty",
      .group = use_group,
      .options = {{"RUN", &typed->run, "Run folder.", {.required = true}},
                  {"--range", &typed->range, "Range whose equation is used. Left out: the one that the run chose."},
                  {"--method", &typed->method, "Method that found it. Left out: the one whose verdict the range has."},
                  {"--body",
                   &typed->body,
                   "Of several bodies, the one whose response is looked at. Left out: 1.",
                   {.name = "K", .check = whole_number(1, 1000)}},
                  {"--input", &typed->input, "Of several inputs, the one that drives: f, f2 ...; r for the base."},
                  {"--draws",
                   &typed->num_draws,
                   "Draws of the coefficients; 0: no uncertainty.",
                   {.name = "N", .preset = std::to_string(typed->num_draws), .check = whole_number(0, 100000)}},
                  {"--static-friction",
                   &typed->static_friction,
                   "Static friction per mass, m/s^2, which motion that slips does not show.",
                   {.check = non_negative_number()}}},
      .run =
          [typed](const GlobalOptions& global, Console& console) {
            ResponseArguments arguments = *typed;
            arguments.folder = global.output;
            arguments.seed = global.seed;
            arguments.set = global.set;
            arguments.num_threads = thread_count(global);
            arguments.force = global.force;
            arguments.strict = global.strict;
            arguments.command_line = global.command_line;
            run_response(arguments, console);
            return 0;
          },
      .more = {"--set from_hz, to_hz, step_hz: left out, about the frequencies of equation and record",
               "--set amplitude_mm of the base (left out: as in the record's steps, or 4.5), or amplitude of f"},
      .examples = {"ardent frc drive-run",
                   "ardent frc drive-run --range mixed --set amplitude_mm=4 --static-friction 0.385"}};
}

}  // namespace apps
