#include "dsp/io/table_file.hpp"

#include <fmt/format.h>
#include <rapidcheck/catch.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>

#include "dsp/io/table_layout.hpp"
#include "dsp/signal_table.hpp"
#include "support/fault.hpp"
#include "support/fuzz.hpp"
#include "support/scratch.hpp"

namespace test_io_table_file {

using dsp::FaultKind;
using support::check_fault;
using support::Scratch;

namespace {

const std::filesystem::path real_data = ARDENT_REAL_DATA;

struct Table {
  dsp::SourceInfo info;
  dsp::FrameBlock frames;
};

Table read(const std::filesystem::path& file, const dsp::OpenOptions& options = {}, Eigen::Index block_frames = 1000) {
  const auto source = dsp::open_source(file, options);
  Table table{source->info(), dsp::FrameBlock(source->info().num_frames, source->info().columns.size())};
  dsp::FrameBlock block;
  Eigen::Index done = 0;
  while (const auto got = source->read(block, block_frames)) {
    REQUIRE(done + got <= table.frames.rows());
    table.frames.middleRows(done, got) = block;
    done += got;
  }
  REQUIRE(done == table.frames.rows());
  return table;
}

// The same four rows however they are written.
void check_rows(const Table& table) {
  REQUIRE(table.frames.rows() == 4);
  REQUIRE(table.frames.cols() == 3);
  dsp::FrameBlock expected(4, 3);
  expected << 0.0, 1.5, -2e-3, 0.25, 2.5, 3.0, 0.5, -3.5, 4.0, 0.75, 4.5, 1e6;
  CHECK((table.frames - expected).cwiseAbs().maxCoeff() == 0.0);
}

bool has_check(const Table& table, const std::string& name) {
  for (const auto& check : table.info.checks)
    if (check.name == name) return true;
  return false;
}

std::string stamps(int count, const std::function<double(int)>& time, const char* format = "%.9f") {
  std::string text = "t,x\n";
  for (int i = 0; i < count; ++i) {
    char line[64];
    std::snprintf(line, sizeof line, format, time(i));
    text += std::string(line) + "," + std::to_string(i) + "\n";
  }
  return text;
}

}  // namespace

TEST_CASE("a table is understood however it is written", "[dsp][table_file]") {
  const Scratch scratch;
  const auto check = [&](const std::string& text, bool named) {
    INFO(text);
    const auto table = read(scratch.file("a.txt", text));
    check_rows(table);
    CHECK(table.info.named == named);
    CHECK(table.info.sample_rate_hz == (named ? 4.0 : 0.0));
  };
  const std::string plain = "t,x,y\n0,1.5,-2e-3\n0.25,2.5,3\n0.5,-3.5,4.0\n0.75,4.5,1e6\n";
  check(plain, true);
  check("\xef\xbb\xbf" + plain, true);                                                    // byte order mark
  check("t,x,y\r\n0,1.5,-2e-3\r\n0.25,2.5,3\r\n0.5,-3.5,4.0\r\n0.75,4.5,1e6\r\n", true);  // CRLF
  check("t;x;y\n0;1,5;-2e-3\n0,25;2,5;3\n0,5;-3,5;4,0\n0,75;4,5;1e6\n", true);            // semicolon, decimal comma
  check("t\tx\ty\n0\t1,5\t-2e-3\n0,25\t2,5\t3\n0,5\t-3,5\t4,0\n0,75\t4,5\t1e6\n", true);  // tab, decimal comma
  check("\"t\",\"x\",\"y\"\n\"0\",\"1.5\",\"-2e-3\"\n0.25,2.5,+3\n0.5,-3.5,4.0\n0.75,4.5,1e6\n", true);  // quotes
  check("# rig 7\n\n% by hand\n" + plain, true);                                                         // comments
  check("0,1.5,-2e-3\n0.25,2.5,3\n# knocked\n0.5,-3.5,4.0\n\n0.75,4.5,1e6\n", false);                    // no header
  check("t,x,y,\n0,1.5,-2e-3,\n0.25,2.5,3,\n0.5,-3.5,4.0,\n0.75,4.5,1e6,\n", true);  // trailing comma
  check("t,x,y\n0,1.5,-2e-3,\n0.25,2.5,3,\n0.5,-3.5,4.0,\n0.75,4.5,1e6,\n", true);   // only under the header
  check("  0   1.5  -2e-3\n 0.25  2.5 3\n0.5 -3.5\t4.0  \n0.75 4.5 1e6\n", false);   // blanks
  check("# t x y\n0 1.5 -2e-3\n0.25 2.5 3\n0.5 -3.5 4.0\n0.75 4.5 1e6\n", true);     // names in a remark
  check("t , x , y\n0 , 1.5 , -2e-3\n0.25 , 2.5 , 3\n0.5 , -3.5 , 4.0\n0.75 , 4.5 , 1e6\n", true);  // blanks within
  check("time,x,y\ns,mm,-\n0,1.5,-2e-3\n0.25,2.5,3\n0.5,-3.5,4.0\n0.75,4.5,1e6\n", true);           // a line of units
}

TEST_CASE("missing values are NaN, not zero", "[dsp][table_file]") {
  const Scratch scratch;
  const auto table = read(scratch.file("a.csv", "x,y,z\n1,,3\nNaN,inf,NA\n4,5,\n7,8,9\n"));
  CHECK(table.frames(0, 0) == 1.0);
  for (const auto& [row, column] : {std::pair{0, 1}, {1, 0}, {1, 1}, {1, 2}, {2, 2}})
    CHECK(std::isnan(table.frames(row, column)));
}

TEST_CASE("a ragged row, a cut last line and a bad cell are refused with line and column", "[dsp][table_file]") {
  const Scratch scratch;
  const auto refused = [&](const std::string& text, const std::string& name, const std::vector<std::string>& pieces) {
    check_fault([&] { (void)read(scratch.file("a.csv", text)); }, FaultKind::input, name, pieces);
  };
  refused("x,y\n1,2\n3\n5,6\n7,8\n", "table.ragged", {"a.csv:3:", "1 columns, want 2"});
  refused("x,y\n1,2\n3,4,5\n5,6\n", "table.ragged", {"a.csv:3:", "3 columns, want 2"});
  refused("x,y\n1,2\n3,4\n5", "table.cut", {"a.csv:4:", "the last line is cut", "--salvage"});
  refused("x,y\n1,2\n3,4\n5,six\n7,8\n", "table.cell", {"a.csv:4: column 2: 'six' is no number"});
  refused("x,y\n1,2\n3,1e999\n7,8\n", "table.cell", {"a.csv:3: column 2: '1e999'"});
  refused("x,y,z\n1,2\n3,4\n", "table.header", {"a.csv:1:", "names 3 columns, the rows have 2"});
  refused("no numbers here\nnone\n", "container.unknown", {"row of numbers"});
  refused("x," + std::string(2'000'000, '1') + "\n1,2\n", "table.line", {"a.csv:1:", "1 MiB"});
  const auto salvaged = read(scratch.file("a.csv", "x,y\n1,2\n3,4\n5"), {.salvage = true});
  CHECK(salvaged.frames.rows() == 2);
  CHECK(has_check(salvaged, "table.cut"));
}

TEST_CASE("a last line without its end is left out with a warning: its last number may be cut", "[dsp][table_file]") {
  const Scratch scratch;
  for (const bool salvage : {false, true}) {
    const auto table = read(scratch.file("a.csv", "x,y\n1,2\n3,412.3e-3\n5,787.1"), {.salvage = salvage});
    CHECK(table.frames.rows() == 2);
    REQUIRE(table.info.checks.size() == 1);
    CHECK(table.info.checks[0].name == "table.cut");
    CHECK(table.info.checks[0].status == dsp::CheckStatus::warning);
    CHECK_THAT(table.info.checks[0].message, Catch::Contains("a.csv:4: the last line has no line end"));
  }
  const auto clock = read(scratch.file("a.csv", "t,x\n0,1\n1,2\n2,3\n30"), {.salvage = true});
  CHECK(clock.frames.rows() == 3);
  CHECK(read(scratch.file("a.csv", "x,y\n1,2\n3,4\n# the end")).frames.rows() == 2);
  CHECK(read(scratch.file("a.csv", "x,y\n1,2\n3,4\n# the end")).info.checks.empty());
  const std::string lvm =
      "LabVIEW Measurement\t\nX_Columns\tOne\n***End_of_Header***\t\nDelta_X\t0.1\n***End_of_Header***\n"
      "X_Value\tF\tComment\n0.0\t1\n0.1\t2.5\n0.2\t3.7";
  CHECK(read(scratch.file("a.lvm", lvm)).frames.rows() == 2);
  CHECK(has_check(read(scratch.file("a.lvm", lvm)), "table.cut"));
  check_fault([&] { (void)read(scratch.file("a.csv", "5,787.1")); }, FaultKind::input, "table.empty", {"no whole row"});
}

TEST_CASE("a LabVIEW header without columns is refused", "[dsp][table_file]") {
  const Scratch scratch;
  const auto file =
      scratch.file("a.lvm", "LabVIEW Measurement\n***End_of_Header***\n***End_of_Header***\nComment\n1\n");
  check_fault([&] { (void)read(file); }, FaultKind::input, "table.header", {"without columns"});
}

TEST_CASE("the rate is the roundest that explains the stamps", "[dsp][table_clock]") {
  const Scratch scratch;
  const auto rate = [&](const std::string& text) { return read(scratch.file("a.csv", text)).info.sample_rate_hz; };
  CHECK(rate(stamps(500, [](int i) { return 17 + i / 250.0; })) == 250.0);
  CHECK(rate(stamps(500, [](int i) { return i / 51200.0; })) == 51200.0);
  CHECK(rate(stamps(
            500, [](int i) { return std::floor(1e6 * i / 3200.0) / 1e6; }, "%.6f")) == 3200.0);
  CHECK(rate(stamps(
            5000, [](int i) { return i / 610.3515625; }, "%.6f")) == 610.3515625);
  CHECK(rate(stamps(
            5000, [](int i) { return i / 25.6; }, "%.17g")) == 25.6);
  CHECK(rate(stamps(
            5000, [](int i) { return i * 3 / 51200.0; }, "%.12g")) == 51200.0 / 3);
  CHECK(rate("time (ms),x\n0,1\n10,2\n20,3\n") == 100.0);
  CHECK(has_check(read(scratch.file("a.csv", stamps(
                                                 500, [](int i) { return i / 3200.0; }, "%.6f"))),
                  "clock.printed"));
}

TEST_CASE("stamps of so many figures are rounded ones, not uneven", "[dsp][table_clock]") {
  const Scratch folder;
  for (const int figures : {4, 5, 6}) {
    // Trailing zeros left out, as %g does.
    std::string text = "t,x\n";
    for (int i = 0; i < 15000; ++i) text += fmt::format("{:.{}g},{}\n", i / 50.0, figures, i % 7);
    CHECK(read(folder.file("g.csv", text), {.rate_hz = figures == 4 ? std::optional(50.0) : std::nullopt})
              .info.sample_rate_hz == 50.0);
  }
  // An uneven clock stays one.
  std::string uneven = "t,x\n";
  for (int i = 0; i < 1000; ++i) uneven += fmt::format("{:.5f},1\n", i / 50.0 + (i % 2) * 6e-3);
  check_fault([&] { (void)read(folder.file("u.csv", uneven)); }, FaultKind::input, "clock.jitter", {"u.csv"}, {});
}

TEST_CASE("the roundest rate is found within its uncertainty only", "[dsp][table_clock]") {
  CHECK(dsp::roundest_rate(3199.98, 1e-5) == 3200.0);
  CHECK(dsp::roundest_rate(3199.98, 1e-6) != 3200.0);
  CHECK(dsp::roundest_rate(99.7, 0.05) == 100.0);
  CHECK(dsp::roundest_rate(17066.6667, 1e-8) == 51200.0 / 3);
  CHECK(dsp::roundest_rate(0.25, 1e-9) == 0.25);
}

TEST_CASE("gaps of whole steps are filled and named", "[dsp][table_clock]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", stamps(100, [](int i) { return (i < 40 ? i : i + 7) / 10.0; }));
  const auto table = read(file);
  REQUIRE(table.frames.rows() == 107);
  CHECK(table.info.sample_rate_hz == 10.0);
  REQUIRE(table.info.gaps.size() == 1);
  CHECK(table.info.gaps[0].from_s == Approx(3.9));
  CHECK(table.info.gaps[0].to_s == Approx(4.7));
  for (int i = 0; i < 8; ++i) CHECK(table.frames(39 + i, 1) == Approx(39 + i / 8.0).epsilon(1e-14));
  CHECK(table.frames(106, 1) == 99.0);
  CHECK(has_check(table, "clock.gap"));
  for (const Eigen::Index size : {1, 3, 45})
    CHECK((read(file, {}, size).frames - table.frames).cwiseAbs().maxCoeff() == 0.0);
}

