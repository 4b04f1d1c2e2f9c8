#include "support/printed_equation.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "ident/library/expression.hpp"

namespace support {
namespace {

using Json = nlohmann::json;
using Series = std::vector<double>;

Json document(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return stream ? Json::parse(stream, nullptr, false) : Json();
}

std::map<std::string, Series> columns_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line, cell;
  std::vector<std::string> names;
  std::getline(stream, line);
  for (std::istringstream head(line); std::getline(head, cell, ',');) names.push_back(cell);
  std::map<std::string, Series> columns;
  while (std::getline(stream, line)) {
    std::istringstream row(line);
    for (const std::string& name : names) {
      std::getline(row, cell, ',');
      columns[name].push_back(cell.empty() ? std::nan("") : std::strtod(cell.c_str(), nullptr));
    }
  }
  return columns;
}

/// Twice as many steps a sample would move no NMSE of the tests by a thousandth of itself.
constexpr int steps_per_sample = 8;

/// A signal at every half step, by a sinc under a Hann window of 2 x 40 samples.
Series at_half_steps(const Series& samples) {
  constexpr int factor = 2 * steps_per_sample, reach = 40;
  const auto n = static_cast<int>(samples.size());
  Series fine(static_cast<std::size_t>((n - 1) * factor + 1));
  for (int phase = 0; phase < factor; ++phase) {
    std::array<double, 2 * reach> weights{};
    for (int k = 0; k < 2 * reach; ++k) {
      const double t = static_cast<double>(phase) / factor - (k - reach + 1);
      weights[static_cast<std::size_t>(k)] =
          (t == 0.0 ? 1.0 : std::sin(M_PI * t) / (M_PI * t)) * std::pow(std::cos(0.5 * M_PI * t / (reach + 1)), 2);
    }
    for (int i = 0; i < n && i * factor + phase < static_cast<int>(fine.size()); ++i) {
      double sum = 0.0;
      for (int k = 0; k < 2 * reach; ++k) {
        const int at = i + k - reach + 1;
        // Beyond its ends the record goes on turned about its last value: nothing jumps there.
        const double value =
            at < 0    ? 2.0 * samples.front() - samples[static_cast<std::size_t>(std::min(-at, n - 1))]
            : at >= n ? 2.0 * samples.back() - samples[static_cast<std::size_t>(std::max(0, 2 * (n - 1) - at))]
                      : samples[static_cast<std::size_t>(at)];
        sum += weights[static_cast<std::size_t>(k)] * (std::isfinite(value) ? value : 0.0);
      }
      fine[static_cast<std::size_t>(i * factor + phase)] = sum;
    }
  }
  return fine;
}

struct Term {
  ident::Expression expression;
  double coefficient;
};

/// x'' of the printed equation at a half step.
class Equation {
 public:
  Equation(const Json& method, const std::map<std::string, Series>& columns, double rate_hz)
      : absolute_(method.at("target") == "ddy"), rate_hz_(rate_hz) {
    for (const Json& term : method.at("terms"))
      terms_.push_back({ident::Expression(term.at("name").get<std::string>()), term.at("mean").get<double>()});
    const double lead_s = method.at("coordinates").at(0).at("lead_s");
    zero_ = method.at("coordinates").at(0).at("zero").get<double>();
    for (const auto& [name, values] : columns)
      if (name == "r" || name == "dr" || name == "ddr" || name == "f") inputs_[name] = at_half_steps(values);
    if (const auto f = inputs_.find("f"); f != inputs_.end() && lead_s != 0.0) {
      const Series as_recorded = f->second;
      const double half_s = 0.5 / (steps_per_sample * rate_hz);
      for (std::size_t i = 1; i + 1 < as_recorded.size(); ++i)
        f->second[i] += lead_s * (as_recorded[i + 1] - as_recorded[i - 1]) / (2.0 * half_s);
    }
    for (const Term& term : terms_)
      for (const std::string& g : term.expression.switches())
        if (std::find(switches_.begin(), switches_.end(), g) == switches_.end()) switches_.push_back(g);
    sides_.assign(switches_.size(), 1.0);
  }
  [[nodiscard]] double input(const std::string& name, std::size_t half) const {
    const auto found = inputs_.find(name);
    return found == inputs_.end() ? 0.0 : found->second[std::min(half, found->second.size() - 1)];
  }
  [[nodiscard]] double signal(const std::string& name, std::size_t half, double x, double v) const {
    if (name == "x") return x;
    if (name == "v") return v;
    if (name == "y") return x + zero_ + input("r", half);
    if (name == "dy") return v + input("dr", half);
    if (name == "t") return 0.5 * static_cast<double>(half) / (steps_per_sample * rate_hz_);
    return input(name, half);
  }
  [[nodiscard]] double value(const ident::Expression& expression, std::size_t half, double x, double v) const {
    Series values, sides;
    for (const std::string& name : expression.signals()) values.push_back(signal(name, half, x, v));
    for (const std::string& g : expression.switches())
      sides.push_back(
          sides_[static_cast<std::size_t>(std::find(switches_.begin(), switches_.end(), g) - switches_.begin())]);
    return expression.evaluate(values.data(), sides.data());
  }
  [[nodiscard]] double acceleration(std::size_t half, double x, double v) const {
    double sum = absolute_ ? -input("ddr", half) : 0.0;
    for (const Term& term : terms_) sum += term.coefficient * value(term.expression, half, x, v);
    return sum;
  }
  [[nodiscard]] double switch_value(std::size_t i, std::size_t half, double x, double v) const {
    return value(ident::Expression(switches_[i]), half, x, v);
  }
  [[nodiscard]] std::size_t num_switches() const { return switches_.size(); }
  [[nodiscard]] bool holds(std::size_t i) const { return switches_[i] == "v"; }
  std::vector<double>& sides() { return sides_; }

