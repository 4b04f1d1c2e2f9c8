#include "ident/equation/equation_of_motion.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "sim/ode/friction.hpp"

namespace ident {
namespace {

constexpr std::size_t max_states = 8;
using States = std::array<double, max_states>;
using Sides = std::array<double, sim::max_switches>;

/// Index of a text among the known ones, which it joins if it is new.
std::size_t index_of(std::vector<std::string>& known, const std::string& wanted) {
  const auto found = std::find(known.begin(), known.end(), wanted);
  if (found != known.end()) return static_cast<std::size_t>(found - known.begin());
  known.push_back(wanted);
  return known.size() - 1;
}

/// `indices` of `all` in a row: where they are, if there is but one, else in `row`.
const double* gathered(const std::vector<std::size_t>& indices, const double* all, double* row) {
  if (indices.size() == 1) return all + indices[0];
  for (std::size_t i = 0; i < indices.size(); ++i) row[i] = all[indices[i]];
  return row;
}

}  // namespace

EquationOfMotion::EquationOfMotion(const std::vector<StateEquation>& equations, EquationFrame frame)
    : frame_(std::move(frame)), relative_(!frame_.states.empty() && frame_.states.front() == "x") {
  const auto& states = frame_.states;
  if (states.size() < 2 || states.size() > max_states)
    throw std::invalid_argument("EquationOfMotion: 2 to 8 states are wanted");
  std::vector<std::string> names{"t", "x", "v", "y", "dy"};
  for (const std::string& name : states) (void)index_of(names, name);
  for (const std::string& name : frame_.inputs) (void)index_of(names, name);
  for (const StateEquation& equation : equations) {
    rows_.push_back(make_row(equation, names));
    position_has_row_ = position_has_row_ || equation.state == 0;
  }
  for (std::size_t i = 0; i < switch_names_.size(); ++i)  // a switch holds no other switches
    switches_.push_back(make_part(std::string(switch_names_[i]), names));
  for (const std::string& name : switch_names_) {
    const bool own = name == states[1], other = !own && (name == "v" || name == "dy");
    holds_.push_back(own || (other && !frame_.base_moves) ? Hold::own_speed : other ? Hold::other_speed : Hold::never);
  }
  find_values();
}

EquationOfMotion::Part EquationOfMotion::make_part(const std::string& text, const std::vector<std::string>& names) {
  Part part{Expression(text, names), {}, {}};
  for (const std::string& signal : part.expression.signals()) part.values.push_back(index_of(signals_, signal));
  for (const std::string& name : part.expression.switches()) part.switches.push_back(index_of(switch_names_, name));
  return part;
}

EquationOfMotion::Row EquationOfMotion::make_row(const StateEquation& equation, const std::vector<std::string>& names) {
  if (equation.state >= frame_.states.size() || equation.terms.size() != equation.coefficients.size())
    throw std::invalid_argument("EquationOfMotion: an equation for no state, or terms without coefficients");
  Row row{.state = equation.state, .terms = {}};
  if (!equation.where.empty()) {
    const Expression condition(equation.where, {"v"});
    const double above = 1.0, below = -1.0;
    row.above = condition.evaluate(&above, &above) != 0.0;
    row.below = condition.evaluate(&below, &below) != 0.0;
    row.v_switch = index_of(switch_names_, "v");
  }
  for (std::size_t i = 0; i < equation.terms.size(); ++i)
    row.terms.push_back({make_part(equation.terms[i], names), equation.coefficients[i]});
  return row;
}

void EquationOfMotion::find_values() {
  const auto& states = frame_.states;
  const std::array<std::string, 3> derived{"t", relative_ ? "y" : "x", relative_ ? "dy" : "v"};
  const auto looks_at = [&](const std::string& name) {
    return std::find(signals_.begin(), signals_.end(), name) != signals_.end();
  };
  std::vector<std::string> all = states;
  for (const std::string& name : signals_)
    if (std::find(states.begin(), states.end(), name) == states.end() &&
        std::find(derived.begin(), derived.end(), name) == derived.end())
      (void)index_of(inputs_, name);
  const bool holds_other = std::find(holds_.begin(), holds_.end(), Hold::other_speed) != holds_.end();
  if (frame_.base_moves && looks_at(derived[1])) r_ = index_of(inputs_, "r");
  if (frame_.base_moves && (looks_at(derived[2]) || holds_other)) dr_ = index_of(inputs_, "dr");
  if (holds_other) ddr_ = index_of(inputs_, "ddr");
  all.insert(all.end(), inputs_.begin(), inputs_.end());
  all.insert(all.end(), derived.begin(), derived.end());
  values_.resize(all.size());
  part_values_.resize(signals_.size());
  part_sides_.resize(switch_names_.size());
  const auto place = [&](Part& part) {
    for (std::size_t& value : part.values) value = index_of(all, signals_[value]);
  };
  for (Row& row : rows_)
    for (Term& term : row.terms) place(term.part);
  for (Part& part : switches_) place(part);
}

inline void EquationOfMotion::look(const EquationPoint& point) const {
  double* derived = values_.data();
  for (std::size_t i = 0; i < frame_.states.size(); ++i) *derived++ = point.states[i];
  for (std::size_t i = 0; i < inputs_.size(); ++i) *derived++ = point.inputs[i];
  const double r = r_ ? point.inputs[*r_] : 0.0, dr = dr_ ? point.inputs[*dr_] : 0.0;
  derived[0] = point.t_s;
  derived[1] = relative_ ? point.states[0] + r + frame_.offset_m : point.states[0] - r - frame_.offset_m;
  derived[2] = relative_ ? point.states[1] + dr : point.states[1] - dr;
}

inline double EquationOfMotion::evaluate(const Part& part, const double* sides) const {
  return part.expression.evaluate(gathered(part.values, values_.data(), part_values_.data()),
                                  gathered(part.switches, sides, part_sides_.data()));
}

inline double EquationOfMotion::sum(const Row& row, const double* sides) const {
  if (!(row.above && row.below) && !(sides[row.v_switch] > 0.0 ? row.above : row.below)) return 0.0;
  double sum = 0.0;
  for (const auto& [part, coefficient] : row.terms) sum += coefficient * evaluate(part, sides);
  return sum;
}

void EquationOfMotion::rates(const EquationPoint& point, const double* sides, std::size_t first, double* dydt) const {
  look(point);
  std::fill(dydt + first, dydt + frame_.states.size(), 0.0);
  if (!position_has_row_ && first == 0) dydt[0] = point.states[1];
  for (const Row& row : rows_)
    if (row.state >= first) dydt[row.state] += sum(row, sides);
}

double EquationOfMotion::acceleration(const EquationPoint& point, const double* sides) const {
  look(point);
  double acceleration = 0.0;
  for (const Row& row : rows_)
    if (row.state == 1) acceleration += sum(row, sides);
  return acceleration;
}

double EquationOfMotion::switch_value(std::size_t i, const EquationPoint& point) const {
  look(point);
  return evaluate(switches_[i], nullptr);
}

double EquationOfMotion::held_speed(std::size_t i, const double* inputs) const {
  if (holds_[i] != Hold::other_speed) return 0.0;
  return relative_ ? -inputs[*dr_] : inputs[*dr_];
}

double EquationOfMotion::held_acceleration(std::size_t i, const double* inputs) const {
  if (holds_[i] != Hold::other_speed) return 0.0;
  return relative_ ? -inputs[*ddr_] : inputs[*ddr_];
}

namespace {

/// An equation with its inputs and scales, as a system's functions see it.
class SystemEquation {
 public:
  SystemEquation(std::shared_ptr<const EquationOfMotion> equation,
                 std::function<void(double t, double* inputs)> inputs_at, std::vector<double> scales)
      : equation_(std::move(equation)),
        inputs_at_(std::move(inputs_at)),
        scales_(std::move(scales)),
        inputs_(equation_->inputs().size()) {
    scales_.resize(num_states(), 1.0);
  }
  [[nodiscard]] int num_switches() const { return static_cast<int>(equation_->switches().size()); }

