#include "dsp/samples/faulty_samples.hpp"

#include <fmt/format.h>
#include <rapidcheck/catch.h>
#include <catch2/catch.hpp>
#include <cmath>
#include <ctime>
#include <limits>
#include <numbers>
#include <random>

#include "dsp/samples/raw_spectrum.hpp"
#include "support/signals.hpp"

namespace test_samples_faulty_samples {

namespace {

using dsp::SampleFault;
constexpr double rate_hz = 25600.0;

/// One channel as a sensor and a converter make it.
struct Sensor {
  double amplitude = 1.0, frequency_hz = 1.3, offset = 0.0;
  double noise = 0.01;           ///< of each value the sensor gives
  double step = 0.0;             ///< its resolution
  Eigen::Index repeats = 1;      ///< samples for which it gives the same value
  double limit = 1e9;            ///< it shows no more
  double noise_on_top = 0.0;     ///< of each sample
  double bit = 1.0 / (1 << 22);  ///< of the converter
};

double rounded(double value, double step) {
  return step > 0.0 ? step * std::round(value / step) : value;
}

Eigen::VectorXd measured(const Sensor& sensor, Eigen::Index num_samples, std::uint32_t seed,
                         double sample_rate_hz = rate_hz) {
  const auto noise = support::gaussian(num_samples, seed), on_top = support::gaussian(num_samples, seed + 1);
  Eigen::VectorXd samples(num_samples);
  for (Eigen::Index i = 0; i < num_samples; ++i) {
    const Eigen::Index taken = i - i % sensor.repeats;
    const double angle = 2 * std::numbers::pi * sensor.frequency_hz * static_cast<double>(taken) / sample_rate_hz;
    const double value = sensor.offset + sensor.amplitude * std::sin(angle) + sensor.noise * noise(taken);
    const double shown = std::clamp(rounded(value, sensor.step), -sensor.limit, sensor.limit);
    samples(i) = rounded(shown + sensor.noise_on_top * on_top(i), sensor.bit);
  }
  return samples;
}

const Sensor accelerometer{};
const Sensor laser{.noise = 4e-4, .step = 3e-4, .repeats = 32, .noise_on_top = 7.5e-6};

std::vector<dsp::Channel> channels(Eigen::Index count) {
  std::vector<dsp::Channel> result(static_cast<std::size_t>(count));
  for (std::size_t c = 0; c < result.size(); ++c) result[c] = {.name = fmt::format("c{}", c), .unit = "V"};
  return result;
}

dsp::SampleFaults examined(const dsp::FrameBlock& frames, Eigen::Index block = 4096, double sample_rate_hz = rate_hz,
                           const dsp::FaultySampleOptions& options = {}) {
  dsp::FaultySamples faulty(sample_rate_hz, channels(frames.cols()), options);
  for (Eigen::Index row = 0; row < frames.rows(); row += block)
    faulty.push(frames.middleRows(row, std::min(block, frames.rows() - row)));
  return faulty.finish();
}

dsp::Check check(const dsp::SampleFaults& faults, const std::string& name, const std::string& channel = "c0") {
  for (const auto& found : faults.checks)
    if (found.name == name && found.channel == channel) return found;
  FAIL("no check " << name << " of " << channel);
  return {};
}

/// Every sample in [first, last) lies in a range of this kind, and no sample farther away than `margin` does.
void check_found(const dsp::SampleFaults& faults, SampleFault fault, Eigen::Index first, Eigen::Index last,
                 Eigen::Index margin) {
  REQUIRE(faults.ranges.size() == 1);
  const auto& found = faults.ranges.front();
  INFO(found.first << " .. " << found.last << " " << dsp::to_string(found.fault));
  CHECK(found.fault == fault);
  CHECK(found.first <= first);
  CHECK(found.last >= last);
  CHECK(found.first >= first - margin);
  CHECK(found.last <= last + margin);
  REQUIRE(faults.bad.size() == 1);
  CHECK(faults.bad.front().from_s == Approx(static_cast<double>(found.first) / rate_hz));
  CHECK_THAT(faults.bad.front().why, Catch::Equals(fmt::format("c0: {}", dsp::to_string(fault))));
  CHECK(check(faults, fmt::format("sample.{}", dsp::to_string(fault))).status == dsp::CheckStatus::warning);
}

constexpr Eigen::Index cell = 32;  // 1.25 ms at 25.6 kHz: how well a range without its own first sample is placed

}  // namespace

TEST_CASE("a value held for 0.3 s is found, with and without repeated values and noise on top",
          "[dsp][faulty_samples]") {
  const auto sensor = GENERATE(as<Sensor>(), accelerometer, laser, Sensor{.noise = 4e-4, .step = 3e-4, .repeats = 32});
  const Eigen::Index first = 200003, last = first + 7680;
  const auto with_noise = sensor.noise_on_top > 0.0;
  dsp::FrameBlock frames = measured(sensor, 400000, 1);
  const auto on_top = support::gaussian(last - first, 3, sensor.noise_on_top);
  for (Eigen::Index i = first; i < last; ++i)
    frames(i, 0) = frames(first, 0) + (with_noise ? rounded(on_top(i - first), sensor.bit) : 0.0);
  check_found(examined(frames), SampleFault::held, first + cell, last, 3 * cell);
}

TEST_CASE("a dropout to zero or to full scale is found and distinguished from clipping", "[dsp][faulty_samples]") {
  const auto sensor = GENERATE(as<Sensor>(), accelerometer, laser);
  const auto level = GENERATE(0.0, 1.25, -1.25);
  const Eigen::Index first = 200003, last = first + 5120;
  dsp::FrameBlock frames = measured(sensor, 400000, 2);
  frames.middleRows(first, last - first).setConstant(level);
  // Zero is where it may have been just before: then nothing jumps, and it is a held value.
  const auto faults = examined(frames);
  check_found(faults, faults.ranges.at(0).fault, first + cell, last, 2 * cell);
  CHECK(faults.ranges[0].fault != SampleFault::clipped);
  if (level != 0.0) CHECK(faults.ranges[0].fault == SampleFault::dropout);
  CHECK(faults.ranges[0].level == level);
}

TEST_CASE("clipping is counted and placed to the sample, its level known or not", "[dsp][faulty_samples]") {
  const double level = 0.75;
  const bool known = GENERATE(false, true);
  const dsp::FrameBlock frames = measured({.limit = level, .bit = 1.0 / 4096}, 200000, 4);
  dsp::FaultySampleOptions options{.merge_gap_s = 0.0};
  if (known) options.limits = {{.low = -level, .high = level}};
  const auto faults = examined(frames, 4096, rate_hz, options);
  Eigen::Index num_clipped = 0;
  std::vector<bool> marked(static_cast<std::size_t>(frames.rows()), false);
  for (const auto& range : faults.ranges) {
    CHECK(range.fault == SampleFault::clipped);
    CHECK(std::abs(range.level) == level);
    for (Eigen::Index i = range.first; i < range.last; ++i) marked[static_cast<std::size_t>(i)] = true;
  }
  Eigen::Index missed = 0, wrong = 0;
  const auto clipped = [&](Eigen::Index i) { return i >= 0 && i < frames.rows() && std::abs(frames(i, 0)) == level; };
  for (Eigen::Index i = 0; i < frames.rows(); ++i) {
    num_clipped += clipped(i);
    const bool alone = !clipped(i - 1) && !clipped(i + 1);  // one sample at a known limit may be chance
    missed += clipped(i) && !(known && alone) && !marked[static_cast<std::size_t>(i)];
    wrong += !clipped(i) && marked[static_cast<std::size_t>(i)];
  }
  CHECK(missed == 0);
  CHECK(wrong <= num_clipped / 50);  // standing still is placed to a cell
  CHECK(check(faults, "sample.clipped").value ==
        Approx(static_cast<double>(num_clipped) / static_cast<double>(frames.rows())).epsilon(0.03));
}

TEST_CASE("a laser that clips behind a noisy converter is found without its range", "[dsp][faulty_samples]") {
  Sensor sensor = laser;
  sensor.limit = 0.97;
  dsp::FrameBlock frames = measured(sensor, 400000, 5);
  const auto faults = examined(frames);
  // Truth: the sine beyond the limit. Twenty half periods, each one range.
  REQUIRE(check(faults, "sample.clipped").status == dsp::CheckStatus::warning);
  Eigen::Index missed = 0, wrong = 0, truth = 0;
  std::vector<bool> marked(static_cast<std::size_t>(frames.rows()), false);
  for (const auto& range : faults.ranges) std::fill(marked.begin() + range.first, marked.begin() + range.last, true);
  for (Eigen::Index i = 0; i < frames.rows(); ++i) {
    const auto taken = static_cast<double>(i - i % sensor.repeats);
    const double sine = std::abs(std::sin(2 * std::numbers::pi * sensor.frequency_hz * taken / rate_hz));
    const bool clipped = sine > 0.972, close = sine > 0.965;  // 0.97 and five standard deviations of the noise
    truth += clipped;
    missed += clipped && !marked[static_cast<std::size_t>(i)];
    wrong += !close && marked[static_cast<std::size_t>(i)];
  }
  CHECK(truth > 50000);
  CHECK(missed == 0);
  CHECK(wrong <= 40 * cell);
}

TEST_CASE("crests that are at a laser's limit for a moment only are clipped where longer ones tell the limit",
          "[dsp][faulty_samples]") {
  // A motion that dies away through the limit: most crests near it are not at it, so that levels alone tell nothing.
  constexpr Eigen::Index n = 1200000, update = 32;
  constexpr double limit = 0.97, frequency_hz = 1.0;
  const auto noise = support::gaussian(n, 41), on_top = support::gaussian(n, 42);
  dsp::FrameBlock frames(n, 1);
  std::vector<bool> clipped(static_cast<std::size_t>(n)), near_limit(static_cast<std::size_t>(n));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index taken = i - i % update;
    const double t = static_cast<double>(taken) / rate_hz,
                 amplitude = t < 3.0 ? 1.05 : 0.95 + 0.035 * std::exp(-t / 30.0);
    const double value = amplitude * std::sin(2 * std::numbers::pi * frequency_hz * t) + 4e-5 * noise(taken);
    frames(i, 0) = std::clamp(value, -limit, limit) + 7.5e-6 * on_top(i);
    clipped[static_cast<std::size_t>(i)] = std::abs(value) > limit;
    near_limit[static_cast<std::size_t>(i)] = std::abs(value) > 0.999 * limit;
  }
  const auto faults = examined(frames);
  std::vector<bool> marked(static_cast<std::size_t>(n), false);
  for (const auto& range : faults.ranges) {
    CHECK(range.fault == SampleFault::clipped);
    std::fill(marked.begin() + range.first, marked.begin() + range.last, true);
  }
  Eigen::Index truth = 0, missed = 0, wrong = 0;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    truth += clipped[i];
    missed += clipped[i] && !marked[i];
    wrong += marked[i] && !near_limit[i];
  }
  CHECK(truth > 5000);
  CHECK(missed == 0);
  // Placed to a cell before and two behind, and what lies between two that are joined.
  CHECK(wrong <= static_cast<Eigen::Index>(faults.ranges.size()) * 5 * update);
}

