#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "ident/regression/fit.hpp"
#include "sim/simulate.hpp"
#include "sim/systems.hpp"
#include "support/quad_rvm.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// A polynomial library in (x + offset, v) with the force, on Duffing states: the offset makes its columns collinear.
struct OffsetLibrary {
  MatrixXd phi;
  VectorXd target;
};

OffsetLibrary offset_library(int degree, double offset_std) {
  std::vector<VectorXd> x, v, f, a;
  for (const double ratio : {0.7, 1.0, 1.3}) {
    const auto experiment = sim::make_experiment("duffing", {{"ratio", ratio}});
    const auto run = sim::simulate(experiment.system, experiment.initial, {.duration_s = 25.0, .sample_rate_hz = 20.0});
    x.push_back(run.states.col(0));
    v.push_back(run.states.col(1));
    a.push_back(run.derivatives.col(1));
    f.push_back(run.time_s.unaryExpr(experiment.system.forcing));
  }
  const auto joined = [](const std::vector<VectorXd>& parts) {
    VectorXd whole(3 * parts.front().size());
    whole << parts[0], parts[1], parts[2];
    return whole;
  };
  VectorXd shifted = joined(x);
  shifted.array() += offset_std * std::sqrt((shifted.array() - shifted.mean()).square().mean());
  const VectorXd speed = joined(v);
  OffsetLibrary library{MatrixXd(shifted.size(), (degree + 1) * (degree + 2) / 2 + 1), joined(a)};
  Index column = 0;
  for (int total = 0; total <= degree; ++total)
    for (int power = total; power >= 0; --power)
      library.phi.col(column++) = (shifted.array().pow(power) * speed.array().pow(total - power)).matrix();
  library.phi.col(column) = joined(f);
  return library;
}

double std_of(const VectorXd& values) {
  return std::sqrt((values.array() - values.mean()).square().mean());
}

}  // namespace

TEST_CASE("offset libraries give the support and means of 113-bit arithmetic", "[ident][fast_rvm][slow]") {
  for (const int degree : {3, 5, 7})
    for (const double offset : {0.0, 3.0, 10.0, 30.0, 100.0}) {
      const OffsetLibrary library = offset_library(degree, offset);
      support::QuadColumns columns;
      for (Index j = 0; j < library.phi.cols(); ++j)
        columns.emplace_back(library.phi.col(j).begin(), library.phi.col(j).end());
      support::QuadRvm reference(columns);
      for (int draw = 0; draw < 15; ++draw) {
        const double noise = std::array{1e-1, 1e-3, 1e-6}[static_cast<std::size_t>(draw) % 3];
        const auto seed = static_cast<unsigned>(900 + degree + 100 * (draw / 3));
        const VectorXd target =
            library.target + noise * std_of(library.target) * support::gaussian(library.target.size(), 1, seed);
        const auto fit = ident::fit_fast_rvm(ident::r_factor(library.phi, target));
        const auto expected = reference.fit(target, fit.tau, fit.relevant);
        INFO("degree " << degree << ", offset " << offset << " standard deviations, noise " << noise << ", seed "
                       << seed);
        CHECK(fit.status == ident::FitStatus::converged);
        CHECK(fit.relevant == expected.relevant);
        if (fit.relevant != expected.relevant) continue;
        double worst = 0.0;
        for (std::size_t j = 0; j < expected.mean.size(); ++j)
          worst = std::max(worst, std::abs(fit.mean(static_cast<Index>(j)) - expected.mean[j]) / expected.std[j]);
        CHECK(worst <= 0.01);
      }
    }
}
