#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace ident {

/// Terms in ascending order, with one that is not among them.
[[nodiscard]] inline std::vector<Eigen::Index> with(std::vector<Eigen::Index> terms, Eigen::Index term) {
  terms.insert(std::upper_bound(terms.begin(), terms.end(), term), term);
  return terms;
}

/// Without one, if it is among them.
[[nodiscard]] inline std::vector<Eigen::Index> without(std::vector<Eigen::Index> terms, Eigen::Index term) {
  std::erase(terms, term);
  return terms;
}

}  // namespace ident
