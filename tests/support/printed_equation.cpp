#include "support/printed_equation.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <vector>

#include "ident/library/expression.hpp"
#include "support/program.hpp"

namespace support {
namespace {

using Json = nlohmann::json;
using Series = std::vector<double>;

Json document(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return stream ? Json::parse(stream, nullptr, false) : Json();
}

/// Calls `take` with each row of a table as a map from column to cell.
template <class Take>
void for_each_row(const std::filesystem::path& file, Take&& take) {
  std::ifstream stream(file);
  std::string line, cell;
  std::vector<std::string> names;
  std::getline(stream, line);
  for (std::istringstream head(line); std::getline(head, cell, ',');) names.push_back(cell);
  std::vector<std::string> cells(names.size());
  while (std::getline(stream, line)) {
    std::istringstream row(line);
    for (std::string& one : cells) one.clear(), std::getline(row, one, ',');
    take(names, cells);
  }
}

using Columns = std::map<std::string, Series>;

double number(const std::string& cell) {
  return cell.empty() ? std::nan("") : std::strtod(cell.c_str(), nullptr);
}

/// prepared.csv by recording, in its order.
std::vector<std::pair<std::string, Columns>> prepared_of(const std::filesystem::path& file) {
  std::vector<std::pair<std::string, Columns>> recordings;
  for_each_row(file, [&](const std::vector<std::string>& names, const std::vector<std::string>& cells) {
    const std::string label = names.front() == "recording" ? cells.front() : "";
    if (recordings.empty() || recordings.back().first != label) recordings.push_back({label, {}});
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] != "recording") recordings.back().second[names[i]].push_back(number(cells[i]));
  });
  return recordings;
}

/// Times of the test rows of a range in predictions.csv, by recording.
std::map<std::string, Series> test_times(const std::filesystem::path& file, const std::string& range) {
  std::map<std::string, Series> times;
  for_each_row(file, [&](const std::vector<std::string>&, const std::vector<std::string>& cells) {
    if (cells[0] == range && cells[2] == "test") times[cells[1]].push_back(number(cells[3]));
  });
  return times;
}

