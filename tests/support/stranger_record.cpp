#include "support/stranger_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace support {
namespace {

constexpr double pi = std::numbers::pi;

/// How a file names its columns, and how many of its units make one of SI.
struct Header {
  const char* text;
  double per_metre, per_newton;
};
constexpr std::array headers{
    Header{"time_s,displacement_mm,force_N", 1e3, 1.0},        Header{"t,x,f", 1.0, 1.0},
    Header{"Time [s],Position [mm],Load [N]", 1e3, 1.0},       Header{"Zeit [s],Weg [mm],Kraft [N]", 1e3, 1.0},
    Header{"Temps (s),Deplacement (m),Force (kN)", 1.0, 1e-3}, Header{"time (s),laser (um),load cell (N)", 1e6, 1.0},
    Header{"tiempo_s,desplazamiento_cm,fuerza_N", 1e2, 1.0}};

struct Tone {
  double hz, phase, share;
};
struct Drive {
  std::vector<Tone> tones;  // none: a sweep there and back
  double from_hz = 0.0, to_hz = 0.0, turn_s = 0.0;
  [[nodiscard]] double at(double t) const {
    if (tones.empty()) {
      const double u = std::fmod(t, 2.0 * turn_s), slope = (to_hz - from_hz) / turn_s;
      const double up = std::min(u, turn_s), down = std::max(0.0, u - turn_s);
      return std::sin(2.0 * pi * (from_hz * up + 0.5 * slope * up * up + to_hz * down - 0.5 * slope * down * down));
    }
    double sum = 0.0;
    for (const Tone& tone : tones) sum += tone.share * std::sin(2.0 * pi * tone.hz * t + tone.phase);
    return sum;
  }
};

class Oscillator {
 public:
  double k = 0.0, c = 0.0, k3 = 0.0, force = 0.0;  // per mass
  Drive drive;
  [[nodiscard]] std::vector<double> displacement(double rate_hz, std::size_t count) const {
    constexpr int steps = 8;  // of fourth order, at 400 to the shortest period: errors below 1e-7
    const double h = 1.0 / (rate_hz * steps);
    std::vector<double> result;
    double x = 0.0, v = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      result.push_back(x);
      for (int s = 0; s < steps; ++s) {
        const double t = static_cast<double>(i) / rate_hz + s * h;
        const auto a = [&](double time, double xx, double vv) {
          return force * drive.at(time) - c * vv - k * xx - k3 * xx * xx * xx;
        };
        const double a1 = a(t, x, v), v2 = v + 0.5 * h * a1, a2 = a(t + 0.5 * h, x + 0.5 * h * v, v2);
        const double v3 = v + 0.5 * h * a2, a3 = a(t + 0.5 * h, x + 0.5 * h * v2, v3);
        const double v4 = v + h * a3, a4 = a(t + h, x + h * v3, v4);
        x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
      }
    }
    return result;
  }
};

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

StrangerRecord stranger_record(std::uint32_t seed, double noise_from, double noise_to) {
  std::mt19937 random(seed);
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(random()) / 4294967296.0;
  };
  const auto pick = [&](std::size_t count) { return static_cast<std::size_t>(random() % count); };
  Oscillator oscillator;
  oscillator.k = uniform(20.0, 100.0);
  const double omega = std::sqrt(oscillator.k), natural_hz = omega / (2.0 * pi), ratio = uniform(0.01, 0.1);
  oscillator.c = 2.0 * ratio * omega;
  const double mass_kg = uniform(0.5, 5.0), amplitude_m = uniform(0.002, 0.05), cubic_share = uniform(0.05, 0.5);
  if (pick(2) == 0) {
    oscillator.drive.from_hz = 0.4 * natural_hz;
    oscillator.drive.to_hz = 2.0 * natural_hz;
    oscillator.drive.turn_s = 30.0;
  } else {
    for (int i = 0; i < 5; ++i)
      oscillator.drive.tones.push_back({natural_hz * uniform(0.5, 1.8), uniform(0.0, 2.0 * pi), uniform(0.3, 1.0)});
  }
  constexpr std::array rates{50.0, 100.0, 200.0, 256.0, 1000.0};
  const double rate_hz = rates[pick(rates.size())];
  const auto count = static_cast<std::size_t>(120.0 * rate_hz);
  // The linear oscillator's size sets the force that makes the wanted amplitude; the cubic share is of that amplitude.
  oscillator.force = 1.0;
  const std::vector<double> linear = oscillator.displacement(rate_hz, count);
  double largest = 0.0;
  for (const double x : linear) largest = std::max(largest, std::abs(x));
  oscillator.force = amplitude_m / largest;
  oscillator.k3 = oscillator.k * cubic_share / (1.0 - cubic_share) / (amplitude_m * amplitude_m);
  const std::vector<double> x = oscillator.displacement(rate_hz, count);
  const double noise = uniform(noise_from, noise_to), noise_m = noise * rms(x);
  std::normal_distribution<double> white;
  const Header& header = headers[pick(headers.size())];
  StrangerRecord record;
  const std::string names = header.text;
  record.csv = names + "\n";
  record.csv_unforced = names.substr(0, names.rfind(',')) + "\n";
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    const std::string row = fmt::format("{:.6f},{:.7g}", t, (x[i] + noise_m * white(random)) * header.per_metre);
    record.csv +=
        fmt::format("{},{:.7g}\n", row, oscillator.force * mass_kg * oscillator.drive.at(t) * header.per_newton);
    record.csv_unforced += row + "\n";
  }
  record.truth = {{"x", -oscillator.k}, {"v", -oscillator.c}, {"x^3", -oscillator.k3}, {"f", 1.0 / mass_kg}};
  record.drawn = fmt::format(
      "seed={} k={:.4g} damping={:.3g} cubic={:.3g} amplitude_m={:.3g} mass_kg={:.3g} rate_hz={} "
      "drive={} noise={:.3g} header={}",
      seed, oscillator.k, ratio, cubic_share, amplitude_m, mass_kg, rate_hz,
      oscillator.drive.tones.empty() ? "sweep" : "tones", noise, names);
  return record;
}

}  // namespace support
