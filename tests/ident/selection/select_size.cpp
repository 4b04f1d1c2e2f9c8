#include "ident/selection/select_size.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using Eigen::Index;

namespace {

constexpr Index num_rows = 200;

/// Three orthonormal candidates: the first explains nearly all of the target, the second is worth this gain beside it,
/// the third nothing.
ident::RecordProblems problem(double gain) {
  ident::RFactor data{Eigen::MatrixXd::Identity(4, 4), 3, num_rows};
  const double of_second = std::sqrt(std::expm1(gain / (num_rows - 2)));
  data.R.col(3) << 100.0, of_second, 0.0, 1.0;
  return ident::unit_problem(data);
}

std::vector<Index> settled_terms(double gain, double structural_fraction, double complexity_of_second = 0.0) {
  ident::EffectiveSize size;
  size.num_rows = size.num_uncorrelated = size.num_states = num_rows;
  size.structural_fraction = structural_fraction;
  const ident::RecordProblems candidates = problem(gain);
  ident::Settled settled = ident::select_size(candidates, [&](const ident::Subset&) { return size; });
  ident::prefer_simpler(settled, candidates, Eigen::Vector3d(1.0, complexity_of_second, 0.0));
  return settled.model.terms;
}

}  // namespace

TEST_CASE("a term is worth more than its cost, and that is higher beside noise than beside misfit",
          "[ident][selection][select_size]") {
  // Beside misfit ln n + 2 ln(3 over 2) - 2 ln(3 over 1) = ln n, beside noise ln n + 2 ln 3.
  const double log_n = std::log(static_cast<double>(num_rows));
  CHECK(settled_terms(log_n - 0.1, 1.0) == std::vector<Index>{0});
  CHECK(settled_terms(log_n + 0.1, 1.0) == std::vector<Index>{0, 1});
  const double of_choice = 2.0 * std::log(3.0);
  CHECK(settled_terms(log_n + of_choice - 0.1, 0.0) == std::vector<Index>{0});
  CHECK(settled_terms(log_n + of_choice + 0.1, 0.0) == std::vector<Index>{0, 1});
}

TEST_CASE("a term is not exchanged for a simpler one that does nothing, but left out",
          "[ident][selection][select_size]") {
  // Worth its cost, yet within the limit up to which two models are called one.
  const double gain = std::log(static_cast<double>(num_rows)) + 1.0;
  CHECK(settled_terms(gain, 1.0, 3.0) == std::vector<Index>{0});
  CHECK(settled_terms(gain, 1.0, 0.0) == std::vector<Index>{0, 1});  // nothing is simpler
}

TEST_CASE("a model that leaves no more than its filters leave is complete", "[ident][selection][select_size]") {
  // The second candidate is beyond doubt; the first alone leaves 1.2e-4 of the target.
  ident::EffectiveSize size;
  size.num_rows = size.num_uncorrelated = size.num_states = num_rows;
  const ident::RecordProblems candidates = problem(50.0);
  const auto terms_where_complete = [&](double power) {
    return ident::select_size(
               candidates, [&](const ident::Subset&) { return size; }, power)
        .model.terms;
  };
  CHECK(terms_where_complete(1e-4) == std::vector<Index>{0, 1});
  CHECK(terms_where_complete(2e-4) == std::vector<Index>{0});
}
