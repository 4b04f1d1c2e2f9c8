// One write, open, rename, unlink, fsync or allocation of a command that writes fails, or the command is killed:
// afterwards the old results or the new ones are there, whole, nothing of others is touched, and the next command
// clears up.
#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <map>
#include <random>
#include <set>
#include <sstream>

#include "apps/output/earlier_result.hpp"
#include "apps/output/manifest.hpp"
#include "support/program.hpp"

using support::bytes_of;
using support::Scratch;
namespace fs = std::filesystem;

namespace {

constexpr long most = 300;  // points of a kind; a run opens some 900 times
const std::array<std::string, 6> kinds{"write", "open", "rename", "unlink", "fsync", "memory"};

/// A command and what it takes; results are in "out", beside what is not ours.
struct Command {
  std::string name, line;
  bool slow = false;  ///< half a second: few points are tried
};

const std::vector<Command> commands{
    {"run", "--threads 1 run duffing/response.csv"},
    {"prep", "--threads 1 prep gaps.csv"},
    {"sim", "sim duffing --duration 0.2"},
    {"sim raw", "sim qzs --raw --duration 0.2 --programme decay --set releases=1 --set dwell_s=8"},
    {"sim frc", "sim qzs --frc --set from_hz=1.4 --set to_hz=1.42 --set dwell_s=5"},
    {"frc", "--threads 1 frc base --draws 2 --set amplitude=1 --set from_hz=1 --set to_hz=1.1 --set step_hz=0.1"},
    {"study", "--threads 1 study duffing/response.csv --over order=1 --set 'fit.methods=[\"fast_rvm\"]'"},
    {"replicate", "replicate fig-3", true},
    {"init", "init a.csv"}};

/// Inputs of the commands, and files of a person beside their results.
void prepare(const Scratch& folder) {
  REQUIRE(support::run(folder, "$ARDENT -q sim duffing -o duffing --duration 4").code == 0);
  REQUIRE(support::run(folder, "$ARDENT -q run duffing/response.csv -o base").code == 0);
  fs::copy(folder / "duffing/response.csv", folder / "a.csv");
  std::istringstream rows(bytes_of(folder / "duffing/response.csv"));
  std::string with_gaps;
  int number = 0;
  for (std::string row; std::getline(rows, row); ++number) {
    const std::size_t second = row.find(',') + 1;
    if (number % 100 == 50) row.erase(second, row.find(',', second) - second);
    with_gaps += row + "\n";
  }
  (void)folder.file("gaps.csv", with_gaps);
  fs::create_directory(folder / "out.partial");
  for (const char* name : {"out.partial/mine", "out.lock", "out.old", "notes.txt"}) (void)folder.file(name, "mine");
}

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    names.insert(entry.path().lexically_relative(folder).string());
  return names;
}

void check_whole(const Scratch& folder) {
  const auto listed = apps::listed_outputs(folder / "out");
  if (!listed) {  // of init
    const auto is_old = [&](const char* name) { return bytes_of(folder / "out" / name) == "old"; };
    CHECK(is_old("a.csv.toml") == is_old("a.toml"));
    return;
  }
  CHECK(apps::earlier_result(apps::Folder(folder / "out", "out"), *listed).foreign.empty());
  for (const apps::ManifestFile& file : *listed) CHECK(fs::exists(folder / "out" / file.path));
}

void check_neighbours(const Scratch& folder) {
  for (const char* name : {"out.partial/mine", "out.lock", "out.old", "notes.txt"})
    CHECK(bytes_of(folder / name) == "mine");
}

