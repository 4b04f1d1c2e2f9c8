#pragma once
#include <vector>

#include "ident/bodies/bodies.hpp"
#include "ident/state_space/problem.hpp"

namespace ident {

inline constexpr Eigen::Index least_samples = 32;  ///< of a piece: less says nothing but where it begins

/// A signal's derivative of this order, of what it has below a frequency.
[[nodiscard]] Eigen::VectorXd derived(const Eigen::VectorXd& signal, double rate_hz, int order, double to_hz);

/// The rate of one state of the equations at each sample, of states (samples x states) and inputs there.
[[nodiscard]] Eigen::VectorXd rates_along(const BodiesModel& model, int state, const Eigen::MatrixXd& states,
                                          const Eigen::MatrixXd& inputs, double sample_rate_hz, double begin_s);

/// The likelihood of samples of a record of bodies, stated.
struct BodiesStatement {
  state_space::Problem problem;
  double thinned_by = 1.0;  ///< recorded samples a sample
  /// Of each record of the problem: in which range it lies, and the sample of the record that its last one is.
  struct Origin {
    std::size_t range;
    Eigen::Index last_sample;
  };
  std::vector<Origin> origins = {};
};

/// Of the usable samples in these ranges, each of one part. `thinned_by`: as often as another statement of the same
/// samples; 0: as may be.
[[nodiscard]] BodiesStatement statement_of(const BodiesRecord& record, const BodiesLayout& layout,
                                           const std::vector<BodyTerm>& terms, const std::vector<double>& known,
                                           const std::vector<dsp::IndexRange>& over, Eigen::Index thinned_by);

}  // namespace ident
