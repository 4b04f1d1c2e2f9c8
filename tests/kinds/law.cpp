#include <algorithm>
#include <cmath>

#include "kinds/record.hpp"

namespace kinds {
namespace {

double sign_of(double value) {
  return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0;
}

/// What no candidate holds, as an acceleration. slide: the sign of v, 0 while it sticks.
double missing(const Law& law, double t, const Eigen::Array4d& y, double hidden, double slide) {
  if (law.strength == 0.0) return 0.0;
  const double s = law.strength, shape = law.shape, x = y[0] / law.x_scale, v = y[1] / (law.x_scale * law.omega);
  const auto scaled = [&] {
    const std::string& kind = law.kind;
    if (kind == "one_sided_spring") return -s * std::max(0.0, x - shape);
    if (kind == "gap") return -s * sign_of(x) * std::max(0.0, std::abs(x) - shape);
    if (kind == "hard_stop") return -shape * std::max(0.0, x - 1.5 / (1.0 + s));
    if (kind == "quadratic_damping") return -s * std::abs(v) * v;
    if (kind == "bouc_wen") return -s * y[2] / law.x_scale;
    if (kind == "drifting_spring") return -shape * s * x * t / law.duration;
    if (kind == "drifting_damper") return -0.1 * s * v * t / law.duration;
    if (kind == "mathieu") return -s * std::cos(shape * law.omega * t) * x;
    if (kind == "hidden_mass")
      return -s * shape * (shape * (x - y[2] / law.x_scale) + 0.04 * (v - y[3] / (law.x_scale * law.omega)));
    if (kind == "second_force" || kind == "impacts") return s * hidden;
    if (kind == "x_abs_x") return -shape * s * std::abs(x) * x;
    if (kind == "fifth_power") return -s * std::pow(x, 5);
    if (kind == "tanh_friction") return -s * std::tanh(v / shape);
    if (kind == "magnet") return s * (1.0 / std::pow(std::max(shape - x, 0.05), 2) - 1.0 / (shape * shape));
    return 0.0;  // saturated_sensor and late_input are in what is recorded, not in the motion
  };
  if (law.kind == "stribeck") return s * law.friction * std::exp(-std::abs(v) / shape) * slide;
  return law.omega * law.omega * law.x_scale * scaled();
}

/// Steps of the motion, which friction may cut into pieces.
class Stepper {
 public:
  Stepper(const Law& law, const Drive& drive, double h) : law_(law), drive_(drive), h_(h) {}

  /// At `part` of the step that begins at the value `at` of the drive.
  [[nodiscard]] double acceleration(const Eigen::Array4d& y, Eigen::Index at, double part, double slide) const {
    const double x = y[0], v = y[1], t = h_ * (0.5 * static_cast<double>(at) + part);
    const auto& p = law_.polynomial;
    return p[0] + x * (p[1] + x * (p[3] + x * p[6] + v * p[7]) + v * (p[4] + v * p[8])) +
           v * (p[2] + v * (p[5] + v * p[9])) + law_.input_gain * between(drive_.input, at, part) +
           law_.friction * slide + missing(law_, t, y, between(drive_.hidden, at, part), slide);
  }

  /// The sign with which a payload at rest begins to slide, 0 where friction holds it.
  [[nodiscard]] double start(const Eigen::Array4d& y, Eigen::Index at, double part) const {
    const double force = acceleration(y, at, part, 0.0), most = law_.kind == "stribeck" ? 1.0 + law_.strength : 1.0;
    return std::abs(force) <= -law_.friction * most ? 0.0 : sign_of(force);
  }

  [[nodiscard]] Eigen::Array4d slid(const Eigen::Array4d& y, Eigen::Index at, double part, double length,
                                    double slide) const {
    const double h = length * h_;
    const Eigen::Array4d k1 = slope(y, at, part, slide), k2 = slope(y + h / 2 * k1, at, part + length / 2, slide),
                         k3 = slope(y + h / 2 * k2, at, part + length / 2, slide),
                         k4 = slope(y + h * k3, at, part + length, slide);
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }

