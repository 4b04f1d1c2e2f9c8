// How the program ends where the world does not play along: streams, paths, numbers, memory, pipes, terminals.
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "support/program.hpp"

using support::bytes_of;
using support::expect;
using support::Scratch;
namespace fs = std::filesystem;

namespace {

/// A decaying oscillation at 100 Hz, which a run identifies.
std::string decay(int num_rows = 800) {
  std::string text = "t,x\n";
  for (int i = 0; i < num_rows; ++i) {
    const double t = 0.01 * i;
    text += std::to_string(t) + "," + std::to_string(std::exp(-0.1 * t) * std::cos(9.0 * t)) + "\n";
  }
  return text;
}

/// Ends with this code, within ten seconds, and with one line of error that holds every piece.
void ends(const Scratch& folder, const std::string& command, int code, const std::vector<std::string>& pieces) {
  const auto ended = expect(folder, "timeout 10 " + command, code, pieces);
  CAPTURE(command, ended.err);
  const auto at = ended.err.find("error [");
  REQUIRE(at != std::string::npos);
  CHECK(std::count(ended.err.begin() + static_cast<std::ptrdiff_t>(at), ended.err.end(), '\n') == 1);
}

}  // namespace

TEST_CASE("messages never land in a result, also where standard streams are closed", "[apps][ending]") {
  const Scratch folder;
  const std::string sim = "$ARDENT sim qzs --raw --programme decay --set releases=1 --duration 2 --progress always -o ";
  expect(folder, sim + "whole", 0, {});
  const auto same = [&](const std::string& name) {
    for (const char* file : {"recording.wav", "recording.wav.toml", "truth.csv", "response.csv"})
      CHECK(bytes_of(folder / (name + "/" + file)) == bytes_of(folder / ("whole/" + std::string(file))));
  };
  expect(folder, sim + "no_error 2>&-", 0, {});
  same("no_error");
  CHECK(support::run(folder, sim + "none 0<&- 1>&- 2>&-").code == 5);  // results have nowhere to be shown
  same("none");
  expect(folder, "$ARDENT terms 1>&-", 5, {"[output.write] standard output", "Bad file descriptor"});
}

TEST_CASE("what the system or a file refuses is no mistake of the program", "[apps][ending]") {
  const Scratch folder;
  (void)folder.file("x.csv", decay());
  (void)folder.file("empty.toml", "[[recording]]\nfile = \"\"\n");
  (void)folder.file("far.json", "[{\"label\": \"low\", \"from_s\": 0, \"to_s\": 1e999}]");
  const std::string text_segments = "[{\"label\": \"low\", \"from_s\": 0, \"to_s\": \"1\"}]";
  (void)folder.file("text.json", text_segments);
  fs::create_symlink("loop.csv", folder / "loop.csv");
  fs::create_symlink("loop", folder / "loop");
  fs::create_directory(folder / "folder");
  (void)folder.file("plain", "");
  const std::string longname(300, 'n');
  ends(folder, "$ARDENT run empty.toml", 2, {"[config.range] empty.toml:2: [[recording]] 1: file: is empty"});
  ends(folder, "$ARDENT run x.csv -o o --set segment.file=far.json", 2, {"[segments.syntax]", "beyond what a double"});
  ends(folder, "$ARDENT run x.csv -o o --set segment.file=folder", 3, {"[file.kind] folder", "a directory"});
  ends(folder, "$ARDENT run loop.csv", 3, {"[file.missing] loop.csv", "symbolic links"});
  ends(folder, "$ARDENT study loop.csv -o o", 3, {"[file.missing] loop.csv", "symbolic links"});
  ends(folder, "$ARDENT run " + longname, 3, {"[file.missing]", "too long"});
  ends(folder, "$ARDENT init " + longname + ".csv", 3, {"[file.missing]", "too long"});
  ends(folder, "$ARDENT compare folder loop", 3, {"[run.incomplete]"});
  ends(folder, "$ARDENT report x.csv", 3, {"[run.incomplete]", "is no folder"});
  ends(folder, "$ARDENT report /proc/x", 3, {"[run.incomplete] /proc/x: is not there"});
  ends(folder, "$ARDENT sim duffing -o /proc/x", 5, {"[output.write] /proc/x: ", "Choose another place with -o"});
  for (const std::string command :
       {"run x.csv -o ", "prep x.csv -o ", "study x.csv --over tau=5 -o ", "init x.csv -o ", "sim duffing -o ",
        "sim qzs --frc --set from_hz=1 --set to_hz=1.1 --set step_hz=0.1 -o ", "replicate table-1 -o "}) {
    ends(folder, "$ARDENT " + command + longname, 5, {"too long"});
    ends(folder, "$ARDENT " + command + "loop/o", 5, {"symbolic links"});
    ends(folder, "$ARDENT " + command + "plain/o", 5, {"plain"});
  }
  ends(folder, "$ARDENT sim duffing --duration 1e9 -o o", 4, {"[memory.exhausted]", "Shorten --duration"});
  ends(folder, "$ARDENT sim qzs --from 1e9 --raw -o o", 4, {"[memory.exhausted]", "--from"});
}