  void rates(double t, const double* y, int mode, double* dydt) const {
    const EquationPoint point = at(t, y);
    Sides sides;
    sim::sides_of(mode, num_switches(), sides.data());
    const auto end = sides.begin() + num_switches(), held = std::find(sides.begin(), end, 0.0);
    if (held == end) {
      equation_->rates(point, sides.data(), 0, dydt);
    } else {
      const auto i = static_cast<std::size_t>(held - sides.begin());
      std::replace(sides.begin(), end, 0.0, 1.0);
      if (num_states() > 2) equation_->rates(point, sides.data(), 2, dydt);
      dydt[0] = point.states[1];
      dydt[1] = equation_->held_acceleration(i, point.inputs);
    }
    for (std::size_t i = 0; i < num_states(); ++i) dydt[i] /= scales_[i];
  }
  [[nodiscard]] double switch_value(int i, double t, const double* y) const {
    return equation_->switch_value(static_cast<std::size_t>(i), at(t, y));
  }
  [[nodiscard]] std::optional<sim::RatesAtZero> rates_at_zero(int i, double t, const double* y,
                                                              const double* sides) const {
    const auto which = static_cast<std::size_t>(i);
    if (!equation_->can_hold(which)) return std::nullopt;
    const EquationPoint point = at(t, y);
    Sides side;
    std::copy(sides, sides + num_switches(), side.begin());
    const double held = equation_->held_acceleration(which, point.inputs);
    side[which] = 1.0;
    const double above = equation_->acceleration(point, side.data()) - held;
    side[which] = -1.0;
    return sim::RatesAtZero{above, equation_->acceleration(point, side.data()) - held};
  }
  /// Only where it is held: a speed relative to a moving base cannot be made exactly zero, and rounded to the wrong
  /// side it would be an event again.
  void settle(int i, int side, double t, double* y) const {
    if (side == 0) y[1] = equation_->held_speed(static_cast<std::size_t>(i), at(t, y).inputs) / scales_[1];
  }

