#include "dsp/sensors/mount.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <tuple>
#include <utility>

#include "dsp/regimes/reversals.hpp"
#include "support/signals.hpp"

namespace test_sensors_mount {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double pi = std::numbers::pi, rate_hz = 256.0, drive_hz = 1.25;
constexpr Index period = 205;

// What a sensor on a mount reads of an acceleration, by the exact response to a straight line between samples, twenty
// to a sample at the intermediate rate: another way than the spectrum's.
VectorXd on_mount(const VectorXd& body, const dsp::Mount& mount) {
  const double omega = 2.0 * pi * mount.frequency_hz, z = mount.damping, step_s = 1.0 / (20.0 * rate_hz);
  VectorXd read(body.size());
  double lag = 0.0, speed = 0.0;  // of the sensor behind the body: lag'' + 2 z w lag' + w^2 lag = -body
  for (Index i = 0; i < body.size(); ++i)
    for (int part = 0; part < 20; ++part) {
      if (part == 10) read(i) = -(2.0 * z * omega * speed + omega * omega * lag);
      const double acceleration = -body(i) - 2.0 * z * omega * speed - omega * omega * lag;
      speed += acceleration * step_s;
      lag += speed * step_s;
    }
  return read;
}

struct Ridden {
  dsp::Motion motion;
  VectorXd body_a, body_v;
};

// x of a payload that friction makes turn at each end of its half waves, its base at rest; displacement sensors on the
// mount, too.
Ridden ride(const dsp::Mount& mount, double noise, unsigned seed = 21) {
  const auto n = static_cast<Index>(100.0 * rate_hz);
  Ridden result{{.sample_rate_hz = rate_hz}, VectorXd(n), VectorXd(n)};
  VectorXd x(n);
  double v = 0.0, position = 0.0;
  for (Index i = 0; i < n; ++i) {
    const double angle = 2.0 * pi * drive_hz * static_cast<double>(i) / rate_hz;
    result.body_a(i) = 0.5 * std::cos(angle) + 0.03 * std::cos(3.0 * angle) - (std::sin(angle) > 0.0 ? 0.1 : -0.1);
    v += result.body_a(i) / rate_hz;
    result.body_v(i) = v;
    position += v / rate_hz;
    x(i) = position;
  }
  // Offsets that the sums leave.
  result.body_v.array() -= result.body_v.mean();
  x.array() -= VectorXd::LinSpaced(n, x(0), x(n - 1)).array();
  const VectorXd a = mount.is_rigid() ? result.body_a : on_mount(result.body_a, mount);
  result.motion.signals = {
      {"x", "m", x}, {"v", "m/s", result.body_v}, {"a", "m/s^2", a + support::gaussian(n, seed, noise)}};
  return result;
}

// Base and payload in three tones that the mount passes each in its own way; sensors read the payload through it.
struct Tones {
  dsp::Motion body, read;
};

Tones tones(const dsp::Mount& mount) {
  const auto n = static_cast<Index>(60.0 * rate_hz);
  const char* names[3][3] = {{"x", "r", "y"}, {"v", "dr", "dy"}, {"a", "ddr", "ddy"}};
  Tones result{{.sample_rate_hz = rate_hz}, {.sample_rate_hz = rate_hz}};
  for (int order = 0; order < 3; ++order) {
    VectorXd base(n), body(n), read(n);
    for (Index i = 0; i < n; ++i) {
      std::complex<double> b = 0.0, p = 0.0, q = 0.0;
      for (const auto& [f, size] : {std::pair{1.3, 9e-3}, {4.1, 3e-4}, {9.2, 2e-5}}) {
        const std::complex<double> s(0.0, 2.0 * pi * f);
        const double w = 2.0 * pi * mount.frequency_hz;
        const std::complex<double> spring = 2.0 * mount.damping * w * s + w * w;
        const auto wave = std::pow(s, order) * size * std::exp(s * (static_cast<double>(i) / rate_hz));
        b += 0.5 * wave * std::exp(std::complex<double>(0.0, 0.7));
        p += wave;
        q += wave * spring / (s * s + spring);
      }
      base(i) = b.real(), body(i) = p.real(), read(i) = q.real();
    }
    result.body.signals.push_back({names[order][0], "", body - base});
    result.read.signals.push_back({names[order][0], "", read - base});
    for (dsp::Motion* motion : {&result.body, &result.read}) motion->signals.push_back({names[order][1], "", base});
    result.body.signals.push_back({names[order][2], "", body});
    result.read.signals.push_back({names[order][2], "", read});
  }
  return result;
}

dsp::Mount found(const Ridden& ride) {
  const VectorXd& v = ride.body_v;
  return dsp::find_mount(ride.motion, v, dsp::sign_changes(v, period), 32.0, period);
}

}  // namespace

TEST_CASE("a ringing mount is found with its frequency and damping", "[dsp][mount]") {
  for (const double noise : {0.0, 0.01})
    for (const dsp::Mount mount : {dsp::Mount{10.7, 0.10}, {8.0, 0.2}, {16.0, 0.05}}) {
      INFO(mount.frequency_hz << " Hz, damping " << mount.damping << ", noise " << noise);
      const dsp::Mount is = found(ride(mount, noise));
      CHECK(is.frequency_hz == Approx(mount.frequency_hz).epsilon(0.04));
      CHECK(is.damping == Approx(mount.damping).margin(0.03));
    }
}

