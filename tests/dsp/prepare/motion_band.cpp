#include "dsp/prepare/motion_band.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "dsp/filter/spectral.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/io/sound_writer.hpp"
#include "dsp/prepare.hpp"
#include "dsp/sensors/motion.hpp"
#include "support/scratch.hpp"

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double pi = std::numbers::pi;

/// A periodic motion whose harmonics fall as 1 / h^3, with its exact acceleration.
struct Periodic {
  double fundamental_hz, rate_hz, duration_s;
  [[nodiscard]] VectorXd derivative(int order) const {
    VectorXd result = VectorXd::Zero(static_cast<Index>(rate_hz * duration_s));
    for (int h = 1; h <= 31; h += 2)
      for (Index i = 0; i < result.size(); ++i) {
        const double w = 2.0 * pi * h * fundamental_hz;
        result(i) += std::pow(w, order) / std::pow(h, 3) *
                     std::sin(w * static_cast<double>(i) / rate_hz + 0.5 * pi * order + 0.3 * h);
      }
    return result;
  }
};

VectorXd with_noise(VectorXd signal, double rms, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> white(0.0, rms);
  for (double& value : signal) value += white(random);
  return signal;
}

dsp::MotionBand band_of(const VectorXd& signal, double rate_hz, dsp::Role role = dsp::Role::x) {
  dsp::RawSpectrum spectrum(rate_hz, 1, signal.size(), 32, dsp::usual_segment_s(signal.size(), rate_hz));
  spectrum.push(dsp::FrameBlock(signal));
  dsp::Recording recording{.sample_rate_hz = rate_hz, .channels = {{.name = "channel", .role = role}}};
  recording.samples = signal;
  dsp::MotionBand band = dsp::motion_band_of_channels(recording.channels, spectrum);
  if (dsp::is_unresolved(band))
    band = dsp::motion_band_of_channels(recording.channels, dsp::spectrum_of_slow(recording));
  return band;
}

/// Mean square error of the second derivative taken up to a cut-off.
double error_of(const VectorXd& measured, const VectorXd& exact, double rate_hz, double cutoff_hz) {
  const VectorXd a = dsp::ExtendedSpectrum(measured, rate_hz).derivative(2, {0.78125 * cutoff_hz, cutoff_hz});
  const Index edge = a.size() / 10;
  return (a - exact).segment(edge, a.size() - 2 * edge).squaredNorm();
}

}  // namespace

TEST_CASE("the band of a motion is about where the error of its second derivative is least") {
  for (const double rms : {1e-2, 1e-3, 1e-4}) {
    CAPTURE(rms);
    const Periodic motion{1.3, 500.0, 60.0};
    const VectorXd measured = with_noise(motion.derivative(0), rms, 7), exact = motion.derivative(2);
    const dsp::MotionBand band = band_of(measured, motion.rate_hz);
    CAPTURE(band.to_hz);
    double least = INFINITY;
    for (double cutoff_hz = 1.5; cutoff_hz < 240.0; cutoff_hz *= 1.1)
      least = std::min(least, error_of(measured, exact, motion.rate_hz, cutoff_hz));
    // A harmonic more or less is all that parts them: they lie 2.6 Hz apart and fall by less than 2 each.
    CHECK(error_of(measured, exact, motion.rate_hz, band.to_hz) < 2.0 * least);
    CHECK(band.peak_hz == Approx(1.3).margin(0.25));  // a bin
  }
}

TEST_CASE("the band does not depend on the unit, and grows as the noise falls") {
  const Periodic motion{2.0, 1000.0, 40.0};
  double before_hz = 0.0;
  for (const double rms : {1e-1, 1e-2, 1e-3, 1e-4}) {
    const VectorXd measured = with_noise(motion.derivative(0), rms, 3);
    const double to_hz = band_of(measured, motion.rate_hz).to_hz;
    CHECK(band_of(1e3 * measured, motion.rate_hz).to_hz == Approx(to_hz));
    CHECK(to_hz >= before_hz);
    before_hz = to_hz;
  }
  CHECK(before_hz > 10.0);
  CHECK(before_hz < 100.0);
}

