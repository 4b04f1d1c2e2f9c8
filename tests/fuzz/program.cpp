#include "fuzz/program.hpp"

#include <fmt/format.h>

#include <cmath>

std::string fuzz::small_record() {
  constexpr double rate_hz = 64.0, omega = 2 * 3.14159265358979 * 3.0;
  std::string text = "t,x,v,a,f\n";
  for (int i = 0; i < 128; ++i) {
    const double t = i / rate_hz, swing = 0.01 * std::exp(-0.5 * t);
    const double x = swing * std::cos(omega * t), v = -swing * omega * std::sin(omega * t), a = -omega * omega * x;
    text += fmt::format("{},{:.6g},{:.6g},{:.6g},{:.6g}\n", t, x, v, a, a + 300.0 * x + 0.5 * v);
  }
  return text;
}
