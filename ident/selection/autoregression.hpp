#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/regression/r_factor.hpp"

// Noise that is an autoregression of order one: e_t = rho e_(t-1) + white. Rows e_t - rho e_(t-1) make of it an
// ordinary regression, and lose nothing: generalised least squares. Of order one only, which is what drifts and
// couplings leave: a higher order also follows oscillations, and those may be misfit.

namespace ident {

/// 1 for each row that does not follow the one before it at the next sample of the same record. `samples`,
/// `first_rows`: as of IndependentRows.
[[nodiscard]] std::vector<unsigned char> run_begins(const std::vector<Eigen::Index>& samples,
                                                    const std::vector<Eigen::Index>& first_rows);

/// The rows that `read` gives, whitened: the first of a run times sqrt(1 - rho^2), the others less rho times the one
/// before. `begins` must outlive it.
[[nodiscard]] RowReader whitened(RowReader read, const std::vector<unsigned char>& begins, double rho);
[[nodiscard]] Eigen::VectorXd whitened_values(const Eigen::Ref<const Eigen::VectorXd>& values,
                                              const std::vector<unsigned char>& begins, double rho);

/// The rho of the residual of least squares on all terms, by restricted maximum likelihood: that of the residual itself
/// is too small by what the terms take. One pass over the rows, which are as of r_factor with one target. `first_rows`:
/// of each record, in which the terms have coefficients of their own.
[[nodiscard]] double autoregression(Eigen::Index num_rows, Eigen::Index num_terms, const Eigen::RowVectorXd& largest,
                                    const RowReader& read, const std::vector<unsigned char>& begins, int num_threads,
                                    std::vector<Eigen::Index> first_rows = {0});

}  // namespace ident
