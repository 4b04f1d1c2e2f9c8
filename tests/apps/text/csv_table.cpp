#include "apps/text/csv_table.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

using apps::CsvTable;
using apps::RowWriter;

namespace {

/// A time, and a signal that is missing in one row of three.
CsvTable waves(std::size_t num_rows) {
  return {"waves.csv", "t,a\n", num_rows, [](std::size_t i, RowWriter& cells) {
            cells.number(static_cast<double>(i) / 1000.0, 17);
            cells.number_if_any(i % 3 == 0 ? std::nan("") : std::sin(0.04 * static_cast<double>(i)));
          }};
}

std::string text_of(const CsvTable& table, int num_threads) {
  std::string text;
  apps::write_table(
      table, [&](std::string_view piece) { text += piece; }, num_threads);
  return text;
}

}  // namespace

TEST_CASE("a table has every row in order, with all digits, on any number of threads", "[apps][csv_table]") {
  constexpr std::size_t num_rows = 20'001;  // no whole number of blocks
  const std::string text = text_of(waves(num_rows), 1);
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  CHECK(line == "t,a");
  std::size_t i = 0;
  for (; std::getline(lines, line); ++i) {
    double t = 0.0, a = 0.0;
    const int read = std::sscanf(line.c_str(), "%lf,%lf", &t, &a);
    REQUIRE(t == static_cast<double>(i) / 1000.0);
    REQUIRE(read == (i % 3 == 0 ? 1 : 2));
    if (read == 2) REQUIRE(a == std::sin(0.04 * static_cast<double>(i)));
  }
  CHECK(i == num_rows);
  CHECK(text_of(waves(num_rows), 3) == text);
  CHECK(text_of(waves(0), 2) == "t,a\n");
}
