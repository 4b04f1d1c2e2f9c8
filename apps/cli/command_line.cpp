#include "apps/cli/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <thread>

#include "apps/cli/compare_command.hpp"
#include "apps/cli/fit_command.hpp"
#include "apps/cli/info_command.hpp"
#include "apps/cli/init_command.hpp"
#include "apps/cli/replicate_command.hpp"
#include "apps/cli/report_command.hpp"
#include "apps/cli/response_command.hpp"
#include "apps/cli/run_command.hpp"
#include "apps/cli/simulate_command.hpp"
#include "apps/cli/study_command.hpp"
#include "apps/cli/terms_command.hpp"
#include "apps/process/console.hpp"
#include "apps/process/ending.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/process/standard_streams.hpp"
#include "apps/process/version.hpp"

namespace apps {
namespace {

/// What is allowed anywhere on the command line.
struct GlobalOptions {
  std::filesystem::path output;
  bool quiet = false, json = false, dry_run = false, force = false, strict = false;
  int verbosity = 0, num_threads = 0;
  std::uint64_t seed = 1;
  std::vector<std::string> set;
  ProgressMode progress = ProgressMode::automatic;
};

using Command = std::function<int(Console&)>;

/// A whole number in decimal digits, refused in one short line. Leading zeros go: CLI11 would read it as octal.
CLI::Validator whole(std::uint64_t from, std::uint64_t to = std::numeric_limits<std::uint64_t>::max()) {
  return {[=](std::string& text) {
            std::uint64_t value = 0;
            const char* const end = text.data() + text.size();
            const auto [read_to, error] = std::from_chars(text.data(), end, value);
            if (text.empty() || read_to != end || error != std::errc() || value < from || value > to)
              return fmt::format("want a whole number from {} to {}, got {}", from, to, text);
            text = std::to_string(value);
            return std::string();
          },
          ""};
}

/// A finite number above zero, or zero too, refused in one short line.
CLI::Validator finite(bool zero_too) {
  return {[=](std::string& text) {
            double value = 0.0;
            const bool fits = CLI::detail::lexical_cast(text, value) && std::isfinite(value) &&
                              (zero_too ? value >= 0.0 : value > 0.0);
            return fits ? std::string()
                        : fmt::format("want a finite number {} 0, got {}", zero_too ? "not below" : "above", text);
          },
          zero_too ? "NOT NEGATIVE" : "POSITIVE"};
}
CLI::Validator not_negative() {
  return finite(true);
}

void add_global_options(CLI::App& app, GlobalOptions& options) {
  app.add_option("-o,--output", options.output, "Folder for the results")->type_name("DIR");
  app.add_flag("-q,--quiet", options.quiet, "Results and errors only");
  app.add_flag("-v,--verbose", options.verbosity, "Notes too");
  app.add_flag("--json", options.json, "One JSON document on standard output");
  app.add_option("--seed", options.seed, "Seed of whatever is random")->transform(whole(0))->capture_default_str();
  app.add_option("--threads", options.num_threads,
                 "Threads; 0: as many as there are processors. The results are the same")
      ->transform(whole(0, 1024))
      ->option_text("INT=0");
  app.add_flag("--dry-run", options.dry_run, "Say what would be done");
  app.add_flag("--force", options.force, "Replace an earlier result");
  app.add_flag("--strict", options.strict, "Warnings are errors");
  app.add_option("--set", options.set, "Override a setting: a.b=c")->type_name("KEY=VALUE")->allow_extra_args(false);
  const std::map<std::string, ProgressMode> modes{
      {"auto", ProgressMode::automatic}, {"always", ProgressMode::always}, {"never", ProgressMode::never}};
  app.add_option("--progress", options.progress, "auto (on a terminal), always or never")
      ->transform(CLI::CheckedTransformer(modes))
      ->option_text("WHEN=auto");
  app.set_version_flag("--version", version_text());
}

int num_threads(const GlobalOptions& options) {
  return options.num_threads > 0 ? options.num_threads
                                 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Options that are allowed anywhere and would have no effect on a command are refused, not ignored.
void refuse_unused(const CLI::App& app) {
  static const std::map<std::string, std::vector<std::string>> unused{
      {"info", {"--output", "--seed", "--dry-run", "--set"}},
      {"check", {"--output", "--seed", "--dry-run"}},
      {"report", {"--output", "--seed", "--dry-run", "--set", "--force", "--threads"}},
      {"sim", {"--dry-run"}},
      {"replicate", {"--dry-run", "--seed", "--set"}},
      {"fit", {"--output", "--seed", "--dry-run", "--set"}},
      {"init", {"--seed", "--dry-run", "--set"}},
      {"compare", {"--output", "--seed", "--dry-run", "--set"}},
      {"terms", {"--output", "--seed", "--dry-run", "--set"}}};
  const auto found = unused.find(app.get_subcommands().front()->get_name());
  if (found == unused.end()) return;
  for (const std::string& option : found->second)
    if (app.get_option(option)->count() > 0)
      throw dsp::Fault(dsp::FaultKind::usage, "usage",
                       fmt::format("{}: {} has no effect on this command. Leave it out{}", found->first, option,
                                   option == "--seed" && found->first == "replicate" ? ", or give --first-seed" : ""));
}

void add_info(CLI::App& app, const GlobalOptions& global, Command& chosen) {
  auto* command = app.add_subcommand("info", "What a recording is: container, channels, rate, length, sidecar");
  auto files = std::make_shared<std::vector<std::filesystem::path>>();
  auto salvage = std::make_shared<bool>(false);
  command->add_option("FILE", *files, "Recordings")->required();
  command->add_flag("--salvage", *salvage, "Also what is left of a truncated file");
  command->callback([=, &global, &chosen] {
    chosen = [=, &global](Console& console) {
      run_info(*files, *salvage, global.strict, console);
      return 0;
    };
  });
}

/// run, prep, check and study share their arguments.
CLI::App* add_run(CLI::App& app, const char* name, const char* help, const GlobalOptions& global,
                  const std::vector<std::string>& command_line, Command& chosen,
                  std::function<int(const RunArguments&, Console&)> action) {
  auto* command = app.add_subcommand(name, help);
  auto arguments = std::make_shared<RunArguments>();
  auto max_memory_mb = std::make_shared<std::size_t>(0);
  command->add_option("INPUT", arguments->input, "A config (NAME.toml), or a recording")->required();
  command->add_flag("--salvage", arguments->salvage, "Read what is left of a truncated recording");
  command->add_flag("--uncalibrated", arguments->uncalibrated, "Channels without a sensitivity stay raw");
  command->add_option("--max-memory", *max_memory_mb, "Most memory a recording may take")
      ->transform(whole(1, 1 << 30))
      ->option_text("MB");
  command->callback([=, &global, &chosen] {
    chosen = [=, &global](Console& console) {
      RunArguments all = *arguments;
      all.folder = global.output;
      all.force = global.force;
      all.dry_run = global.dry_run;
      all.strict = global.strict;
      all.num_threads = num_threads(global);
      all.max_memory_bytes = *max_memory_mb * 1000000;
      all.seed = global.seed;
      all.set = global.set;
      all.command_line = command_line;
      return action(all, console);
    };
  });
  return command;
}

void add_study(CLI::App& app, const GlobalOptions& global, const std::vector<std::string>& command_line,
               Command& chosen) {
  auto varied = std::make_shared<StudyArguments>();
  auto* command = add_run(app, "study", "How an identification depends on its settings", global, command_line, chosen,
                          [varied](const RunArguments& arguments, Console& console) {
                            varied->run = arguments;
                            return run_study(*varied, console);
                          });
  command
      ->add_option(
          "--over", varied->over,
          "order, cutoff_hz, rolloff_hz, tau, threshold, selection, recipe, train_share, target, or any key of "
          "a config: KEY=V1,V2,...")
      ->allow_extra_args(false);
  command->add_flag("--grid", varied->grid, "Every combination instead of one setting at a time");
}

/// --ridge-lambda for the setting ridge_lambda.
void add_method_setting(CLI::App& command, const ident::MethodSetting& setting,
                        const std::shared_ptr<FitArguments>& arguments) {
  std::string name = fmt::format("--{}", setting.name);
  std::replace(name.begin(), name.end(), '_', '-');
  const double preset = arguments->settings.value(setting.name);
  if (setting.words.empty()) {
    auto* option = command.add_option_function<double>(
        name, [&setting, arguments](double value) { arguments->settings.set(setting.name, value); },
        std::string(setting.help));
    option->check(setting.may_be_zero ? not_negative() : CLI::Validator(CLI::PositiveNumber));
    if (preset >= 0.0) option->default_str(fmt::format("{}", preset));
    return;
  }
  command
      .add_option_function<std::string>(
          name,
          [&setting, arguments](const std::string& word) {
            arguments->settings.set(setting.name, setting.index_of(word));
          },
          std::string(setting.help))
      ->check(CLI::IsMember(std::vector<std::string>(setting.words.begin(), setting.words.end())))
      ->default_str(std::string(setting.words[static_cast<std::size_t>(preset)]));
}

void add_fit(CLI::App& app, const GlobalOptions& global, Command& chosen) {
  auto* command = app.add_subcommand("fit", "Regression on a table: one column from expressions of the others");
  auto arguments = std::make_shared<FitArguments>();
  command->add_option("TABLE", arguments->table, "CSV or another table that `run` reads")->required();
  command->add_option("--target", arguments->target, "Column to explain")->required();
  command->add_option("--terms", arguments->terms, "\"1,x,x^2\", or a file with a term a line")->required();
  std::vector<std::string_view> names;
  std::string words = "Methods:";
  for (const ident::MethodDescription& method : ident::methods()) {
    names.push_back(method.name);
    words += fmt::format("\n  {:<10} {}", method.name, method.help);
  }
  command->footer(words);
  command
      ->add_option("--methods", arguments->methods,
                   fmt::format("One or several, commas between: {}", fmt::join(names, ",")))
      ->type_name("NAME[,NAME]")
      ->delimiter(',')
      ->allow_extra_args(false);
  for (const ident::MethodSetting& setting : ident::method_settings()) add_method_setting(*command, setting, arguments);
  command->add_flag_callback(
      "--raw-threshold",
      [arguments] {
        arguments->settings.set("threshold_on", ident::find_method_setting("threshold_on")->index_of("raw"));
      },
      "The same as --threshold-on raw");
  command->add_option("--where", arguments->where, "Condition on the rows");
  command->callback([=, &global, &chosen] {
    chosen = [=, &global](Console& console) {
      arguments->num_threads = num_threads(global);
      arguments->strict = global.strict;
      return run_fit(*arguments, console);
    };
  });
}

void add_init(CLI::App& app, const GlobalOptions& global, Command& chosen) {
  auto* command = app.add_subcommand("init", "A first sidecar and config for a recording");
  auto file = std::make_shared<std::filesystem::path>();
  command->add_option("FILE", *file, "Recording")->required();
  command->callback([=, &global, &chosen] {
    chosen = [=, &global](Console& console) {
      run_init(*file, global.output, global.force, console);
      return 0;
    };
  });
}

void add_terms(CLI::App& app, Command& chosen) {
  app.add_subcommand("terms", "Names and functions allowed in candidate terms")->callback([&chosen] {
    chosen = [](Console& console) {
      run_terms(console);
      return 0;
    };
  });
}

void add_report(CLI::App& app, const GlobalOptions& global, Command& chosen) {
  auto* command = app.add_subcommand("report", "The page of a finished run again");
  auto run = std::make_shared<std::filesystem::path>();
  command->add_option("RUN", *run, "Run folder")->required();
  command->callback([=, &global, &chosen] {
    chosen = [=, &global](Console& console) {
      run_report(*run, global.strict, console);
      return 0;
    };
  });
}

void add_compare(CLI::App& app, const GlobalOptions& global, Command& chosen) {
  auto* command = app.add_subcommand("compare", "The equations of several runs side by side");
  auto arguments = std::make_shared<CompareArguments>();
  command->add_option("RUN", arguments->runs, "Run folders")->required();
  command->add_option("--truth", arguments->truth, "truth.json of the simulation the recording came from");
  command->add_option("--method", arguments->method, "Method to show");
  command->callback([=, &global, &chosen] {
    chosen = [=, &global](Console& console) {
      arguments->strict = global.strict;
      run_compare(*arguments, console);
      return 0;
    };
  });
}

void add_sim(CLI::App& app, const GlobalOptions& global, const std::vector<std::string>& command_line,
             Command& chosen) {
  auto* command = app.add_subcommand("sim", "A known system's response and truth, as files");
  auto arguments = std::make_shared<SimulateArguments>();
  command->add_option("SYSTEM", arguments->system, "duffing, coulomb, bouc-wen, valanis-1 ... valanis-4, linear, qzs")
      ->required();
  command->add_option("--noise", arguments->noise,
                      "Fraction of each signal's standard deviation; qzs: times the sensors' own");
  command->add_option("--duration", arguments->duration_s, "Seconds");
  command->add_flag("--frc", arguments->frc,
                    "qzs: amplitude against frequency, swept up and down; --set from_hz, to_hz, step_hz, dwell_s, "
                    "transition_s, amplitude_mm");
  command->add_option("--programme", arguments->programme,
                      "qzs: down (stepped sine, the default), up, or decay (released by hand); --set amplitude_mm, "
                      "dwell_s, from_hz, to_hz, step_hz; decay: amplitude_mm, dwell_s, releases");
  command->add_flag("--raw", arguments->raw, "qzs: also the recording at 25.6 kHz");
  command->add_option("--twin", arguments->twin, "qzs: T0 or T1");
  command->add_option("--sensors", arguments->sensors, "qzs --raw: ideal, noise, full or random");
  command->add_option("--from", arguments->from_s, "qzs --raw: first second of the recording");
  command->add_option("--rate", arguments->rate_hz, "qzs --raw: rate of the recording, Hz; 25600 unless lower");
  command->footer(
      "Parameters of the system by --set name=number. qzs --raw, failing sensors (channel by name or index, seconds):\n"
      "  --set rail=payload_laser:300:300.4       at the upper rail\n"
      "  --set hold=2:300:300.4                   stuck at its value\n"
      "  --set clip=payload_accelerometer:0:9:0.02  limited to +-0.02 V");
  command->add_option("--container", arguments->container,
                      "qzs --raw: rf64 (as recording.wav, which holds more than 4 GiB), wav, w64, caf, flac, aiff");
  command->callback([=, &global, &chosen] {
    chosen = [=, &global](Console& console) {
      if (global.output.empty())
        throw dsp::Fault(dsp::FaultKind::usage, "usage", "sim: -o DIR is missing. Say where the files are to go");
      SimulateArguments all = *arguments;
      all.folder = global.output;
      all.force = global.force;
      all.seed = global.seed;
      all.set = global.set;
      all.command_line = command_line;
      run_simulate(all, console);
      return 0;
    };
  });
}

void add_frc(CLI::App& app, const GlobalOptions& global, const std::vector<std::string>& command_line,
             Command& chosen) {
  auto* command = app.add_subcommand("frc", "Frequency response of an identified equation, with its uncertainty");
  auto arguments = std::make_shared<ResponseArguments>();
  command->add_option("RUN", arguments->run, "Run folder")->required();
  command->add_option("--range", arguments->range, "Range whose equation it is; mixed, or the first, unless said");
  command->add_option("--method", arguments->method, "Method that found it; fast_rvm unless said");
  command->add_option("--draws", arguments->num_draws, "Draws of the coefficients; 0: no uncertainty")
      ->transform(whole(0, 100000))
      ->option_text("INT=40");
  command
      ->add_option("--static-friction", arguments->static_friction,
                   "What a resting payload withstands, m/s^2; slipping does not show it")
      ->check(not_negative());
  command->footer("--set from_hz, to_hz, step_hz, amplitude_mm of the base (amplitude, where a force drives)");
  command->callback([=, &global, &chosen] {
    chosen = [=, &global](Console& console) {
      ResponseArguments all = *arguments;
      all.folder = global.output;
      all.seed = global.seed;
      all.set = global.set;
      all.num_threads = num_threads(global);
      all.force = global.force;
      all.strict = global.strict;
      all.command_line = command_line;
      run_response(all, console);
      return 0;
    };
  });
}

void add_replicate(CLI::App& app, const GlobalOptions& global, const std::vector<std::string>& command_line,
                   Command& chosen) {
  auto* command = app.add_subcommand("replicate", "The paper's tables and figures again, beside what it printed");
  auto arguments = std::make_shared<ReplicateArguments>();
  command
      ->add_option("ITEM", arguments->items,
                   "A case (duffing, coulomb, bouc-wen, bouc-wen-2, valanis-1 ... valanis-4, qzs-low, qzs-high, "
                   "qzs-mixed, qzs), table-1 ... table-12, fig-2 ... fig-9, fig-11 ... fig-13, all")
      ->required();
  command->add_option("--seeds", arguments->num_seeds, "How many draws of the noise")
      ->transform(whole(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--first-seed", arguments->first_seed, "The first of them")
      ->transform(whole(0))
      ->capture_default_str();
  command->add_option("--noise", arguments->noise,
                      "Fraction of each target's standard deviation (0.1); qzs: times the sensors' own (1)");
  command->add_option("--selection", arguments->selection, "evidence or type2 (the paper's)")->capture_default_str();
  command->add_option("--tau", arguments->tau, "What a term's gain must exceed");
  command->callback([=, &global, &chosen] {
    chosen = [=, &global](Console& console) {
      if (global.output.empty())
        throw dsp::Fault(dsp::FaultKind::usage, "usage", "replicate: -o DIR is missing. Say where the files are to go");
      ReplicateArguments all = *arguments;
      all.folder = global.output;
      all.force = global.force;
      all.command_line = command_line;
      run_replicate(all, console);
      return 0;
    };
  });
}

void add_commands(CLI::App& app, const GlobalOptions& global, const std::vector<std::string>& command_line,
                  Command& chosen) {
  add_info(app, global, chosen);
  add_run(app, "check", "All checks of a run, nothing written", global, command_line, chosen,
          [](const RunArguments& arguments, Console& console) {
            run_check(arguments, console);
            return 0;
          });
  add_run(app, "run", "From a recording to its equation of motion", global, command_line, chosen, run_identification);
  add_run(app, "prep", "Calibration, decimation and motion only", global, command_line, chosen,
          [](const RunArguments& arguments, Console& console) {
            run_preparation(arguments, console);
            return 0;
          });
  add_study(app, global, command_line, chosen);
  add_sim(app, global, command_line, chosen);
  add_frc(app, global, command_line, chosen);
  add_replicate(app, global, command_line, chosen);
  add_fit(app, global, chosen);
  add_init(app, global, chosen);
  add_compare(app, global, chosen);
  add_report(app, global, chosen);
  add_terms(app, chosen);
}

/// Reads the command line into `chosen`; false where the help or the version was asked for, and printed.
bool parse(CLI::App& app, int argc, const char* const* argv, Console& console) {
  try {
    app.parse(argc, argv);
    return true;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0)
      throw dsp::Fault(dsp::FaultKind::usage, "usage", fmt::format("{}. See ardent --help", error.what()));
    std::ostringstream text;  // --help, --version
    app.exit(error, text);
    console.result(text.str());
    return false;
  }
}

/// Does what the command line says. Until it is read, `console` is one of its own.
int run(int argc, const char* const* argv, const std::vector<std::string>& command_line, Console& console) {
  CLI::App app("From raw vibration recordings to an equation of motion with error bars", "ardent");
  app.require_subcommand(1);
  app.fallthrough();
  GlobalOptions global;
  Command chosen;
  add_global_options(app, global);
  add_commands(app, global, command_line, chosen);
  if (!parse(app, argc, argv, console)) return 0;
  console =
      Console({.verbosity = global.quiet ? -1 : global.verbosity, .json = global.json, .progress = global.progress});
  refuse_unused(app);
  return chosen(console);
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  reserve_standard_streams();
  install_signal_handlers();
  Console console(ConsoleOptions{
      .json = std::any_of(argv, argv + argc, [](std::string_view argument) { return argument == "--json"; })});
  const auto action = [&] {
    return run(argc, argv, std::vector<std::string>(argv + std::min(argc, 1), argv + argc), console);
  };
  return ending_of(std::ref(action), console);  // by reference: a copy might find no memory
}

}  // namespace apps