TEST_CASE("nothing waits for a pipe that no one writes to", "[apps][ending]") {
  const Scratch folder;
  (void)folder.file("x.csv", decay());
  fs::create_directory(folder / "run");
  for (const char* name : {"pipe", "pipe.toml", "pipe.txt", "pipe.csv", "pipe.csv.toml", "run/manifest.json"})
    REQUIRE(::mkfifo((folder / name).c_str(), 0600) == 0);
  ends(folder, "$ARDENT run pipe.toml", 2, {"[config.file] pipe.toml", "a pipe"});
  ends(folder, "$ARDENT run pipe.csv", 3, {"a pipe"});
  ends(folder, "$ARDENT run x.csv -o o --set segment.file=pipe", 3, {"a pipe"});
  ends(folder, "$ARDENT check x.csv --set segment.file=pipe", 2, {"[segments.file] pipe", "a pipe"});
  ends(folder, "$ARDENT run x.csv -o o --set recording.0.sidecar=pipe", 2, {"a pipe"});
  ends(folder, "$ARDENT fit x.csv --target x --terms pipe.txt", 2, {"[config.file] pipe.txt", "a pipe"});
  for (const char* command : {"report run", "compare run", "frc run"})
    ends(folder, std::string("$ARDENT ") + command, 3, {"[run.incomplete] run/manifest.json", "a pipe"});
  expect(folder, "$ARDENT run x.csv -o done --set library.order=1 -q", 0, {});
  ends(folder, "$ARDENT compare done --truth pipe", 3, {"a pipe"});
  for (const char* file : {"equation.txt", "equation.json", "metrics.json"}) {
    fs::remove(folder / "done" / file);
    REQUIRE(::mkfifo((folder / "done" / file).c_str(), 0600) == 0);
  }
  ends(folder, "$ARDENT report done", 3, {"equation.txt", "a pipe"});
  ends(folder, "$ARDENT compare done", 3, {"metrics.json", "a pipe"});
  ends(folder, "$ARDENT frc done", 3, {"equation.json", "a pipe"});
}

TEST_CASE("help and version that cannot be written are an error", "[apps][ending]") {
  const Scratch folder;
  for (const char* asked : {"--help", "--version", "run --help"})
    ends(folder, std::string("$ARDENT ") + asked + " > /dev/full", 5, {"[output.write] standard output"});
  CHECK_THAT(expect(folder, "$ARDENT sim --help", 0, {"--twin"}).err, Catch::Equals(""));
}

TEST_CASE("numbers of the command line out of their range are refused", "[apps][ending]") {
  const Scratch folder;
  (void)folder.file("x.csv", decay());
  for (const char* arguments : {"sim duffing -o o --seed -1",
                                "sim duffing -o o --seed 18446744073709551616",
                                "sim duffing -o o --seed 1.5",
                                "sim duffing -o o --seed 0x10",
                                "sim duffing -o o --seed ''",
                                "sim duffing -o o --threads -1",
                                "sim duffing -o o --noise nan",
                                "sim duffing -o o --noise 1e999",
                                "sim duffing -o o --noise 1e300",
                                "sim qzs --raw -o o --noise 1e300",
                                "replicate table-1 -o o --noise 1e300",
                                "sim duffing -o o --duration 1e308",
                                "sim qzs -o o --duration 1e308",
                                "sim qzs --raw -o o --from 1e308",
                                "sim duffing -o o --duration -1",
                                "sim duffing -o o --duration inf",
                                "replicate table-1 -o o --seeds -1",
                                "replicate table-1 -o o --seeds 1e99",
                                "replicate table-1 -o o --first-seed -5",
                                "replicate table-1 -o o --tau nan",
                                "run x.csv --max-memory -1",
                                "run x.csv --max-memory 99999999999999999999",
                                "frc r --draws -1",
                                "frc r --static-friction inf",
                                "fit x.csv --target x --terms t --tau inf",
                                "fit x.csv --target x --terms t --ridge-lambda 1e999"})
    ends(folder, std::string("$ARDENT ") + arguments, 2, {});
  CHECK_FALSE(fs::exists(folder / "o"));
  ends(folder, "$ARDENT sim duffing -o o --duration 1e308", 2, {"--duration 1e+308, want 0.01 to 1e+09"});
  ends(folder, "$ARDENT sim duffing -o o --noise 1e300", 2, {"--noise 1e+300, want 0 to 1000"});
  expect(folder, "$ARDENT sim duffing -o o --seed 010 --duration 1", 0, {});
  CHECK_THAT(bytes_of(folder / "o/truth.json"), Catch::Contains("\"seed\": 10,"));
}

