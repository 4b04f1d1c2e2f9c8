/// Tables as loggers, oscilloscopes, phones and spreadsheets write them: one decay of 3 Hz at 50 Hz, in mm, in the
/// layout of each, is read as the same numbers.

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "dsp/io/sample_source.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"

using dsp::FaultKind;
using support::check_fault;
using support::Scratch;

namespace {

constexpr int num_rows = 300;
constexpr double rate_hz = 50.0;

double value(int i) {
  return std::round(2e4 * std::exp(-0.01 * i) * std::cos(0.12 * 3.14159265358979 * i)) / 1e3;
}

/// `header`, then a row for each sample.
std::string table(const std::string& header, const std::function<std::string(int)>& row) {
  std::string text = header;
  for (int i = 0; i < num_rows; ++i) text += row(i) + "\n";
  return text;
}

std::string plain(int i) {
  return fmt::format("{:.2f},{:.3f}", i / rate_hz, value(i));
}

std::string with_commas(std::string text) {
  for (char& c : text)
    if (c == '.') c = ',';
  return text;
}

struct Read {
  dsp::SourceInfo info;
  std::vector<double> column;
  [[nodiscard]] bool has_check(const std::string& name) const {
    return std::any_of(info.checks.begin(), info.checks.end(), [&](const auto& check) { return check.name == name; });
  }
};

Read read(const std::string& text, int column, const dsp::OpenOptions& options = {}) {
  const Scratch scratch;
  const auto source = dsp::open_source(scratch.file("a.csv", text), options);
  Read result{source->info(), {}};
  dsp::FrameBlock block;
  while (const auto count = source->read(block, 64))
    for (Eigen::Index i = 0; i < count; ++i) result.column.push_back(block(i, column));
  return result;
}

/// All values in column `column` (0-based), on a clock of 50 Hz.
Read check_decay(const std::string& text, int column = 1, const std::string& unit = "mm",
                 const dsp::OpenOptions& options = {}, double in_unit = 1.0) {
  INFO(text.substr(0, 200));
  Read found = read(text, column, options);
  CHECK(found.info.sample_rate_hz == rate_hz);
  CHECK(found.info.units[static_cast<std::size_t>(column)] == unit);
  REQUIRE(found.column.size() == num_rows);
  for (int i = 0; i < num_rows; ++i)
    CHECK(found.column[static_cast<std::size_t>(i)] == Approx(in_unit * value(i)).margin(1e-9));
  return found;
}

}  // namespace

TEST_CASE("units stand behind slash, comma, bracket, blank or in a line of their own", "[dsp][table_kinds]") {
  for (const char* header : {"t / s,x / mm\n", "\"Time, s\",\"Displacement, mm\"\n", "Time (s),Weg [mm]\n",
                             "Latest: Time (s),Latest: Position (mm)\n", "Time [s] Run #1,Position [mm] Run #1\n",
                             "seconds_elapsed,laser_mm\n"})
    check_decay(table(header, plain));
  check_decay(table("Time,Laser\n[ s ],[ mm ]\n", plain));
  check_decay(
      table("t;x\ns;mm\n", [](int i) { return with_commas(fmt::format("{:.2f};{:.3f}", i / 50.0, value(i))); }));
  check_decay(table("Zeit,Weg \xb5m\n", plain), 1, "\xc2\xb5m");  // Latin-1
}

TEST_CASE("lines above the names are skipped with a note or say the rate", "[dsp][table_kinds]") {
  const auto tab = [](int i) { return fmt::format("{:.2f}\t{:.3f}", i / 50.0, value(i)); };
  const auto named = check_decay(table("File name\tDecay\nNumber of channels\t1\n\nTime (s)\tLaser/AI 1 (mm)\n", tab));
  CHECK(named.info.columns[1] == "Laser/AI 1 (mm)");
  CHECK(named.has_check("table.skipped"));
  check_decay(table("Source File Name:\tm.pvd\nSignal:\tTime - Velocity\n\nTime\tVelocity\n[ s ]\t[ mm/s ]\n", tab), 1,
              "mm/s");
  // Where no column is a clock, the header's rate counts.
  const auto one = [](int i) { return fmt::format("{:.3f};0", value(i)); };
  for (const char* header :
       {"Sample rate;50 Hz\nx_mm;y_mm\n", "# Abtastrate: 50\nx_mm;y_mm\n", "dt (ms);20\nx_mm;y_mm\n"})
    check_decay(table(header, one), 0);
}