/// A command and its trials.
class Bench {
 public:
  /// `settings`: of what is loaded before the program.
  explicit Bench(const Command& command, std::string settings = "")
      : command_(command), settings_(std::move(settings)) {
    prepare(folder_);
    if (command.name == "init") {
      fs::create_directory(folder_ / "out");
      for (const char* name : {"out/a.csv.toml", "out/a.toml"}) (void)folder_.file(name, "old");
    }
    require_clean_run();
    REQUIRE(support::run(folder_, "ARDENT_COUNTS=counts " + preloaded()).code == 0);
    std::istringstream text(bytes_of(folder_ / "counts"));
    for (const std::string& kind : kinds) text >> counts_[kind];
    fs::remove(folder_ / "counts");
    before_ = names_in(folder_ / "");
  }
  [[nodiscard]] long count(const std::string& kind) const { return counts_.at(kind); }
  [[nodiscard]] const Scratch& folder() const { return folder_; }
  /// Allocations whose failing ended the command without a word.
  [[nodiscard]] std::string line() const {
    return fmt::format("$ARDENT -q --force -o out {} > /dev/null", command_.line);
  }

  /// Makes the call fail, or with "+" that and all later ones of its kind; the exit code.
  int fail(const std::string& kind, long number, const char* on = "") {
    const std::string point = fmt::format("{}:{}{}", kind, number, on);
    CAPTURE(command_.name, point);
    const support::Ended ended = support::run(folder_, fmt::format("ARDENT_FAIL={} {}", point, preloaded()));
    CAPTURE(ended.err);
    // What cannot be opened may be an input.
    const bool known_code =
        ended.code == 0 || ended.code == 4 || ended.code == 5 || (kind == "open" && ended.code == 3);
    const bool one_line = ended.err.starts_with("error [") && std::count(ended.err.begin(), ended.err.end(), '\n') == 1;
    const bool in_words = known_code && (ended.code == 0 || one_line);
    CHECK(in_words);
    check_after();
    return ended.code;
  }
  /// Kills it right before the call.
  void kill_at(const std::string& kind, long number) {
    const std::string point = fmt::format("{}:{}", kind, number);
    CAPTURE(command_.name, point);
    const std::string deed = fmt::format("ARDENT_AT={} ARDENT_DO='kill -9 $PPID' ", point);
    CHECK(support::run(folder_, deed + preloaded()).code == 128 + SIGKILL);
    check_next();
    check_neighbours(folder_);
  }
  void check_after() {
    check_whole(folder_);
    check_neighbours(folder_);
    if (!command_.slow) check_next();
  }
  /// The next run succeeds and clears up.
  void check_next() const {
    require_clean_run();
    CHECK(names_in(folder_ / "") == before_);
  }

 private:
  [[nodiscard]] std::string preloaded() const {
    return fmt::format("{}LD_PRELOAD=" ARDENT_FAILING_CALLS " {}", settings_, line());
  }
  void require_clean_run() const {
    const support::Ended ended = support::run(folder_, line());
    CAPTURE(ended.err);
    REQUIRE(ended.code == 0);
    check_whole(folder_);
  }

  Command command_;
  std::string settings_;
  Scratch folder_;
  std::map<std::string, long> counts_;
  std::set<std::string> before_;
};

/// Evenly chosen numbers from 1 to `count`, `at_most` of them at the most.
std::vector<long> even_points(long count, long at_most) {
  std::vector<long> points;
  const long size = std::min(count, at_most);
  for (long i = 0; i < size; ++i) points.push_back(1 + i * count / size);
  return points;
}

}  // namespace

#ifndef ARDENT_SANITIZED  // the sanitizers replace the same calls

TEST_CASE("whatever write, open, rename, unlink or fsync fails, results are whole and nothing of others is touched",
          "[apps][failing_calls]") {
  for (const Command& command : commands) {
    Bench bench(command);
    for (const std::string kind : {"write", "open", "rename", "unlink", "fsync"}) {
      CHECK((bench.count(kind) > 0));
      for (const long number : even_points(bench.count(kind), command.slow ? 5 : most)) (void)bench.fail(kind, number);
    }
    for (const std::string kind : {"rename", "unlink"})  // and the way back fails, too
      for (const long number : even_points(bench.count(kind), command.slow ? 2 : 10))
        (void)bench.fail(kind, number, "+");
    bench.check_next();
  }
}

