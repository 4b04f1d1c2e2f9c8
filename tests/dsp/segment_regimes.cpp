#include "dsp/segment_regimes.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "support/motion.hpp"
#include "support/signals.hpp"

namespace test_segment_regimes {

using dsp::Regime;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 64.0, two_pi = 2.0 * std::numbers::pi;

struct Phase {
  double duration_s, from_m, to_m;  ///< amplitude; 0: locked
  Regime regime;
};

struct Programme {
  dsp::Motion motion;
  std::vector<Regime> truth;
};

// A sine whose amplitude drifts within each phase and jumps between them, within a second, against a base whose
// displacement it opposes where low and follows where high; from `slower_from_s` on a tenth slower.
Programme programme(const std::vector<Phase>& phases, double frequency_hz, double noise_m, unsigned seed,
                    double base_m = 0.005, double slower_from_s = INFINITY) {
  std::vector<double> amplitude;
  Programme result;
  for (const Phase& phase : phases) {
    const auto count = static_cast<Index>(phase.duration_s * rate_hz);
    const double sign = phase.regime == Regime::high ? 1.0 : -1.0;
    for (Index i = 0; i < count; ++i) {
      const double fraction = static_cast<double>(i) / static_cast<double>(count);
      amplitude.push_back(sign * (phase.from_m + (phase.to_m - phase.from_m) * fraction));
      result.truth.push_back(phase.regime);
    }
  }
  const auto n = static_cast<Index>(amplitude.size()), half = static_cast<Index>(rate_hz / 2);
  VectorXd x(n), v(n), r(n);
  double angle = 0.0;
  for (Index i = 0; i < n; ++i) {
    const double here_hz = static_cast<double>(i) / rate_hz < slower_from_s ? frequency_hz : 0.9 * frequency_hz;
    double mean = 0.0;
    const Index from = std::max<Index>(0, i - half), to = std::min(n, i + half);
    for (Index k = from; k < to; ++k) mean += amplitude[static_cast<std::size_t>(k)] / static_cast<double>(to - from);
    x(i) = mean * std::sin(angle);
    v(i) = mean * two_pi * here_hz * std::cos(angle);
    r(i) = base_m * std::sin(angle);
    angle += two_pi * here_hz / rate_hz;
  }
  x += support::gaussian(n, seed, noise_m);
  v += support::gaussian(n, seed + 1, noise_m * two_pi * 4.0);
  r += support::gaussian(n, seed + 2, noise_m);
  result.motion = support::motion_of(rate_hz, {{"x", x}, {"v", v}, {"r", r}});
  return result;
}

dsp::Signal& signal(dsp::Motion& motion, const char* name) {
  return *std::find_if(motion.signals.begin(), motion.signals.end(), [&](auto& one) { return one.name == name; });
}

std::vector<Regime> labels(const dsp::Segmentation& found) {
  std::vector<Regime> all;
  for (const dsp::Segment& segment : found.segments)
    all.insert(all.end(), static_cast<std::size_t>(segment.last - segment.first), segment.regime);
  return all;
}

double agreement(const Programme& p, const dsp::Segmentation& found) {
  const auto all = labels(found);
  REQUIRE(all.size() == p.truth.size());
  double same = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) same += all[i] == p.truth[i];
  return same / static_cast<double>(all.size());
}

int num_branches(const dsp::Motion& motion) {
  const auto found = dsp::segment_regimes(motion).segments;
  const auto has = [&](Regime regime) {
    return std::any_of(found.begin(), found.end(), [&](const auto& segment) { return segment.regime == regime; });
  };
  return (has(Regime::low) ? 1 : 0) + (has(Regime::high) ? 1 : 0);
}

}  // namespace

TEST_CASE("segments cover every sample once, in order", "[dsp][segment_regimes]") {
  const auto p = programme(
      {{60, 0.007, 0.009, Regime::low}, {60, 0.026, 0.012, Regime::high}, {30, 0, 0, Regime::stick}}, 1.5, 1e-5, 1);
  const auto found = dsp::segment_regimes(p.motion);
  Index next = 0;
  for (const dsp::Segment& segment : found.segments) {
    CHECK(segment.first == next);
    CHECK(segment.last > segment.first);
    next = segment.last;
  }
  CHECK(next == p.motion.num_samples());
}

