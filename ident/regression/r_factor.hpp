#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "ident/regression/fold_rows.hpp"

namespace ident {

/// All a linear regression T = Phi C + noise needs to know of its m rows: the triangle of [Phi T] = Q R, for which
/// R'R = [Phi'Phi Phi'T; T'Phi T'T], in the units of the columns. It is what the methods of ident/regression/fit.hpp
/// take. Its size does not grow with the recording, and records add up by `merge`; Phi'Phi, whose condition number is
/// the square of Phi's, is never formed.
struct RFactor {
  Eigen::MatrixXd R;             ///< (b+q) x (b+q), upper triangular; the last q columns are the targets
  Eigen::Index num_terms = 0;    ///< b
  Eigen::Index num_samples = 0;  ///< m
  Eigen::VectorXd degree{};      ///< b: degrees of the terms, as ident/library/library.hpp has them; empty: not known
  [[nodiscard]] Eigen::Index num_targets() const { return R.cols() - num_terms; }
};

/// 0, 1, ..., count - 1: all columns.
[[nodiscard]] std::vector<Eigen::Index> all_columns(Eigen::Index count);

/// The triangle R (n x n) of a QR factorisation of these rows (any number x n, of any magnitude); not a
/// number where one of theirs is not finite.
[[nodiscard]] Eigen::MatrixXd triangle(const Eigen::Ref<const Eigen::MatrixXd>& rows);

/// Folds rows into an R factor in constant memory, 256 at a time. The result depends on the rows and their order only,
/// bit for bit: not on how they were cut into blocks. It may depend on the processor, in its last bits.
class RFactorBuilder {
 public:
  /// b >= 0 terms and q >= 1 targets; else throws std::invalid_argument.
  RFactorBuilder(Eigen::Index num_terms, Eigen::Index num_targets);
  /// Any number of rows x (b+q): the terms' columns, then the targets'. Throws std::invalid_argument for another width.
  /// Values must be finite, and their squares must not overflow: r_factor sees to both.
  void push(const Eigen::Ref<const Eigen::MatrixXd>& rows);
  /// Of the rows so far; more may follow.
  [[nodiscard]] RFactor finish() const;

 private:
  Eigen::Index num_terms_, num_targets_, num_samples_ = 0, filled_ = 0;
  RowBlock block_;
  Eigen::MatrixXd R_;
};

/// One-shot: phi is m x b, targets m x q, of any magnitude. Throws std::invalid_argument if they differ in their rows,
/// if there is no target, or if a value is not finite.
[[nodiscard]] RFactor r_factor(const Eigen::Ref<const Eigen::MatrixXd>& phi,
                               const Eigen::Ref<const Eigen::MatrixXd>& targets);
/// The same bits, with shards of a fixed number of rows shared out among threads and merged in their order.
[[nodiscard]] RFactor r_factor(const Eigen::Ref<const Eigen::MatrixXd>& phi,
                               const Eigen::Ref<const Eigen::MatrixXd>& targets, int num_threads);
/// The same bits again from rows that are read block by block, once, and never held together: `read` writes rows
/// [first, first + block.rows()) of [Phi T] into `block`, whose columns are the terms and then the targets; with more
/// than one thread it is called from several at once. `largest` is the greatest magnitude in each of these columns.
/// Throws std::invalid_argument if it has another width or a value is not finite.
using RowReader = std::function<void(Eigen::Index first, Eigen::Ref<Eigen::MatrixXd> block)>;
[[nodiscard]] RFactor r_factor(Eigen::Index num_rows, Eigen::Index num_terms, const Eigen::RowVectorXd& largest,
                               const RowReader& read, int num_threads = 1);
/// As if the rows of `b` were stacked below those of `a`, whose degrees are kept. Throws std::invalid_argument if the
/// shapes differ.
[[nodiscard]] RFactor merge(const RFactor& a, const RFactor& b);
/// The same rows with only these terms (in this order) and one target. Throws std::invalid_argument for an index that
/// is not there.
[[nodiscard]] RFactor select(const RFactor& data, const std::vector<Eigen::Index>& terms, Eigen::Index target);

}  // namespace ident
