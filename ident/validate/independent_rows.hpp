#pragma once
#include <Eigen/Core>
#include <vector>

namespace ident {

/// What fraction of as many white values a residual is worth: 1 / (1 + 2 sum over lags of (N(l) / n) r(l)^2), r its
/// autocorrelation and N(l) the number of pairs of rows l samples apart. Correlations within chance (r^2 N(l) up to
/// 2 ln n) count as none. `samples`: each row's sample in its record, ascending; what lies between rows is no evidence.
[[nodiscard]] double independent_fraction(const Eigen::Ref<const Eigen::VectorXd>& residual,
                                          const std::vector<Eigen::Index>& samples);

}  // namespace ident
