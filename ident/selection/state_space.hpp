#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/library/library.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/selection/nearest_distant_row.hpp"

namespace ident {

/// What an equation of some candidate terms is a function of, on some rows: two variables of state (x and v, or y and
/// dy, or what the terms use first), the inputs among the other signals, and the signs of the terms' switches.
class StateSpace {
 public:
  StateSpace(const std::vector<const Term*>& terms, const std::vector<Row>& rows,
             const std::vector<Columns>& recordings, const std::string& target);
  /// The terms are functions of more than x, v, y and dy.
  [[nodiscard]] bool has_inputs() const { return has_inputs_; }
  /// Smooth functions of the state that a library of polynomials lacks: monomials of the next two degrees, each sign
  /// and each input times low powers. Never candidates.
  [[nodiscard]] Eigen::Index num_probes() const;
  /// Of rows [first, first + block.rows()).
  void read_probes(Eigen::Index first, Eigen::Ref<Eigen::MatrixXd> block) const;
  /// Of evenly spread rows each with its nearest neighbour that is more than `min_separation` samples away or in
  /// another record; the nearer half of them. `samples`, `first_rows`: as of IndependentRows.
  [[nodiscard]] std::vector<RowPair> revisits(Eigen::Index min_separation, const std::vector<Eigen::Index>& samples,
                                              const std::vector<Eigen::Index>& first_rows) const;

 private:
  [[nodiscard]] Eigen::Index num_inputs() const { return values_.cols() - 2; }
  int degree_ = 3;  ///< of the library
  bool has_inputs_ = false;
  Eigen::MatrixXd values_;  ///< rows x (2 + inputs), each at most 1
  Eigen::MatrixXd signs_;   ///< rows x switches
};

}  // namespace ident
