#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <memory>

#include "apps/cli/command.hpp"
#include "apps/export/printed_equation.hpp"
#include "apps/output/bodies_file.hpp"
#include "apps/output/finished_run.hpp"
#include "apps/output/output_folder.hpp"
#include "apps/output/run_json.hpp"
#include "apps/process/path.hpp"

namespace apps {
namespace {

namespace fs = std::filesystem;

struct ExportArguments {
  fs::path run;
  std::string to, range, method;
};

/// By the system's C compiler, whatever it says going to our standard error. Files of a folder that is reached by a
/// descriptor of ours alone have another name for it.
void compile(const fs::path& source, const fs::path& library) {
  const fs::path folder = fs::canonical(source.parent_path());
  std::vector<std::string> line{"cc",
                                "-shared",
                                "-fPIC",
                                "-O2",
                                "-fvisibility=hidden",
                                "-o",
                                folder / library.filename(),
                                folder / source.filename(),
                                "-lm"};
  std::vector<char*> words;
  for (std::string& word : line) words.push_back(word.data());
  words.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  pid_t pid = 0;
  const int failed = ::posix_spawnp(&pid, "cc", &actions, nullptr, words.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  if (failed == 0) ::waitpid(pid, &status, 0);
  if (failed != 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw dsp::Fault(dsp::FaultKind::output, "export.compiler",
                     fmt::format("the C compiler cc {}; a model for co-simulation wants it: apt install gcc, or "
                                 "--to c and compile elsewhere",
                                 failed != 0 ? fmt::format("cannot be run ({})", std::strerror(failed))
                                             : std::string("ended with an error")));
}

void write_fmu(const ExportedEquation& equation, const OutputFolder& folder) {
  const FmuTexts texts = printed_fmu(equation);
  folder.write("equation.c", texts.source);
  folder.write("modelDescription.xml", texts.description);
  compile(folder.path("equation.c"), folder.path("equation.so"));
  folder.write("equation.fmu", zipped({{"modelDescription.xml", texts.description},
                                       {"sources/equation.c", texts.source},
                                       {"binaries/linux64/equation.so", read_run_file(folder.path("equation.so"))}}));
}

struct Destination {
  std::string_view word, file;
  std::string (*print)(const ExportedEquation&);  ///< none: several files
};
constexpr std::array<Destination, 7> destinations{{{"python", "equation.py", printed_python},
                                                   {"matlab", "equation.m", printed_matlab},
                                                   {"c", "equation.c", printed_c},
                                                   {"modelica", "Equation.mo", printed_modelica},
                                                   {"latex", "equation.tex", printed_latex},
                                                   {"json", "equation.json", printed_json},
                                                   {"fmu", "equation.fmu", nullptr}}};

int export_equation(const ExportArguments& arguments, const GlobalOptions& global, Console& console) {
  const fs::path equation_file = arguments.run / "equation.json";
  const fs::path destination =
      global.output.empty() ? named_path(arguments.run).concat("-" + arguments.to) : fs::path(global.output);
  check_finished_run(arguments.run, global.strict, console);
  require_apart(destination, {equation_file});
  OutputFolder folder(destination, global.force);
  Manifest manifest = begin_manifest("export", global.command_line, global.seed, folder.destination());
  const bool are_bodies = is_bodies_run(arguments.run);
  if (are_bodies && !(arguments.range.empty() && arguments.method.empty()))
    throw dsp::Fault(dsp::FaultKind::usage, "usage",
                     "export: --range and --method are for runs of one body. Leave them out");
  const ExportedEquation equation = are_bodies
                                        ? read_exported_bodies(arguments.run)
                                        : read_exported_equation(arguments.run, arguments.range, arguments.method);
  if (!equation.run) console.warning("export.no_free_run", "nothing to compare the program with: " + equation.no_run);
  refuse_warnings(global.strict, console);
  std::string_view file;
  for (const Destination& one : destinations) {
    if (one.word != arguments.to) continue;
    file = one.file;
    if (one.print != nullptr)
      folder.write(one.file, one.print(equation));
    else
      write_fmu(equation, folder);
  }
  if (equation.run && arguments.to != "latex") folder.write("free_run.csv", printed_run(equation, *equation.run));
  for (const char* name : {"equation.json", "metrics.json", "prepared.csv"})
    if (fs::exists(arguments.run / name)) add_input(manifest, arguments.run / name, folder.destination());
  manifest.warnings = console.warnings();
  folder.commit(std::move(manifest));
  console.result(console.json() ? fmt::format("{{\"file\": \"{}\"}}\n", file)
                                : fmt::format("{}\n{} in {}, {}\n", text_of_models(equation, "\n"),
                                              equation.models.size() == 1 ? "it is" : "they are",
                                              (folder.destination() / file).string(), origin_of(equation)));
  return 0;
}

}  // namespace

Command export_command() {
  const auto typed = std::make_shared<ExportArguments>();
  OptionValue to{.name = "LANGUAGE", .required = true};
  for (const Destination& one : destinations) to.words.emplace_back(one.word);
  return {
      .name = "export",
      .help = "The equation of a run as a program or model that runs elsewhere",
      .group = use_group,
      .unused = {{"--seed"}, {"--dry-run"}, {"--set"}, {"--threads"}},
      .options = {{"RUN", &typed->run, "Run folder.", {.required = true}},
                  {"--to", &typed->to, "What it is written as.", to},
                  {"--range", &typed->range, "Range whose equation is used. Left out: the one that the run chose."},
                  {"--method", &typed->method, "Method that found it. Left out: the one whose verdict the range has."}},
      .run = [typed](const GlobalOptions& global,
                     Console& console) { return export_equation(*typed, global, console); },
      .examples = {"ardent export drive-run --to python -o drive-model && python3 drive-model/equation.py",
                   "ardent export drive-run --to fmu --range high"},
      .details =
          "Writes a folder with the equation in one file, of a run with several bodies or an inner state all of them; "
          "its coefficients with their standard deviations and covariance, its inputs, where its x is zero and between "
          "which x and v it was fitted. Beside it is free_run.csv: the inputs of the longest free run of the verdict "
          "and the x that follows, integrated again in small steps. python3 equation.py (numpy, scipy), equation in "
          "Octave or MATLAB, and equation.c compiled "
          "with -DEQUATION_MAIN run it themselves, locate each sgn where it switches and hold the motion there as dry "
          "friction does, and print how far they are from that x; beyond 1e-8 of the largest they end with 1. fmu is "
          "FMI 2.0 for co-simulation, compiled by cc; it takes derivatives of its inputs up to the third."};
}

}  // namespace apps
