#include "apps/text/csv_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "dsp/io/input_file.hpp"
#include "dsp/values/for_each_index.hpp"

namespace apps {

void RowWriter::separate() {
  if (!at_begin_) rows_ += ',';
  at_begin_ = false;
}

void RowWriter::text(std::string_view cell) {
  separate();
  rows_ += cell;
}

void RowWriter::number(double value, int digits) {
  separate();
  std::array<char, 32> text{};
  char* const end = text.data() + text.size();
  const auto written = digits > 0 ? std::to_chars(text.data(), end, value, std::chars_format::general, digits)
                                  : std::to_chars(text.data(), end, value);
  rows_.append(text.data(), written.ptr);
}

void RowWriter::number_if_any(double value) {
  if (std::isfinite(value))
    number(value);
  else
    empty();
}

void RowWriter::empty() {
  separate();
}

void RowWriter::end_row() {
  rows_ += '\n';
  at_begin_ = true;
}

void write_table(const CsvTable& table, const Sink& sink, int num_threads,
                 const std::function<void(double)>& progress) {
  constexpr std::size_t rows_of_block = 4096;
  sink(table.header);
  std::vector<RowWriter> blocks(static_cast<std::size_t>(std::max(1, num_threads)));
  for (std::size_t first = 0; first < table.num_rows; first += rows_of_block * blocks.size()) {
    dsp::for_each_index(blocks.size(), num_threads, [&](std::size_t k) {
      blocks[k] = {};
      const std::size_t begin = first + k * rows_of_block, end = std::min(begin + rows_of_block, table.num_rows);
      for (std::size_t i = begin; i < end; ++i) table.fill(i, blocks[k]), blocks[k].end_row();
    });
    for (const RowWriter& block : blocks)
      if (!block.rows().empty()) sink(block.rows());
    if (progress) progress(static_cast<double>(first) / static_cast<double>(table.num_rows));
  }
}

std::string table_header(const std::filesystem::path& file) {
  constexpr std::size_t most_bytes = 1 << 20;
  const std::string begin = dsp::InputFile(file).text(0, most_bytes);
  return begin.substr(0, begin.find('\n'));
}

}  // namespace apps
