// What expressions are worth: as before the tree, as a second computation, in blocks and from several threads.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <thread>

#include "ident/library/expression.hpp"
#include "ident/library/muparser_values.hpp"
#include "support/motion.hpp"
#include "support/random.hpp"
#include "support/random_tree.hpp"

namespace test_library_expression_values {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

const std::vector<std::string> names{"x", "v", "ddr", "z"};

dsp::Motion recorded_motion() {
  return support::motion_of(64.0, {{"x", Eigen::Vector3d(0.7, -1.3, 0.013)},
                                   {"v", Eigen::Vector3d(-0.31, 2.1, -0.0027)},
                                   {"ddr", Eigen::Vector3d(0.0113, 0.5, -9.81)},
                                   {"z", Eigen::Vector3d(-2.3, 0.77, 1.9)}});
}

bool same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

/// A second computation, node by node without blocks or registers; `values` of x, v, ddr.
double value_of(const ident::Node& node, const std::array<double, 3>& values) {
  using ident::Operation;
  if (node.operation == Operation::number) return node.value;
  if (node.operation == Operation::signal) return values[node.name == "x" ? 0 : node.name == "v" ? 1 : 2];
  const double g = value_of(*node.left, values), h = node.right ? value_of(*node.right, values) : 0.0;
  if (node.operation == Operation::call) {
    double (*const functions[])(double) = {std::fabs, ident::sign, std::sin,  std::cos,
                                           std::exp,  std::log,    std::sqrt, std::tanh};
    return functions[static_cast<int>(node.function)](g);
  }
  if (node.operation == Operation::power) {
    const bool product = node.left->operation == Operation::signal && node.right->operation == Operation::number;
    if (product && h == 2.0) return g * g;
    if (product && h == 3.0) return g * g * g;
    return std::pow(g, h);
  }
  const double results[] = {-g,
                            g + h,
                            g - h,
                            g * h,
                            g / h,
                            0.0,
                            0.0,
                            double(g < h),
                            double(g <= h),
                            double(g > h),
                            double(g >= h),
                            double(g == h),
                            double(g != h),
                            double(g != 0.0 && h != 0.0),
                            double(g != 0.0 || h != 0.0)};
  return results[static_cast<int>(node.operation) - static_cast<int>(Operation::negate)];
}

}  // namespace

TEST_CASE("terms have the values that muParser gave, bit for bit", "[ident][expression]") {
  const auto motion = recorded_motion();
  const auto values = [&](const char* text) { return ident::Expression(text, names).evaluate(motion); };
  for (const recorded::Value& expected : recorded::exact) {
    CAPTURE(expected.text);
    const VectorXd found = values(expected.text);
    for (Index i = 0; i < 3; ++i) CHECK(same(found(i), expected.at[i]));
  }
  for (const recorded::Value& expected : recorded::folded) {
    CAPTURE(expected.text);
    const VectorXd found = values(expected.text);
    for (Index i = 0; i < 3; ++i) CHECK(found(i) == Approx(expected.at[i]).epsilon(2e-15));  // a few roundings
  }
}

TEST_CASE("random expressions are worth what a second computation says, in columns and at points",
          "[ident][expression][property]") {
  support::RandomTree random(1, support::RandomTree::Kind::any);
  constexpr Index num_rows = 1100;  // two blocks and a part
  const VectorXd x = support::gaussian(num_rows, 1, 2), v = support::gaussian(num_rows, 1, 3),
                 ddr = support::gaussian(num_rows, 1, 4);
  const auto motion = support::motion_of(64.0, {{"x", x}, {"v", v}, {"ddr", ddr}});
  int wrong = 0, finite = 0;
  for (int k = 0; k < 400; ++k) {
    const auto tree = random(k % 6);
    const ident::Expression expression(ident::print_tree(*tree, ident::Notation::text), names);
    const VectorXd column = expression.evaluate(motion);
    for (const Index i : {Index{0}, Index{511}, Index{512}, num_rows - 1}) {
      const double expected = value_of(*tree, {x(i), v(i), ddr(i)});
      std::vector<double> values, signs;
      for (const std::string& name : expression.signals()) values.push_back(motion.at(name)(i));
      for (const std::string& text : expression.switches())
        signs.push_back(ident::sign(ident::Expression(text, names).evaluate(motion)(i)));
      finite += std::isfinite(expected);
      if (same(column(i), expected) && same(expression.evaluate(values.data(), signs.data()), expected)) continue;
      ++wrong;
      WARN(expression.text());
    }
  }
  CHECK(wrong == 0);
  CHECK(finite > 800);  // half of them; the others test that what is not finite stays so
}

TEST_CASE("threads share an expression", "[ident][expression]") {
  const auto motion =
      support::motion_of(64.0, {{"x", support::gaussian(5000, 1, 5)}, {"v", support::gaussian(5000, 1, 6)}});
  const ident::Expression expression("sgn(v)*x^2 + exp(-x^2)*(v - 1)^2", names);
  const VectorXd alone = expression.evaluate(motion);
  std::array<int, 4> different{};
  std::vector<std::thread> threads;
  for (int& count : different)
    threads.emplace_back([&] {
      for (int k = 0; k < 20; ++k) {
        count += expression.evaluate(motion) != alone;
        const double values[] = {motion.at("v")(k), motion.at("x")(k)}, sign = ident::sign(values[0]);
        count += !(std::abs(expression.evaluate(values, &sign) - expression.evaluate(motion)(k)) == 0.0);
      }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(different == std::array<int, 4>{});
}

}  // namespace test_library_expression_values
