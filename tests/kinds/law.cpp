#include "kinds/law.hpp"

#include <algorithm>
#include <cmath>

namespace kinds {
namespace {

double sign_of(double value) {
  return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0;
}

/// The pull of a magnet at d - x, less its value at 0.
double pull_of(double x, double d) {
  const double left = std::max(d - x, 0.05 * d);
  return 1.0 / (left * left) - 1.0 / (d * d);
}

/// Slopes of the inner state: Bouc-Wen, or a mass that hangs on the payload.
void inner_slopes(const Law& law, const State& y, const Drive& drive, State& slope) {
  if (law.kind == "bouc_wen") {
    const double most = law.shape * law.x_scale;
    slope[2] = y[1] - 0.5 * (std::abs(y[1]) * y[2] + y[1] * std::abs(y[2])) / most;
  } else if (law.kind == "hidden_mass") {
    const double omega = law.shape * law.omega;
    slope[2] = y[3];
    slope[3] = omega * omega * (y[0] - y[2]) + 0.04 * omega * (y[1] - y[3]);
    if (law.input_gain == -1.0) slope[3] -= drive.input;  // both masses ride on the base
  }
}

double smooth_acceleration(const Law& law, double t, const State& y, const Drive& drive, double slide) {
  const auto values = polynomial_values(y[0], y[1]);
  double sum = law.input_gain * drive.input + missing_acceleration(law, t, y, drive, slide);
  for (std::size_t i = 0; i < values.size(); ++i) sum += law.polynomial[i] * values[i];
  return sum;
}

Drive between(const Drive* three, double part) {
  const double first = (1.0 - part) * (1.0 - 2.0 * part), middle = 4.0 * part * (1.0 - part),
               last = part * (2.0 * part - 1.0);
  return {first * three[0].input + middle * three[1].input + last * three[2].input,
          first * three[0].hidden + middle * three[1].hidden + last * three[2].hidden};
}

/// One step of the drive's table, which friction may cut into pieces.
class Step {
 public:
  Step(const Law& law, const Drive* three, double t, double h) : law_(law), three_(three), t_(t), h_(h) {}

