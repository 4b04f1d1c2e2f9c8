#pragma once
#include <vector>

#include "ident/bodies/bodies.hpp"
#include "ident/state_space/problem.hpp"

namespace ident {

inline constexpr Eigen::Index least_samples = 32;  ///< of a piece: less says nothing but where it begins

/// A signal's derivative of this order, of what it has below a frequency.
[[nodiscard]] Eigen::VectorXd derived(const Eigen::VectorXd& signal, double rate_hz, int order, double to_hz);

/// The likelihood of samples of a record of bodies, stated.
struct BodiesStatement {
  state_space::Problem problem;
  double thinned_by = 1.0;       ///< recorded samples a sample
  Eigen::Index last_sample = 0;  ///< of the record, that of the last sample of the last piece
};

/// Of the usable samples among these. `thinned_by`: as often as another statement of the same samples; 0: as may be.
[[nodiscard]] BodiesStatement statement_of(const BodiesRecord& record, const BodiesLayout& layout,
                                           const std::vector<BodyTerm>& terms, const std::vector<double>& known,
                                           dsp::IndexRange over, Eigen::Index thinned_by);

}  // namespace ident
