#include "ident/columns/sensor_columns.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "ident/columns/columns.hpp"

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// By how much the equation changes with a signal, sample by sample: smoothly, and at switches by an impulse a cell
/// wide of the same area.
class SignalSlope {
 public:
  SignalSlope(const dsp::Motion& motion, std::string name) : motion_(motion), name_(std::move(name)) {}
  [[nodiscard]] const std::string& name() const { return name_; }
  void add(Expression derivative, double coefficient) { smooth_.emplace_back(std::move(derivative), coefficient); }
  void add_impulse(Index at, double area) { impulses_[at] += area; }
  /// What it is at all times; none where that differs.
  [[nodiscard]] std::optional<double> constant() const {
    if (!impulses_.empty()) return std::nullopt;
    double sum = 0.0;
    for (const auto& [derivative, coefficient] : smooth_) {
      if (!derivative.signals().empty() || !derivative.switches().empty()) return std::nullopt;
      sum += coefficient * derivative.evaluate(nullptr, nullptr);
    }
    return sum;
  }
  [[nodiscard]] VectorXd block(Index first, Index count) const {
    VectorXd values = VectorXd::Zero(count);
    for (const auto& [derivative, coefficient] : smooth_)
      values += coefficient * finite(derivative.evaluate(motion_, first, count));
    for (auto it = impulses_.lower_bound(first); it != impulses_.end() && it->first < first + count; ++it)
      values(it->first - first) += it->second;
    return values;
  }

 private:
  const dsp::Motion& motion_;
  std::string name_;
  std::vector<std::pair<Expression, double>> smooth_;
  std::map<Index, double> impulses_;
};

class EquationSlopes {
 public:
  EquationSlopes(const dsp::Motion& motion, const WeightedTerms& equation) : motion_(motion) {
    for (const auto& [term, coefficient] : equation) {
      for (const std::string& signal : term.signals()) of(signal).add(term.derivative(signal), coefficient);
      for (std::size_t i = 0; i < term.switches().size(); ++i) add_jumps(term, i, coefficient);
    }
  }
  [[nodiscard]] const std::vector<SignalSlope>& slopes() const { return slopes_; }
  [[nodiscard]] bool constant_in(const std::string& signal) const {
    return std::all_of(slopes_.begin(), slopes_.end(),
                       [&](const SignalSlope& slope) { return slope.name() != signal || slope.constant(); });
  }

 private:
  SignalSlope& of(const std::string& signal) {
    for (SignalSlope& slope : slopes_)
      if (slope.name() == signal) return slope;
    return slopes_.emplace_back(motion_, signal);
  }

  /// Where g, the argument of the term's switch i, passes zero, a change of it moves the jump: by that over the slope
  /// of g in time.
  void add_jumps(const Expression& term, std::size_t i, double coefficient) {
    const Expression argument(term.switches()[i]);
    // Where g hardly moves it rests, and its zeros are noise.
    constexpr double resting = 0.05;
    double square = 0.0;
    for_each_step(argument, [&](Index, double g, double next) { square += (next - g) * (next - g); });
    const double least = resting * std::sqrt(square / static_cast<double>(motion_.num_samples() - 1));
    std::vector<std::pair<std::string, Expression>> gradient;
    for (const std::string& signal : argument.signals()) gradient.emplace_back(signal, argument.derivative(signal));
    std::vector<Expression> others;
    for (const std::string& text : term.switches()) others.emplace_back(text);
    for_each_step(argument, [&](Index n, double g, double next) {
      const double change = next - g;
      if ((g < 0.0) == (next < 0.0) || std::abs(change) < least) return;
      const double fraction = std::clamp(-g / change, 0.0, 1.0);
      const double area = coefficient * jump_of(term, others, i, n) / std::abs(change);
      if (!std::isfinite(area)) return;
      for (const auto& [signal, derivative] : gradient) {
        const VectorXd slope = derivative.evaluate(motion_, n, 2);
        of(signal).add_impulse(n, (1.0 - fraction) * area * slope(0));
        of(signal).add_impulse(n + 1, fraction * area * slope(1));
      }
    });
  }

  /// Calls visit(n, g at sample n, g at sample n + 1) for all n, block by block: g takes as much as a signal.
  template <class Visit>
  void for_each_step(const Expression& g, const Visit& visit) const {
    constexpr Index block = 16384;
    const Index num_steps = motion_.num_samples() - 1;
    for (Index first = 0; first < num_steps; first += block) {
      const Index count = std::min(block, num_steps - first);
      const VectorXd values = g.evaluate(motion_, first, count + 1);
      for (Index n = 0; n < count; ++n) visit(first + n, values(n), values(n + 1));
    }
  }