TEST_CASE("a motion above its noise everywhere keeps the record's band, and what a cut-off loses is counted") {
  // Tones of equal acceleration: 1 m/s^2 at 3, 11 and 27 Hz; nothing else.
  VectorXd x = VectorXd::Zero(12000);
  for (const double f : {3.0, 11.0, 27.0})
    for (Index i = 0; i < x.size(); ++i) x(i) += std::sin(2.0 * pi * f * static_cast<double>(i) / 200.0) / (f * f);
  const dsp::MotionBand band = band_of(x, 200.0);
  CHECK(band.kept_fraction(5.0) == Approx(1.0 / 3.0).epsilon(0.01));
  CHECK(band.kept_fraction(15.0) == Approx(2.0 / 3.0).epsilon(0.01));
  CHECK(band.kept_fraction(40.0) == Approx(1.0).epsilon(0.01));
  CHECK(dsp::band_check(band, 15.0).status == dsp::CheckStatus::warning);
  CHECK(dsp::band_check(band, 40.0).status == dsp::CheckStatus::note);
}

TEST_CASE("a tone that ends at 8 Hz goes from 25.6 kHz to 25.6 Hz") {
  dsp::PrepareOptions options;
  options.cutoff_hz = dsp::cutoff_for({.signal = "x", .to_hz = 8.0, .nyquist_hz = 12800.0});
  CHECK(options.cutoff_hz == Approx(10.24).margin(0.06));
  CHECK(dsp::rate_by_cutoff(options, 25600.0).rate_hz == Approx(25.6).epsilon(0.12));  // the next short filter
  options.rate_hz = 100.0;
  CHECK(dsp::rate_by_cutoff(options, 25600.0).rate_hz == 100.0);
}

TEST_CASE("an acceleration alone becomes a displacement from where its drift ends") {
  const Periodic motion{1.3, 500.0, 120.0};
  VectorXd drift(static_cast<Index>(motion.rate_hz * motion.duration_s));
  for (Index i = 0; i < drift.size(); ++i)
    drift(i) = 0.02 * std::sin(2.0 * pi * 0.02 * static_cast<double>(i) / motion.rate_hz);
  const VectorXd measured = with_noise(motion.derivative(2) + drift, 1e-3, 5);
  const dsp::MotionBand band = band_of(measured, motion.rate_hz, dsp::Role::a);
  CHECK(band.from_hz > 0.02);
  CHECK(band.from_hz < 1.3);
  dsp::Recording recording{.name = "r", .sample_rate_hz = motion.rate_hz, .channels = {{"acc", dsp::Role::a, "m/s^2"}}};
  recording.samples = measured;
  const dsp::Motion found =
      dsp::relative_motion(recording, {.band = {100.0, 120.0}, .integrate_from_hz = band.from_hz});
  const Index edge = found.edge_samples, count = measured.size() - 2 * edge;
  const VectorXd x = motion.derivative(0), v = motion.derivative(1);
  // What prediction beyond the ends makes of the drift fades over some lengths of the high-pass.
  CHECK((found.at("x") - x).segment(edge, count).norm() < 4e-2 * x.segment(edge, count).norm());
  CHECK((found.at("v") - v).segment(edge, count).norm() < 1e-2 * v.segment(edge, count).norm());
  CHECK(found.find("x")->unit == "m");
}

TEST_CASE("a motion too slow for pieces of a few seconds is found in longer ones") {
  const Periodic motion{0.05, 10.0, 1200.0};
  for (const auto& [order, role] : {std::pair{0, dsp::Role::x}, {2, dsp::Role::a}}) {
    const dsp::MotionBand band = band_of(with_noise(motion.derivative(order), order == 0 ? 1e-3 : 1e-4, 5), 10.0, role);
    CHECK(band.peak_hz == Approx(0.05).epsilon(0.1));
    CHECK(band.to_hz > 0.14);  // it has a third harmonic of a ninth of the acceleration
    CHECK(band.to_hz < 2.0);
    if (order == 2) CHECK((band.from_hz > 0.01 && band.from_hz < 0.04));
  }
}

TEST_CASE("of a short record an integral takes a tenth at either end, beside the filters") {
  const Periodic motion{10.0, 400.0, 2.0};
  dsp::Recording recording{.name = "r", .sample_rate_hz = 400.0, .channels = {{"acc", dsp::Role::a, "m/s^2"}}};
  recording.samples = motion.derivative(2);
  const auto lost_s = [&](const dsp::PrepareOptions& options) {
    const dsp::Prepared prepared = dsp::prepare(recording, options);
    return static_cast<double>(prepared.signals.edge_samples) / prepared.signals.sample_rate_hz;
  };
  const double filters_s = lost_s({.integrate_from_hz = 40.0});  // shorter than the derivatives' band
  CHECK(lost_s({}) - filters_s < 0.2 + 1.0 / 400.0);
  CHECK(lost_s({.integrate_from_hz = 1.0}) == lost_s({}));
}

