#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/ranges/ranges.hpp"

namespace ident {

/// The rows of a range in these terms, read from the recordings' columns as they are needed. Both must outlive it.
class RowsOfTerms {
 public:
  RowsOfTerms(const std::vector<Row>& rows, const std::vector<Columns>& recordings,
              const std::vector<Eigen::Index>& terms)
      : rows_(rows), recordings_(recordings) {
    for (const Eigen::Index term : terms) {
      const std::vector<TermColumn>& known = recordings.front().term_columns;
      terms_.push_back(known.empty() ? TermColumn{term} : known[static_cast<std::size_t>(term)]);
    }
  }
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(rows_.size()); }
  [[nodiscard]] Eigen::Index num_terms() const { return static_cast<Eigen::Index>(terms_.size()); }
  /// Rows [first, first + block.rows()).
  void read(Eigen::Index first, Eigen::Ref<Eigen::MatrixXd> block) const {
    for (Eigen::Index i = 0; i < block.rows();) {
      const Row& row = rows_[static_cast<std::size_t>(first + i)];
      const Eigen::Index count = end_of_stretch(rows_, first + i, first + block.rows()) - first - i;
      for (Eigen::Index j = 0; j < block.cols(); ++j) {
        const TermColumn term = terms_[static_cast<std::size_t>(j)];
        auto values = block.col(j).segment(i, count);
        if (term.recording > 0 && static_cast<std::size_t>(term.recording) != row.recording + 1)
          values.setZero();
        else
          values = recordings_[row.recording].phi.col(term.column).segment(row.sample, count);
      }
      i += count;
    }
  }
  /// Calls visit(first row, block) for all rows in order.
  template <class Visit>
  void for_each_block(Visit&& visit) const {
    for (Eigen::Index first = 0; first < size(); first += block_rows) {
      Eigen::MatrixXd block(std::min(block_rows, size() - first), num_terms());
      read(first, block);
      visit(first, block);
    }
  }

 private:
  static constexpr Eigen::Index block_rows = 1024;
  const std::vector<Row>& rows_;
  const std::vector<Columns>& recordings_;
  std::vector<TermColumn> terms_;
};

}  // namespace ident
