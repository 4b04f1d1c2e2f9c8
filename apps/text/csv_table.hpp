#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace apps {

/// Takes a file piece by piece.
using Sink = std::function<void(std::string_view)>;

/// Rows of a table behind one another, cell by cell.
class RowWriter {
 public:
  void text(std::string_view cell);           ///< as it stands
  void number(double value, int digits = 0);  ///< to so many digits; 0: as few as give it back when read
  void number_if_any(double value);           ///< the same; an empty cell where it is not finite
  void empty();                               ///< an empty cell
  void end_row();                             ///< the next cell begins a new row
  [[nodiscard]] const std::string& rows() const& { return rows_; }
  void rows() const&& = delete;

 private:
  void separate();
  std::string rows_;
  bool at_begin_ = true;
};

/// A table whose rows are made when they are asked for.
struct CsvTable {
  std::string name;    ///< "prepared.csv"
  std::string header;  ///< with its end of line
  std::size_t num_rows = 0;
  std::function<void(std::size_t, RowWriter&)> fill;  ///< the cells of one row; from any thread
};

/// Rows are made on up to num_threads threads, the caller's one of them; only that calls the sink and, where there is
/// one, `progress` with the fraction that is done.
void write_table(const CsvTable& table, const Sink& sink, int num_threads = 1,
                 const std::function<void(double)>& progress = {});

/// The first line of a table in a folder of results. Throws dsp::Fault (input) as dsp::InputFile.
[[nodiscard]] std::string table_header(const std::filesystem::path& file);

}  // namespace apps