TEST_CASE("branches of programmes of any size and frequency, with jumps and without", "[dsp][segment_regimes]") {
  // Amplitudes from a third of a millimetre to decimetres.
  for (const double size : {0.05, 1.0, 12.0})
    for (const double frequency_hz : {0.8, 1.6, 4.0}) {
      INFO("size " << size << " frequency " << frequency_hz);
      const double noise = 3e-6 * size, base = 0.005 * size;
      const auto jump = programme({{80, 0.007 * size, 0.012 * size, Regime::low},
                                   {80, 0.026 * size, 0.012 * size, Regime::high},
                                   {40, 0, 0, Regime::stick}},
                                  frequency_hz, noise, 2, base);
      CHECK(agreement(jump, dsp::segment_regimes(jump.motion)) >= 0.98);  // 200 s: the second of blur at each boundary
      const auto twice = programme({{60, 0.007 * size, 0.009 * size, Regime::low},
                                    {60, 0.030 * size, 0.028 * size, Regime::high},
                                    {60, 0.013 * size, 0.010 * size, Regime::low},
                                    {60, 0.025 * size, 0.016 * size, Regime::high}},
                                   frequency_hz, noise, 3, base);
      CHECK(agreement(twice, dsp::segment_regimes(twice.motion)) >= 0.995);
      const auto calm = programme({{120, 0.005 * size, 0.02 * size, Regime::low}}, frequency_hz, noise, 4, base);
      CHECK(agreement(calm, dsp::segment_regimes(calm.motion)) == 1.0);
    }
}

TEST_CASE("the larger branch is high, whichever way the drive counts", "[dsp][segment_regimes]") {
  const auto hard = programme({{60, 0.007, 0.009, Regime::low}, {60, 0.030, 0.028, Regime::high}}, 1.5, 1e-5, 8);
  auto soft = hard;  // a spring that softens has the phases the other way round
  signal(soft.motion, "r").values *= -1.0;
  CHECK(agreement(soft, dsp::segment_regimes(soft.motion)) >= 0.995);
}

TEST_CASE("out of a rest a response is on the branch on which it settles while its drive stays",
          "[dsp][segment_regimes]") {
  // Against the base for four cycles, or for 24, on the way to the upper branch.
  for (const double against_s : {8.0 / 3.0, 16.0}) {
    const auto p = programme({{60, 0.007, 0.009, Regime::low},
                              {20, 0, 0, Regime::stick},
                              {against_s, -0.008, -0.008, Regime::high},
                              {60, 0.028, 0.026, Regime::high}},
                             1.5, 1e-5, 9);
    CHECK(agreement(p, dsp::segment_regimes(p.motion)) >= 0.99);  // the second of blur at each boundary
  }
  // For 24 cycles on the lower branch until the drive changes: its frequency, or its level alone.
  const std::vector<Phase> jumps{{60, 0.007, 0.009, Regime::low},
                                 {20, 0, 0, Regime::stick},
                                 {16, 0.008, 0.008, Regime::low},
                                 {60, 0.028, 0.026, Regime::high}};
  const auto slower = programme(jumps, 1.5, 1e-5, 9, 0.005, 95);
  CHECK(agreement(slower, dsp::segment_regimes(slower.motion)) >= 0.99);
  auto larger = programme(jumps, 1.5, 1e-5, 9);
  signal(larger.motion, "r").values.tail(61 * 64) *= 1.1;
  CHECK(agreement(larger, dsp::segment_regimes(larger.motion)) >= 0.99);
}

TEST_CASE("a response whose swings are excluded from the third on settles as they show", "[dsp][segment_regimes]") {
  auto p = programme({{60, 0.007, 0.009, Regime::low},
                      {30, 0.028, 0.026, Regime::high},
                      {20, 0, 0, Regime::stick},
                      {4, -0.008, -0.008, Regime::high},
                      {40, 0.028, 0.026, Regime::high}},
                     1.5, 1e-5, 9);
  for (std::size_t i = 112 * 64; i < p.truth.size(); ++i) p.motion.excluded[i] = 1, p.truth[i] = Regime::excluded;
  CHECK(agreement(p, dsp::segment_regimes(p.motion)) >= 0.99);
}

TEST_CASE("a boundary comes with its probability and its standard deviation", "[dsp][segment_regimes]") {
  const auto p = programme({{60, 0.007, 0.009, Regime::low}, {60, 0.030, 0.028, Regime::high}}, 1.5, 1e-5, 8);
  const auto found = dsp::segment_regimes(p.motion).segments;
  REQUIRE(found.size() == 2);
  CHECK(found[0].probability > 0.99);
  CHECK(found[1].probability > 0.99);
  CHECK(found[1].first_std_s == found[0].last_std_s);
  CHECK(found[1].first_std_s < 0.1);
  CHECK(std::isnan(found[0].first_std_s));
}

TEST_CASE("a jump that lies in excluded samples is one all the same", "[dsp][segment_regimes]") {
  auto p = programme({{60, 0.007, 0.009, Regime::low}, {60, 0.030, 0.028, Regime::high}}, 1.5, 1e-5, 8);
  for (std::size_t i = 58 * 64; i < 63 * 64; ++i) p.motion.excluded[i] = 1, p.truth[i] = Regime::excluded;
  CHECK(agreement(p, dsp::segment_regimes(p.motion)) == 1.0);
}

