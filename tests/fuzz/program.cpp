#include "fuzz/program.hpp"

#include <fmt/format.h>

#include <cmath>

std::string fuzz::small_record() {
  constexpr double rate_hz = 64.0, frequency_hz = 3.0, pi = 3.14159265358979;
  std::string text = "t,x,v,a\n";
  for (int i = 0; i < 128; ++i) {
    const double t = i / rate_hz, omega = 2 * pi * frequency_hz, swing = 0.01 * std::exp(-0.5 * t);
    text += fmt::format("{},{:.6g},{:.6g},{:.6g}\n", t, swing * std::cos(omega * t),
                        -swing * omega * std::sin(omega * t), -swing * omega * omega * std::cos(omega * t));
  }
  return text;
}
