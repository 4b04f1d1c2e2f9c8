#include "dsp/sensors/mount.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "dsp/regimes/reversals.hpp"
#include "support/signals.hpp"

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
Ridden ride(const dsp::Mount& mount, double noise) {
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
      {"x", "m", x}, {"v", "m/s", result.body_v}, {"a", "m/s^2", a + support::gaussian(n, 21, noise)}};
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
  const auto error = dsp::mount_error(ridden.motion, mount, {5.0, 8.0}, {45.0, 60.0});
  const VectorXd& read = ridden.motion.at("a");
  const Index from = 512, count = read.size() - 1024;  // the ends lean on a prediction
  const VectorXd back = read - error.acceleration;
  // What is left is above 45 Hz, where leaps have 2 % of their power.
  CHECK(support::nmse(read.segment(from, count), ridden.body_a.segment(from, count)) > 0.02);
  CHECK(support::nmse(back.segment(from, count), ridden.body_a.segment(from, count)) < 2e-3);
}