TEST_CASE("a short zero in a lively channel is not taken for the sensor", "[dsp][faulty_samples]") {
  dsp::FrameBlock frames = measured(accelerometer, 200000, 6);
  frames.middleRows(100000, 100).setZero();  // 3.9 ms, not four whole cells
  CHECK(examined(frames).ranges.empty());
}

TEST_CASE("what comes to rest by degrees is not held", "[dsp][faulty_samples]") {
  SECTION("a decay that ends in the converter's last step") {
    Eigen::VectorXd samples(256000);
    for (Eigen::Index i = 0; i < samples.size(); ++i) {
      const double t = static_cast<double>(i) / rate_hz;
      samples(i) = rounded(std::exp(-0.8 * t) * std::cos(2 * std::numbers::pi * 3.0 * t), 1e-3);
    }
    CHECK(examined(dsp::FrameBlock(samples)).ranges.empty());
  }
  SECTION("a body stopped by friction at each turn, coarsely measured") {
    Eigen::VectorXd samples(2500);  // 250 Hz; a third of a second at rest at either end of its way
    for (Eigen::Index i = 0; i < samples.size(); ++i) {
      const double turn = std::fmod(static_cast<double>(i) / 250.0, 2.0),
                   way = std::min(1.0, std::fmod(turn, 1.0) / 0.67);
      samples(i) = rounded((turn < 1.0 ? 1.0 : -1.0) * std::cos(std::numbers::pi * way), 1e-2);
    }
    CHECK(examined(dsp::FrameBlock(samples), 4096, 250.0).ranges.empty());
  }
  SECTION("a coarse reading between slow movements") {
    Eigen::VectorXd samples(20000);
    for (Eigen::Index i = 0; i < samples.size(); ++i)
      samples(i) = rounded(std::max(0.0, std::sin(2 * std::numbers::pi * static_cast<double>(i) / 5000.0)), 0.01);
    const auto faults = examined(dsp::FrameBlock(samples), 4096, 100.0);
    CHECK(faults.ranges.empty());
  }
}