TEST_CASE("what passes through a resonance without a jump is one regime", "[dsp][segment_regimes]") {
  // A linear oscillator of 1.5 Hz and 5 % damping on its base, swept slowly and in steps from 1 to 2 Hz: the phase
  // turns from 0 to pi, and the amplitude is largest where it does.
  for (const bool stepped : {false, true}) {
    const Index n = 400 * 64;
    VectorXd x(n), v(n), r(n);
    double angle = 0.0;
    for (Index i = 0; i < n; ++i) {
      const double t = static_cast<double>(i) / rate_hz;
      const double f = 1.0 + (stepped ? 0.05 * std::floor(t / 20.0) : t / 400.0), ratio = f / 1.5;
      angle += two_pi * f / rate_hz;
      const std::complex<double> turn = std::polar(0.005, angle),
                                 response = ratio * ratio / std::complex(1.0 - ratio * ratio, 0.1 * ratio) * turn;
      x(i) = response.real();
      v(i) = (response * std::complex(0.0, two_pi * f)).real();
      r(i) = turn.real();
    }
    x += support::gaussian(n, 40, 1e-5);
    r += support::gaussian(n, 41, 1e-5);
    CHECK(num_branches(support::motion_of(rate_hz, {{"x", x}, {"v", v}, {"r", r}})) == 1);
  }
}

TEST_CASE("random excitation leaves one regime", "[dsp][segment_regimes]") {
  // A linear oscillator on a base moved by noise, in steps of half a sample.
  for (unsigned seed = 50; seed < 60; ++seed) {
    const Index n = 300 * 64;
    const VectorXd push = support::gaussian(n, seed, 1.0);
    VectorXd x(n), v(n), r(n);
    double slow = 0.0, slower = 0.0, displacement = 0.0, speed = 0.0;
    for (Index i = 0; i < n; ++i) {
      slow += 0.2 * (push(i) - slow), slower += 0.05 * (slow - slower);
      speed += (-0.9 * speed - 89.0 * displacement + 20.0 * slower) / rate_hz;
      displacement += speed / rate_hz;
      x(i) = displacement, v(i) = speed, r(i) = slower;
    }
    INFO("seed " << seed);
    CHECK(num_branches(support::motion_of(rate_hz, {{"x", x}, {"v", v}, {"r", r}})) == 1);
  }
}

TEST_CASE("an amplitude that is given parts low from high", "[dsp][segment_regimes]") {
  const auto p = programme({{60, 0.005, 0.03, Regime::low}}, 1.5, 1e-5, 5);
  const auto found = dsp::segment_regimes(p.motion, {.high_amplitude_m = 0.017});
  REQUIRE(found.segments.size() == 2);
  CHECK(found.segments[1].regime == Regime::high);
  CHECK(static_cast<double>(found.segments[1].first) / rate_hz == Approx(60.0 * 12.0 / 25.0).margin(0.7));
  CHECK(found.options.high_amplitude_m == 0.017);
}

TEST_CASE("excluded samples keep their label, and a swing for a moment is no regime", "[dsp][segment_regimes]") {
  auto p = programme({{60, 0.007, 0.007, Regime::low}, {3, 0.02, 0.02, Regime::low}, {60, 0.007, 0.007, Regime::low}},
                     1.5, 1e-5, 6);
  for (std::size_t i = 100; i < 200; ++i) p.motion.excluded[i] = 1;
  const auto found = dsp::segment_regimes(p.motion);
  REQUIRE(found.segments.size() == 3);
  CHECK(found.segments[1].regime == Regime::excluded);
  CHECK(found.segments[1].first == 100);
  CHECK(found.segments[2].regime == Regime::low);
}

TEST_CASE("where noise hides stops none are found, by speed or by halts", "[dsp][segment_regimes]") {
  // 1.25 Hz for two minutes at 256 Hz, a velocity that is mostly noise, and an acceleration that in the last third is
  // zero at every reversal.
  const Index n = 120 * 256;
  VectorXd x(n), v(n), a(n);
  for (Index i = 0; i < n; ++i) {
    const double angle = two_pi * 1.25 * static_cast<double>(i) / 256.0;
    x(i) = 0.01 * std::sin(angle);
    v(i) = 0.01 * two_pi * 1.25 * std::cos(angle);
    a(i) =
        3 * i > 2 * n && std::abs(std::cos(angle)) < 0.1 ? 0.0 : -0.01 * std::pow(two_pi * 1.25, 2) * std::sin(angle);
  }
  const auto stuck = [&](double noise_m) {
    const VectorXd noisy = x + support::gaussian(n, 31, noise_m);
    dsp::Motion motion = support::motion_of(256.0, {{"x", noisy}, {"v", v}, {"a", a}});
    for (dsp::Signal& signal : motion.signals)
      if (signal.name == "v") signal.flat_to_hz = 100.0;  // as if it were derived from x
    const auto found = dsp::segment_regimes(motion);
    return std::any_of(found.segments.begin(), found.segments.end(),
                       [](const auto& segment) { return segment.regime == Regime::stick; });
  };
  CHECK(stuck(1e-6));
  CHECK_FALSE(stuck(8e-3));
}

