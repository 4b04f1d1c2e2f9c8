#include "ident/bodies/system.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "ident/state_space/model.hpp"
#include "sim/ode/friction.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Sides = std::array<double, sim::max_switches>;

state_space::Problem problem_of(const BodiesModel& model) {
  const std::vector<double> known(model.mean.begin(), model.mean.end());
  return {.equations = equations_of(model.layout, model.terms, known), .channels = {}, .records = {}};
}

/// The unknowns of a | b, solved in their order; one that those before it determine already is 0.
VectorXd solved_in_order(MatrixXd a) {
  constexpr double determined = 1e-9;  // of its own coefficient: what rounding leaves of it
  const Index n = a.rows();
  const VectorXd own = a.diagonal();
  for (Index i = 0; i < n; ++i) {
    if (!(std::abs(a(i, i)) > determined * std::abs(own(i)))) {
      a.row(i).setZero(), a.col(i).setZero();
      a(i, i) = 1.0;
      continue;
    }
    for (Index j = 0; j < n; ++j)
      if (j != i) a.row(j) -= a(j, i) / a(i, i) * a.row(i);
  }
  return a.col(n).cwiseQuotient(a.leftCols(n).diagonal());
}

class Bodies {
 public:
  Bodies(const BodiesModel& model, InputsAt inputs_at)
      : layout_(model.layout), model_(problem_of(model)), rates_(model_), inputs_at_(std::move(inputs_at)) {
    values_.resize(2 * layout_.inputs.size());
  }
  [[nodiscard]] int num_switches() const { return model_.num_switches(); }

  void rates(double t, const double* y, int mode, double* dydt) {
    Sides sides;
    sim::sides_of(mode, num_switches(), sides.data());
    look(t, y);
    (void)hold(sides);
    evaluate(sides, state_space::Slopes::none);
    for (int i = 0; i < model_.num_states(); ++i) dydt[i] = *rates_.rate(i);
  }
  [[nodiscard]] double switch_value(int i, double t, const double* y) {
    look_from(t, y, state_space::Slopes::none);
    return *rates_.switch_value(i);
  }
  /// Of the side that would keep switch i at zero: beyond 1 it leads up, below -1 down.
  [[nodiscard]] std::optional<sim::RatesAtZero> rates_at_zero(int i, double t, const double* y, const double* given) {
    Sides sides;
    std::copy_n(given, num_switches(), sides.begin());
    double& side = sides[static_cast<std::size_t>(i)];
    const bool was_held = std::exchange(side, 0.0) == 0.0;
    look(t, y);
    const std::vector<double> pulls = hold(sides);
    if (!was_held && !(pulls[static_cast<std::size_t>(i)] < 0.0)) return std::nullopt;
    return sim::RatesAtZero{side - 1.0, side + 1.0};
  }
  /// Where it is held: by the least change of speeds.
  void settle(int i, int side, double t, double* y) {
    if (side != 0) return;
    look_from(t, y);
    double squares = 0.0;
    for (int j = 0; j < model_.num_states(); ++j)
      if (has_equation(j)) squares += std::pow(*rates_.switch_slope(i, j), 2);
    const double g = *rates_.switch_value(i);
    for (int j = 0; j < model_.num_states(); ++j)
      if (has_equation(j)) y[j] -= g * *rates_.switch_slope(i, j) / squares;
  }

 private:
  [[nodiscard]] bool has_equation(int state) const { return state % 2 == 1 || state >= 2 * layout_.num_bodies; }

  void look(double t, const double* y) {
    for (int i = 0; i < model_.num_states(); ++i) *rates_.state(i) = y[i];
    const auto n = static_cast<int>(layout_.inputs.size());
    inputs_at_(t, values_.data(), values_.data() + n);
    for (int i = 0; i < n; ++i) *rates_.input(i) = values_[i], *rates_.input_rate(i) = values_[n + i];
    *rates_.input(n) = t, *rates_.input_rate(n) = 1.0;
  }
  void evaluate(const Sides& sides, state_space::Slopes slopes = state_space::Slopes::by_states_and_time) {
    for (int i = 0; i < num_switches(); ++i) *rates_.sides(i) = sides[static_cast<std::size_t>(i)];
    rates_.evaluate({}, slopes);
  }
  /// On the side of each switch that y is on.
  void look_from(double t, const double* y, state_space::Slopes slopes = state_space::Slopes::by_states_and_time) {
    look(t, y);
    rates_.take_sides();
    rates_.evaluate({}, slopes);
  }
  /// d(g)/dt of these switches with the sides.
  [[nodiscard]] VectorXd paces(const std::vector<int>& of, const Sides& sides) {
    evaluate(sides);
    VectorXd paces(std::ssize(of));
    for (Index k = 0; k < paces.size(); ++k) {
      const int i = of[static_cast<std::size_t>(k)];
      paces(k) = *rates_.switch_slope(i, model_.num_states());
      for (int j = 0; j < model_.num_states(); ++j) paces(k) += *rates_.switch_slope(i, j) * *rates_.rate(j);
    }
    return paces;
  }
  /// In the place of sides that are 0 those that keep each g at zero. By how much the pace of a switch changes with its
  /// own side; of those that were not 0: 0.
  std::vector<double> hold(Sides& sides) {
    std::vector<double> pulls(static_cast<std::size_t>(num_switches()), 0.0);
    std::vector<int> held;
    for (int i = 0; i < num_switches(); ++i)
      if (sides[static_cast<std::size_t>(i)] == 0.0) held.push_back(i);
    if (held.empty()) return pulls;
    const auto n = std::ssize(held);
    const VectorXd at_zero = paces(held, sides);
    MatrixXd by_side(n, n + 1);
    by_side.col(n) = -at_zero;
    for (Index k = 0; k < n; ++k) {
      const auto i = static_cast<std::size_t>(held[static_cast<std::size_t>(k)]);
      sides[i] = 1.0;
      by_side.col(k) = paces(held, sides) - at_zero;
      sides[i] = 0.0;
      pulls[i] = by_side(k, k);
    }
    const VectorXd solved = solved_in_order(std::move(by_side));
    for (Index k = 0; k < n; ++k) sides[static_cast<std::size_t>(held[static_cast<std::size_t>(k)])] = solved(k);
    return pulls;
  }

  BodiesLayout layout_;
  state_space::Model model_;
  state_space::Rates<1> rates_;
  InputsAt inputs_at_;
  std::vector<double> values_;  ///< of the inputs, then their rates
};

}  // namespace

sim::System system_of(const BodiesModel& model, InputsAt inputs_at) {
  const auto bodies = std::make_shared<Bodies>(model, std::move(inputs_at));
  sim::System system{.name = "equations of bodies", .states = equations_of(model.layout, {}).states, .rhs = {}};
  system.rhs = [bodies](double t, const double* y, int mode, double* dydt) { bodies->rates(t, y, mode, dydt); };
  if (bodies->num_switches() == 0) return system;
  sim::add_switches(system,
                    {.count = bodies->num_switches(),
                     .value = [bodies](int i, double t, const double* y) { return bodies->switch_value(i, t, y); },
                     .rates_at_zero = [bodies](int i, double t, const double* y,
                                               const double* sides) { return bodies->rates_at_zero(i, t, y, sides); },
                     .settle = [bodies](int i, int side, double t, double* y) { bodies->settle(i, side, t, y); }});
  return system;
}

}  // namespace ident
