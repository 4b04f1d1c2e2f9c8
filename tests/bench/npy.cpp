#include "bench/npy.hpp"

#include <cstdio>
#include <stdexcept>
#include <string>

namespace bench {

NpyTable::NpyTable(const std::filesystem::path& file) : in_(file, std::ios::binary) {
  std::string start(10, '\0');
  in_.read(start.data(), 10);
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(start[i]); };
  std::string header(static_cast<std::size_t>(byte(8) + 256 * byte(9)), '\0');
  in_.read(header.data(), static_cast<std::streamsize>(header.size()));
  begin_ = 10 + static_cast<std::streamoff>(header.size());
  const auto shape = header.find("'shape': (");
  long rows = 0, cols = 0;
  const bool is_table = in_ && start.starts_with("\x93NUMPY") && header.find("'<f8'") != std::string::npos &&
                        header.find("'fortran_order': False") != std::string::npos && shape != std::string::npos &&
                        std::sscanf(header.c_str() + shape, "'shape': (%ld, %ld)", &rows, &cols) == 2;
  if (!is_table) throw std::runtime_error(file.string() + ": not a table of doubles, row by row, in numpy's format");
  rows_ = rows;
  cols_ = cols;
}

Eigen::MatrixXd NpyTable::read(Eigen::Index first, Eigen::Index count) {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows(count, cols_);
  in_.clear();
  in_.seekg(begin_ + static_cast<std::streamoff>(8 * first * cols_));
  in_.read(reinterpret_cast<char*>(rows.data()), static_cast<std::streamsize>(8 * rows.size()));
  if (!in_) throw std::runtime_error("a table ends before its last row");
  return rows;
}

}  // namespace bench
