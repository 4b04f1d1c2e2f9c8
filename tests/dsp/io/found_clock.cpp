#include "dsp/io/found_clock.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "dsp/io/read_recording.hpp"
#include "dsp/io/sample_source.hpp"
#include "dsp/values/fault.hpp"
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

TEST_CASE("days of spreadsheets and of MATLAB are a clock in days, however their column is called",
          "[dsp][found_clock]") {
  const Scratch scratch;
  const auto days = [](double first) {
    return [first](int i) { return fmt::format("{:.10f}", first + i / 200.0 / 86400.0); };
  };
  for (const double first : {45050.75, 738000.5}) {
    CAPTURE(first);
    for (const char* header : {"", "t;x;f\n", "datenum;x;f\n"}) {
      const auto source = open(scratch, header + rows(300, days(first)));
      CHECK(source->info().sample_rate_hz == 200.0);
      CHECK(source->info().checks.front().name == "clock.assumed");
    }
  }
  // A part of a day without a date could be seconds at millions of hertz.
  const std::string text = "t;x;f\n" + rows(300, days(0.0));
  check_fault([&] { (void)open(scratch, text); }, FaultKind::input, "clock.unit", {"in days 200 Hz"}, {"unit = \"d\""});
  CHECK(open(scratch, text, {.time_column = "1", .time_unit = "d"})->info().sample_rate_hz == 200.0);
  CHECK(open(scratch, "Time (s);x;f\n" + rows(300, days(45050.75)))->info().sample_rate_hz > 1e7);  // as it says
}

TEST_CASE("a counter of 32 or 16 bits that begins anew goes on", "[dsp][found_clock]") {
  const Scratch scratch;
  const auto counter = [](int bits) {
    return [bits](int i) {
      return fmt::format("{}", ((std::int64_t{1} << bits) - 1000 + 20 * i) % (std::int64_t{1} << bits));
    };
  };
  for (const auto& [header, bits, rate_hz] : {std::tuple{"micros;x;f\n", 32, 50e3}, {"millis;x;f\n", 16, 50.0}}) {
    CAPTURE(header);
    const auto source = open(scratch, header + rows(300, counter(bits)));
    CHECK(source->info().sample_rate_hz == Approx(rate_hz));
    CHECK(source->info().num_frames == 300);
    CHECK(source->info().gaps.empty());
  }
  check_fault([&] { (void)open(scratch, "millis;x;f\n" + rows(300, [](int i) { return 20 * (i % 200); })); },
              FaultKind::input, "clock.backwards", {"head -n 201 "});
}