TEST_CASE("a friction stop at the extreme of the record is one visit and no clipping", "[dsp][faulty_samples]") {
  Eigen::VectorXd samples(2500);
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    const auto moving = static_cast<double>(i < 875 ? i : std::max<Eigen::Index>(875, i - 41));
    const double decay = 1.0 - 1e-5 * std::abs(moving - 875.0);
    samples(i) = rounded(decay * std::sin(2 * std::numbers::pi * 0.002 * (moving - 1000.0)), 7e-4);
  }
  const auto faults = examined(dsp::FrameBlock(samples), 4096, 250.0);
  CHECK(faults.ranges.empty());
  CHECK(check(faults, "sample.clipped").message == "none");
}

TEST_CASE("a channel that is at its extreme for a third of the record rests there", "[dsp][faulty_samples]") {
  Eigen::VectorXd samples(200000);
  for (Eigen::Index i = 0; i < samples.size(); ++i)
    samples(i) = std::max(0.2, std::sin(2 * std::numbers::pi * static_cast<double>(i) / 4973.0));
  const auto faults = examined(dsp::FrameBlock(samples), 4096, 100.0);
  CHECK(faults.ranges.empty());
  CHECK_THAT(check(faults, "sample.clipped").message,
             Catch::Contains("56 % of the record is at 0.2 V: treated as rest"));
}