 private:
  [[nodiscard]] std::size_t num_states() const { return equation_->frame().states.size(); }
  [[nodiscard]] EquationPoint at(double t, const double* y) const {
    for (std::size_t i = 0; i < num_states(); ++i) states_[i] = y[i] * scales_[i];
    if (!inputs_.empty()) inputs_at_(t, inputs_.data());
    return {t, states_.data(), inputs_.data()};
  }
  std::shared_ptr<const EquationOfMotion> equation_;
  std::function<void(double t, double* inputs)> inputs_at_;
  std::vector<double> scales_;
  mutable States states_{};  ///< scratch of one evaluation, as inputs_
  mutable std::vector<double> inputs_;
};

}  // namespace

sim::System system_of(std::shared_ptr<const EquationOfMotion> equation,
                      std::function<void(double t, double* inputs)> inputs_at, std::vector<double> scales) {
  sim::System system{.name = "identified equation", .states = equation->frame().states, .rhs = {}};
  const auto seen =
      std::make_shared<const SystemEquation>(std::move(equation), std::move(inputs_at), std::move(scales));
  system.rhs = [seen](double t, const double* y, int mode, double* dydt) { seen->rates(t, y, mode, dydt); };
  if (seen->num_switches() == 0) return system;
  sim::add_switches(system,
                    {.count = seen->num_switches(),
                     .value = [seen](int i, double t, const double* y) { return seen->switch_value(i, t, y); },
                     .rates_at_zero = [seen](int i, double t, const double* y,
                                             const double* sides) { return seen->rates_at_zero(i, t, y, sides); },
                     .settle = [seen](int i, int side, double t, double* y) { seen->settle(i, side, t, y); }});
  return system;
}

}  // namespace ident
