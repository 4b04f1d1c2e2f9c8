#include "apps/output/csv_table.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "apps/output/gzip.hpp"
#include "support/scratch.hpp"

using apps::CsvTable;
using apps::RowWriter;
using apps::TableForm;

namespace {

/// A time, a large and a small signal with digits to the last.
CsvTable waves(std::size_t num_rows) {
  return {"waves.csv", "t,a,b\n", num_rows, [](std::size_t i, RowWriter& cells) {
            const double t = static_cast<double>(i) / 1000.0;
            cells.time(t, 17);
            cells.number(100.0 * std::sin(40.0 * t) + std::cos(1e4 * t * t), 17);
            cells.number(1e-6 * std::cos(7.0 * t), 17);
          }};
}

std::string text_of(const CsvTable& table, const TableForm& form) {
  std::string text;
  apps::write_table(table, form, [&](std::string_view piece) { text += piece; });
  return form.compressed ? apps::gunzip_begin(text, std::size_t{1} << 24) : text;
}

std::vector<std::array<double, 3>> rows_of(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  CHECK(line == "t,a,b");
  std::vector<std::array<double, 3>> rows;
  while (std::getline(lines, line)) {
    auto& row = rows.emplace_back();
    REQUIRE(std::sscanf(line.c_str(), "%lf,%lf,%lf", &row[0], &row[1], &row[2]) == 3);
  }
  return rows;
}

}  // namespace

TEST_CASE("a compressed table holds the same bytes, a rounded one the same numbers to its resolution",
          "[apps][csv_table]") {
  const CsvTable table = waves(3000);
  const std::string plain = text_of(table, {});
  CHECK(text_of(table, {.compressed = true}) == plain);
  const auto exact = rows_of(plain);
  REQUIRE(exact.size() == 3000);
  for (const double resolution : {1e-6, 1e-4}) {
    const auto rounded = rows_of(text_of(table, {.compressed = true, .resolution = resolution}));
    REQUIRE(rounded.size() == exact.size());
    for (std::size_t i = 0; i < exact.size(); ++i) {
      CHECK(rounded[i][0] == exact[i][0]);  // times stay
      CHECK(std::abs(rounded[i][1] - exact[i][1]) <= 0.5001 * resolution * 101.0);
      CHECK(std::abs(rounded[i][2] - exact[i][2]) <= 0.5001 * resolution * 1e-6);
    }
  }
  const auto sparse = rows_of(text_of(table, {.compressed = true, .resolution = 1e-4, .row_step = 4}));
  REQUIRE(sparse.size() == 750);
  CHECK(sparse[1][0] == exact[4][0]);
}

TEST_CASE("each form of a table is smaller than the one before, and its size is known beforehand",
          "[apps][csv_table]") {
  const CsvTable table = waves(100000);
  double before = 1e300;
  const auto forms = apps::table_forms();
  for (std::size_t i = 0; i < 6; ++i) {
    double bytes = 0.0;
    apps::write_table(table, forms[i], [&](std::string_view piece) { bytes += static_cast<double>(piece.size()); });
    CAPTURE(forms[i].sentence(), bytes, before);
    CHECK(bytes < before);
    CHECK(apps::estimated_bytes(table, forms[i]) == Approx(bytes).epsilon(0.03));
    before = bytes;
  }
  CHECK(forms.back().row_step > 100000);
}

TEST_CASE("the header of a table is found whether it is compressed or not", "[apps][csv_table]") {
  const support::Scratch folder;
  std::string bytes;
  apps::write_table(waves(2000), {.compressed = true}, [&](std::string_view piece) { bytes += piece; });
  (void)folder.file("waves.csv.gz", bytes);
  CHECK(apps::table_header(folder / "", "waves.csv") == "t,a,b");
  (void)folder.file("waves.csv", "t,x\n1,2\n");
  CHECK(apps::table_header(folder / "", "waves.csv") == "t,x");
}