TEST_CASE("channels as a whole: constant, a switch, coarse, shifted, drifting, with spikes", "[dsp][faulty_samples]") {
  const Eigen::Index n = 256000;
  dsp::FrameBlock frames(n, 6);
  for (Eigen::Index c = 0; c < 6; ++c) frames.col(c) = measured(accelerometer, n, 10 + static_cast<std::uint32_t>(c));
  frames.col(0).setConstant(0.0);
  for (Eigen::Index i = 0; i < n; ++i) frames(i, 1) = i / 9000 % 4 == 0 ? 5.0 : 0.0;
  frames.col(2) = frames.col(2).unaryExpr([](double x) { return rounded(x, 0.1); });
  frames.col(3).array() += 2.0;
  frames.col(4) += Eigen::VectorXd::LinSpaced(n, 0.0, 0.5);
  for (const Eigen::Index i : {70000, 150016, 200031}) frames(i, 5) += i == 150016 ? -3.0 : 2.0;
  const auto faults = examined(frames);
  CHECK(faults.ranges.empty());
  CHECK(check(faults, "sample.constant", "c0").message == "all values are zero");
  const auto coarse = check(faults, "sample.quantised", "c2");
  CHECK(coarse.status == dsp::CheckStatus::warning);
  CHECK(coarse.value == Approx(std::log2(21.0)).margin(0.1));  // -1 to 1 in steps of 0.1
  CHECK(check(faults, "sample.offset", "c3").value == Approx(2.0).margin(1e-3));
  CHECK(check(faults, "sample.offset", "c3").status == dsp::CheckStatus::note);
  // Thirteen whole periods lean on a line by a fraction of their amplitude of about 6 / (pi 13).
  CHECK(check(faults, "sample.drift", "c4").value == Approx(0.5).margin(0.2));
  const auto spikes = check(faults, "sample.spike", "c5");
  CHECK(spikes.value == 3);
  CHECK_THAT(spikes.message, Catch::Contains("the first at 2.73") && Catch::Contains("the largest at 5.86"));
  CHECK(check(faults, "sample.spike", "c3").value == 0);
}