TEST_CASE("a clock that goes back, repeats, jitters or loses its step is refused", "[dsp][table_clock]") {
  const Scratch scratch;
  const auto refused = [&](const std::function<double(int)>& time, const std::string& name,
                           const std::vector<std::string>& pieces) {
    check_fault([&] { (void)read(scratch.file("a.csv", stamps(100, time))); }, FaultKind::input, name, pieces);
  };
  refused([](int i) { return (i == 50 ? 48.5 : i) / 10.0; }, "clock.backwards", {"a.csv:52:", "4.9 to 4.85"});
  refused([](int i) { return (i == 50 ? 49 : i) / 10.0; }, "clock.repeated", {"a.csv:52:", "4.9 s occurs twice"});
  refused([](int i) { return (i + 0.3 * std::sin(i * i)) / 10.0; }, "clock.jitter", {"uneven", "a.csv.toml"});
  check_fault([&] { (void)read(scratch / "a.csv"); }, FaultKind::input, "clock.jitter", {},
              {"rate = 10\nclock = \"interpolate\"\n"});
  refused([](int i) { return (i < 40 ? i : i + 7.4) / 10.0; }, "clock.gap", {"a.csv:42:", "no whole number of steps"});
  check_fault([&] { (void)read(scratch.file("a.csv", "t,x\n0,1\n1,1\n,2\n3,4\n")); }, FaultKind::input, "table.cell",
              {"a.csv:4", "no time"});
  const auto slight =
      read(scratch.file("b.csv", stamps(100, [](int i) { return (i + 0.005 * std::sin(i * i)) / 10.0; })));
  CHECK(slight.info.sample_rate_hz == Approx(10.0).epsilon(1e-4));
  CHECK(has_check(slight, "clock.jitter"));
}

