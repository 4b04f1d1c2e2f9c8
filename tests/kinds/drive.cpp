#include "kinds/drive.hpp"

#include <algorithm>
#include <complex>

namespace kinds {
namespace {

constexpr double TURN = 2.0 * std::numbers::pi;

void add_line(Signal& signal, double hz, double amplitude, double phase, double step_s) {
  const double omega = TURN * hz;
  const std::complex<double> turn = std::polar(1.0, omega * step_s);
  std::complex<double> line = std::polar(amplitude, phase);
  for (std::size_t i = 0; i < signal.value.size(); ++i, line *= turn) {
    signal.value[i] += line.real();
    signal.twice_integrated[i] -= line.real() / (omega * omega);
  }
}

Signal lines(RandomStream& random, int number, double low, double high, double step_s, std::size_t count) {
  Signal signal{std::vector<double>(count), std::vector<double>(count)};
  for (int i = 0; i < number; ++i) {
    const double hz = low + (high - low) * (i + random.uniform()) / number;
    const double rayleigh = std::sqrt(-2.0 * std::log(1.0 - random.uniform()));
    add_line(signal, hz, rayleigh / std::sqrt(number), random.uniform(0.0, TURN), step_s);
  }
  return signal;
}

Signal sweep(RandomStream& random, double low, double high, double step_s, std::size_t count) {
  Signal signal{std::vector<double>(count), {}};
  const bool logarithmic = random.uniform() < 0.5, down = random.uniform() < 0.3;
  const double from = down ? high : low, to = down ? low : high;
  double phase = random.uniform(0.0, TURN);
  for (std::size_t i = 0; i < count; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(count);
    signal.value[i] = std::sqrt(2.0) * std::sin(phase) * std::min(1.0, 20.0 * std::min(part, 1.0 - part));
    phase += TURN * step_s * (logarithmic ? from * std::pow(to / from, part) : from + (to - from) * part);
  }
  return signal;
}

Signal steps(RandomStream& random, double low, double high, double step_s, std::size_t count) {
  Signal signal{std::vector<double>(count), {}};
  const auto stages = static_cast<std::size_t>(random.uniform(5.0, 11.0));
  double phase = random.uniform(0.0, TURN), amplitude = 0.0, hz = low, wanted = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % (count / stages + 1) == 0) {
      hz = random.log_uniform(low, high);
      wanted = random.log_uniform(0.5, 2.0);
    }
    amplitude += (wanted - amplitude) * std::min(1.0, hz * step_s);  // over a period
    signal.value[i] = amplitude * std::sqrt(2.0) * std::sin(phase);
    phase += TURN * step_s * hz;
  }
  return signal;
}

}  // namespace

Signal draw_signal(const std::string& kind, RandomStream& random, double low, double high, double step_s,
                   std::size_t count) {
  if (kind == "noise") return lines(random, 150, low, high, step_s, count);
  if (kind == "multisine") {
    const int number = static_cast<int>(random.uniform(3.0, 9.0));
    return lines(random, number, low, high, step_s, count);
  }
  return kind == "sweep" ? sweep(random, low, high, step_s, count) : steps(random, low, high, step_s, count);
}

std::vector<double> draw_pushes(RandomStream& random, double mean_s, double step_s, std::size_t count) {
  std::vector<double> pushes(count);
  const double end = static_cast<double>(count) * step_s;
  for (double at = mean_s * random.uniform(); at < end; at -= mean_s * std::log(1.0 - random.uniform())) {
    const double size = random.normal(), length = mean_s * random.log_uniform(0.2 / 15.0, 0.2);
    const auto first = static_cast<std::size_t>(at / step_s);
    const auto width = static_cast<std::size_t>(length / step_s) + 2;
    for (std::size_t i = 0; i < width && first + i < count; ++i)
      pushes[first + i] += size * std::sin(std::numbers::pi * static_cast<double>(i) / static_cast<double>(width));
  }
  return pushes;
}

}  // namespace kinds