TEST_CASE("a laser's repetition is reported", "[dsp][faulty_samples]") {
  const auto faults = examined(measured(laser, 256000, 20));
  // Now and then two values are the same.
  CHECK(check(faults, "sample.repeated").value == Approx(32 / rate_hz).epsilon(0.15));
  CHECK(faults.ranges.empty());
}

TEST_CASE("repetition is found of any number of samples, wherever it begins", "[dsp][faulty_samples]") {
  // At 22.05 kHz a cell has 28 samples, a multiple of 7; at 25.6 kHz 32, of which 64 and 256 are multiples. Eight cells
  // and a sample are a multiple of 5 at 22.05 and 50 kHz, of 3 at 51.2 kHz.
  const auto [sample_rate_hz, repeats] = GENERATE(table<double, Eigen::Index>({{22050.0, 7},
                                                                               {25600.0, 64},
                                                                               {25600.0, 256},
                                                                               {11025.0, 14},
                                                                               {22050.0, 5},
                                                                               {50000.0, 5},
                                                                               {51200.0, 3},
                                                                               {2000.0, 2},
                                                                               {5000.0, 5}}));
  const Eigen::Index late = GENERATE(0, 1);
  CAPTURE(sample_rate_hz, repeats, late);
  constexpr Eigen::Index n = 1 << 20;
  const Eigen::VectorXd samples = measured({.repeats = repeats}, n + late, 21, sample_rate_hz).tail(n);
  const auto faults = examined(samples, 4096, sample_rate_hz);
  // Some four thousand steps are drawn from all places by turns: sixteen meet a change of the longest, give or take
  // one.
  CHECK(check(faults, "sample.repeated").value == Approx(static_cast<double>(repeats) / sample_rate_hz).epsilon(0.15));
}

TEST_CASE("the same is found for any block size", "[dsp][faulty_samples]") {
  const Eigen::Index n = 130000;
  dsp::FrameBlock frames(n, 3);
  frames.col(0) = measured(laser, n, 30);
  frames.col(1) = measured(accelerometer, n, 31);
  frames.col(2) = measured({.limit = 0.8}, n, 32);
  frames.col(0).segment(40000, 6000).setConstant(frames(40000, 0));
  frames.col(1).segment(80000, 4000).setConstant(2.0);
  frames(100000, 1) = 7.0;
  const auto expected = examined(frames, n);
  REQUIRE(expected.ranges.size() >= 3);
  for (const Eigen::Index block : {1, 7, 1000, 65536}) {
    const auto found = examined(frames, block);
    REQUIRE(found.ranges.size() == expected.ranges.size());
    for (std::size_t i = 0; i < found.ranges.size(); ++i) {
      CHECK(found.ranges[i].first == expected.ranges[i].first);
      CHECK(found.ranges[i].last == expected.ranges[i].last);
      CHECK(found.ranges[i].level == expected.ranges[i].level);
    }
    REQUIRE(found.checks.size() == expected.checks.size());
    for (std::size_t i = 0; i < found.checks.size(); ++i) {
      CHECK(found.checks[i].value == expected.checks[i].value);
      CHECK(found.checks[i].message == expected.checks[i].message);
    }
  }
}

