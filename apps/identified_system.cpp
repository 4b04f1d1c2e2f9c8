#include "apps/identified_system.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "ident/library/expression.hpp"

namespace apps {
namespace {

using Eigen::Index;

/// A term with the places of its signals among (t, f, states).
struct PlacedTerm {
  const ident::Expression* expression;
  std::vector<std::size_t> places;
  double coefficient;
};

struct PlacedRow {
  std::size_t state;
  bool while_positive = true, while_negative = true;  ///< signs of v for which it holds
  std::vector<PlacedTerm> terms;
};

class Equations {
 public:
  Equations(const ident::CandidateLibrary& library, const std::vector<IdentifiedRow>& rows,
            const std::vector<std::string>& states, std::function<double(double)> forcing)
      : forcing_(std::move(forcing)), num_states_(states.size()), values_(states.size() + 2) {
    std::vector<std::string> names{"t", "f"};
    names.insert(names.end(), states.begin(), states.end());
    for (const IdentifiedRow& row : rows) {
      PlacedRow placed{static_cast<std::size_t>(row.row - 1), true, true, {}};
      if (!row.where.empty()) {
        const ident::Expression condition(row.where, {"v"});
        const double up = 1.0, down = -1.0;
        placed.while_positive = condition.evaluate(&up, nullptr) != 0.0;
        placed.while_negative = condition.evaluate(&down, nullptr) != 0.0;
        switches_ = true;
      }
      for (std::size_t i = 0; i < row.terms.size(); ++i) {
        const ident::Expression& expression = library.terms[static_cast<std::size_t>(row.terms[i])].expression;
        PlacedTerm term{&expression, {}, row.mean(static_cast<Index>(i))};
        for (const std::string& signal : expression.signals()) {
          const auto place = std::find(names.begin(), names.end(), signal);
          if (place == names.end()) throw std::invalid_argument("identified_system: " + signal + " has no equation");
          term.places.push_back(static_cast<std::size_t>(place - names.begin()));
        }
        for (const std::string& argument : expression.switches()) {
          if (argument != "v") throw std::invalid_argument("identified_system: sgn(" + argument + ") is not of v");
          switches_ = true;
        }
        placed.terms.push_back(std::move(term));
      }
      rows_.push_back(std::move(placed));
    }
  }

  [[nodiscard]] bool switches() const { return switches_; }

  /// Rates with sgn(v) = sign, whatever v itself does inside a step.
  void rates(double t, const double* y, double sign, double* dydt) const {
    values_[0] = t;
    values_[1] = forcing_(t);
    std::copy(y, y + num_states_, values_.begin() + 2);
    std::fill(dydt, dydt + num_states_, 0.0);
    for (const PlacedRow& row : rows_) {
      if (!(sign > 0.0 ? row.while_positive : row.while_negative)) continue;
      for (const PlacedTerm& term : row.terms) {
        arguments_.clear();
        for (const std::size_t place : term.places) arguments_.push_back(values_[place]);
        dydt[row.state] += term.coefficient * term.expression->evaluate(arguments_.data(), &sign);
      }
    }
  }
  [[nodiscard]] double acceleration(double t, const double* y, double sign) const {
    rates_.resize(num_states_);
    rates(t, y, sign, rates_.data());
    return rates_[1];
  }

 private:
  std::function<double(double)> forcing_;
  std::size_t num_states_;
  bool switches_ = false;
  std::vector<PlacedRow> rows_;
  mutable std::vector<double> values_, arguments_, rates_;  ///< scratch of one evaluation
};

}  // namespace

sim::System identified_system(const ident::CandidateLibrary& library, const std::vector<IdentifiedRow>& rows,
                              std::vector<std::string> states, std::function<double(double)> forcing) {
  const auto equations = std::make_shared<const Equations>(library, rows, states, forcing);
  sim::System system;
  system.name = "identified equations";
  system.states = std::move(states);
  system.forcing = std::move(forcing);
  // Mode: the sign of v, 0 for stick.
  system.rhs = [equations](double t, const double* y, int mode, double* dydt) {
    equations->rates(t, y, mode < 0 ? -1.0 : 1.0, dydt);
    if (mode == 0) dydt[0] = dydt[1] = 0.0;
  };
  if (!equations->switches()) {
    system.next_mode = [](double, double*, int, int) { return 1; };
    return system;
  }
  system.num_switches = 2;
  system.switching = [equations](double t, const double* y, int mode, double* values) {
    values[0] = mode == 0 ? equations->acceleration(t, y, 1.0) : y[1];
    values[1] = mode == 0 ? equations->acceleration(t, y, -1.0) : 1.0;
  };
  system.next_mode = [equations](double t, double* y, int, int which) {
    if (which < 0 && y[1] != 0.0) return y[1] > 0.0 ? 1 : -1;
    y[1] = 0.0;
    double up = equations->acceleration(t, y, 1.0), down = equations->acceleration(t, y, -1.0);
    if (up == 0.0 && down == 0.0) {  // at rest while the force passes zero
      up = equations->acceleration(t + 1e-6, y, 1.0);
      down = equations->acceleration(t + 1e-6, y, -1.0);
    }
    return up > 0.0 ? 1 : down < 0.0 ? -1 : 0;
  };
  return system;
}

}  // namespace apps
