#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ident/library/expression.hpp"
#include "sim/ode/system.hpp"

namespace ident {

/// d(state)/dt = sum of coefficient_i term_i.
struct StateEquation {
  std::size_t state = 1;  ///< index; 1 is the speed of the motion
  std::vector<std::string> terms;
  std::vector<double> coefficients;
  std::string where = {};  ///< a condition on the sign of v under which it holds; empty: always
};

/// What the terms of an equation of motion may look at, beside t and the motion (x, v, y, dy) that follows from states
/// and base.
struct EquationFrame {
  std::vector<std::string> states = {"x", "v"};  ///< position and speed first, {"x", "v"} or {"y", "dy"}; at most 8
  std::vector<std::string> inputs = {};          ///< known from elsewhere: "r", "dr", "ddr", "f" ...
  bool base_moves = false;  ///< x = y - r - offset_m by the inputs r, dr, ddr; else x = y - offset_m
  double offset_m = 0.0;
};

/// Where the equations are looked at.
struct EquationPoint {
  double t_s = 0.0;
  const double* states = nullptr;  ///< in the order of the frame
  const double* inputs = nullptr;  ///< in the order of EquationOfMotion::inputs
};

/// State equations in candidate terms, compiled once. A position without an equation of its own changes by its speed.
/// Not to be shared between threads.
class EquationOfMotion {
 public:
  /// Throws dsp::Fault as Expression does, for terms that look at anything else and conditions on anything but v, and
  /// std::invalid_argument for a state without name.
  EquationOfMotion(const std::vector<StateEquation>& equations, EquationFrame frame);

  /// What the terms and switches look at, in order of first appearance.
  [[nodiscard]] const std::vector<std::string>& signals() const& { return signals_; }
  void signals() const&& = delete;
  /// The g of every sgn(g), likewise; a condition looks at v.
  [[nodiscard]] const std::vector<std::string>& switches() const& { return switch_names_; }
  void switches() const&& = delete;
  /// The inputs that must be given to what follows, in this order.
  [[nodiscard]] const std::vector<std::string>& inputs() const& { return inputs_; }
  void inputs() const&& = delete;
  [[nodiscard]] const EquationFrame& frame() const& { return frame_; }
  void frame() const&& = delete;

  /// d(state)/dt of the states from `first` on, the switches being on these sides (1, -1).
  void rates(const EquationPoint& point, const double* sides, std::size_t first, double* dydt) const;
  /// d(state 1)/dt.
  [[nodiscard]] double acceleration(const EquationPoint& point, const double* sides) const;
  [[nodiscard]] double switch_value(std::size_t i, const EquationPoint& point) const;
  /// Whether friction can hold the motion on switch i: it is v or dy.
  [[nodiscard]] bool can_hold(std::size_t i) const { return holds_[i] != Hold::never; }
  /// The speed at which switch i is zero, and the acceleration that keeps it there.
  [[nodiscard]] double held_speed(std::size_t i, const double* inputs) const;
  [[nodiscard]] double held_acceleration(std::size_t i, const double* inputs) const;

 private:
  /// An expression, with the indices of what it looks at among values_ and of its switches among those of all.
  struct Part {
    Expression expression;
    std::vector<std::size_t> values, switches;
  };
  struct Term {
    Part part;
    double coefficient;
  };
  struct Row {
    std::size_t state;
    bool above = true, below = true;  ///< the sides of v on which it holds
    std::size_t v_switch = 0;         ///< index; where it does not hold on both
    std::vector<Term> terms;
  };
  enum class Hold { never, own_speed, other_speed };

  [[nodiscard]] Part make_part(const std::string& text, const std::vector<std::string>& names);
  [[nodiscard]] Row make_row(const StateEquation& equation, const std::vector<std::string>& names);
  void find_values();
  void look(const EquationPoint& point) const;
  [[nodiscard]] double evaluate(const Part& part, const double* sides) const;
  [[nodiscard]] double sum(const Row& row, const double* sides) const;

  EquationFrame frame_;
  bool relative_;  ///< x and v are the first states, not y and dy
  std::vector<std::string> signals_, switch_names_, inputs_;
  std::vector<Row> rows_;
  bool position_has_row_ = false;
  std::vector<Part> switches_;
  std::vector<Hold> holds_;
  std::optional<std::size_t> r_, dr_, ddr_;  ///< indices among the inputs, where needed
  /// Scratch of one evaluation: states, inputs, t, y (x where y is a state), dy (v); and those of one part.
  mutable std::vector<double> values_, part_values_, part_sides_;
};

/// The equation as a system to integrate, its switches located, friction on v or dy holding where neither side leads
/// away. `inputs_at` gives the inputs at a time; the system's states are the equation's divided by `scales`.
[[nodiscard]] sim::System system_of(std::shared_ptr<const EquationOfMotion> equation,
                                    std::function<void(double t, double* inputs)> inputs_at,
                                    std::vector<double> scales = {});

}  // namespace ident