TEST_CASE("sines with noise, repetition and rounding have no faults, in any unit", "[dsp][faulty_samples]") {
  rc::prop("nothing is found", [] {
    const double sample_rate_hz = *rc::gen::element(50.0, 250.0, 2000.0, 25600.0, 51200.0);
    const auto from = [](std::vector<double> values) { return *rc::gen::elementOf(values); };
    Sensor sensor;
    sensor.frequency_hz = from({0.003, 0.02, 0.11}) * std::min(sample_rate_hz, 100.0);
    sensor.offset = from({0.0, -0.3, 20.0});
    sensor.noise = from({0.0, 1e-6, 1e-3, 0.1});
    sensor.step = from({0.0, 1e-5, 1e-3, 0.02});
    sensor.repeats = *rc::gen::element(1, 2, 5, 32, 100);
    sensor.noise_on_top = from({0.0, 1e-6, 1e-4});
    sensor.bit = from({0.0, 1e-7, 1e-4, 0.01});
    const double unit = std::ldexp(1.0, *rc::gen::inRange(-400, 400));  // exact: the same verdict is due
    const auto seed = *rc::gen::inRange<std::uint32_t>(0, 1000000);
    const auto n = *rc::gen::inRange<Eigen::Index>(1, 60000);
    const dsp::FrameBlock frames = measured(sensor, n, seed, sample_rate_hz);
    const auto faults = examined(frames, 4096, sample_rate_hz), scaled = examined(unit * frames, 4096, sample_rate_hz);
    RC_ASSERT(faults.ranges.empty());
    RC_ASSERT(scaled.ranges.empty());
    RC_ASSERT(faults.checks.size() == scaled.checks.size());
    for (std::size_t i = 0; i < faults.checks.size(); ++i)
      RC_ASSERT(faults.checks[i].status == scaled.checks[i].status);
  });
}

TEST_CASE("nonsense is refused", "[dsp][faulty_samples]") {
  CHECK_THROWS_AS(dsp::FaultySamples(0.0, channels(1)), std::invalid_argument);
  CHECK_THROWS_AS(dsp::FaultySamples(100.0, {}), std::invalid_argument);
  CHECK_THROWS_AS(dsp::RawSpectrum(0.0, 1, 1000), std::invalid_argument);
  CHECK_THROWS_AS(dsp::RawSpectrum(100.0, 0, 1000), std::invalid_argument);
  CHECK_THROWS_AS(dsp::FaultySamples(100.0, channels(2), {.limits = {{}}}), std::invalid_argument);
  dsp::FaultySamples faulty(100.0, channels(2));
  CHECK_THROWS_AS(faulty.push(dsp::FrameBlock::Zero(3, 1)), std::invalid_argument);
  dsp::FrameBlock frames = dsp::FrameBlock::Zero(3, 2);
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    frames(1, 1) = value;
    CHECK_THROWS_AS(faulty.push(frames), std::invalid_argument);
  }
  CHECK(dsp::FaultySamples(100.0, channels(2)).finish().checks.empty());
}

TEST_CASE("looking at samples costs little more than copying them", "[dsp][faulty_samples]") {
  dsp::FrameBlock frames(4096, 4), copy;
  for (Eigen::Index c = 0; c < 4; ++c)
    frames.col(c) = measured({.frequency_hz = 6.25}, 4096, 40 + static_cast<std::uint32_t>(c));
  dsp::FaultySamples faulty(rate_hz, channels(4));
  const auto seconds = [](const auto& act) {  // least of many: what else the machine does only adds
    double least = std::numeric_limits<double>::infinity();
    for (int repetition = 0; repetition < 60; ++repetition) {
      const auto begin = std::clock();
      for (int i = 0; i < 64; ++i) act();
      least = std::min(least, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    }
    return least;
  };
  const double copying = seconds([&] {
    copy = frames;
    asm volatile("" : : "r"(copy.data()) : "memory");
  });
  const double looking = seconds([&] { faulty.push(frames); });
  // Five times on an idle machine with optimisation; sanitizers cost both about the same factor each.
  CHECK(looking < 60 * copying);
}

}  // namespace test_samples_faulty_samples
