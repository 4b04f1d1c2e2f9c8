/// Small files as people of this trade hand them in, of known truth, beside the project: each is read as it stands, or
/// refused with lines that work when they are pasted.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <optional>
#include <regex>

#include "support/program.hpp"

namespace {

using support::Scratch;

const std::filesystem::path reports = std::filesystem::path(ARDENT_REAL_DATA) / "reports";

struct Report {
  const char* file;
  double rate_hz, frequency_hz;  // what a run finds; 0: another test's matter
  const char* refusal = "";      // of the bare file, whose lines are pasted then
};

std::optional<double> number_behind(const std::string& text, const std::string& words) {
  std::smatch match;
  const std::regex pattern(words + " ([0-9.]+)");
  if (!std::regex_search(text, match, pattern)) return std::nullopt;
  return std::stod(match[1]);
}

/// With single blanks between words.
std::string unwrapped(const std::string& text) {
  return std::regex_replace(text, std::regex("\\s+"), " ");
}

/// What a refusal has printed to be pasted.
std::string lines_of(const std::string& err) {
  std::string lines;
  std::istringstream text(err);
  bool is_behind = false;
  for (std::string line; std::getline(text, line);) {
    const bool is_message = std::regex_search(line, std::regex("^(error|warning|note) "));
    if (is_behind && !is_message) lines += line + "\n";
    is_behind = is_behind || line.starts_with("error ");
  }
  return lines;
}

}  // namespace

TEST_CASE("files as people hand them in are read, or refused with lines that work", "[apps][report_files][real]") {
  if (!std::filesystem::exists(reports)) {
    WARN("skipped: " << reports << " is not there");
    return;
  }
  for (const Report& report : {Report{"accelerometer_epoch_ns.csv", 100, 0},
                               Report{"slash_units.csv", 200, 2.4},
                               Report{"comma_units.txt", 200, 2.4},
                               Report{"latest_time.csv", 200, 2.4},
                               Report{"millis.csv", 200, 2.4},
                               Report{"sparse_last_column.csv", 200, 2.4},
                               Report{"braces.csv", 200, 2.4},
                               Report{"text_column.csv", 200, 2.4},
                               Report{"preamble_tab.txt", 200, 2.4},
                               Report{"preamble_units.txt", 200, 2.4},
                               Report{"excel_sep.csv", 200, 2.4},
                               Report{"quoted_comma.csv", 200, 2.4},
                               Report{"month_names.csv", 200, 2.4},
                               Report{"trailing_summary.csv", 200, 2.4},
                               Report{"segments.lvm", 200, 2.4},
                               Report{"two_rates.lvm", 200, 2.4},
                               Report{"scalar_fs.mat", 200, 2.4},
                               Report{"matrix_with_time.mat", 200, 2.4, "motion.none"},
                               Report{"scope_increment.csv", 200, 2.4, "motion.none"},
                               Report{"rows_twice.csv", 100, 1.8},
                               Report{"accelerometer_xyz.csv", 100, 0, "motion.none"},
                               Report{"plane_xy.csv", 100, 0, "motion.none"},
                               Report{"runs_side_by_side.csv", 20, 0.83, "clock.run"},
                               Report{"phone_jitter.csv", 100, 1.8, "clock.jitter"}}) {
    INFO(report.file);
    const Scratch folder;
    std::filesystem::copy_file(reports / report.file, folder / report.file);
    auto ended = support::run(folder, fmt::format("$ARDENT -q run {} -o run", report.file));
    if (*report.refusal != 0) {
      CHECK(ended.code == 3);
      CHECK_THAT(ended.err, Catch::Contains(fmt::format("[{}]", report.refusal)));
      (void)folder.file(report.file + std::string(".toml"), lines_of(ended.err));
      ended = support::run(folder, fmt::format("$ARDENT -q run {} -o run", report.file));
    }
    INFO(ended.out + ended.err);
    CHECK(ended.code == 0);
    const std::string screen = unwrapped(ended.out);
    CHECK(number_behind(screen, "recorded at") == report.rate_hz);
    if (report.frequency_hz == 0) continue;
    const auto found_hz = number_behind(screen, "natural frequency(?: about it)?");
    REQUIRE(found_hz);
    CHECK(*found_hz == Approx(report.frequency_hz).epsilon(0.004));
  }
}

TEST_CASE("a rate that a file's clock contradicts is an error", "[apps][report_files][real]") {
  if (!std::filesystem::exists(reports)) return;
  const Scratch folder;
  std::filesystem::copy_file(reports / "slash_units.csv", folder / "slash_units.csv");
  (void)folder.file("slash_units.csv.toml", "rate = 100\n");
  const auto ended = support::run(folder, "$ARDENT -q run slash_units.csv -o run");
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Catch::Contains("[rate.mismatch]") && Catch::Contains("200 Hz"));
}

