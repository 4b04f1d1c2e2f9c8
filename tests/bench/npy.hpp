#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <fstream>

namespace bench {

/// A table of doubles, row by row, as numpy.save writes it, read block by block. Throws std::runtime_error for another.
class NpyTable {
 public:
  explicit NpyTable(const std::filesystem::path& file);
  [[nodiscard]] Eigen::Index rows() const { return rows_; }
  [[nodiscard]] Eigen::Index cols() const { return cols_; }
  /// Rows [first, first + count).
  [[nodiscard]] Eigen::MatrixXd read(Eigen::Index first, Eigen::Index count);
  [[nodiscard]] Eigen::MatrixXd read() { return read(0, rows_); }

 private:
  std::ifstream in_;
  std::streamoff begin_ = 0;
  Eigen::Index rows_ = 0, cols_ = 0;
};

}  // namespace bench