 private:
  bool absolute_;
  double rate_hz_, zero_ = 0.0;
  std::vector<Term> terms_;
  std::map<std::string, Series> inputs_;
  std::vector<std::string> switches_;
  Series sides_;
};

struct State {
  double x = 0.0, v = 0.0;
};

/// One step of the classical Runge-Kutta method, `part` of a whole one; inputs are taken where the whole step has them.
State stepped(const Equation& equation, std::size_t half, const State& from, double h_s) {
  const auto rate = [&](const State& at, std::size_t offset) {
    return State{at.v, equation.acceleration(half + offset, at.x, at.v)};
  };
  const auto moved = [&](const State& by, double s) { return State{from.x + s * by.x, from.v + s * by.v}; };
  const State k1 = rate(from, 0), k2 = rate(moved(k1, 0.5 * h_s), 1), k3 = rate(moved(k2, 0.5 * h_s), 1),
              k4 = rate(moved(k3, h_s), 2);
  return {from.x + h_s / 6.0 * (k1.x + 2.0 * k2.x + 2.0 * k3.x + k4.x),
          from.v + h_s / 6.0 * (k1.v + 2.0 * k2.v + 2.0 * k3.v + k4.v)};
}

/// A whole step in which each switch may pass once.
State advanced(Equation& equation, std::size_t half, State state, double h_s) {
  double left_s = h_s;
  for (int passes = 0; passes < 4 && left_s > 0.0; ++passes) {
    State next = stepped(equation, half, state, left_s);
    std::optional<std::size_t> passed;
    double within_s = left_s;
    for (std::size_t i = 0; i < equation.num_switches(); ++i) {
      if (equation.sides()[i] * equation.switch_value(i, half + 2, next.x, next.v) >= 0.0) continue;
      double low = 0.0, high = within_s;
      for (int halving = 0; halving < 40; ++halving) {
        const double middle = 0.5 * (low + high);
        const State at = stepped(equation, half, state, middle);
        (equation.sides()[i] * equation.switch_value(i, half + 1, at.x, at.v) < 0.0 ? high : low) = middle;
      }
      within_s = high, passed = i;
    }
    if (!passed) return next;
    state = stepped(equation, half, state, within_s);
    left_s -= within_s;
    double& side = equation.sides()[*passed];
    side = -side;
    if (!equation.holds(*passed)) continue;
    const double beyond = equation.acceleration(half + 1, state.x, 0.0);
    if (beyond * side < 0.0) return {state.x, 0.0};  // it would turn back at once: held for the rest of the step
  }
  return state;
}

}  // namespace