namespace {

/// What a run of a file says, with the sidecar and the settings that were pasted so far.
struct Said {
  int code = 0;
  std::string fault, err, screen;
};

Said said_by(const Scratch& folder, const std::string& file, const std::string& options = "") {
  std::filesystem::remove_all(folder / "run");
  const auto ended = support::run(folder, fmt::format("$ARDENT -q run {} -o run {}", file, options));
  std::smatch name;
  Said said{ended.code, "", ended.err, unwrapped(ended.out)};
  if (ended.code != 0 && std::regex_search(ended.err, name, std::regex("error \\[([a-z_.]+)\\]"))) said.fault = name[1];
  return said;
}

/// Keys for the whole file come before its channels.
void paste(const Scratch& folder, const std::string& file, const std::string& lines) {
  const std::string name = file + ".toml";
  const std::string before = std::filesystem::exists(folder / name) ? support::bytes_of(folder / name) : "";
  (void)folder.file(name, lines.find("[[") == std::string::npos ? lines + before : before + lines);
}

double percent_left_out(const std::string& screen) {
  return number_behind(std::regex_replace(screen, std::regex("([0-9.]+) % of the record is left out"), "left: $1"),
                       "left:")
      .value_or(0.0);
}

}  // namespace

TEST_CASE("every line that these files make the program propose leads on", "[apps][report_files][real]") {
  if (!std::filesystem::exists(reports)) return;
  int num_applied = 0;
  for (const auto& entry : std::filesystem::directory_iterator(reports)) {
    const std::string file = entry.path().filename().string();
    if (file == "README.md" || file == "SHA256SUMS") continue;
    INFO(file);
    const Scratch folder;
    std::filesystem::copy_file(entry.path(), folder / file);
    Said said = said_by(folder, file);
    // A refusal is followed by none or by another.
    for (int round = 0; round < 3 && said.code == 3 && !lines_of(said.err).empty(); ++round, ++num_applied) {
      const std::string fault = said.fault;
      paste(folder, file, lines_of(said.err));
      said = said_by(folder, file);
      CHECK(said.fault != fault);
    }
    INFO(said.err);
    CHECK((said.code == 0 || said.fault == "container.unsupported"));
    // A cut-off that is to leave less out does.
    std::smatch match;
    if (!std::regex_search(said.screen, match, std::regex("reach less far with (prepare.cutoff_hz) = ([0-9.e+]+)")))
      continue;
    ++num_applied;
    const Said after = said_by(folder, file, fmt::format("--set {}={}", match[1].str(), match[2].str()));
    CHECK(after.code == 0);
    CHECK(percent_left_out(after.screen) < percent_left_out(said.screen));
  }
  CHECK(num_applied > 10);
}

TEST_CASE("a size that no vibration has is asked for, with the line that mends it", "[apps][report_files]") {
  struct Table {
    const char *header, *fault, *channel;
    double time_s, offset, amplitude;  // what the numbers of a time of 1 s are, and of the motion
  };
  for (const Table& table : {Table{"time_s,x_m", "sample.size", "x", 1.0, 0.0, 19.0},
                             Table{"time_s,x_mm", "clock.slow", "", 1000.0, 0.0, 9.0},
                             Table{"t,theta", "sample.size", "theta", 1.0, 0.0, 20.0},
                             Table{"t,acc", "sample.gravity", "acc", 1.0, 256.0, 100.0},
                             Table{"t,acc", "sample.gravity", "acc", 1.0, 1.0, 0.3},
                             Table{"t,ax", "sample.gravity", "ax", 1.0, -1.0, 0.3}}) {
    INFO(table.header << " " << table.offset);
    std::string text = table.header + std::string("\n");
    for (int i = 0; i < 3000; ++i) {
      const double t = 0.01 * i;
      const double motion = std::exp(-0.05 * t) * std::cos(2.0 * 3.14159265358979 * 1.8 * t);
      text += fmt::format("{:.9g},{:.5f}\n", table.time_s * t, table.offset + table.amplitude * motion);
    }
    const Scratch folder;
    (void)folder.file("m.csv", text);
    const std::string before = said_by(folder, "m.csv").screen;
    CHECK_THAT(before, Catch::Contains(fmt::format("[{}]", table.fault)));
    std::smatch line;
    REQUIRE(std::regex_search(before, line, std::regex("[Ww]rite ([^\\[]*) (?:under its|into a) \\[\\[channel\\]\\]")));
    const std::string name = *table.channel != 0 ? fmt::format("name = \"{}\"\n", table.channel) : "";
    paste(folder, "m.csv", "[[channel]]\n" + name + std::regex_replace(line[1].str(), std::regex(", "), "\n") + "\n");
    const std::string after = said_by(folder, "m.csv").screen;
    CHECK_THAT(after, !Catch::Contains(fmt::format("[{}]", table.fault)));
    const auto found_hz = number_behind(after, "natural frequency");
    REQUIRE(found_hz);
    CHECK(*found_hz == Approx(1.8).epsilon(0.001));
  }
}
