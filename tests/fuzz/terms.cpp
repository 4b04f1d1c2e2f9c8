// A candidate term or condition a line: compiled, evaluated in each way, and all of them as a library.
#include <array>
#include <cmath>
#include <sstream>

#include "dsp/values/fault.hpp"
#include "fuzz/harness.hpp"
#include "ident/library/expression.hpp"
#include "ident/library/library.hpp"
#include "support/motion.hpp"

namespace {

// Names that are prefixes of each other and of functions.
dsp::Motion motion() {
  constexpr Eigen::Index size = 20;
  std::vector<std::pair<std::string, Eigen::VectorXd>> signals;
  double phase = 0.0;
  for (const char* name : {"t", "x", "x1", "x10", "v", "a", "s", "z", "f", "ddr"}) {
    signals.emplace_back(name, Eigen::VectorXd(size));
    for (Eigen::Index i = 0; i < size; ++i)
      signals.back().second[i] = i == 3 ? 0.0 : std::sin(phase + 0.7 * static_cast<double>(i));
    phase += 1.0;
  }
  return support::motion_of(10.0, signals);
}

void evaluate(const std::string& text, const dsp::Motion& motion, const std::vector<std::string>& names) {
  const ident::Expression expression(text, names);
  (void)expression.evaluate(motion);
  (void)ident::rows_where(expression, motion);
  const std::vector<double> values(expression.signals().size(), -0.5), signs(expression.switches().size(), 1.0);
  (void)expression.evaluate(values.data(), signs.data());
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  return {"z\nx^3*v\nx*abs(x)*v\nsgn(v)",
          "abs(v) > 0.004 && t < 10",
          "-f+sin(3*x)*2^v",
          "z/(x10-x1)+exp(-t)*sqrt(abs(z))-log(f+2)",
          "v*cos(2*t)\n-1e-3*ddr\n2*tanh(1e2*v)\nsgn(x-2*v)*(z+0)",
          "2500*x + x^3\n-2^2*x^3\n(x==v)||t>=1e300"};
}

void fuzz::run(const std::string& input) {
  const dsp::Motion signals = motion();
  std::vector<std::string> names, terms;
  for (const auto& signal : signals.signals) names.push_back(signal.name);
  std::istringstream lines(input);
  for (std::string line; std::getline(lines, line);) {
    terms.push_back(line);
    try {
      evaluate(line, signals, names);
    } catch (const dsp::Fault&) {  // one term of several: the others are looked at all the same
    }
  }
  for (const ident::Term& term : ident::make_library({.order = 2, .terms = terms}, "a", signals).terms) {
    (void)term.expression.evaluate(signals);
    (void)ident::coefficient_unit("m/s^2", term.unit);
  }
}
