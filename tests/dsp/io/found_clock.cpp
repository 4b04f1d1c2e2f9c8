#include "dsp/io/found_clock.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "dsp/fault.hpp"
#include "dsp/io/sample_source.hpp"
#include "dsp/read_recording.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"

using dsp::FaultKind;
using support::check_fault;
using support::Scratch;

namespace {

/// Rows "clock;motion;force" without a header.
std::string rows(int count, const auto& clock) {
  std::string text;
  for (int i = 0; i < count; ++i)
    text += fmt::format("{};{:.4f};{:.3f}\n", clock(i), std::sin(0.3 * i), std::cos(0.2 * i));
  return text;
}

std::unique_ptr<dsp::SampleSource> open(const Scratch& scratch, const std::string& text,
                                        dsp::OpenOptions options = {}) {
  return dsp::open_source(scratch.file("a.csv", text), options);
}

}  // namespace

TEST_CASE("a column that rises evenly is the clock of a table without names", "[dsp][found_clock]") {
  const Scratch scratch;
  const auto source = open(scratch, rows(300, [](int i) { return fmt::format("{:.3f}", 5.0 + 0.004 * i); }));
  CHECK(source->info().sample_rate_hz == 250.0);
  CHECK(source->info().time_column == 0);
  CHECK(source->info().clock_start.s == 5.0);
}

TEST_CASE("in seconds slower than once a second, its unit is a question with the rates that would follow",
          "[dsp][found_clock]") {
  const Scratch scratch;
  const std::string text = rows(300, [](int i) { return fmt::format("{}", 4 * i); });
  check_fault([&] { (void)open(scratch, text); }, FaultKind::input, "clock.unit",
              {"column 1", "in ms 250 Hz", "in us 250000 Hz", "a.csv.toml"},
              {"[[channel]]\nname = \"t\"\nindex = 1\nrole = \"t\"\nunit = \"ms\"\n"});
  // A rate that a person gives answers it.
  CHECK(open(scratch, text, {.rate_hz = 250.0})->info().time_column == 0);
  CHECK(open(scratch, text, {.rate_hz = 250e3})->info().sample_rate_hz == 250e3);
  check_fault([&] { (void)open(scratch, text, {.rate_hz = 60.0}); }, FaultKind::input, "rate.mismatch",
              {"60 Hz", "role = \"other\""});
  // What is no rate of vibration in ms is proposed in us; a column called time is asked for, too.
  check_fault([&] { (void)open(scratch, rows(300, [](int i) { return 5000 * i; })); }, FaultKind::input, "clock.unit",
              {}, {"unit = \"us\""});
  check_fault([&] { (void)open(scratch, "t;x;f\n" + rows(300, [](int i) { return 5 * i; })); }, FaultKind::input,
              "clock.unit", {"in ms 200 Hz"});
  CHECK(open(scratch, "t_s;x;f\n" + rows(300, [](int i) { return 5 * i; }))->info().sample_rate_hz == 0.2);
}

TEST_CASE("a count of rows, a motion and a column that falls back once are no clock", "[dsp][found_clock]") {
  const Scratch scratch;
  CHECK(open(scratch, rows(300, [](int i) { return i + 1; }))->info().sample_rate_hz == 0.0);
  // From a column beside the count the clock is taken.
  const auto both = open(scratch, rows(300, [](int i) { return fmt::format("{};{:.2f}", i, 0.01 * i); }));
  CHECK(both->info().time_column == 1);
  CHECK(both->info().sample_rate_hz == 100.0);
  CHECK(open(scratch, rows(3000, [](int i) { return std::sin(0.001 * i); }))->info().time_column == -1);
  CHECK(open(scratch, rows(300, [](int i) { return i == 250 ? 1.0 : 0.01 * i; }))->info().time_column == -1);
  CHECK(open(scratch, rows(300, [](int i) { return fmt::format("{:.5f}", 0.01 * i + 0.1 * std::pow(i, 1.5)); }))
            ->info()
            .time_column == -1);
  CHECK_FALSE(dsp::is_clock_like({0.0, 0.1, 0.2}));
  // A column with a signal's name is what it is called, and of two in question neither is taken.
  CHECK(open(scratch, "load;x;f\n" + rows(300, [](int i) { return 0.001 * i; }))->info().time_column == -1);
  CHECK(open(scratch, rows(300, [](int i) { return fmt::format("{:.3f};{:.3f}", 0.002 * i, 0.01 * i); }))
            ->info()
            .time_column == -1);
}
