#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace apps {

/// Takes a file piece by piece.
using Sink = std::function<void(std::string_view)>;

/// How much of a table is written.
struct TableForm {
  bool compressed = false;   ///< gzip, the name then ends in .csv.gz
  double resolution = 0.0;   ///< 0: all digits; else numbers are rounded to this part of their column's largest
  std::size_t row_step = 1;  ///< every row, one in two, ...
  [[nodiscard]] std::string sentence() const;  ///< "all digits, one row in 4"
};
/// From all there is to ever less; each is smaller than the one before.
[[nodiscard]] std::vector<TableForm> table_forms();

/// Cells of one row after the other, as a table makes them and a form asks for them.
class RowWriter {
 public:
  explicit RowWriter(double resolution) : resolution_(resolution) {}
  void text(std::string_view cell);           ///< as it stands
  void number(double value, int digits = 0);  ///< to so many digits; 0: as few as give it back when read
  /// Never rounded: where the form keeps all digits to so many, else to as few as give it back when read.
  void time(double value, int digits = 0);
  void empty();
  /// The row so far, with its end; the next cell begins a new one.
  [[nodiscard]] std::string_view row() &;
  /// Of each column: what numbers are rounded to follows from it.
  void set_peaks(std::vector<double> peaks) { peaks_ = std::move(peaks); }
  [[nodiscard]] const std::vector<double>& peaks() const& { return peaks_; }
  void peaks() const&& = delete;
  void gather_peaks();  ///< of the rows that come; nothing is written

 private:
  void separate();
  std::string line_, finished_;
  std::vector<double> peaks_;
  std::size_t column_ = 0;
  double resolution_ = 0.0;
  bool gathering_ = false;
};

/// A table whose rows are made when they are asked for.
struct CsvTable {
  std::string name;    ///< "prepared.csv"
  std::string header;  ///< with its end of line
  std::size_t num_rows = 0;
  std::function<void(std::size_t, RowWriter&)> fill;  ///< the cells of one row; from any thread
};

/// Rows are made on up to num_threads threads, the caller's one of them; only that calls the sink.
void write_table(const CsvTable& table, const TableForm& form, const Sink& sink, int num_threads = 1);
/// Bytes that write_table would write, estimated from rows here and there.
[[nodiscard]] double estimated_bytes(const CsvTable& table, const TableForm& form);
/// "prepared.csv", or "prepared.csv.gz".
[[nodiscard]] std::string file_name(const CsvTable& table, const TableForm& form);

/// The first line of a table in a folder of results, which may be compressed. Throws dsp::Fault (input) as
/// dsp::InputFile for one that is not there in either form.
[[nodiscard]] std::string table_header(const std::filesystem::path& folder, const std::string& name);

}  // namespace apps