PrintedRun printed_run(const std::filesystem::path& run) {
  const Json equations = document(run / "equation.json"), metrics = document(run / "metrics.json");
  if (!equations.contains("chosen") || !equations.at("chosen").is_object()) return {"no equation was chosen"};
  const auto row_of = [&](const Json& all, const Json& name, const char* key) {
    return *std::find_if(all.begin(), all.end(), [&](const Json& one) { return one.at(key) == name; });
  };
  const Json& chosen = equations.at("chosen");
  const Json range = row_of(metrics.at("ranges"), chosen.at("range"), "name");
  const Json judged = row_of(range.at("methods"), chosen.at("method"), "method");
  const Json printed =
      row_of(row_of(equations.at("ranges"), chosen.at("range"), "name").at("methods"), chosen.at("method"), "method");
  if (!judged.at("nmse").at("free_run").is_number()) return {"there is no free run"};
  if (printed.at("coordinates").size() != 1) return {"several recordings"};
  const std::map<std::string, Series> columns = columns_of(run / "prepared.csv");
  if (!columns.contains("x") || !columns.contains("v")) return {"no prepared rows"};
  const Series& t = columns.at("t");
  const double rate_hz = static_cast<double>(t.size() - 1) / (t.back() - t.front());
  const Json& at = printed.at("coordinates").at(0);
  const double shift = at.at("zero").get<double>() - at.at("prepared_zero").get<double>();
  Series x = columns.at("x");
  for (double& value : x) value -= shift;
  Equation equation(printed, columns, rate_hz);
  const auto sample = [&](double time_s) {
    return static_cast<std::size_t>(std::lround((time_s - t.front()) * rate_hz));
  };
  std::vector<bool> scored(x.size(), false);
  for (const Json& interval : range.at("test_s"))
    for (std::size_t i = sample(interval.at(0)); i <= sample(interval.at(1)) && i < x.size(); ++i) scored[i] = true;
  double error = 0.0, size = 0.0;
  for (const Json& piece : judged.at("free_runs")) {
    const std::size_t first = sample(piece.at("from_s")), last = std::min(sample(piece.at("to_s")), x.size());
    State state{x[first], columns.at("v")[first]};
    for (std::size_t i = 0; i < equation.num_switches(); ++i)
      equation.sides()[i] = equation.switch_value(i, first * 2 * steps_per_sample, state.x, state.v) < 0.0 ? -1.0 : 1.0;
    for (std::size_t i = first; i < last; ++i) {
      if (scored[i]) error += (state.x - x[i]) * (state.x - x[i]), size += x[i] * x[i];
      for (int step = 0; step < steps_per_sample; ++step)
        state = advanced(equation, 2 * (i * steps_per_sample + static_cast<std::size_t>(step)), state,
                         1.0 / (steps_per_sample * rate_hz));
    }
  }
  return {{}, judged.at("nmse").at("free_run"), error / size};
}

void check_printed_equation(const std::filesystem::path& run) {
  const PrintedRun found = printed_run(run);
  if (!found.why_not.empty()) return;
  CAPTURE(run);
  constexpr double of_nmse = 0.02, of_interpolation = 1e-8;
  CHECK(found.reached == Approx(found.claimed).epsilon(of_nmse).margin(of_interpolation));
}

}  // namespace support