TEST_CASE("where two names cannot be exchanged in one step results are whole all the same", "[apps][failing_calls]") {
  for (const Command& command : commands) {
    if (command.name != "sim" && command.name != "init") continue;
    Bench bench(command, "ARDENT_PLAIN_RENAME=1 ");
    for (const std::string kind : {"rename", "unlink", "open"})
      for (const char* on : {"", "+"})
        for (const long number : even_points(bench.count(kind), 20)) (void)bench.fail(kind, number, on);
    for (long number = 1; number <= bench.count("rename"); ++number) bench.kill_at("rename", number);
    bench.check_next();
  }
}

TEST_CASE("an allocation that fails ends a command in words, with whole results", "[apps][failing_calls]") {
  std::mt19937 random(20261122);
  for (const Command& command : commands) {
    Bench bench(command);
    // Each of the first ones, then one at a random place in each of as many equal parts of all.
    const long points = command.slow ? 5 : 14, part = bench.count("memory") / points + 1;
    for (long number = 1; number <= points; ++number) (void)bench.fail("memory", number);
    for (const long number : even_points(bench.count("memory"), points))
      (void)bench.fail("memory", number + static_cast<long>(random() % static_cast<unsigned long>(part)));
    bench.check_next();
  }
}

TEST_CASE("an allocation that fails before main ends a command in one line", "[apps][failing_calls]") {
  const Scratch folder;
  const std::string preloaded = "LD_PRELOAD=" ARDENT_FAILING_CALLS " $ARDENT --version > /dev/null";
  REQUIRE(support::run(folder, "ARDENT_COUNTS=counts " + preloaded).code == 0);
  std::istringstream counts(bytes_of(folder / "counts"));
  long count = 0;  // of the last kind
  while (counts >> count) continue;
  for (const long number : even_points(count, 12)) {
    const support::Ended ended = support::run(folder, fmt::format("ARDENT_FAIL=startup:{} {}", number, preloaded));
    CAPTURE(number, count);
    CHECK(ended.code == 4);
    CHECK(ended.err == "error [memory.exhausted] no memory left, not even for a message\n");
  }
}

// `run` allocates 60,000 times: every one of them would take hours.
TEST_CASE("a thousand allocations of each command that fail, and every other call", "[.][study][failing_calls]") {
  for (const Command& command : commands) {
    Bench bench(command);
    for (const std::string& kind : kinds) {
      std::map<int, int> outcomes;
      for (const long number : even_points(bench.count(kind), 1000)) ++outcomes[bench.fail(kind, number)];
      std::string text;
      for (const auto& [code, number] : outcomes) text += fmt::format(" {} x {}", number, code);
      WARN(command.name << ", " << kind << ": " << bench.count(kind) << " calls; exit codes" << text);
    }
  }
}

TEST_CASE("a command that is killed leaves old or new results whole, and the next one clears up",
          "[apps][failing_calls]") {
  std::mt19937 random(4711);
  for (const Command& command : commands) {
    if (command.slow) continue;
    Bench bench(command);
    CAPTURE(command.name);
    const auto begin = std::chrono::steady_clock::now();
    REQUIRE(support::run(bench.folder(), bench.line()).code == 0);
    const auto usual = std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - begin);
    for (const std::string kind : {"rename", "unlink"})
      for (const long number : even_points(bench.count(kind), 10)) bench.kill_at(kind, number);
    for (int kill = 0; kill < 10; ++kill) {
      support::Running running(bench.folder() / "", "exec " + bench.line());
      std::this_thread::sleep_for(std::chrono::microseconds(random() % static_cast<unsigned>(usual.count())));
      running.send(SIGKILL);
      const int code = running.wait().code;
      CHECK((code == 0 || code == 128 + SIGKILL));
      bench.check_after();
    }
  }
}

#endif
