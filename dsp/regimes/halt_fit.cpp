#include "dsp/regimes/halt_fit.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/values/linear.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Basis = Eigen::Matrix<double, Eigen::Dynamic, 4>;

// The reversal lies within a wave of the low-pass and a halt lasts for up to one: both are searched in such steps.
constexpr std::ptrdiff_t steps_per_wave = 16, num_reversals = 2 * steps_per_wave + 1,
                         num_halt_lengths = steps_per_wave + 1;

// Columns: 1, t, t^2 but for the halt, and 1 from its end on. Times in samples from the reversal.
Basis course(const ShortLowPass& low_pass, Index reach, double wave, double reversal, double halt) {
  Basis columns(2 * reach + 1, 4);
  for (Index i = 0; i < columns.rows(); ++i) {
    const double t = static_cast<double>(i - reach) - reversal;
    const auto until = [&](int power) { return low_pass.passed(power, t) - low_pass.switched_on(power, t); };
    const auto from = [&](int power) { return low_pass.switched_on(power, t - halt); };
    columns(i, 0) = until(0) + from(0);
    columns(i, 1) = (until(1) + from(1) + halt * from(0)) / wave;
    columns(i, 2) = (until(2) + from(2) + 2.0 * halt * from(1) + halt * halt * from(0)) / (wave * wave);
    columns(i, 3) = from(0);
  }
  return columns;
}

// Without memory from the heap, for which the threads would wait for one another.
double misfit(const Basis& basis, const VectorXd& a, double power) {
  Eigen::Vector4d in_basis;
  in_basis.noalias() = basis.transpose() * a;
  return power - in_basis.squaredNorm();
}

}  // namespace

HaltFit::HaltFit(const ShortLowPass& low_pass, double cutoff_cycles_per_sample)
    : wave_(1.0 / cutoff_cycles_per_sample), reach_(static_cast<Index>(std::ceil(2.0 * wave_))) {
  for (std::ptrdiff_t halt = 0; halt < num_halt_lengths; ++halt) {
    Bases bases;
    for (std::ptrdiff_t step = 0; step < num_reversals; ++step) {
      const double reversal = (static_cast<double>(step) / steps_per_wave - 1.0) * wave_;
      const Basis columns =
          course(low_pass, reach_, wave_, reversal, static_cast<double>(halt) / steps_per_wave * wave_);
      bases.emplace_back(Qr(columns).basis());
    }
    by_halt_.push_back(std::move(bases));
  }
}

// Downhill from a step of the grid; between steps by the parabola through three.
HaltFit::Least HaltFit::least_about(const Bases& bases, const VectorXd& a, double power, std::ptrdiff_t step) {
  const auto at = [&](std::ptrdiff_t k) { return misfit(bases[static_cast<std::size_t>(k)], a, power); };
  Least least{step, at(step)};
  double before = INFINITY, after = INFINITY;  // at its neighbours
  for (std::ptrdiff_t k = step + 1; k < num_reversals; ++k) {
    if (after = at(k); after >= least.misfit) break;
    before = least.misfit;
    least = {k, after};
    after = INFINITY;
  }
  if (least.step == step)
    for (std::ptrdiff_t k = step - 1; k >= 0; --k) {
      if (before = at(k); before >= least.misfit) break;
      after = least.misfit;
      least = {k, before};
      before = INFINITY;
    }
  if (const double bend = before - 2.0 * least.misfit + after; std::isfinite(bend) && bend > 0.0)
    least.misfit = std::max(0.0, least.misfit - (after - before) * (after - before) / (8.0 * bend));
  return least;
}

HaltFit::Result HaltFit::operator()(const VectorXd& a) const {
  const double power = a.squaredNorm();
  std::ptrdiff_t step = 0;
  double lowest = INFINITY;
  for (std::ptrdiff_t k = 0; k < num_reversals; ++k)
    if (const double here = misfit(by_halt_.front()[static_cast<std::size_t>(k)], a, power); here < lowest)
      lowest = here, step = k;

  double without = 0.0, least = INFINITY;
  std::size_t best = 0;
  for (std::size_t k = 0; k < by_halt_.size(); ++k) {
    const Least here = least_about(by_halt_[k], a, power, step);
    step = here.step;
    if (k == 0) without = here.misfit;
    if (here.misfit < least) least = here.misfit, best = k;
  }
  return {.halt_samples = static_cast<double>(best) / steps_per_wave * wave_,
          .gain = std::sqrt(std::max(0.0, without - least)),
          .rms = std::sqrt(least / static_cast<double>(a.size()))};
}

}  // namespace dsp