TEST_CASE("codes that steer a terminal are escaped wherever text of a file is shown", "[apps][ending]") {
  const Scratch folder;
  (void)folder.file("x.csv", decay());
  const std::string escape =
      "\x1b]0;title\x07\xC2\x9B"
      "31m";
  (void)folder.file("x.csv.toml", "[[channel]]\nname = \"x\"\nrole = \"x\"\n[[range]]\nname = \"\\u001b[31mred\"\n");
  const auto clean = [&](const std::string& command, int code) {
    CAPTURE(command);
    const auto ended = support::run(folder, command);
    CHECK(ended.code == code);
    for (const char* forbidden : {"\x1b", "\x07", "\xC2\x9B"}) {
      CHECK_THAT(ended.out, !Catch::Contains(forbidden));
      CHECK_THAT(ended.err, !Catch::Contains(forbidden));
    }
    return ended;
  };
  CHECK_THAT(clean("$ARDENT run x.csv -o done --set library.order=1", 0).out, Catch::Contains("\\x1b[31mred"));
  clean("$ARDENT check x.csv", 0);
  (void)folder.file("done/equation.txt", "a = " + escape + "1 x\n");
  (void)folder.file("done/equation.json", "{\"a\": \"" + escape + "\"}\n");
  CHECK_THAT(clean("$ARDENT report done", 0).out, Catch::Contains("a = \\x1b]0;title\\x07\\x9b31m1 x\n"));
  const auto document = clean("$ARDENT report done --json", 0).out;
  CHECK(nlohmann::json::parse(document)["a"] == escape);
  fs::create_directory(folder / escape);
  clean("$ARDENT sim duffing --duration 1 -o '" + escape + "/o'", 0);
  clean("$ARDENT info '" + escape + ".csv'", 3);
}

#ifndef ARDENT_SANITIZED
TEST_CASE("memory that ends, wherever, is said in one line and leaves nothing", "[apps][ending]") {
  const Scratch folder;
  (void)folder.file("x.csv", decay(4000));
  const std::string run = "$ARDENT run x.csv --threads 1 --set library.order=1 --set 'fit.methods=[\"ols\"]' -o o";
  int succeeded = 0, refused = 0;
  // From too little for the shared libraries, which they say themselves before the program begins, to plenty.
  for (int limit_kb = 30'000; limit_kb < 400'000 && succeeded < 3; limit_kb += 1'500) {
    const auto ended = support::run(folder, "ulimit -v " + std::to_string(limit_kb) + "; " + run);
    // So do objects that libraries make before main: where a thrown exception finds no memory either, all of it ends.
    const bool before_main = ended.err.starts_with("terminate called without an active exception");
    if (ended.code == 127 || before_main || ended.err.find("libgomp") != std::string::npos) continue;
    CAPTURE(limit_kb, ended.code, ended.err);
    REQUIRE((ended.code == 0 || ended.code == 4));
    (ended.code == 0 ? succeeded : refused) += 1;
    if (ended.code == 4) CHECK_THAT(ended.err, Catch::Contains("error [memory.exhausted]"));
    CHECK(fs::exists(folder / "o") == (ended.code == 0));
    CHECK_FALSE(fs::exists(folder / "o.lock"));
    fs::remove_all(folder / "o");
    fs::remove_all(folder / "o.partial");
  }
  CHECK(succeeded == 3);
  CHECK(refused > 0);
}

TEST_CASE("a run goes on where no thread is to be had, with the same result", "[apps][ending]") {
  const Scratch folder;
  (void)folder.file("x.csv", decay(20'000));
  const std::string run = "$ARDENT run x.csv --threads 8 --set library.order=2 -q -o ";
  expect(folder, run + "many", 0, {});
  // A thread's stack of 8 GB fits no address space of 4 GB.
  expect(folder, "ulimit -s 8000000; ulimit -v 4000000; " + run + "one", 0, {});
  for (const char* file : {"equation.json", "predictions.csv"})
    CHECK(bytes_of(folder / "one" / file) == bytes_of(folder / "many" / file));
}
#endif