  void advance(Eigen::Array4d& y, Eigen::Index at, double& slide) const {
    if (law_.friction == 0.0) {
      y = slid(y, at, 0.0, 1.0, 0.0);
      return;
    }
    double part = 0.0;
    for (int piece = 0; piece < 8 && part < 1.0; ++piece) {
      if (slide == 0.0) slide = start(y, at, part);
      if (slide == 0.0) return;
      double before = 0.0, after = 1.0 - part;
      const Eigen::Array4d end = slid(y, at, part, after, slide);
      if (end[1] * slide >= 0.0) {
        y = end;
        return;
      }
      for (int halving = 0; halving < 40; ++halving) {  // v changes its sign between them
        const double middle = 0.5 * (before + after);
        (slid(y, at, part, middle, slide)[1] * slide >= 0.0 ? before : after) = middle;
      }
      y = slid(y, at, part, after, slide);
      y[1] = slide = 0.0;
      part += after;
    }
  }

 private:
  static double between(const Eigen::ArrayXd& values, Eigen::Index at, double part) {
    if (values.size() == 0) return 0.0;
    return (1.0 - part) * (1.0 - 2.0 * part) * values[at] + 4.0 * part * (1.0 - part) * values[at + 1] +
           part * (2.0 * part - 1.0) * values[at + 2];
  }
  [[nodiscard]] Eigen::Array4d slope(const Eigen::Array4d& y, Eigen::Index at, double part, double slide) const {
    Eigen::Array4d slope(y[1], acceleration(y, at, part, slide), 0.0, 0.0);
    if (law_.kind == "bouc_wen") {
      const double most = law_.shape * law_.x_scale;
      slope[2] = y[1] - 0.5 * (std::abs(y[1]) * y[2] + y[1] * std::abs(y[2])) / most;
    } else if (law_.kind == "hidden_mass") {
      const double omega = law_.shape * law_.omega;
      slope[2] = y[3];
      slope[3] = omega * omega * (y[0] - y[2]) + 0.04 * omega * (y[1] - y[3]);
      if (law_.input_gain == -1.0) slope[3] -= between(drive_.input, at, part);  // both masses ride on the base
    }
    return slope;
  }

  const Law& law_;
  const Drive& drive_;
  double h_;
};

}  // namespace

Signals integrate(const Law& law, Eigen::Array4d state, const Drive& drive, double sample_s, int steps, double most) {
  const Eigen::Index samples = static_cast<Eigen::Index>(law.duration / sample_s) + 1;
  Signals out;
  for (Eigen::ArrayXd* series : {&out.x, &out.v, &out.a, &out.missing}) series->resize(samples);
  const Stepper stepper(law, drive, sample_s / steps);
  double slide = sign_of(state[1]);
  for (Eigen::Index k = 0; k < samples; ++k) {
    const Eigen::Index at = 2 * steps * k;
    if (law.friction == 0.0) slide = sign_of(state[1]);
    if (slide == 0.0) slide = stepper.start(state, at, 0.0);
    const bool stuck = law.friction != 0.0 && slide == 0.0;
    out.x[k] = state[0];
    out.v[k] = state[1];
    out.a[k] = stuck ? 0.0 : stepper.acceleration(state, at, 0.0, slide);
    out.missing[k] =
        missing(law, static_cast<double>(k) * sample_s, state, drive.hidden.size() ? drive.hidden[at] : 0.0, slide);
    out.stuck_share += stuck ? 1.0 / static_cast<double>(samples) : 0.0;
    if (!(std::abs(state[0]) < most * law.x_scale)) return {};
    for (int i = 0; i < steps; ++i) stepper.advance(state, at + 2 * i, slide);
  }
  return out;
}

}  // namespace kinds
