#include <catch2/catch.hpp>
#include <sstream>

#include "support/program.hpp"

namespace fs = std::filesystem;
using support::expect;
using support::Scratch;

namespace {
constexpr const char* all_commands[] = {"info",   "check",     "init",    "run",    "prep",      "study",
                                        "report", "compare",   "predict", "export", "frc",       "sim",
                                        "fit",    "replicate", "terms",   "help",   "completion"};

/// Command lines end with exit code 2 and one line that holds this message.
void check_refused(const std::vector<std::pair<std::string, std::string>>& typed) {
  const Scratch folder;
  for (const auto& [arguments, message] : typed) {
    CAPTURE(arguments);
    const auto ended = expect(folder, "$ARDENT " + arguments, 2, {message});
    CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
  }
}
}  // namespace

TEST_CASE("every command shows its options and two examples, and ardent --help shows every command", "[apps][help]") {
  const Scratch folder;
  const std::string overview = expect(folder, "$ARDENT --help", 0, {"Find its equation of motion"}).out;
  for (const std::string command : all_commands) {
    CAPTURE(command);
    CHECK_THAT(overview, Catch::Contains("\n  " + command + " "));
    const std::string help = expect(folder, "$ARDENT " + command + " --help", 0, {"Options", "--json", "Examples"}).out;
    if (command != "terms")  // help on them is a topic
      CHECK(help == support::run(folder, "$ARDENT help " + command).out);
    const std::string examples = help.substr(help.find("\nExamples\n"));
    std::size_t num = 0;
    for (std::size_t at = 0; (at = examples.find("ardent " + command, at)) != std::string::npos; ++at) ++num;
    CHECK(num >= 2);
    std::istringstream lines(help.substr(0, help.find("\nExamples\n")));
    for (std::string line; std::getline(lines, line);) CHECK(line.size() <= 100);
  }
  CHECK_THAT(overview, !Catch::Contains("manual"));
}

TEST_CASE("a command shows what it takes and nothing that it refuses", "[apps][help]") {
  const Scratch folder;
  const auto run =
      expect(folder, "$ARDENT run --help", 0, {"-o, --output DIR", "--set KEY=VALUE", "--force", "--require"});
  CHECK_THAT(expect(folder, "$ARDENT check --help", 0, {"--set"}).out, !Catch::Contains("--output"));
  expect(folder, "$ARDENT check a.csv -o x", 2, {"--output has no effect"});
  expect(folder, "$ARDENT --json info none.csv", 3, {"none.csv"});  // also before the command
}

TEST_CASE("the nearest command, option, topic or key is named", "[apps][help]") {
  check_refused({{"rnu a.csv", "there is no command 'rnu'. Did you mean ardent run?"},
                 {"comapre a b", "Did you mean ardent compare?"},
                 {"xyzzy", "For a recording: ardent run FILE"},
                 {"", "no command"},
                 {"run a.csv --forse", "run: there is no option --forse. Did you mean --force?"},
                 {"run a.csv --ouput=x", "Did you mean --output?"},
                 {"run", "run: INPUT is missing"},
                 {"info a.csv --draws 3", "other commands have it"},
                 {"predict r a.csv b.csv", "'b.csv' is one argument too many"},
                 {"help confg", "Did you mean 'config'?"},
                 {"help cutof_hz", "Did you mean 'cutoff_hz'?"}});
}

TEST_CASE("a value that an option does not take is refused in one line that says what it takes", "[apps][help]") {
  check_refused(
      {{"run a.csv --threads 010x", "run: --threads: want a whole number from 0 to 1024, got 010x"},
       {"run a.csv --progress now", "run: --progress: now, which is none of always,auto,never"},
       {"run a.csv --set", "run: --set: 1 required KEY=VALUE missing"},
       {"fit a.csv --target x --terms v --ridge-lambda 0", "fit: --ridge-lambda: want a finite number above 0, got 0"},
       {"frc r --static-friction inf", "frc: --static-friction: want a finite number not below 0, got inf"},
       {"sim duffing -o d --noise much", "sim: Could not convert: --noise = much"}});
}