TEST_CASE("lines that are no rows are counted in the line named", "[dsp][table_clock]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", "t,x\n0,1\n# knocked\n1,2\n\n2,3\n# here\n2,4\n3,5\n");
  check_fault([&] { (void)read(file); }, FaultKind::input, "clock.repeated", {"a.csv:8:"});
}

TEST_CASE("a column is no clock if its unit is not one of time", "[dsp][table_clock]") {
  const Scratch scratch;
  const auto table = read(scratch.file("a.csv", "t_mm,x\n3,1\n2,2\n"));
  CHECK(table.info.time_column == -1);
}

TEST_CASE("an uneven clock is interpolated on request", "[dsp][table_clock]") {
  const Scratch scratch;
  // x is linear in the row number and so, between rows, in time.
  const auto time = [](int i) { return (i + 0.3 * std::sin(i * i)) / 10.0; };
  const auto table =
      read(scratch.file("a.csv", stamps(200, time)), {.rate_hz = 20.0, .clock = dsp::ClockKind::interpolate});
  CHECK(table.info.sample_rate_hz == 20.0);
  for (Eigen::Index n = 0; n < table.frames.rows(); ++n) {
    const double at_s = static_cast<double>(n) / 20.0;
    CHECK(table.frames(n, 0) == Approx(at_s).margin(1e-9));
    int row = 1;
    while (row < 199 && time(row) < at_s) ++row;
    const double expected = row - 1 + (at_s - time(row - 1)) / (time(row) - time(row - 1));
    CHECK(table.frames(n, 1) == Approx(expected).margin(1e-6));  // stamps are printed to 1e-9 s, steps at least 0.04 s
  }
}