  /// From `part` of the step, over `length` of it, sliding with the sign `slide`.
  [[nodiscard]] State slid(const State& y, double part, double length, double slide) const {
    const double h = length * h_;
    const State k1 = slopes(y, part, slide), k2 = slopes(moved(y, k1, h / 2), part + length / 2, slide),
                k3 = slopes(moved(y, k2, h / 2), part + length / 2, slide),
                k4 = slopes(moved(y, k3, h), part + length, slide);
    State out = y;
    for (std::size_t i = 0; i < y.size(); ++i) out[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    return out;
  }

  /// The sign with which a payload at rest begins to slide, 0 where friction holds it.
  [[nodiscard]] double start(const State& y, double part) const {
    const double force = smooth_acceleration(law_, t_ + part * h_, y, between(three_, part), 0.0);
    return std::abs(force) <= law_.static_friction() ? 0.0 : sign_of(force);
  }

  void advance(State& y, double& slide) const {
    double part = 0.0;
    for (int piece = 0; piece < 8 && part < 1.0; ++piece) {
      if (slide == 0.0) slide = start(y, part);
      if (slide == 0.0) return;
      const State end = slid(y, part, 1.0 - part, slide);
      if (end[1] * slide >= 0.0) {
        y = end;
        return;
      }
      double before = 0.0, after = 1.0 - part;  // v changes its sign between them
      for (int halving = 0; halving < 40; ++halving) {
        const double middle = 0.5 * (before + after);
        (slid(y, part, middle, slide)[1] * slide >= 0.0 ? before : after) = middle;
      }
      y = slid(y, part, after, slide);
      y[1] = 0.0;
      part += after;
      slide = 0.0;
    }
  }

 private:
  [[nodiscard]] State slopes(const State& y, double part, double slide) const {
    const Drive drive = between(three_, part);
    State slope{y[1], smooth_acceleration(law_, t_ + part * h_, y, drive, slide) + law_.friction * slide, 0.0, 0.0};
    inner_slopes(law_, y, drive, slope);
    return slope;
  }
  static State moved(State y, const State& slope, double h) {
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += h * slope[i];
    return y;
  }

  const Law& law_;
  const Drive* three_;
  double t_, h_;
};

}  // namespace

double Law::static_friction() const {
  return -friction * (kind == "stribeck" ? 1.0 + strength : 1.0);
}

std::array<double, 10> polynomial_values(double x, double v) {
  return {1.0, x, v, x * x, x * v, v * v, x * x * x, x * x * v, x * v * v, v * v * v};
}

double missing_acceleration(const Law& law, double t, const State& y, const Drive& drive, double slide) {
  if (law.strength == 0.0) return 0.0;
  const double s = law.strength, unit = law.omega * law.omega * law.x_scale, x = y[0] / law.x_scale,
               v = y[1] / (law.x_scale * law.omega);
  const std::string& kind = law.kind;
  if (kind == "one_sided_spring") return -s * unit * std::max(0.0, x - law.shape);
  if (kind == "gap") return -s * unit * sign_of(x) * std::max(0.0, std::abs(x) - law.shape);
  if (kind == "hard_stop") return -law.shape * unit * std::max(0.0, x - 1.5 / (1.0 + s));
  if (kind == "quadratic_damping") return -s * unit * std::abs(v) * v;
  if (kind == "stribeck") return s * law.friction * std::exp(-std::abs(v) / law.shape) * slide;
  if (kind == "bouc_wen") return -s * law.omega * law.omega * y[2];
  if (kind == "drifting_spring") return -law.shape * s * unit * x * t / law.duration;
  if (kind == "drifting_damper") return -s * 0.1 * unit * v * t / law.duration;
  if (kind == "mathieu") return -s * unit * std::cos(law.shape * law.omega * t) * x;
  if (kind == "hidden_mass") {
    const double omega = law.shape * law.omega;
    return -s * (omega * omega * (y[0] - y[2]) + 0.04 * omega * (y[1] - y[3]));
  }
  if (kind == "second_force" || kind == "impacts") return s * drive.hidden;
  if (kind == "x_abs_x") return -law.shape * s * unit * std::abs(x) * x;
  if (kind == "fifth_power") return -s * unit * x * x * x * x * x;
  if (kind == "tanh_friction") return -s * unit * std::tanh(v / law.shape);
  if (kind == "magnet") return s * unit * pull_of(x, law.shape);
  return 0.0;  // saturated_sensor and late_input are in what is recorded, not in the motion
}

Motion integrate(const Law& law, State state, const std::vector<Drive>& drive, double sample_s, int steps) {
  Motion motion;
  const std::size_t stride = 2 * static_cast<std::size_t>(steps), samples = (drive.size() - 1) / stride + 1;
  const double h = sample_s / steps;
  const bool rubs = law.friction != 0.0;
  double slide = sign_of(state[1]);
  for (std::size_t k = 0; k < samples; ++k) {
    const Drive* now = &drive[k * stride];  // the last sample has none behind it, and start() looks at the first alone
    const double t = static_cast<double>(k) * sample_s;
    if (rubs && slide == 0.0) slide = Step(law, now, t, h).start(state, 0.0);
    const double sense = rubs ? slide : sign_of(state[1]);
    const double missing = missing_acceleration(law, t, state, *now, sense);
    const bool stuck = rubs && slide == 0.0;
    motion.x.push_back(state[0]);
    motion.v.push_back(state[1]);
    motion.missing.push_back(missing);
    motion.a.push_back(stuck ? 0.0 : smooth_acceleration(law, t, state, *now, sense) + law.friction * sense);
    motion.stuck_share += stuck ? 1.0 / static_cast<double>(samples) : 0.0;
    if (!(std::abs(state[0]) < 20.0 * law.x_scale)) {
      motion.finite = false;
      return motion;
    }
    for (int i = 0; i < steps && k + 1 < samples; ++i) {
      const Step step(law, now + 2 * i, t + i * h, h);
      if (rubs)
        step.advance(state, slide);
      else
        state = step.slid(state, 0.0, 1.0, sign_of(state[1]));
    }
  }
  return motion;
}

}  // namespace kinds