/// A signal at every half step, by a sinc under a Hann window of 2 x 40 samples.
Series at_half_steps(const Series& samples, int steps_per_sample) {
  constexpr int reach = 40;
  const int factor = 2 * steps_per_sample;
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

/// Position and speed, of x or, where the equation is for y'', of y.
struct State {
  double q = 0.0, u = 0.0;
};

/// x'' or y'' of the printed equation at a half step.
class Equation {
 public:
  Equation(const Json& method, const Json& coordinates, const Columns& columns, double rate_hz, int steps_per_sample)
      : absolute_(method.at("target") == "ddy"), half_s_(0.5 / (steps_per_sample * rate_hz)) {
    for (const Json& term : method.at("terms"))
      if (!term.contains("recording") || term.at("recording") == coordinates.at("recording"))
        terms_.push_back({ident::Expression(term.at("name").get<std::string>()), term.at("mean").get<double>()});
    const double lead_s = coordinates.at("lead_s");
    zero_ = coordinates.at("zero").get<double>();
    const auto is_used = [&](const std::string& name) {
      return name == "r" || name == "dr" || name == "ddr" ||
             std::any_of(terms_.begin(), terms_.end(), [&](const Term& term) {
               const auto has = [&](const ident::Expression& one) {
                 const auto& signals = one.signals();
                 return std::find(signals.begin(), signals.end(), name) != signals.end();
               };
               const auto& switches = term.expression.switches();
               return has(term.expression) || std::any_of(switches.begin(), switches.end(), [&](const std::string& g) {
                        return has(ident::Expression(g));
                      });
             });
    };
    for (const auto& [name, values] : columns)
      if (name != "x" && name != "v" && name != "t" && is_used(name))
        inputs_[name] = at_half_steps(values, steps_per_sample);
    if (const auto f = inputs_.find("f"); f != inputs_.end() && lead_s != 0.0) {
      const Series as_recorded = f->second;
      const double half_s = half_s_;
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
  [[nodiscard]] State state(const State& relative, std::size_t half) const {
    return absolute_ ? State{relative.q + zero_ + input("r", half), relative.u + input("dr", half)} : relative;
  }
  [[nodiscard]] double x(std::size_t half, const State& at) const {
    return absolute_ ? at.q - zero_ - input("r", half) : at.q;
  }
  [[nodiscard]] double signal(const std::string& name, std::size_t half, const State& at) const {
    if (name == "x") return x(half, at);
    if (name == "v") return absolute_ ? at.u - input("dr", half) : at.u;
    if (name == "y") return absolute_ ? at.q : at.q + zero_ + input("r", half);
    if (name == "dy") return absolute_ ? at.u : at.u + input("dr", half);
    if (name == "t") return static_cast<double>(half) * half_s_;
    return input(name, half);
  }
  [[nodiscard]] double value(const ident::Expression& expression, std::size_t half, const State& at) const {
    Series values, sides;
    for (const std::string& name : expression.signals()) values.push_back(signal(name, half, at));
    for (const std::string& g : expression.switches())
      sides.push_back(
          sides_[static_cast<std::size_t>(std::find(switches_.begin(), switches_.end(), g) - switches_.begin())]);
    return expression.evaluate(values.data(), sides.data());
  }
  [[nodiscard]] double acceleration(std::size_t half, const State& at) const {
    double sum = 0.0;
    for (const Term& term : terms_) sum += term.coefficient * value(term.expression, half, at);
    return sum;
  }
  [[nodiscard]] double switch_value(std::size_t i, std::size_t half, const State& at) const {
    return value(ident::Expression(switches_[i]), half, at);
  }
  [[nodiscard]] std::size_t num_switches() const { return switches_.size(); }
  [[nodiscard]] bool holds(std::size_t i) const { return switches_[i] == "v" || switches_[i] == "dy"; }
  /// What a motion held on switch `i` has of the base's, of which `name` is r, dr or ddr: a body held against the
  /// ground moves relative to the base, and one held against the base moves with it.
  [[nodiscard]] double held(std::size_t i, const std::string& name, std::size_t half) const {
    if ((switches_[i] == "dy") == absolute_) return 0.0;
    return absolute_ ? input(name, half) : -input(name, half);
  }
  std::vector<double>& sides() { return sides_; }

 private:
  bool absolute_;
  double half_s_, zero_ = 0.0;
  std::vector<Term> terms_;
  std::map<std::string, Series> inputs_;
  std::vector<std::string> switches_;
  Series sides_;
};

/// One step of the classical Runge-Kutta method, `part` of a whole one; inputs are taken where the whole step has them.
State stepped(const Equation& equation, std::size_t half, const State& from, double h_s) {
  const auto rate = [&](const State& at, std::size_t offset) {
    return State{at.u, equation.acceleration(half + offset, at)};
  };
  const auto moved = [&](const State& by, double s) { return State{from.q + s * by.q, from.u + s * by.u}; };
  const State k1 = rate(from, 0), k2 = rate(moved(k1, 0.5 * h_s), 1), k3 = rate(moved(k2, 0.5 * h_s), 1),
              k4 = rate(moved(k3, h_s), 2);
  return {from.q + h_s / 6.0 * (k1.q + 2.0 * k2.q + 2.0 * k3.q + k4.q),
          from.u + h_s / 6.0 * (k1.u + 2.0 * k2.u + 2.0 * k3.u + k4.u)};
}

/// A whole step, to each passage of a switch and on from there.
State advanced(Equation& equation, std::size_t half, State state, double h_s) {
  const auto has_passed = [&](std::size_t i, std::size_t at_half, const State& at) {
    return equation.sides()[i] * equation.switch_value(i, at_half, at) < 0.0;
  };
  double left_s = h_s;
  for (int passages = 0; passages < 16 && left_s > 0.0; ++passages) {
    State next = stepped(equation, half, state, left_s);
    std::optional<std::size_t> passed;
    double within_s = left_s;
    for (std::size_t i = 0; i < equation.num_switches(); ++i) {
      if (!has_passed(i, passed ? half + 1 : half + 2, next)) continue;
      double low = 0.0;
      for (int halving = 0; halving < 40; ++halving) {
        const double middle = 0.5 * (low + within_s);
        (has_passed(i, half + 1, stepped(equation, half, state, middle)) ? within_s : low) = middle;
      }
      next = stepped(equation, half, state, within_s);
      passed = i;
    }
    state = next;
    if (!passed) break;
    left_s -= within_s;
    const std::size_t i = *passed;
    double& side = equation.sides()[i];
    side = -side;
    if (!equation.holds(i)) continue;
    state.u = equation.held(i, "dr", half + 1);
    if ((equation.acceleration(half + 1, state) - equation.held(i, "ddr", half + 1)) * side >= 0.0) continue;
    state = {state.q + left_s * state.u, equation.held(i, "dr", half + 2)};  // it would turn back at once: held
    for (std::size_t other = 0; other < equation.num_switches(); ++other)
      if (other != i && has_passed(other, half + 2, state)) equation.sides()[other] *= -1.0;
    break;
  }
  return state;
}

struct Sums {
  double error = 0.0, size = 0.0;
};

/// The runs of one recording, compared at its test rows.
Sums run_through(const Json& printed, const Json& coordinates, const Json& pieces, const Columns& columns,
                 const Series& test_s, int steps_per_sample, double start_error = 0.0) {
  const Series& t = columns.at("t");
  const double rate_hz = static_cast<double>(t.size() - 1) / (t.back() - t.front());
  const double shift = coordinates.at("zero").get<double>() - coordinates.at("prepared_zero").get<double>();
  Series x = columns.at("x");
  for (double& value : x) value -= shift;
  Equation equation(printed, coordinates, columns, rate_hz, steps_per_sample);
  const auto sample = [&](double time_s) {
    return static_cast<std::size_t>(std::lround((time_s - t.front()) * rate_hz));
  };
  std::vector<bool> scored(x.size(), false);
  for (const double time_s : test_s) scored[std::min(sample(time_s), x.size() - 1)] = true;
  Sums sums;
  for (const Json& piece : pieces) {
    const std::size_t first = sample(piece.at("from_s")), last = std::min(sample(piece.at("to_s")), x.size());
    const auto halves = 2 * static_cast<std::size_t>(steps_per_sample);
    State state = equation.state({x[first] * (1.0 + start_error), columns.at("v")[first]}, first * halves);
    for (std::size_t i = 0; i < equation.num_switches(); ++i)
      equation.sides()[i] = equation.switch_value(i, first * halves, state) < 0.0 ? -1.0 : 1.0;
    for (std::size_t i = first; i < last; ++i) {
      const double error = equation.x(i * halves, state) - x[i];
      if (scored[i]) sums.error += error * error, sums.size += x[i] * x[i];
      for (std::size_t half = i * halves; half < (i + 1) * halves; half += 2)
        state = advanced(equation, half, state, 1.0 / (steps_per_sample * rate_hz));
    }
  }
  return sums;
}

bool agree(double reached, double claimed) {
  // Between the rows of prepared.csv the drive is interpolated: 0.3 % of x where it comes from an acceleration. Two
  // runs that lie so far apart have errors whose rms, not whose squares, differ by no more than that.
  constexpr double of_error = 0.01, of_interpolation = 0.003;
  return std::abs(std::sqrt(reached) - std::sqrt(claimed)) <= of_error * std::sqrt(claimed) + of_interpolation;
}

Json chosen_method(const Json& document, const Json& chosen) {
  const auto row_of = [&](const Json& all, const char* key, const Json& name) {
    return *std::find_if(all.begin(), all.end(), [&](const Json& one) { return one.at(key) == name; });
  };
  return row_of(row_of(document.at("ranges"), "name", chosen.at("range")).at("methods"), "method", chosen.at("method"));
}

/// Lets support::run know of this check.
const bool is_checked_after_runs = [] {
  after_run = check_printed_equations;
  return true;
}();

}  // namespace

PrintedRun printed_run(const std::filesystem::path& run) {
  const Json equations = document(run / "equation.json"), metrics = document(run / "metrics.json");
  if (!equations.contains("chosen") || !equations.at("chosen").is_object()) return {"no equation was chosen"};
  const Json& chosen = equations.at("chosen");
  const Json judged = chosen_method(metrics, chosen), printed = chosen_method(equations, chosen);
  if (!judged.at("nmse").at("free_run").is_number()) return {"there is no free run"};
  const auto recordings = prepared_of(run / "prepared.csv");
  const auto test_s = test_times(run / "predictions.csv", chosen.at("range"));
  if (recordings.empty() || test_s.empty()) return {"the run has no tables"};
  const auto own_of = [&](const std::string& name) {
    return std::find_if(recordings.begin(), recordings.end(),
                        [&](const auto& one) { return recordings.size() == 1 || one.first == name; });
  };
  for (const Json& coordinates : printed.at("coordinates"))
    if (const std::string name = coordinates.at("recording");
        own_of(name) == recordings.end() || !test_s.contains(name))
      return {"a recording whose name is quoted"};
  const auto reached = [&](int steps_per_sample, double start_error) {
    Sums sums;
    for (const Json& coordinates : printed.at("coordinates")) {
      const std::string name = coordinates.at("recording");
      const auto own = own_of(name);
      Json pieces = Json::array();
      for (const Json& piece : judged.at("free_runs"))
        if (piece.at("recording") == own - recordings.begin() + 1) pieces.push_back(piece);
      const Sums one =
          run_through(printed, coordinates, pieces, own->second, test_s.at(name), steps_per_sample, start_error);
      sums.error += one.error, sums.size += one.size;
    }
    return sums.error / sums.size;
  };
  PrintedRun result{{}, judged.at("nmse").at("free_run"), reached(8, 0.0)};
  if (agree(result.reached, result.claimed)) return result;
  result.reached = reached(32, 0.0);  // each is four times the work
  constexpr double follows_in_part = 0.1, start_error = 1e-4;
  if (!agree(result.reached, result.claimed) && result.claimed > follows_in_part &&
      !agree(reached(32, start_error), result.reached))
    return {"it does not follow x, and where it goes hangs on the last digits"};
  return result;
}

double printed_rms(const std::filesystem::path& run, double share) {
  const Json equations = document(run / "equation.json");
  const Json printed = chosen_method(equations, equations.at("chosen"));
  const Columns columns = prepared_of(run / "prepared.csv").at(0).second;
  Series times;
  const Series& t = columns.at("t");
  for (std::size_t i = 0; i < t.size(); ++i)
    if (columns.at("excluded")[i] == 0.0 && static_cast<double>(i) >= (1.0 - share) * static_cast<double>(t.size()))
      times.push_back(t[i]);
  const Json pieces = Json::array({{{"from_s", times.front()}, {"to_s", times.back()}}});
  const Sums sums = run_through(printed, printed.at("coordinates").at(0), pieces, columns, times, 8);
  return std::sqrt(sums.error / static_cast<double>(times.size()));
}

void check_printed_equation(const std::filesystem::path& run) {
  const PrintedRun found = printed_run(run);
  if (!found.why_not.empty()) return;
  CAPTURE(run, found.claimed, found.reached);
  CHECK(agree(found.reached, found.claimed));
}

void check_printed_equations(const std::filesystem::path& folder) {
  static std::set<std::pair<std::string, std::filesystem::file_time_type>> checked;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, ignored)) {
    if (entry.path().filename() != "manifest.json" ||
        !std::filesystem::exists(entry.path().parent_path() / "metrics.json"))
      continue;
    if (checked.insert({entry.path().string(), entry.last_write_time()}).second)
      check_printed_equation(entry.path().parent_path());
  }
}

}  // namespace support
