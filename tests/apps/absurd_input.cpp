// Input that is far from anything that moves: an answer in seconds, and what to change.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "support/program.hpp"

namespace test_absurd_input {

using support::Scratch;

namespace {

/// A driven oscillator with x in metres under this header: x of two sines, f what its equation needs.
std::string table(const std::string& header) {
  std::string text = header + "\n";
  char line[160];
  for (int i = 0; i < 6000; ++i) {
    const double t = 0.01 * i;
    double x = 0.0, v = 0.0, a = 0.0;
    for (const auto& [amplitude, hz] : {std::pair{0.02, 0.91}, {0.012, 1.73}, {0.008, 2.6}, {0.004, 0.37}}) {
      const double w = 2.0 * std::numbers::pi * hz, phase = w * t + 7.0 * hz;
      x += amplitude * std::sin(phase), v += amplitude * w * std::cos(phase), a -= amplitude * w * w * std::sin(phase);
    }
    const double f = a + 0.6 * v + 60.0 * x + 1.6e4 * x * x * x;
    std::snprintf(line, sizeof line, "%.2f,%.9g,%.9g,%.9g,%.9g\n", t, x, v, a, f);
    text += line;
  }
  return text;
}

/// The lines that the screen of a run shows to be pasted into this file.
std::string to_paste(const std::string& screen) {
  std::string lines;
  std::size_t from = screen.find("                 schema = 1\n");
  REQUIRE(from != std::string::npos);
  for (std::size_t end; screen.compare(from, 17, std::string(17, ' ')) == 0; from = end + 1) {
    end = screen.find('\n', from);
    lines += screen.substr(from + 17, end + 1 - from - 17);
  }
  return lines;
}

}  // namespace

TEST_CASE("metres in a column of micrometres: named, run in seconds, and mended by the lines shown", "[apps][absurd]") {
  const Scratch folder;
  (void)folder.file("drive.csv", table("t [s],x [um],v [m/s],a [m/s^2],f [N]"));
  (void)folder.file("right.csv", table("t [s],x [m],v [m/s],a [m/s^2],f [N]"));
  // Five times what it takes, and a tenth of what it took.
  const auto run = support::expect(folder, "timeout 10 $ARDENT -q run drive.csv -o run", 0, {});
  CHECK_THAT(run.out, Catch::Contains("x: metres read as micrometres"));
  CHECK_THAT(run.out, !Catch::Contains("no two units explain"));
  CHECK_THAT(run.out, Catch::Contains("does not describe") && Catch::Contains("given up"));
  (void)folder.file("drive.csv.toml", to_paste(run.out));
  CHECK_THAT(support::expect(folder, "$ARDENT -q run drive.csv -o run --force", 0, {}).out,
             Catch::Contains("This equation describes the record") && !Catch::Contains("mend"));
  (void)support::expect(folder, "$ARDENT -q run right.csv -o right", 0, {});
  (void)support::expect(folder, "cmp right/metrics.json run/metrics.json", 0, {});
}

TEST_CASE("a system far faster than its table is refused", "[apps][absurd]") {
  const Scratch folder;
  const auto refused =
      support::expect(folder, "timeout 20 $ARDENT sim duffing --set omega_n=1e6 -o out", 4, {"[sim.too_fast]"});
  CHECK_THAT(refused.err, Catch::Contains("1.59e+05 Hz") && Catch::Contains("Try --set"));
  (void)support::expect(folder, "test ! -e out", 0, {});
  (void)support::expect(
      folder, "timeout 20 $ARDENT sim qzs --duration 20 --set k1=1e14 --set mu_kinetic=0 --set mu_static=0 -o rig", 4,
      {"[sim.diverged]"});
  (void)support::expect(folder, "$ARDENT sim duffing --set omega_n=1000 -o fast", 0, {});
}

}  // namespace test_absurd_input
