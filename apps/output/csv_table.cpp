#include "apps/output/csv_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

#include "apps/output/gzip.hpp"
#include "dsp/for_each_index.hpp"
#include "dsp/io/input_file.hpp"

namespace apps {
namespace {

constexpr std::size_t header_bytes = 1 << 20;

void append_number(std::string& line, double value, int digits) {
  std::array<char, 32> text{};
  char* const end = text.data() + text.size();
  const auto written = digits > 0 ? std::to_chars(text.data(), end, value, std::chars_format::general, digits)
                                  : std::to_chars(text.data(), end, value);
  line.append(text.data(), written.ptr);
}

/// Significant digits that give `value` to the decimal place of `step`; none where it is less than half of that.
int digits_to(double value, double step) {
  if (std::abs(value) < 0.5 * step) return 0;
  return std::max(1, static_cast<int>(std::floor(std::log10(std::abs(value))) - std::floor(std::log10(step))) + 1);
}

/// What the columns are rounded to follows from these; none where the form keeps all digits.
template <class Wanted>
std::vector<double> peaks_of(const CsvTable& table, const TableForm& form, const Wanted& wanted) {
  if (!(form.resolution > 0.0)) return {};
  RowWriter rows(form.resolution);
  rows.gather_peaks();
  for (std::size_t i = 0; i < table.num_rows; i += form.row_step)
    if (wanted(i)) table.fill(i, rows), (void)rows.row();
  return rows.peaks();
}

/// Rows of a form, block by block.
template <class Wanted>
void each_row(const CsvTable& table, const TableForm& form, const Wanted& wanted, const Sink& sink, int num_threads) {
  constexpr std::size_t rows_of_block = 4096;
  const std::vector<double> peaks = peaks_of(table, form, wanted);
  const std::size_t block = rows_of_block * form.row_step;
  std::vector<std::string> texts(static_cast<std::size_t>(std::max(1, num_threads)));
  for (std::size_t first = 0; first < table.num_rows; first += block * texts.size()) {
    dsp::for_each_index(texts.size(), num_threads, [&](std::size_t k) {
      texts[k].clear();
      RowWriter rows(form.resolution);
      rows.set_peaks(peaks);
      const std::size_t begin = first + k * block, end = std::min(begin + block, table.num_rows);
      for (std::size_t i = begin; i < end; i += form.row_step)
        if (wanted(i)) table.fill(i, rows), texts[k] += rows.row();
    });
    for (const std::string& text : texts)
      if (!text.empty()) sink(text);
  }
}

template <class Wanted>
void write_rows(const CsvTable& table, const TableForm& form, const Wanted& wanted, const Sink& sink, int num_threads) {
  if (!form.compressed) {
    sink(table.header);
    return each_row(table, form, wanted, sink, num_threads);
  }
  GzipWriter gzip(sink);
  gzip.write(table.header);
  each_row(
      table, form, wanted, [&](std::string_view rows) { gzip.write(rows); }, num_threads);
  gzip.finish();
}

}  // namespace

std::string TableForm::sentence() const {
  std::string text =
      resolution > 0.0 ? fmt::format("rounded to {:g} of each column's largest value", resolution) : "all digits";
  return text + (row_step > 1 ? fmt::format(", one row in {}", row_step) : ", every row");
}

std::vector<TableForm> table_forms() {
  constexpr double fine = 1e-6, medium = 1e-5, coarse = 1e-4;
  constexpr std::size_t most_step = std::size_t{1} << 20;
  std::vector<TableForm> forms{{false}, {true}, {true, fine}, {true, medium}, {true, coarse}};
  for (std::size_t step = 2; step <= most_step; step += std::max<std::size_t>(1, step / 3))
    forms.push_back({true, coarse, step});
  return forms;
}

void RowWriter::separate() {
  if (column_ > 0) line_ += ',';
  ++column_;
}

void RowWriter::text(std::string_view cell) {
  separate();
  line_ += cell;
}

void RowWriter::time(double value, int digits) {
  separate();
  append_number(line_, value, resolution_ > 0.0 ? 0 : digits);
}

void RowWriter::number(double value, int digits) {
  separate();
  const std::size_t column = column_ - 1;
  if (gathering_) {
    if (peaks_.size() <= column) peaks_.resize(column + 1, 0.0);
    if (std::isfinite(value)) peaks_[column] = std::max(peaks_[column], std::abs(value));
    return;
  }
  if (resolution_ == 0.0 || !std::isfinite(value)) return append_number(line_, value, digits);
  const int kept = digits_to(value, resolution_ * (column < peaks_.size() ? peaks_[column] : 0.0));
  if (kept == 0)
    line_ += '0';
  else
    append_number(line_, value, std::min(kept, 17));
}

void RowWriter::empty() {
  separate();
}

std::string_view RowWriter::row() & {
  line_ += '\n';
  column_ = 0;
  finished_.swap(line_);
  line_.clear();
  return finished_;
}

void RowWriter::gather_peaks() {
  gathering_ = true;
}

void write_table(const CsvTable& table, const TableForm& form, const Sink& sink, int num_threads) {
  write_rows(
      table, form, [](std::size_t) { return true; }, sink, num_threads);
}

double estimated_bytes(const CsvTable& table, const TableForm& form) {
  constexpr std::size_t num_blocks = 32, block_rows = 256;
  const std::size_t spacing = std::max(block_rows, table.num_rows / num_blocks / form.row_step) * form.row_step;
  std::size_t rows = 0, bytes = 0;
  write_rows(
      table, form, [&](std::size_t i) { return i % spacing < block_rows * form.row_step; },
      [&](std::string_view piece) { bytes += piece.size(); }, 1);
  for (std::size_t i = 0; i < table.num_rows; i += form.row_step)
    rows += i % spacing < block_rows * form.row_step ? 1 : 0;
  const std::size_t all = (table.num_rows + form.row_step - 1) / form.row_step;
  return rows == 0 ? static_cast<double>(bytes)
                   : static_cast<double>(bytes) * static_cast<double>(all) / static_cast<double>(rows);
}

std::string file_name(const CsvTable& table, const TableForm& form) {
  return table.name + (form.compressed ? ".gz" : "");
}

std::string table_header(const std::filesystem::path& folder, const std::string& name) {
  std::error_code unknown;
  const std::filesystem::path plain = folder / name, compressed = folder / (name + ".gz");
  const bool is_compressed = !std::filesystem::exists(plain, unknown) && std::filesystem::exists(compressed, unknown);
  const std::string begin = dsp::InputFile(is_compressed ? compressed : plain).text(0, header_bytes);
  const std::string text = is_compressed ? gunzip_begin(begin, header_bytes) : begin;
  return text.substr(0, text.find('\n'));
}

}  // namespace apps
