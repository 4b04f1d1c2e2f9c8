#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <string>
#include <thread>

#include "support/program.hpp"

using support::Scratch;
namespace fs = std::filesystem;

namespace {

/// A signal well into a command that would take minutes: it ends with 128 + signal soon after, and leaves nothing.
void stops(const Scratch& folder, const std::string& command, int signal) {
  using namespace std::chrono_literals;
  CAPTURE(command, signal);
  support::Running running(folder / "", "exec $ARDENT " + command);
  std::this_thread::sleep_for(700ms);
  const auto sent = std::chrono::steady_clock::now();
  running.send(signal);
  const auto ended = running.wait();
  const auto took = std::chrono::steady_clock::now() - sent;
  CAPTURE(ended.err);
  CHECK(ended.code == 128 + signal);
  CHECK_THAT(ended.err, Catch::Contains("error [interrupted]"));
  CHECK(took < 4s);  // one second on a machine with nothing else to do
  CHECK_FALSE(fs::exists(folder / "o"));
}

/// A table of seven columns without pattern, and 300 products of six of them, at most five of one.
void make_wide_library(const Scratch& folder) {
  std::string table = "y,a,b,c,d,e,g\n", terms;
  for (int i = 0; i < 1500; ++i) {
    for (int j = 0; j < 7; ++j) table += (j > 0 ? "," : "") + std::to_string(std::sin(1.3 * (j + 1) * i * i + j));
    table += "\n";
  }
  int num_terms = 0;
  for (int code = 1; num_terms < 300; ++code) {  // powers as digits
    std::string term;
    int rest = code, degree = 0;
    for (const char* name : {"a", "b", "c", "d", "e", "g"}) {
      if (rest % 6 > 0) term += (term.empty() ? "" : "*") + std::string(name) + "^" + std::to_string(rest % 6);
      degree += rest % 6;
      rest /= 6;
    }
    if (degree > 5) continue;
    terms += term + "\n";
    ++num_terms;
  }
  (void)folder.file("wide.csv", table);
  (void)folder.file("terms.txt", terms);
}

}  // namespace

TEST_CASE("a signal stops a fit of hundreds of terms, whatever the method", "[apps][interrupt]") {
  const Scratch folder;
  make_wide_library(folder);
  for (const char* method : {"slow_rvm", "ols"})
    stops(folder, std::string("fit wide.csv --target y --terms terms.txt --methods ") + method, SIGTERM);
}

TEST_CASE("a signal stops whatever computes for long", "[apps][interrupt]") {
  const Scratch folder;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) stops(folder, "sim duffing --duration 2e5 -o o", signal);
  for (const char* command :
       {"sim linear --duration 1e6 -o o", "sim bouc-wen --duration 1e5 -o o", "sim valanis-4 --duration 1e5 -o o",
        "sim qzs --frc --set step_hz=0.0005 -o o", "sim qzs --duration 1e6 -o o",
        "replicate valanis-4 --seeds 500 -o o", "replicate fig-11 -o o"})
    stops(folder, command, SIGTERM);
}

TEST_CASE("a hangup that is ignored from outside stays ignored", "[apps][interrupt]") {
  const Scratch folder;
  support::Running running(folder / "", "trap '' HUP; exec $ARDENT sim duffing --duration 500 -o o");
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  running.send(SIGHUP);
  CHECK(running.wait().code == 0);
  CHECK(fs::exists(folder / "o/truth.json"));
}