TEST_CASE("a stated rate settles stamps printed too coarsely", "[dsp][table_clock]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", stamps(
                                              300, [](int i) { return std::floor(i / 3.0) / 100; }, "%.2f"));
  check_fault([&] { (void)read(file); }, FaultKind::input, "clock.repeated", {"state the rate at the top of"});
  CHECK(read(file, {.rate_hz = 300.0}).info.sample_rate_hz == 300.0);
  check_fault([&] { (void)read(file, {.rate_hz = 200.0}); }, FaultKind::input, "clock.repeated", {});
}

TEST_CASE("LabVIEW text of every kind is read", "[dsp][table_file][real]") {
  const auto folder = real_data / "format_samples";
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: " << folder << " is not there");
    return;
  }
  const auto comma = read(folder / "short.lvm");
  CHECK(comma.info.sample_rate_hz == 25'600.0);
  CHECK(comma.frames.rows() == 10);
  CHECK(comma.frames(0, 1) == 0.914018);
  CHECK(comma.info.units[2] == "m/s^2");
  const auto several = read(folder / "multi_time_column.lvm");
  CHECK(several.info.sample_rate_hz == 51'200.0);
  CHECK(several.info.partial[2]);
  CHECK(several.frames(2, 3) == 0.467541);
  CHECK(read(folder / "no_decimal_separator.lvm").frames(3, 5) == -0.009433);
  CHECK(read(folder / "long_single_header_multi_ch.lvm").info.sample_rate_hz == 1024.0);
  CHECK(read(folder / "with_empty_fields.lvm").frames(0, 7) == -0.011923);
  check_fault([&] { (void)read(folder / "with_comments.lvm"); }, FaultKind::input, "clock.jitter", {"uneven"});
}

TEST_CASE("no text whatever crashes the reader of tables", "[dsp][table_file]") {
  const Scratch scratch;
  const std::string lvm =
      "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\t\nChannels\t1\nSamples\t3\n"
      "Delta_X\t0.1\n***End_of_Header***\nX_Value\tF\tComment\n0.0\t1\n0.1\t2\n0.2\t3\n";
  const std::vector<std::string> originals{stamps(20, [](int i) { return i / 10.0; }), lvm, "a;b\n1,5;2\n2,5;3\n",
                                           "1 2\n3 4\n"};
  rc::prop("changed, cut, doubled", [&] {
    auto text = *rc::gen::elementOf(originals);
    const int changes = *rc::gen::inRange(0, 6);
    for (int i = 0; i < changes; ++i)
      text[*rc::gen::inRange<std::size_t>(0, text.size())] =
          *rc::gen::oneOf(rc::gen::elementOf(std::string(",;\t \n\r\"#-+.eE019nNaA")), rc::gen::inRange<char>(1, 127));
    text.resize(*rc::gen::inRange<std::size_t>(1, text.size() + 1));
    const auto file = scratch.file("fuzz.csv", text);
    const bool salvage = *rc::gen::arbitrary<bool>();
    support::check_whole_or_refused([&] { return dsp::open_source(file, {.salvage = salvage}); }, 7);
  });
}

TEST_CASE("a clock with more missing than there is, and a rate with hardly a row a frame, are refused",
          "[dsp][table_clock]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", stamps(100, [](int i) { return (i < 50 ? i : i + 101) / 10.0; }));
  check_fault([&] { (void)read(file); }, FaultKind::input, "clock.gap", {"more is missing (101 frames) than is there"});
  check_fault([&] { (void)read(file, {.rate_hz = 1000.0, .clock = dsp::ClockKind::interpolate}); }, FaultKind::input,
              "clock.gap", {"100 rows over 20 s are too few for 1000 Hz"});
}