TEST_CASE("a file is looked through in pieces and tells the band of all of it") {
  const support::Scratch folder;
  const Periodic motion{1.3, 500.0, 60.0};
  const VectorXd x = with_noise(motion.derivative(0), 1e-3, 9);
  std::string csv = "t_s,x_m\n";
  for (Index i = 0; i < x.size(); ++i) csv += fmt::format("{:.3f},{:.9g}\n", static_cast<double>(i) / 500.0, x(i));
  const auto file = folder.file("r.csv", csv);
  const dsp::MotionBand band = dsp::find_motion_band([&] { return dsp::RecordingReader(file); });
  CHECK(band.signal == "x");
  CHECK(band.to_hz == Approx(band_of(x, 500.0).to_hz));
}

TEST_CASE("the band of a motion is in the unit of its clock") {
  const support::Scratch folder;
  for (const double peak_hz : {0.3, 1.3, 3.0}) {  // 6, 26 and 60 periods
    CAPTURE(peak_hz);
    const VectorXd x = with_noise(Periodic{peak_hz, 200.0, 20.0}.derivative(0), 1e-3, 13);
    std::vector<double> cutoffs;
    for (const char* unit : {"s", "ms", "us"}) {
      std::string csv = fmt::format("t_{},x_m\n", unit);
      for (Index i = 0; i < x.size(); ++i) csv += fmt::format("{:.3f},{:.9g}\n", static_cast<double>(i) / 200.0, x(i));
      const auto file = folder.file(fmt::format("{}.csv", unit), csv);
      cutoffs.push_back(dsp::cutoff_for(dsp::find_motion_band([&] { return dsp::RecordingReader(file); })));
    }
    REQUIRE(cutoffs[0] > 0.0);
    CHECK(cutoffs[1] == Approx(1e3 * cutoffs[0]).epsilon(1e-9));  // three digits are kept of it
    CHECK(cutoffs[2] == Approx(1e6 * cutoffs[0]).epsilon(1e-9));
  }
}

TEST_CASE("a slow motion recorded fast is found, and where its noise exceeds it") {
  const support::Scratch folder;
  // An eighth of it has 300,000 samples: means of three, which blocks of a power of two cut.
  const double rate_hz = 10'000.0;
  const Periodic motion{0.12, rate_hz, 239.99};
  // Its noise has the density that 1e-4 has at 64 Hz, where an eighth is short enough as it is.
  const VectorXd x = with_noise(motion.derivative(0), 1e-4 * std::sqrt(rate_hz / 64.0), 11);
  dsp::FrameBlock samples(x.size(), 2);
  for (Index i = 0; i < x.size(); ++i) {
    const double base = 0.2 * std::cos(0.3 * static_cast<double>(i) / rate_hz);
    samples.row(i) << 0.25 * x(i) + base, base;
  }
  const auto file = folder / "slow.rf64";
  dsp::SoundFileWriter writer(file, {.container = dsp::SoundContainer::rf64,
                                     .sample_rate_hz = rate_hz,
                                     .num_channels = 2,
                                     .num_frames = samples.rows()});
  writer.write(samples);
  writer.close();
  std::string sidecar = "schema = 1\n";
  for (const char* name : {"y", "r"})
    sidecar += fmt::format(
        "[[channel]]\nname = \"{0}\"\nrole = \"{0}\"\nfull_scale = \"1 V\"\nsensitivity = \"1 V/m\"\n", name);
  (void)folder.file("slow.rf64.toml", sidecar);
  const dsp::MotionBand band = dsp::find_motion_band([&] { return dsp::RecordingReader(file); });
  CHECK(band.signal == "y - r");
  const double bin_hz = 8.0 / 239.99;
  CHECK(std::abs(band.peak_hz - 0.12) <= 0.5 * bin_hz);
  CHECK(band.nyquist_hz == 0.5 * rate_hz);
  const dsp::MotionBand slower = band_of(with_noise(Periodic{0.12, 64.0, 240.0}.derivative(0), 1e-4, 12), 64.0);
  // Between two harmonics the spectrum has no place for a least value: they are 0.24 Hz apart.
  CHECK(std::abs(band.to_hz - slower.to_hz) <= 0.24);
}

TEST_CASE("of what is too slow for any piece there is no band") {
  const support::Scratch folder;
  std::string csv = "t_s,x_m\n";
  for (int i = 0; i < 10'000; ++i) csv += fmt::format("{},{:.9g}\n", 0.01 * i, std::sin(0.01 * i / 100.0));
  const auto file = folder.file("slow.csv", csv);
  const dsp::MotionBand band = dsp::find_motion_band([&] { return dsp::RecordingReader(file); });
  CHECK(band.signal.empty());
  CHECK(band.nyquist_hz == 0.0);
  CHECK(dsp::cutoff_for(band) == 0.0);
}