TEST_CASE("an oscilloscope's increment is the step of a count of rows", "[dsp][table_kinds]") {
  const auto found = check_decay(table("X,CH1,Start,Increment\nSequence,Volt,-1.0e+00,2.0e-02\n",
                                       [](int i) { return fmt::format("{},{:.3f},", i, value(i)); }),
                                 1, "Volt");
  CHECK(found.info.columns[1] == "CH1");
  CHECK(found.info.partial[0]);
}

TEST_CASE("spreadsheets' habits are read", "[dsp][table_kinds]") {
  check_decay(table("\xef\xbb\xbfsep=;\nTime [s];Position [mm]\n",
                    [](int i) { return with_commas(fmt::format("{:.2f};{:.3f}", i / 50.0, value(i))); }));
  check_decay(table("\"Time (s)\",\"Position (mm)\"\n", [](int i) {
    return fmt::format("\"{}\",\"{}\"", with_commas(fmt::format("{:.2f}", i / 50.0)),
                       with_commas(fmt::format("{:.3f}", value(i))));
  }));
  check_decay(table("{System 1};;\nTime {1} [s];Value {1} [mm];\n",
                    [](int i) { return fmt::format("{:.2f};{:.3f};", i / 50.0, value(i)); }));
  std::string wide("\xff\xfe");
  for (const char c : table("time_s,x_mm\r\n", plain)) wide += std::string{c, '\0'};
  check_decay(wide);
}

TEST_CASE("columns that are no signals are left out with a note", "[dsp][table_kinds]") {
  const auto text = check_decay(table("time_s,x_mm,status\n", [](int i) { return plain(i) + ",OK"; }));
  CHECK(text.info.partial[2]);
  CHECK(text.has_check("table.left_out"));
  const auto sparse =
      check_decay(table("time_s,laser_mm,encoder_mm\n", [](int i) { return plain(i) + (i % 4 == 0 ? ",1.5" : ","); }));
  CHECK(sparse.info.columns.size() == 3);
  CHECK(sparse.info.partial[2]);
  CHECK(read(table("Counter,Time (s),d_mm\n", [](int i) { return fmt::format("{},{}", i, plain(i)); }), 2)
            .info.partial[0]);
}

TEST_CASE("a summary under the rows is left out with a warning", "[dsp][table_kinds]") {
  for (const char* end : {"\nMean,0.0065\nStd,7.3\n", "Mean,0.0065\n"})
    CHECK(check_decay(table("time_s,x_mm\n", plain) + end).has_check("table.end"));
}

TEST_CASE("months by name, epochs by their size and words for units of time are clocks", "[dsp][table_kinds]") {
  check_decay(table("Timestamp,x_mm\n", [](int i) {
    return fmt::format("03-Nov-2022 16:00:{:02}.{:03},{:.3f}", i / 50, i % 50 * 20, value(i));
  }));
  for (const auto& [unit, digits] : {std::pair{"", 3}, {"ms", 0}, {"us", 3}, {"ns", 6}}) {
    CAPTURE(unit);
    const std::string zeros(static_cast<std::size_t>(digits), '0');
    check_decay(table("time,x_mm\n", [&, seconds = digits == 3 && *unit == 0](int i) {
      return seconds ? fmt::format("{:.2f},{:.3f}", 1.7e9 + i / 50.0, value(i))
                     : fmt::format("{}{},{:.3f}", 1'700'000'000'000 + 20 * i, zeros, value(i));
    }));
  }
  check_decay(table("millis,x_mm\n", [](int i) { return fmt::format("{},{:.3f}", 1203 + 20 * i, value(i)); }));
}