TEST_CASE("a time column is named or numbered, and refused where it is not", "[dsp][table_file]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", "x,stamp\n1,0.1\n2,0.2\n3,0.3\n");
  CHECK(read(file, {.time_column = "2"}).info.sample_rate_hz == 10.0);
  CHECK(read(file, {.time_column = "stamp"}).info.sample_rate_hz == 10.0);
  for (const char* wrong : {"3", "0", "clock"})
    check_fault([&] { (void)read(file, {.time_column = wrong}); }, FaultKind::usage, "channel.index",
                {"no time column '" + std::string(wrong) + "' among 2 columns"});
}

TEST_CASE("a table that is cut while it is read is refused", "[dsp][table_file]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", stamps(1'000'000, [](int i) { return i / 10.0; }));
  const auto source = dsp::open_source(file);
  dsp::FrameBlock block;
  REQUIRE(source->read(block, 10) == 10);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  check_fault(
      [&] {
        while (source->read(block, 100'000) > 0) {
        }
      },
      FaultKind::input, "file.changed", {"a.csv", "while it was read"});
}

TEST_CASE("columns whose names become one are refused as signals", "[dsp][table_file]") {
  const Scratch scratch;
  const auto table = dsp::read_signal_table(scratch.file("a.csv", "force [kN],x\n1,2\n3,4\n"));
  REQUIRE(table.renamed.size() == 1);
  CHECK(table.renamed[0].second == table.signals.signals[0].name);
  const auto twice = scratch.file("b.csv", table.renamed[0].second + ",force [kN]\n1,2\n3,4\n");
  check_fault([&] { (void)dsp::read_signal_table(twice); }, FaultKind::input, "channel.name",
              {"two columns are called '" + table.renamed[0].second + "'"});
}

