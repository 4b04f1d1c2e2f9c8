#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/ode/dormand_prince.hpp"
#include "sim/ode/runge_kutta.hpp"
#include "sim/ode/steps.hpp"

namespace sim {
namespace {

/// Step sizes by a PI controller and the test of stiffness as in [HW96], IV.2.
template <class Formula, int N>
class ExplicitSteps final : public Steps {
 public:
  using Vector = typename RungeKutta<Formula, N>::Vector;
  ExplicitSteps(const System& system, const StepOptions& options)
      : system_(system),
        options_(options),
        absolute_(options.absolute_tolerance),
        formula_(options.absolute_tolerance.size()),
        max_step_s_(options.max_step_s > 0.0 ? options.max_step_s : std::numeric_limits<double>::infinity()) {}

  void restart(double t, const double* y, int mode) override {
    mode_ = mode;
    begin_s_ = end_s_ = t;
    formula_.start(rhs(), t, Eigen::Map<const Vector>(y, absolute_.size()));
    if (next_h_ == 0.0) next_h_ = first_step();
  }

  std::optional<std::string> step() override {
    if (end_s_ > begin_s_) formula_.go_on();
    for (bool first = true;; first = false) {
      const double left_s = options_.stop_s - end_s_, wanted = std::min(next_h_, max_step_s_);
      const bool last = 1.01 * wanted >= left_s;  // no crumb is left over
      const double h = last ? left_s : wanted;
      if (!(0.1 * h > std::numeric_limits<double>::epsilon() * std::abs(end_s_))) {
        begin_s_ = end_s_;
        return formula_.begin_slope().allFinite() ? "below the rounding of t" : "the rates there are no numbers";
      }
      formula_.step(rhs(), h);
      const double error = error_of_step();
      if (error <= 1.0) {
        begin_s_ = end_s_;
        end_s_ = last ? options_.stop_s : end_s_ + h;
        choose_next(h, error, first ? largest_factor : 1.0);
        look_for_stiffness();
        return std::nullopt;
      }
      next_h_ = h * (std::isfinite(error) ? std::max(smallest_factor, safety * std::pow(error, -exponent)) : 0.1);
    }
  }

  [[nodiscard]] double begin_s() const override { return begin_s_; }
  [[nodiscard]] double end_s() const override { return end_s_; }
  void states(double t, double* y) override {
    const double h = end_s_ - begin_s_;
    if (t < end_s_)
      formula_.between(rhs(), std::max((t - begin_s_) / h, 0.0), y);
    else
      std::copy_n((h > 0.0 ? formula_.end() : formula_.begin()).data(), absolute_.size(), y);
  }
  [[nodiscard]] bool stiff() const override { return num_stiff_ >= 15; }
  [[nodiscard]] int num_checks() const override { return Formula::num_checks; }
  [[nodiscard]] long num_rhs_evaluations() const override { return num_rhs_evaluations_; }

 private:
  static constexpr double order = Formula::order, safety = 0.9, smallest_factor = 0.2, largest_factor = 10.0;
  static constexpr double past = Formula::order == 5 ? 0.04 : 0.0, exponent = 1.0 / order - 0.75 * past;

  [[nodiscard]] auto rhs() {
    return [this](double t, const double* y, double* dydt) {
      ++num_rhs_evaluations_;
      system_.rhs(t, y, mode_, dydt);
    };
  }

  double error_of_step() {
    const double at_end = formula_.error(absolute_, options_.relative_tolerance);
    if (!(at_end <= 1.0)) return at_end;
    const double between = formula_.error_between(rhs(), absolute_, options_.relative_tolerance);
    return between <= at_end ? at_end : between;
  }

  void choose_next(double h, double error, double most) {
    const double factor = safety * std::pow(std::max(error, 1e-10), -exponent) * std::pow(last_error_, past);
    last_error_ = std::max(error, 1e-4);
    next_h_ = h * std::clamp(factor, smallest_factor, most);
  }

  void look_for_stiffness() {
    if (formula_.stiffness() > Formula::stability_radius) {
      num_smooth_ = 0;
      ++num_stiff_;
    } else if (++num_smooth_ == 6) {
      num_stiff_ = 0;
    }
  }

  /// One that an Euler step would get wrong by a hundredth of the tolerance ([HNW93], II.4).
  double first_step() {
    const Vector scale = absolute_ + options_.relative_tolerance * formula_.begin().cwiseAbs();
    const auto size = [&](const Vector& v) {
      return std::sqrt(v.cwiseQuotient(scale).squaredNorm() / static_cast<double>(v.size()));
    };
    const double d0 = size(formula_.begin()), d1 = size(formula_.begin_slope());
    double h = d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1;
    h = std::min({h, max_step_s_, options_.stop_s - end_s_});
    const Vector along = formula_.begin() + h * formula_.begin_slope();
    Vector slope = along;
    rhs()(end_s_ + h, along.data(), slope.data());
    const double d2 = size(slope - formula_.begin_slope()) / h, largest = std::max(d1, d2);
    return std::min(100.0 * h, largest > 1e-15 ? std::pow(0.01 / largest, 1.0 / order) : std::max(1e-6, 1e-3 * h));
  }

  const System& system_;
  StepOptions options_;
  Vector absolute_;
  RungeKutta<Formula, N> formula_;
  double max_step_s_;
  double begin_s_ = 0.0, end_s_ = 0.0, next_h_ = 0.0, last_error_ = 1e-4;
  int mode_ = 0, num_stiff_ = 0, num_smooth_ = 0;
  long num_rhs_evaluations_ = 0;
};

template <class Formula>
std::unique_ptr<Steps> steps_by(const System& system, const StepOptions& options) {
  switch (options.absolute_tolerance.size()) {
    case 2:
      return std::make_unique<ExplicitSteps<Formula, 2>>(system, options);
    case 3:
      return std::make_unique<ExplicitSteps<Formula, 3>>(system, options);
    case 4:
      return std::make_unique<ExplicitSteps<Formula, 4>>(system, options);
    default:
      return std::make_unique<ExplicitSteps<Formula, Eigen::Dynamic>>(system, options);
  }
}

}  // namespace

std::unique_ptr<Steps> explicit_steps(const System& system, const StepOptions& options) {
  constexpr double tight = 1e-7;
  return options.relative_tolerance < tight ? steps_by<DormandPrince8>(system, options)
                                            : steps_by<DormandPrince5>(system, options);
}

}  // namespace sim