TEST_CASE("options of one name before and after the command add up, and lists take commas", "[apps][help]") {
  const Scratch folder;
  expect(folder, "printf 't,x\\n0,1\\n1,2\\n2,1\\n' > a.csv", 0, {});
  expect(folder, "$ARDENT --set one=1 run a.csv --set two=2 --set three=3", 2, {"'one'", "'two'", "'three'"});
  const auto both = expect(folder, "$ARDENT fit a.csv --target x --terms t --methods sindy,ols", 0, {"sindy:", "ols:"});
  CHECK(both.out == support::run(folder, "$ARDENT fit a.csv --target x --terms t --methods sindy --methods ols").out);
}

TEST_CASE("topics and keys are explained", "[apps][help]") {
  const Scratch folder;
  for (const char* topic : {"config", "sidecar", "terms", "methods", "verdict", "files", "exit-codes"})
    expect(folder, std::string("$ARDENT help ") + topic, 0, {std::string(topic) + ": "});
  expect(folder, "$ARDENT help", 0, {"cutoff_hz", "sidecar", "predict", "tutorial", "method", "validation"});
  for (const std::string guide : {"tutorial", "method", "validation"})
    CHECK(expect(folder, "$ARDENT help " + guide, 0, {}).out ==
          support::bytes_of(std::filesystem::path(ARDENT_DOCS) / (guide + ".md")));
  expect(folder, "$ARDENT help cutoff_hz", 0, {"config: [prepare].", "in Hz"});
}

TEST_CASE("completion scripts are understood by their shells, and complete", "[apps][help]") {
  const Scratch folder;
  expect(folder, "$ARDENT completion bash > c && bash -n c", 0, {});
  const auto completed = [&](const std::string& words, int at) {
    return support::run(folder, "bash -c '. ./c; COMP_WORDS=(" + words + "); COMP_CWORD=" + std::to_string(at) +
                                    "; _ardent; echo \"${COMPREPLY[@]}\"'")
        .out;
  };
  CHECK(completed("ardent re", 1) == "report replicate\n");
  CHECK(completed("ardent run --for", 2) == "--force\n");
  CHECK(completed("ardent run --require d", 3) == "describes\n");
  CHECK(completed("ardent help conf", 2) == "config\n");
  CHECK(completed("ardent run --set prepare.state_c", 3) == "prepare.state_cutoff_hz=\n");
  CHECK(completed("ardent check --set range.0.tr", 3) == "range.0.train_to=\n");
  expect(folder, "$ARDENT completion zsh > z; if command -v zsh; then zsh -n z; else head -1 z; fi", 0, {});
  expect(folder, "$ARDENT completion fish", 2, {"bash"});
}

TEST_CASE("manual pages have every command, every topic and no loose request", "[apps][help]") {
  const Scratch folder;
  expect(folder, "$ARDENT manual -o share", 0, {});
  for (const char* page :
       {"man/man1/ardent.1", "man/man1/ardent-run.1", "man/man5/ardent-config.5", "man/man5/ardent-sidecar.5",
        "bash-completion/completions/ardent", "zsh/vendor-completions/_ardent"})
    CHECK(fs::exists(folder / (std::string("share/") + page)));
  for (const auto& entry : fs::recursive_directory_iterator(folder / "share/man")) {
    if (!entry.is_regular_file()) continue;
    std::istringstream lines(support::bytes_of(entry.path()));
    for (std::string line; std::getline(lines, line);) {
      CAPTURE(entry.path(), line);
      if (!line.empty() && (line[0] == '.' || line[0] == '\''))
        CHECK_THAT(line, Catch::Matches("\\.(TH|SH|TP|B|PP|nf|fi|RS|RE|nh|ad l|br).*"));
    }
  }
}