TEST_CASE("dates and times of day are a clock, in any style of table", "[dsp][table_clock]") {
  // From 2.5 s before midnight at 100 Hz.
  const auto stamp = [](int i) {
    const int ms = 86'397'500 + 10 * i, day = ms / 86'400'000, rest = ms % 86'400'000;
    return std::array{day, rest / 3'600'000, rest / 60'000 % 60, rest / 1000 % 60, rest % 1000};
  };
  const auto table = [&](const std::string& header, const std::function<std::string(const std::array<int, 5>&)>& time,
                         const char* row) {
    std::string text = header;
    for (int i = 0; i < 500; ++i)
      text += time(stamp(i)) + fmt::format(fmt::runtime(row), 0.5 * std::sin(0.1 * i)) + "\n";
    return text;
  };
  const Scratch folder;
  const auto iso = [](const std::array<int, 5>& t) {
    return fmt::format("2026-12-{}T{:02}:{:02}:{:02}.{:03}+01:00", 30 + t[0], t[1], t[2], t[3], t[4]);
  };
  const auto german = [](const std::array<int, 5>& t) {
    return fmt::format("{}.12.2026 {:02}:{:02}:{:02},{:03}", 30 + t[0], t[1], t[2], t[3], t[4]);
  };
  const auto apart = [](const std::array<int, 5>& t) {
    return fmt::format("2026-12-{};{:02}:{:02}:{:02}.{:03}", 30 + t[0], t[1], t[2], t[3], t[4]);
  };
  const auto minutes = [](const std::array<int, 5>& t) {
    return fmt::format("{:02}:{:02}.{:02}", t[2], t[3], t[4] / 10);
  };
  struct Case {
    std::string text;
    int column;
  };
  for (const Case& one :
       {Case{table("when,x_mm\n", iso, ",{:.4f}"), 0}, Case{table("", iso, ",{:.4f}"), 0},
        Case{table("Datum;x_mm\n", german, ";{:.4f}"), 0}, Case{table("Date;Time;x_mm\n", apart, ";{:.4f}"), 1},
        Case{table("Time\tx\n", minutes, "\t{:.4f}"), 0}}) {
    CAPTURE(one.text.substr(0, 80));
    const Table found = read(folder.file("a.csv", one.text));
    CHECK(found.info.time_column == one.column);
    CHECK(found.info.sample_rate_hz == 100.0);
    CHECK(found.info.gaps.empty());
    // 2026-12-30 is 20817 days after 1970-01-01: 40 behind 2026-11-20, which tests/dsp/io/moment.cpp counts.
    CHECK(found.info.clock_start.day == (one.text.find("Time\tx") == 0 ? std::nullopt : std::optional(20817)));
    REQUIRE(found.frames.rows() == 500);
    CHECK(found.frames(499, found.frames.cols() - 1) == Approx(0.5 * std::sin(49.9)).margin(5e-5));  // as printed
  }
  check_fault([&] { (void)read(folder.file("b.csv", table("t,x\n", iso, ",{:.4f}") + "noon,1\n")); }, FaultKind::input,
              "table.cell", {"b.csv:502", "'noon' is no time of day", "10:00:00.123"});
  check_fault([&] { (void)read(folder.file("c.csv", "day,x\nFriday,1\nFriday,2\n")); }, FaultKind::input,
              "container.unknown", {"line 3, column 1 is 'Friday'"});
}

TEST_CASE("a table without a row of numbers names the cell that is none", "[dsp][table_file]") {
  struct Case {
    const char *text, *blamed;
  };
  const Scratch folder;
  for (const Case& one :
       {Case{"t;x;f\n0,5;1,5;abc\n1,0;2,5;abc\n", "line 3, column 3 is 'abc'"},         // a comma is no fault of 1,0
        Case{"t,x,f\n0,,abc\n1,,abc\n", "line 3, column 3 is 'abc'"},                   // an empty cell is only missing
        Case{"t,x\n0,abc\nmade by,a logger\n# 1,2,on\n", "line 2, column 2 is 'abc'"},  // a footer is no row
        Case{"a;b\nc;d\n", "line 2, column 1 is 'c'"}}) {
    CAPTURE(one.text);
    check_fault([&] { (void)read(folder.file("a.csv", one.text)); }, FaultKind::input, "container.unknown",
                {one.blamed});
  }
}

TEST_CASE("a column of numbers called time is the clock, not the stamps beside it", "[dsp][table_clock]") {
  std::string text = "Timestamp,Time (s),acc\n";
  for (int i = 0; i < 40; ++i) text += fmt::format("2026-11-20 10:00:{:02},{:.2f},{}\n", i / 10, 0.1 * i, i % 7);
  const Scratch folder;
  const auto source = dsp::open_source(folder.file("stamps.csv", text), {});
  CHECK(source->info().sample_rate_hz == Approx(10.0));
  CHECK(source->info().time_column == 1);
  CHECK(source->info().partial[0]);
}

}  // namespace test_io_table_file
