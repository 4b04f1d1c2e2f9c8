#include "fuzz/program.hpp"

#include <fmt/format.h>

#include <cmath>

std::string fuzz::small_record() {
  constexpr double rate_hz = 64.0, slow = 2 * 3.14159265358979 * 2.0, fast = 1.7 * slow;
  std::string text = "t,x,v,a,f\n";
  for (int i = 0; i < 128; ++i) {
    const double t = i / rate_hz;
    const double x = 0.01 * (std::cos(slow * t) + std::sin(fast * t));
    const double v = 0.01 * (fast * std::cos(fast * t) - slow * std::sin(slow * t));
    const double a = -0.01 * (slow * slow * std::cos(slow * t) + fast * fast * std::sin(fast * t));
    text += fmt::format("{},{:.6g},{:.6g},{:.6g},{:.6g}\n", t, x, v, a, a + 300.0 * x + 0.5 * v);
  }
  return text;
}