TEST_CASE("a payload that rests for most of the time is found to rest, on a base and without one",
          "[dsp][segment_regimes]") {
  // Swings of 4 mm between rests that take 50 to 98 % of 400 s, against a base of 20 mm that moves all along.
  for (const double at_rest : {0.5, 0.9, 0.98})
    for (const bool has_base : {true, false}) {
      CAPTURE(at_rest, has_base);
      std::vector<Phase> phases;
      constexpr double cycle_s = 100.0;
      for (int k = 0; k < 4; ++k) {
        phases.push_back({(1.0 - at_rest) * cycle_s, 0.004, 0.004, Regime::low});
        phases.push_back({at_rest * cycle_s, 0.0, 0.0, Regime::stick});
      }
      Programme of = programme(phases, 2.0, 1e-6, 7, 0.02);
      if (!has_base) std::erase_if(of.motion.signals, [](const dsp::Signal& one) { return one.name == "r"; });
      const dsp::Segmentation found = dsp::segment_regimes(of.motion, {});
      CHECK(found.options.stick_speed_m_per_s > 0.0);
      const auto all = labels(found);
      const auto stuck = static_cast<double>(std::count(all.begin(), all.end(), Regime::stick));
      // A rest begins and ends within the second in which the amplitude changes.
      CHECK(stuck / static_cast<double>(all.size()) == Approx(at_rest).margin(4.0 * 2.0 / 400.0));
    }
}

TEST_CASE("a row of halts that the record cuts goes on to its last reversal, motion behind a single stop does not",
          "[dsp][segment_regimes]") {
  // Half waves of 0.4 s; before the last but one, or before each, 0.1 s without motion; the last is cut.
  constexpr int num_halves = 50;
  constexpr Index half = 102, cut = 10;
  for (const bool row : {true, false}) {
    VectorXd v(0);
    for (int k = 0; k < num_halves; ++k) {
      const bool last = k + 1 == num_halves, halts = !last && (row || k + 2 == num_halves);
      const Index halt = halts ? 26 : 0, count = last ? cut : half;
      VectorXd next = VectorXd::Zero(halt + count);
      for (Index i = 0; i < count; ++i)
        next(halt + i) = (k % 2 == 0 ? 0.1 : -0.1) * std::sin(std::numbers::pi * (static_cast<double>(i) + 0.5) / half);
      v.conservativeResize(v.size() + next.size());
      v.tail(next.size()) = next;
    }
    VectorXd x(v.size());
    double sum = 0.0;
    for (Index i = 0; i < v.size(); ++i) x(i) = sum += v(i) / 256.0;
    const auto found = dsp::segment_regimes(support::motion_of(256.0, {{"x", x}, {"v", v}}),
                                            {.stick_speed_m_per_s = 0.01, .stick_duration_s = 0.02})
                           .segments;
    REQUIRE(found.size() >= 2);
    CHECK(found.back().regime != Regime::stick);
    CHECK(found[found.size() - 2].regime == Regime::stick);
    CHECK(std::abs(v.size() - found.back().first - (row ? cut : cut + half)) <= 4);
  }
}

TEST_CASE("a speed that is given is the only sign of a stop", "[dsp][segment_regimes]") {
  const auto p = programme({{60, 0.02, 0.02, Regime::low}, {30, 0, 0, Regime::stick}}, 1.5, 1e-5, 6);
  const auto found = dsp::segment_regimes(p.motion, {.stick_speed_m_per_s = 0.01, .stick_duration_s = 0.1});
  CHECK(agreement(p, found) > 0.95);
}

TEST_CASE("thresholds that make no sense are refused", "[dsp][segment_regimes]") {
  const auto p = programme({{20, 0.007, 0.007, Regime::low}}, 1.5, 1e-5, 7);
  CHECK_THROWS_AS(dsp::segment_regimes(p.motion, {.high_amplitude_m = -0.01}), std::invalid_argument);
  CHECK_THROWS_AS(dsp::segment_regimes(p.motion, {.stick_speed_m_per_s = -1.0}), std::invalid_argument);
  CHECK_THROWS_AS(dsp::regime_from_string("middle"), std::invalid_argument);
  CHECK(dsp::regime_from_string(dsp::to_string(Regime::stick)) == Regime::stick);
}

}  // namespace test_segment_regimes