  /// By how much the term jumps where its switch i goes from -1 to 1.
  double jump_of(const Expression& term, const std::vector<Expression>& arguments, std::size_t i, Index n) const {
    const auto values_of = [&](const Expression& expression) {
      std::vector<double> values;
      for (const std::string& signal : expression.signals()) values.push_back(motion_.at(signal)(n));
      return values;
    };
    std::vector<double> signs;
    for (const Expression& argument : arguments)
      signs.push_back(argument.evaluate(values_of(argument).data(), nullptr) < 0.0 ? -1.0 : 1.0);
    const std::vector<double> values = values_of(term);
    signs[i] = 1.0;
    const double above = term.evaluate(values.data(), signs.data());
    signs[i] = -1.0;
    return above - term.evaluate(values.data(), signs.data());
  }

  const dsp::Motion& motion_;
  std::vector<SignalSlope> slopes_;
};

/// What these changes change "equation - target" by.
VectorXd change_of_error(const std::vector<dsp::Signal>& changes, const std::vector<dsp::Signal>& slopes,
                         const std::string& target, Index count) {
  VectorXd sum = VectorXd::Zero(count);
  for (const dsp::Signal& change : changes) {
    if (change.name == target) sum -= change.values;
    for (const dsp::Signal& slope : slopes)
      if (slope.name == change.name) sum += slope.values.cwiseProduct(change.values);
  }
  return sum;
}

}  // namespace

dsp::Motion regression_accelerations(const dsp::Prepared& prepared) {
  dsp::Motion result{.sample_rate_hz = prepared.filter.output_rate_hz()};
  for (const char* name : {"a", "ddy", "ddr"})
    if (const dsp::Signal* signal = prepared.intermediate.find(name))
      result.signals.push_back({name, signal->unit, dsp::regression_signal(prepared, name)});
  return result;
}

SensorColumns sensor_columns(const dsp::Prepared& prepared, const dsp::Motion& accelerations,
                             const std::vector<std::shared_ptr<const SensorShape>>& shapes,
                             const WeightedTerms& equation, const std::string& target, const dsp::Stretch& wanted,
                             const std::function<void()>& poll) {
  const EquationSlopes equation_slopes(prepared.intermediate, equation);
  const bool constant = std::all_of(accelerations.signals.begin(), accelerations.signals.end(),
                                    [&](const auto& signal) { return equation_slopes.constant_in(signal.name); });
  // Where the equation is linear in the accelerations, filters come in any order: theirs last, at the lower rate.
  const auto comes_last = [&](const SensorShape& shape) { return shape.of_accelerations && constant; };
  std::vector<SignalChange> changes;
  std::vector<Index> columns;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    if (comes_last(*shapes[k])) continue;
    if (poll) poll();
    changes.push_back(shapes[k]->change(prepared.intermediate));
    columns.push_back(static_cast<Index>(k));
  }
  BlockMeans means;
  if (loses_known_means(prepared))
    means = BlockMeans(prepared.intermediate.num_samples(), std::ssize(shapes), prepared.intermediate.sample_rate_hz);
  // Block by block: at the intermediate rate there is room for none of the columns.
  const MatrixXd formed =
      dsp::filtered_within(prepared, wanted, std::max<Index>(1, std::ssize(changes)), [&](Index first, Index count) {
        if (poll) poll();
        std::vector<dsp::Signal> slopes;
        for (const SignalSlope& slope : equation_slopes.slopes())
          slopes.push_back({slope.name(), "", slope.block(first, count)});
        MatrixXd block = MatrixXd::Zero(count, std::max<Index>(1, std::ssize(changes)));
        for (std::size_t k = 0; k < changes.size(); ++k)
          block.col(static_cast<Index>(k)) = change_of_error(changes[k](first, count), slopes, target, count);
        for (std::size_t k = 0; means.size > 0 && k < changes.size(); ++k)
          means.add(first, columns[k], block.col(static_cast<Index>(k)));
        return block;
      });
  MatrixXd result(formed.rows(), std::ssize(shapes));
  for (std::size_t k = 0; k < columns.size(); ++k) result.col(columns[k]) = formed.col(static_cast<Index>(k));
  if (columns.size() == shapes.size()) return {std::move(result), std::move(means)};
  const Index count = result.rows();
  std::vector<dsp::Signal> slopes;
  for (const SignalSlope& slope : equation_slopes.slopes())
    if (accelerations.find(slope.name()) != nullptr)
      slopes.push_back({slope.name(), "", VectorXd::Constant(count, *slope.constant())});
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    if (!comes_last(*shapes[k])) continue;
    if (poll) poll();
    result.col(static_cast<Index>(k)) =
        change_of_error(shapes[k]->change(accelerations)(0, count), slopes, target, count);
  }
  return {std::move(result), std::move(means)};  // what is of accelerations only has no mean
}

}  // namespace ident