TEST_CASE("a unit of time counts behind every name that speaks of time, and one that is not known is no second",
          "[dsp][table_kinds]") {
  for (const char* name : {"Zeit in ms", "Time in ms", "Elapsed time ms", "elapsed_ms", "time_stamp_ms"}) {
    CAPTURE(name);
    const auto rows =
        table(fmt::format("{},x\n", name), [](int i) { return fmt::format("{:.1f},{:.3f}", 0.1 * i, value(i)); });
    CHECK(read(rows, 1, {.with_clock = true}).info.sample_rate_hz == Approx(10'000.0));
  }
  const auto minutes =
      table("Time (min),x\n", [](int i) { return fmt::format("{:.4f},{:.3f}", 0.0005 * i, value(i)); });
  CHECK(read(minutes, 1, {.with_clock = true}).info.sample_rate_hz != Approx(2'000.0));
}

TEST_CASE("a ramp is no clock where the header states the rate", "[dsp][table_kinds]") {
  const auto rows = table("# Sample rate: 1000 Hz\nsetpoint,acc\n",
                          [](int i) { return fmt::format("{:.2f},{:.3f}", 0.01 * i, value(i)); });
  const auto found = read(rows, 0, {.with_clock = true});
  CHECK(found.info.sample_rate_hz == 1000.0);
  CHECK(found.info.time_column < 0);
}

TEST_CASE("an even column is the clock whatever its name, and contradicts another rate", "[dsp][table_kinds]") {
  const std::string text = table("Abtastung,x_mm\n", plain);
  CHECK(check_decay(text).has_check("clock.assumed"));
  check_fault([&] { (void)read(text, 1, {.rate_hz = 60.0}); }, FaultKind::input, "rate.mismatch", {"60 Hz"});
  // Described as a signal it is one.
  CHECK(read(text, 1, {.rate_hz = 60.0, .signal_columns = {"1"}}).info.time_column == -1);
}

TEST_CASE("several runs side by side are asked for, and one is taken", "[dsp][table_kinds]") {
  const std::string text = table("Time (s) Run #1;Weg (mm) Run #1;Time (s) Run #2;Weg (mm) Run #2\n", [](int i) {
    return fmt::format("{:.2f};{:.3f};{:.2f};{:.3f}", i / 50.0, -value(i), i / 50.0, value(i));
  });
  check_fault([&] { (void)read(text, 1); }, FaultKind::input, "clock.run", {"2 runs", "a.csv.toml"},
              {"run = 1  # columns 1 to 2: 'Time', 'Weg'\n# run = 2", "\n# run = \"all\""});
  const auto second = check_decay(text, 3, "mm", {.run = 2});
  CHECK(second.info.columns[3] == "Weg");
  CHECK(second.info.partial[1]);
  check_fault([&] { (void)read(text, 1, {.run = 3}); }, FaultKind::usage, "channel.index", {"holds 2 runs"});
}

TEST_CASE("runs are told apart by what stands before their names, too", "[dsp][table_kinds]") {
  const auto run_rows = [](int i) {
    return fmt::format("{:.2f},{:.3f},{:.2f},{:.3f}", i / 50.0, -value(i), i / 50.0, value(i));
  };
  for (const std::string names : {"Run 1: Time (s),Run 1: Weg (mm),Run 2: Time (s),Run 2: Weg (mm)\n",
                                  "Time (s),Run 1: Weg (mm),Time (s),Run 2: Weg (mm)\n"}) {
    const std::string text = table(names, run_rows);
    check_fault([&] { (void)read(text, 1); }, FaultKind::input, "clock.run", {"2 runs"}, {"run = \"all\""});
    CHECK(check_decay(text, 3, "mm", {.run = 2}).info.num_runs == 2);
  }
}

TEST_CASE("of two clocks in one table the faster one is used, and what is on the other named with its rate",
          "[dsp][table_kinds]") {
  for (const std::string names : {"t_fast,Weg_mm,t_slow,angle_deg\n", "Time (s),Weg_mm,Time 2 (s),angle_deg\n"}) {
    const std::string text = table(names, [](int i) {
      const std::string slow = i % 2 == 0 && i / 2 < num_rows / 4 ? fmt::format("{:.2f},{}", i / 2 / 12.5, i % 7) : ",";
      return fmt::format("{},{}", plain(i), i < num_rows / 4 ? fmt::format("{:.2f},{}", i / 12.5, i % 7) : ",");
    });
    INFO(text.substr(0, 200));
    const auto found = check_decay(text);
    CHECK(found.info.num_frames == num_rows);
    CHECK(found.info.partial[3]);
    CHECK(std::any_of(found.info.checks.begin(), found.info.checks.end(), [](const auto& check) {
      return check.name == "table.left_out" && check.message.find("12.5 Hz") != std::string::npos;
    }));
  }
}

TEST_CASE("bars between cells, marks between thousands, exponents of Fortran", "[dsp][table_kinds]") {
  const auto with = [](char from, const std::string& to) {
    return [=](int i) {
      std::string row = plain(i);
      return row.replace(row.find(from), 1, to);
    };
  };
  (void)check_decay(table("time_s|x_mm\n", with(',', "|")));
  (void)check_decay(
      table("time_s,x_mm\n", [](int i) { return fmt::format("{:.2f}D+00,{:.3f}d0", i / 50.0, value(i)); }));
  const auto found =
      read(table("time_s;x_um\n",
                 [](int i) { return fmt::format("{},{:02d};{}.{:03d},5", i / 50, i % 50 * 2, 1 + i % 7, i % 1000); }),
           1);
  CHECK(found.column[8] == 2008.5);
}

TEST_CASE("a remark with names over one with units names the columns", "[dsp][table_kinds]") {
  const auto found = check_decay(table("# time,x\n# s,mm\n", plain));
  CHECK(found.info.columns[1] == "x");
}

TEST_CASE("empty columns at the end are none", "[dsp][table_kinds]") {
  const auto found = check_decay(table("time_s,x_mm,,\n", [](int i) { return plain(i) + ",,"; }));
  CHECK(found.info.columns.size() == 2);
}

TEST_CASE("lines may end in carriage returns alone, and UTF-16 needs no mark", "[dsp][table_kinds]") {
  const std::string text = table("time_s,x_mm\n", plain);
  std::string old = text, wide;
  std::replace(old.begin(), old.end(), '\n', '\r');
  (void)check_decay(old);
  for (const char c : text) wide += {c, '\0'};
  (void)check_decay(wide);
  wide.clear();
  for (const char c : text) wide += {'\0', c};
  (void)check_decay(wide);
}

TEST_CASE("header_row and skip_rows say where names are", "[dsp][table_kinds]") {
  const std::string text = table("a,b,c\ntime_s,x_mm\nnot,names\n", plain);
  const auto found = check_decay(text, 1, "mm", {.header_row = 2});
  CHECK(found.info.columns[1] == "x_mm");
  const std::string wide = table("time_s,x_mm,more\n", plain);
  check_fault([&] { (void)read(wide, 1); }, FaultKind::input, "table.header", {"names 3 columns, the rows have 2"},
              {"skip_rows = 1\n"});
  CHECK(read(wide, 1, {.skip_rows = 1}).info.sample_rate_hz == rate_hz);
}

TEST_CASE("rows that were written twice are used once", "[dsp][table_kinds]") {
  const auto found =
      check_decay(table("time_s,x_mm\n", [](int i) { return i % 60 == 7 ? plain(i) + "\n" + plain(i) : plain(i); }));
  CHECK(found.has_check("table.repeated"));
}

TEST_CASE("rows lost on a clock as coarse as its step leave short gaps, said in one line", "[dsp][table_kinds]") {
  std::string text = "time_s,x_mm\n";
  for (int i = 0; i < num_rows; ++i)
    if (i % 50 != 20) text += plain(i) + "\n";
  const auto found = read(text, 1);
  CHECK(found.info.sample_rate_hz == rate_hz);
  CHECK(found.column.size() == num_rows);
  CHECK(found.info.gaps.size() == 6);
  CHECK(std::count_if(found.info.checks.begin(), found.info.checks.end(),
                      [](const auto& check) { return check.name == "clock.gap"; }) == 1);
}

TEST_CASE("a clock that trembles by less than a tenth of a step is interpolated", "[dsp][table_kinds]") {
  // A straight line in time is what straight lines between rows give back exactly.
  const auto at_s = [](int i) { return (i + 0.05 * std::sin(1.0 * i * i)) / rate_hz; };
  std::string text = "t,x\n";
  for (int i = 0; i < num_rows; ++i) text += fmt::format("{:.9f},{:.9f}\n", at_s(i), 3.0 * at_s(i));
  const auto found = read(text, 1);
  CHECK(found.info.sample_rate_hz == rate_hz);
  CHECK(found.has_check("clock.jitter"));
  for (int i = 0; i + 1 < num_rows; ++i)
    CHECK(found.column[static_cast<std::size_t>(i)] == Approx(3.0 * i / rate_hz).margin(1e-8));
}

TEST_CASE("rows written whenever something moved are refused as such, with lines that work", "[dsp][table_kinds]") {
  std::string text = "time_us,position\n";
  double at_s = 0.0;
  for (int i = 0; i < num_rows; ++i) {
    at_s += 1.0 / (100.0 + 95.0 * std::sin(0.1 * i));
    text += fmt::format("{:.0f},{}\n", 1e6 * at_s, i);
  }
  check_fault([&] { (void)read(text, 1); }, FaultKind::input, "clock.jitter", {"when something had moved"},
              {"clock = \"events\""});
  const auto found = read(text, 1, {.rate_hz = 100.0, .clock = dsp::ClockKind::events});
  CHECK(found.info.sample_rate_hz == 100.0);
  CHECK(found.info.gaps.empty());
}

TEST_CASE("a header in a LabVIEW file for every segment is no row, and a second rate is named", "[dsp][table_kinds]") {
  std::string text = "LabVIEW Measurement\t\nMulti_Headings\tYes\nX_Columns\tOne\n***End_of_Header***\t\n\t\n";
  for (int i = 0; i < num_rows; ++i) {
    if (i % 100 == 0)
      text +=
          "Channels\t1\t\nSamples\t100\t\nY_Unit_Label\tmm\t\nDelta_X\t0.02\t\n***End_of_Header***\t\n"
          "X_Value\tlaser\tComment\n";
    text += fmt::format("{:.2f}\t{:.3f}\n", i / rate_hz, value(i));
  }
  check_decay(text);
  std::string two =
      "LabVIEW Measurement\t\nX_Columns\tMulti\n***End_of_Header***\t\nSamples\t300\t\t75\t\n"
      "Y_Unit_Label\tmm\t\tmm\t\n***End_of_Header***\t\nX_Value\tlaser\tX_Value\tencoder\tComment\n";
  for (int i = 0; i < num_rows; ++i)
    two += fmt::format("{:.2f}\t{:.3f}\t", i / rate_hz, value(i)) +
           (i < 75 ? fmt::format("{:.2f}\t1\t\n", 0.08 * i) : "\t\t\n");
  const auto found = check_decay(two);
  REQUIRE(found.has_check("table.left_out"));
  CHECK_THAT(found.info.checks.front().message, Catch::Contains("'encoder' (75 samples, others have 300)"));
}

TEST_CASE("a line of units of which one is unknown is no line of names", "[dsp][table_kinds]") {
  const auto two = [](int i) { return fmt::format("{:.2f},{:.3f},7", i / rate_hz, value(i)); };
  for (const char* header : {"Time,Laser,Level\ns,mm,Skt\n", "Time,Laser,Level\n[s],[mm],[Skt]\n"}) {
    const auto found = check_decay(table(header, two));
    CHECK(found.info.columns == std::vector<std::string>{"Time", "Laser", "Level"});
    CHECK(found.info.units[2].empty());
  }
  CHECK_FALSE(check_decay(table("Test,Rig\nTime (s),Weg mm\n", plain)).info.columns[0] == "Test");
}

TEST_CASE("names that are numbers are no row", "[dsp][table_kinds]") {
  const auto named = read(table("Time,1\n", plain), 1);
  CHECK(named.info.columns == std::vector<std::string>{"Time", "1"});
  CHECK(named.column.size() == num_rows);
  for (const char* header : {"0,1\n", "1,2\n"}) {
    const auto numbered = read(table(header, plain), 1);
    CHECK(numbered.info.sample_rate_hz == rate_hz);
    CHECK(numbered.column.size() == num_rows);
    CHECK(numbered.column.front() == Approx(value(0)));
  }
}

TEST_CASE("lines of a word and a number do not outvote a few rows", "[dsp][table_kinds]") {
  std::string keys;
  for (int i = 0; i < 60; ++i) keys += fmt::format("setting{},{}\n", i, 1.5 * i);
  for (const char* names : {"t,x_mm\n", "t,x_mm,count\n"}) {
    const bool has_three = std::string(names).find("count") != std::string::npos;
    std::string text = keys + names;
    for (int i = 0; i < 12; ++i) text += plain(i) + (has_three ? ",1\n" : "\n");
    const auto found = read(text, 1);
    CHECK(found.info.columns[1] == "x_mm");
    CHECK(found.column.size() == 12);
  }
}

TEST_CASE("lines of a million separators take a moment and little memory", "[dsp][table_kinds]") {
  std::string text;
  for (int i = 0; i < 40; ++i) text += std::string(1'000'000, ',') + "\n";
  check_fault([&] { (void)read(text, 0); }, FaultKind::input, "container.unknown", {"no line"});
}

TEST_CASE("what instruments print where they have no value is missing", "[dsp][table_kinds]") {
  for (const char* none : {"OL", "-", "--", "#N/A", "#DIV/0!", "****", "-OVLD", "Inf", "n/a", ""}) {
    CAPTURE(none);
    const auto found =
        read(table("time_s,x_mm\n", [&](int i) { return i == 270 ? fmt::format("5.40,{}", none) : plain(i); }), 1);
    REQUIRE(found.column.size() == num_rows);
    CHECK(std::isnan(found.column[270]));
    CHECK(found.column[271] == Approx(value(271)));
  }
  check_fault([] { (void)read(table("time_s,x_mm\n", [](int i) { return i == 270 ? "5.40,1.2.3" : plain(i); }), 1); },
              FaultKind::input, "table.cell", {"a.csv:272: column 2: '1.2.3' is no number"});
  check_decay(table("time  x\n----  ---\n",  // a line under names is no row
                    [](int i) { return fmt::format("{:.2f}  {:.3f}", i / rate_hz, value(i)); }),
              1, "");
}

TEST_CASE("thousands between blanks and apostrophes and a typographer's minus are read", "[dsp][table_kinds]") {
  for (const std::string mark : {" ", "\xc2\xa0", "\xe2\x80\xaf", "'", "\xe2\x80\x99"}) {
    CAPTURE(mark);
    check_decay(table("Zeit (s);Weg (um)\n",
                      [&](int i) {
                        std::string digits = fmt::format("{:.0f}", std::abs(1e3 * value(i)));
                        if (digits.size() > 3) digits.insert(digits.size() - 3, mark);
                        return fmt::format("{:.2f};{}{}", i / rate_hz, value(i) < 0 ? "\xe2\x88\x92" : "", digits);
                      }),
                1, "um", {}, 1e3);
  }
}

TEST_CASE("commas that mark thousands are no decimal commas", "[dsp][table_kinds]") {
  const auto row = [](int i) {
    std::string digits = fmt::format("{:.0f}", 1e3 * value(i));
    if (std::abs(value(i)) >= 1.0) digits.insert(digits.size() - 3, ",");
    return fmt::format("{}\t{}", 20 * i, digits);
  };
  check_fault([&] { (void)read(table("Time (ms)\tx (um)\n", row), 1); }, FaultKind::input, "table.thousands",
              {"column 2", "tr -d , < "});
  // Three decimals throughout, with a zero before them, are decimals.
  check_decay(
      table("Time (ms)\tx (mm)\n", [](int i) { return with_commas(fmt::format("{}\t{:.3f}", 20 * i, value(i))); }));
  check_fault([] { (void)read(table("t (s),x (mm)\n", [](int i) { return with_commas(plain(i)); }), 1); },
              FaultKind::input, "table.header", {"commas are both", "sed -E"});
}

TEST_CASE("rows end before empty cells and words, and a second line of names is none", "[dsp][table_kinds]") {
  const auto rows = table("time_s,x_mm\n", plain);
  CHECK_FALSE(check_decay(rows + ",\n,\n").has_check("table.end"));
  CHECK(check_decay(rows + "END OF DATA\nMax,20.0\n").has_check("table.end"));
  const auto again =
      check_decay(table("time_s,x_mm\n", [](int i) { return (i == 150 ? "time_s,x_mm\n" : "") + plain(i); }));
  CHECK(again.has_check("table.header_again"));
}

TEST_CASE("keys and values beside the first rows are no columns", "[dsp][table_kinds]") {
  const auto found = check_decay(table("",
                                       [](int i) {
                                         const char* beside[] = {"Record Length,300,", "Interval,2e-2,", "Source,CH1,"};
                                         return std::string(i < 3 ? beside[i] : ",,") + "," + plain(i) + ",";
                                       }),
                                 4, "");
  CHECK(found.info.time_column == 3);
  CHECK(found.info.partial == std::vector<bool>{true, true, true, false, false});
}

TEST_CASE("a remark names columns with blanks in their names, and channels that take turns are refused",
          "[dsp][table_kinds]") {
  for (const char* header : {"% time [s]   Laser A [mm]\n", "# time [s] x [mm]\n"})
    check_decay(table(header, [](int i) { return fmt::format("{:.2f}  {:.3f}", i / rate_hz, value(i)); }));
  const auto turns = table("time_s,channel,value\n", [](int i) {
    return fmt::format("{:.2f},x,{:.3f}\n{:.2f},f,1.5", i / rate_hz, value(i), i / rate_hz);
  });
  check_fault([&] { (void)read(turns, 2); }, FaultKind::input, "table.turns",
              {"'channel'", "{v[$1, $2] = $3}", "a.csv.wide"});
}

TEST_CASE("a count of rows goes on where rows are lost", "[dsp][table_kinds]") {
  const auto found =
      read(table("count,time_s,x_mm\n", [](int i) { return fmt::format("{},{}", i + i / 50, plain(i + i / 50)); }), 2);
  CHECK(found.info.partial[0]);
}
