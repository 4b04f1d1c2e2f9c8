#include "ident/state_space/tape.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "ident/library/expression_parser.hpp"

using ident::state_space::side_by_side;
using ident::state_space::Slopes;
using ident::state_space::Tape;

namespace {

const std::vector<std::string> signals{"x", "v", "f", "t"};

ident::Tree tree(const std::string& text) {
  return ident::parse_expression(
      text, [](std::string_view) { return true; }, "");
}

/// Value and derivatives by x, v and time at one point, f passing with rate 0.7 and t with 1; on the sides that hold
/// there.
std::vector<double> at(const std::string& text, double x, double v, double f, double t) {
  const Tape tape({tree(text)}, signals, 2);
  std::vector<double> registers = tape.registers<1>(), sides(static_cast<std::size_t>(tape.num_switches()), 1.0);
  const int stride = tape.stride();
  const auto run = [&] {
    registers[0] = x, registers[static_cast<std::size_t>(stride)] = v;
    registers[static_cast<std::size_t>(2 * stride)] = f, registers[static_cast<std::size_t>(2 * stride + 3)] = 0.7;
    registers[static_cast<std::size_t>(3 * stride)] = t, registers[static_cast<std::size_t>(3 * stride + 3)] = 1.0;
    tape.run<1>(registers.data(), sides.data(), Slopes::by_states_and_time);
  };
  run();
  for (std::size_t i = 0; i < sides.size(); ++i)
    sides[i] = registers[static_cast<std::size_t>(tape.switch_value(static_cast<int>(i)) * stride)] < 0.0 ? -1.0 : 1.0;
  run();
  const auto first = registers.begin() + tape.result(0) * stride;
  return {first, first + stride};
}

}  // namespace

TEST_CASE("values and derivatives of a tape are those of the function, by differences", "[ident][state_space]") {
  const std::string text = GENERATE("x^3", "x^2*v - v/x", "sin(x)*cos(v)", "abs(v)*v", "sgn(x - v)*v^2", "exp(-x^2)*f",
                                    "log(x)*sqrt(v + 2)", "tanh(3*v)*t", "x^1.5", "x^-2*v", "(v + 2)^x",
                                    "(x > 0.1)*x + (v < 0)*2*v", "((x > 0) || (v > 0))*f*x", "-x^2*-v");
  const double x = 0.37, v = -0.81, f = 1.3, t = 2.1, d = 1e-6;
  const std::vector<double> exact = at(text, x, v, f, t);
  const auto value = [&](double dx, double dv, double dt) {
    return at(text, x + dx, v + dv, f + 0.7 * dt, t + dt).front();
  };
  CAPTURE(text);
  // Central differences err by d^2 times a third derivative, some 1e-11, and by rounding, 1e-16 / d.
  CHECK(exact[1] == Approx((value(d, 0, 0) - value(-d, 0, 0)) / (2 * d)).margin(1e-8));
  CHECK(exact[2] == Approx((value(0, d, 0) - value(0, -d, 0)) / (2 * d)).margin(1e-8));
  CHECK(exact[3] == Approx((value(0, 0, d) - value(0, 0, -d)) / (2 * d)).margin(1e-8));
}

TEST_CASE("points side by side have the bits of points one by one", "[ident][state_space]") {
  const Tape tape({tree("x^3*v + abs(v)*f"), tree("sin(x)/v")}, signals, 2);
  std::vector<double> many = tape.registers<side_by_side>(), one = tape.registers<1>();
  const std::vector<double> sides(side_by_side, -1.0);
  const auto value = [](int signal, int lane) { return std::cos(3.0 * signal + 0.4 * lane); };
  for (int s = 0; s < 4; ++s)
    for (int l = 0; l < side_by_side; ++l)
      many[static_cast<std::size_t>(s * tape.stride() * side_by_side + l)] = value(s, l);
  tape.run<side_by_side>(many.data(), sides.data(), Slopes::by_states);
  for (int l = 0; l < side_by_side; ++l) {
    for (int s = 0; s < 4; ++s) one[static_cast<std::size_t>(s * tape.stride())] = value(s, l);
    tape.run<1>(one.data(), sides.data(), Slopes::by_states);
    for (int i = 0; i < 2; ++i)
      for (int d = 0; d < 3; ++d)
        CHECK(many[static_cast<std::size_t>((tape.result(i) * tape.stride() + d) * side_by_side + l)] ==
              one[static_cast<std::size_t>(tape.result(i) * tape.stride() + d)]);
  }
}