TEST_CASE("a rigid mount stays rigid", "[dsp][mount]") {
  for (const double noise : {0.0, 0.005, 0.05}) CHECK(found(ride({}, noise)).is_rigid());
  // No reversals, nothing to go by.
  const Ridden smooth = ride({10.7, 0.1}, 0.0);
  CHECK(dsp::find_mount(smooth.motion, smooth.body_v, {}, 32.0, period).is_rigid());
}

TEST_CASE("what a mount adds, taken off, gives the body's acceleration back", "[dsp][mount]") {
  const dsp::Mount mount{10.7, 0.10};
  const Ridden ridden = ride(mount, 0.0);
  dsp::Motion undone = ridden.motion;
  dsp::undo_mount(undone, mount, {45.0, 60.0});
  const VectorXd &read = ridden.motion.at("a"), &back = undone.at("a");
  const Index from = 512, count = read.size() - 1024;  // the ends lean on a prediction
  // What is left is above 45 Hz, where leaps have 2 % of their power.
  CHECK(support::nmse(read.segment(from, count), ridden.body_a.segment(from, count)) > 0.02);
  CHECK(support::nmse(back.segment(from, count), ridden.body_a.segment(from, count)) < 2e-3);
}

TEST_CASE("a mount undone gives displacement, velocity and acceleration of payload and relative motion back",
          "[dsp][mount]") {
  const dsp::Mount mount{10.7, 0.10};
  const Tones known = tones(mount);
  dsp::Motion undone = known.read;
  dsp::undo_mount(undone, mount, {20.0, 30.0});
  const Index edge = 512, inner = undone.num_samples() - 2 * edge;  // the ends lean on a prediction
  for (const dsp::Signal& signal : known.body.signals) {
    INFO(signal.name);
    CHECK(support::nmse(undone.at(signal.name).segment(edge, inner), signal.values.segment(edge, inner)) < 1e-8);
  }
  CHECK(support::nmse(known.read.at("ddy"), known.body.at("ddy")) > 1e-3);
}

TEST_CASE("what a mount's frequency or damping changes is what undoing another mount gives", "[dsp][mount]") {
  const dsp::Mount mount{10.7, 0.10};
  const dsp::SpectralBand band{20.0, 30.0};
  const Tones known = tones(mount);
  const auto undone_by = [&](const dsp::Mount& other) {
    dsp::Motion motion = known.read;
    dsp::undo_mount(motion, other, band);
    return motion;
  };
  const dsp::Motion undone = undone_by(mount);
  const double step = 1e-3;
  for (const auto& [parameter, more, less] :
       {std::tuple{dsp::MountParameter::frequency, dsp::Mount{10.7 + step, 0.1}, dsp::Mount{10.7 - step, 0.1}},
        std::tuple{dsp::MountParameter::damping, dsp::Mount{10.7, 0.1 + step}, dsp::Mount{10.7, 0.1 - step}}})
    for (int order = 0; order < 3; ++order) {
      const char* name = order == 0 ? "y" : order == 1 ? "dy" : "ddy";
      const dsp::Motion with_more = undone_by(more), with_less = undone_by(less);
      const VectorXd expected = (with_more.at(name) - with_less.at(name)) / (2.0 * step);
      const VectorXd change =
          dsp::mount_sensitivity(dsp::payload_signal(undone, order), rate_hz, mount, parameter, band);
      // Second order of the step: 1e-4 of the damping's own square. Ends are predicted anew.
      const Index edge = 512, inner = change.size() - 2 * edge;
      CHECK((change - expected).segment(edge, inner).norm() < 1e-3 * expected.segment(edge, inner).norm());
    }
}

TEST_CASE("a mount's standard deviations are not less than how much noise makes it scatter", "[dsp][mount]") {
  constexpr unsigned num_seeds = 12;
  VectorXd frequency(num_seeds), damping(num_seeds), frequency_std(num_seeds), damping_std(num_seeds);
  for (unsigned k = 0; k < num_seeds; ++k) {
    const dsp::Mount is = found(ride({10.7, 0.10}, 0.01, 500 + k));
    REQUIRE_FALSE(is.is_rigid());
    frequency(k) = is.frequency_hz, damping(k) = is.damping;
    frequency_std(k) = is.frequency_std_hz, damping_std(k) = is.damping_std;
  }
  const auto scatter = [](const VectorXd& values) {
    return std::sqrt((values.array() - values.mean()).square().sum() / static_cast<double>(values.size() - 1));
  };
  // Twelve draws know a scatter to 21 %: 1.6 is three of these.
  CHECK(scatter(frequency) < 1.6 * frequency_std.mean());
  CHECK(scatter(damping) < 1.6 * damping_std.mean());
  CHECK(frequency_std.maxCoeff() < 0.5);
  CHECK(damping_std.maxCoeff() < 0.05);
}

}  // namespace test_sensors_mount
