#include "apps/cli/response_command.hpp"
#include "apps/output/bodies_file.hpp"

#include <fmt/format.h>

#include <memory>
#include <stdexcept>

#include "apps/cli/command.hpp"
#include "apps/config/sweep_settings.hpp"
#include "apps/output/equation_file.hpp"
#include "apps/output/equation_response.hpp"
#include "apps/output/finished_run.hpp"
#include "apps/page/outcome_pages.hpp"
#include "apps/process/output_folder.hpp"
#include "apps/process/path.hpp"

namespace apps {
namespace {

EquationResponse respond(const ResponseArguments& arguments, Console& console) try {
  const auto poll = shown_poll(console, "computing the frequency response");
  EquationResponse result;
  result.equation = read_equation(arguments.run, arguments.range, arguments.method);
  auto driven = ident::equation_oscillator(result.equation, result.equation.mean);
  result.drive = driven.drive;
  result.has_friction = driven.has_friction;
  result.static_friction = arguments.static_friction.value_or(0.0);
  if (!(result.static_friction >= 0.0) || (arguments.static_friction && !driven.has_friction))
    refuse_sweep("--static-friction must not be negative, and needs an equation with sgn(v)");
  driven.oscillator.static_friction = result.static_friction;
  result.steps = read_final_steps(arguments.run);
  const auto [sweep, amplitude_measured] = sweep_of(arguments.set, driven, result.equation.largest_x, result.steps);
  result.sweep = sweep;
  result.num_draws = arguments.num_draws;
  const bool is_base = driven.drive == ident::DriveKind::base;
  if (amplitude_measured) result.amplitude_std = is_base ? result.equation.displacement_std : result.equation.force_std;
  result.seed = arguments.seed;
  result.steady = sim::steady_response(driven.oscillator, result.sweep, {.poll = poll});
  if (result.steady.response.up.empty() || result.steady.response.down.empty())
    throw dsp::Fault(dsp::FaultKind::numerics, "frc.diverged",
                     fmt::format("frc: the motion runs away at {:.5g} Hz, where the sweep begins. Begin at another "
                                 "frequency or lower the amplitude",
                                 result.steady.diverged_hz));
  if (arguments.num_draws > 0)
    result.draws = ident::response_draws(result.equation, result.sweep,
                                         {.num_draws = arguments.num_draws,
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
  refuse_bodies_run(arguments.run, "frc");
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
