#include <cstdio>

#include "ident/fit.hpp"
#include "sim/simulate.hpp"
#include "sim/systems.hpp"

int main() {
  const auto run = sim::simulate(sim::make_experiment("duffing").system, Eigen::VectorXd::Zero(2),
                                 {.duration_s = 5.0, .sample_rate_hz = 100.0});
  const auto fit = ident::fit_ols(ident::r_factor(run.states.rightCols(1), run.derivatives.leftCols(1)));
  std::printf("dx/dt = %.6f v\n", fit.mean(0));
  return fit.mean(0) > 0.999999 && fit.mean(0) < 1.000001 ? 0 : 1;
}
