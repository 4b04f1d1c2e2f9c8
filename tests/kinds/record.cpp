#include "kinds/record.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace kinds {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
constexpr double TURN = 2.0 * std::numbers::pi;

/// The same with every standard library (splitmix64: Steele, Lea, Flood, OOPSLA 2014).
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t index, std::uint64_t attempt) : state_(seed) {
    state_ = next() ^ index;
    state_ = next() ^ attempt;
  }
  double in(double from, double to) { return from + (to - from) * static_cast<double>(next() >> 11) * 0x1p-53; }
  double log_in(double from, double to) { return std::exp(in(std::log(from), std::log(to))); }
  bool happens(double probability) { return in(0.0, 1.0) < probability; }
  double sign() { return happens(0.5) ? -1.0 : 1.0; }
  double rayleigh() { return std::sqrt(-2.0 * std::log(1.0 - in(0.0, 1.0))); }
  double normal() { return rayleigh() * std::cos(in(0.0, TURN)); }
  template <class List>
  auto pick(const List& list) {
    return list[static_cast<std::size_t>(in(0.0, static_cast<double>(list.size())))];
  }

 private:
  std::uint64_t next() {
    std::uint64_t mixed = state_ += 0x9e3779b97f4a7c15U;
    mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9U;
    mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111ebU;
    return mixed ^ (mixed >> 31);
  }
  std::uint64_t state_;
};

double rms(const ArrayXd& values) {
  return std::sqrt(values.square().mean());
}

/// A signal of rms about 1 at `count` moments, with frequencies between low and high; of lines also what it is twice
/// integrated.
struct Signal {
  ArrayXd value, twice_integrated;
};

Signal lines(Random& random, int number, double low, double high, double step_s, Index count) {
  Signal signal{ArrayXd::Zero(count), ArrayXd::Zero(count)};
  for (int n = 0; n < number; ++n) {
    const double omega = TURN * (low + (high - low) * (n + random.in(0.0, 1.0)) / number);
    const std::complex<double> turn = std::polar(1.0, omega * step_s);
    std::complex<double> line = std::polar(random.rayleigh() / std::sqrt(number), random.in(0.0, TURN));
    for (Index i = 0; i < count; ++i, line *= turn) {
      signal.value[i] += line.real();
      signal.twice_integrated[i] -= line.real() / (omega * omega);
    }
  }
  return signal;
}

Signal sine(Random& random, bool stepped, double low, double high, double step_s, Index count) {
  Signal signal{ArrayXd(count), {}};
  const bool down = random.happens(0.3);
  const double from = down ? high : low, to = down ? low : high;
  const auto stage = count / static_cast<Index>(random.in(5.0, 11.0)) + 1;
  double phase = random.in(0.0, TURN), amplitude = 0.0, wanted = 1.0, hz = from;
  for (Index i = 0; i < count; ++i) {
    if (!stepped) hz = from * std::pow(to / from, static_cast<double>(i) / static_cast<double>(count));
    if (stepped && i % stage == 0) {
      hz = random.log_in(low, high);
      wanted = random.log_in(0.5, 2.0);
    }
    amplitude += (wanted - amplitude) * std::min(1.0, hz * step_s);  // over a period
    signal.value[i] = amplitude * std::sqrt(2.0) * std::sin(phase);
    phase += TURN * step_s * hz;
  }
  return signal;
}

Signal draw_signal(const std::string& kind, Random& random, double hz, double step_s, Index count) {
  const double low = hz * random.in(0.2, 0.6), high = hz * random.in(1.4, 3.0);
  if (kind == "noise") return lines(random, 150, low, high, step_s, count);
  if (kind == "multisine") return lines(random, static_cast<int>(random.in(3.0, 9.0)), low, high, step_s, count);
  return sine(random, kind == "steps", low, high, step_s, count);
}

/// Half-sine pushes at random moments.
ArrayXd pushes(Random& random, double mean_s, double step_s, Index count) {
  ArrayXd out = ArrayXd::Zero(count);
  double at = mean_s * random.in(0.0, 1.0);
  for (; at < static_cast<double>(count) * step_s; at -= mean_s * std::log(1.0 - random.in(0.0, 1.0))) {
    const double size = random.normal();
    const auto first = static_cast<Index>(at / step_s);
    const auto width = static_cast<Index>(mean_s * random.log_in(0.013, 0.2) / step_s) + 2;
    for (Index i = 0; i < std::min(width, count - first); ++i)
      out[first + i] += size * std::sin(TURN / 2 * static_cast<double>(i) / static_cast<double>(width));
  }
  return out;
}

/// A record in the making. What acts begins `margin` half steps before the record.
struct Plan {
  Record record;
  Eigen::Array4d start = Eigen::Array4d::Zero();
  Drive drive;
  Signal early;
  Index margin = 0;
  int steps = 2;
  [[nodiscard]] double half_step() const { return 0.5 / (record.rate_hz * steps); }
  [[nodiscard]] bool is(std::initializer_list<const char*> some) const {
    return std::find(some.begin(), some.end(), record.law.kind) != some.end();
  }
};

void draw_scales(Plan& plan, Random& random) {
  Record& record = plan.record;
  Law& law = record.law;
  const bool decay = !plan.is({"late_input", "second_force"}) && random.happens(0.25);
  record.natural_hz = random.log_in(0.5, decay ? 6.0 : 20.0);
  law.omega = TURN * record.natural_hz;
  law.duration = std::round(std::max(random.log_in(20.0, 120.0), 15.0 / record.natural_hz));
  do record.rate_hz = random.pick(std::array{50.0, 100.0, 125.0, 200.0, 250.0, 256.0, 400.0, 500.0});
  while (record.rate_hz < 12.0 * record.natural_hz);
  law.x_scale = std::clamp(random.log_in(0.3, 30.0) / (law.omega * law.omega), 1e-4, 0.2);
  record.noise = random.happens(0.15) ? 0.0 : random.log_in(5e-4, 0.02);
  record.excitation = decay ? "none" : random.happens(0.55) ? "force" : "base";
  record.drive = decay ? "decay" : random.pick(std::array{"noise", "multisine", "sweep", "steps"});
  law.input_gain = decay ? 0.0 : record.excitation == "force" ? 1.0 / random.log_in(0.2, 50.0) : -1.0;
  plan.steps = std::max(2, static_cast<int>((plan.is({"hard_stop"}) ? 100.0 : 25.0) * law.omega / record.rate_hz) + 1);
}

/// What candidates hold. In a decay damping is such that the motion lasts about as long as the record.
void draw_polynomial(Plan& plan, Random& random) {
  Law& law = plan.record.law;
  const bool decay = plan.record.excitation == "none";
  const double w = law.omega, x = law.x_scale, lasting = 1.0 / (w * law.duration), cubic = -w * w / (x * x);
  auto& p = law.polynomial;
  p[1] = -w * w;
  p[2] = -2.0 * w * (decay ? random.in(1.5, 4.0) * lasting : random.log_in(0.008, 0.1));
  if (plan.is({"hardening", "hardening_coulomb"})) p[6] = cubic * random.log_in(0.1, 3.0);
  if (plan.is({"softening"})) p[6] = -cubic * random.in(0.05, 0.18);
  if (plan.is({"asymmetric"})) {
    p[3] = w * w / x * random.sign() * random.in(0.15, 0.6);
    p[6] = cubic * random.in(0.15, 0.6);
  }
  if (plan.is({"bistable"})) {
    p[1] = w * w;
    p[6] = cubic * random.in(0.5, 1.5);
  }
  if (plan.is({"coulomb", "hardening_coulomb", "stribeck"}))
    law.friction = -w * w * x * (decay ? TURN / 4 * lasting / random.in(0.4, 1.0) : random.log_in(0.03, 0.25));
  if (plan.is({"cubic_damping"}))
    p[9] = -(decay ? random.in(3.0, 25.0) * lasting : random.log_in(0.03, 0.3)) / (w * x * x);
  if (plan.is({"amplitude_damping"}))
    p[7] = -w / (x * x) * (decay ? random.in(8.0, 80.0) * lasting : random.log_in(0.05, 0.5));
  if (plan.is({"self_excited"})) {
    p[2] = 2.0 * w * random.in(0.02, 0.15);
    p[7] = -4.0 * p[2] / (x * x) * random.in(0.7, 1.4);
  }
  if (!plan.record.right && random.happens(0.3)) p[6] = cubic * random.in(0.1, 0.6);
}

void draw_shape(Plan& plan, Random& random) {
  double& shape = plan.record.law.shape;
  if (plan.is({"one_sided_spring"})) shape = random.in(-0.2, 0.5);
  if (plan.is({"gap"})) shape = random.in(0.1, 0.6);
  if (plan.is({"hard_stop"})) shape = random.log_in(20.0, 150.0);
  if (plan.is({"stribeck"})) shape = random.in(0.05, 0.3);
  if (plan.is({"bouc_wen", "tanh_friction"})) shape = random.in(0.1, 0.8);
  if (plan.is({"drifting_spring", "x_abs_x", "saturated_sensor"})) shape = random.sign();
  if (plan.is({"mathieu"})) shape = random.in(0.2, 2.5);
  if (plan.is({"hidden_mass"})) shape = random.in(0.5, 2.5);
  if (plan.is({"magnet"})) shape = random.in(1.3, 2.5);
}

/// The input of which a linear oscillator's x would have an rms of .4 to .9 scales, or a release from rest.
void draw_drive(Plan& plan, Random& random) {
  Record& record = plan.record;
  const Law& law = record.law;
  const Index count = 2 * plan.steps * (static_cast<Index>(law.duration * record.rate_hz) + 1) + 1;
  const double hz = record.natural_hz, h = plan.half_step();
  if (record.excitation != "none") {
    plan.margin = static_cast<Index>(0.5 / hz / h);
    plan.early = draw_signal(record.drive, random, hz, h, count + plan.margin);
    plan.drive.input = plan.early.value.tail(count);
    Law linear{.kind = "linear", .input_gain = law.input_gain, .omega = law.omega, .duration = law.duration};
    linear.polynomial[1] = -law.omega * law.omega;
    linear.polynomial[2] = -std::max(std::abs(law.polynomial[2]), 0.03 * law.omega);
    const double moved = rms(integrate(linear, plan.start, plan.drive, 1.0 / record.rate_hz, plan.steps, 1e300).x);
    const double level = random.in(0.4, 0.9) * law.x_scale / moved;
    for (ArrayXd* series : {&plan.drive.input, &plan.early.value, &plan.early.twice_integrated}) *series *= level;
    if (record.excitation != "base" || random.happens(0.5)) plan.early.twice_integrated.resize(0);
  } else {
    plan.start[0] = random.sign() * (plan.is({"self_excited"}) ? 0.2 : random.in(1.0, 2.0)) * law.x_scale;
    plan.start[2] = plan.is({"hidden_mass"}) ? plan.start[0] : 0.0;
  }
  if (plan.is({"second_force"}))
    plan.drive.hidden = draw_signal(random.pick(std::array{"noise", "multisine", "steps"}), random, hz, h, count).value;
  if (plan.is({"impacts"})) plan.drive.hidden = pushes(random, random.in(5.0, 25.0) / hz, h, count);
}

/// Late inputs, and u = L tanh(s / L) of a saturated sensor; of a displacement with its derivatives.
void record_signals(Plan& plan) {
  Record& record = plan.record;
  Signals& signals = record.signals;
  const double strength = record.law.strength;
  const double lag = plan.is({"late_input"}) ? strength * 0.1 / record.natural_hz / plan.half_step() : 0.0;
  const Index shift = std::min(plan.margin, static_cast<Index>(lag + 0.5));
  record.lag_s = static_cast<double>(shift) * plan.half_step();
  const auto sampled = [&](const ArrayXd& series) -> ArrayXd {
    if (series.size() == 0) return {};
    return ArrayXd::NullaryExpr(signals.x.size(),
                                [&](Index i) { return series[plan.margin + 2 * plan.steps * i - shift]; });
  };
  signals.input = sampled(plan.early.value);
  signals.base = sampled(plan.early.twice_integrated);
  if (!plan.is({"saturated_sensor"})) return;
  if (record.law.shape > 0.0 && record.excitation == "force") {
    const double level = rms(signals.input) / strength;
    signals.input = level * (signals.input / level).tanh();
  } else {
    const double level = record.law.x_scale / strength;
    const ArrayXd u = (signals.x / level).tanh(), slope = 1.0 - u.square();
    signals.x = level * u;
    signals.a = slope * signals.a - 2.0 / level * u * slope * signals.v.square();
    signals.v = slope * signals.v;
  }
}

/// Motion under the law as it stands; false: it runs away, reaches the magnet, sticks, ends early, or shows what is
/// missing at the ends of the record alone.
bool moves(Plan& plan) {
  Record& record = plan.record;
  record.signals = integrate(record.law, plan.start, plan.drive, 1.0 / record.rate_hz, plan.steps, 20.0);
  Signals& signals = record.signals;
  const Index count = signals.x.size();
  if (count == 0) return false;
  record.share_term = rms(signals.missing) / rms(signals.a);
  const bool met = plan.is({"magnet"}) && signals.x.maxCoeff() > 0.85 * record.law.shape * record.law.x_scale;
  const bool ended = record.excitation != "none"
                         ? signals.stuck_share > 0.1
                         : rms(signals.v.segment(count / 3, count / 3)) < 0.04 * rms(signals.v.head(count / 10));
  // What acts at the very ends alone is in none of the rows that filters leave.
  const bool at_ends = rms(signals.missing.segment(count / 10, count - count / 5)) < 0.5 * rms(signals.missing);
  record_signals(plan);
  const Eigen::MatrixXd columns = library_columns(signals);
  const Eigen::VectorXd a = signals.a.matrix();
  record.share_left = (a - columns * columns.colPivHouseholderQr().solve(a)).norm() / a.norm();
  return !met && !ended && !at_ends;
}

/// The strength with which the share that is left is within a third of the wanted one.
bool tune(Plan& plan, double wanted) {
  Law& law = plan.record.law;
  const double most = plan.is({"drifting_spring"}) ? (law.shape < 0.0 ? 0.85 : 3.0) : plan.is({"mathieu"}) ? 1.5 : 30.0;
  law.strength = 0.3;
  for (int trial = 0; trial < 8; ++trial) {
    const bool moved = moves(plan);
    const double share = moved ? plan.record.share_left : 2.0 * wanted;
    if (moved && share >= 0.02 && share <= 0.5 && std::abs(std::log(share / wanted)) < 0.3) return true;
    law.strength = std::min(most, law.strength * std::clamp(wanted / share, 0.3, 4.0));
  }
  return false;
}

struct Unit {
  const char* name;
  double per_si;
};
constexpr std::array<Unit, 5> LENGTHS = {{{"m", 1.0}, {"mm", 1e3}, {"um", 1e6}, {"cm", 1e2}, {"in", 1.0 / 0.0254}}};
constexpr std::array<Unit, 3> ACCELERATIONS = {{{"m/s2", 1.0}, {"g", 1.0 / 9.80665}, {"mm/s2", 1e3}}};
constexpr std::array<Unit, 3> FORCES = {{{"N", 1.0}, {"kN", 1e-3}, {"lbf", 1.0 / 4.4482216152605}}};

/// Columns as laboratories write them, with white noise of `noise` times the rms of the motion or the input.
void draw_columns(Plan& plan, Random& random) {
  Record& record = plan.record;
  const Signals& signals = record.signals;
  const auto style = random.pick(std::array<std::array<const char*, 2>, 3>{{{"_", ""}, {" [", "]"}, {" (", ")"}}});
  const auto add = [&](const char* name, const Unit& unit, const ArrayXd& values, const ArrayXd& like) {
    const double deviation = record.noise * rms(like);
    const bool inch = unit.name == std::string("in");  // x_in may be an input
    record.columns.push_back({std::string(name) + (inch ? " [" : style[0]) + unit.name + (inch ? "]" : style[1]),
                              unit.per_si * values.unaryExpr([&](double value) {
                                return deviation > 0.0 ? value + deviation * random.normal() : value;
                              })});
  };
  const Unit second = random.happens(0.15) ? Unit{"ms", 1e3} : Unit{"s", 1.0};
  const Index count = signals.x.size();
  add(random.pick(std::array{"time", "t"}), second,
      ArrayXd::LinSpaced(count, 0.0, static_cast<double>(count - 1) / record.rate_hz), ArrayXd::Zero(1));
  const Unit length = random.pick(LENGTHS), gravity = random.pick(ACCELERATIONS);
  const bool accelerometer = random.happens(0.4) && !plan.is({"saturated_sensor"});
  if (signals.base.size() > 0) {
    add("base", length, signals.base, signals.x);
    add("payload", length, signals.x + signals.base, signals.x);
  } else if (record.excitation == "base") {
    add(random.pick(std::array{"x", "rel_disp"}), length, signals.x, signals.x);
    add("base_acceleration", gravity, signals.input, signals.input);
    if (accelerometer) add("payload_acceleration", gravity, signals.a + signals.input, signals.a);
  } else {
    add(random.pick(std::array{"x", "displacement", "Weg"}), length, signals.x, signals.x);
    if (record.excitation == "force")
      add(random.pick(std::array{"f", "force", "Kraft"}), random.pick(FORCES), signals.input, signals.input);
    if (accelerometer) add("acceleration", gravity, signals.a, signals.a);
  }
}

std::optional<Record> drawn(std::uint64_t seed, std::uint64_t index, std::uint64_t attempt) {
  Random random(seed, index, attempt);
  Plan plan;
  Record& record = plan.record;
  record.right = index % 2 == 0;
  record.law.kind = record.right ? RIGHT[index / 2 % RIGHT.size()] : WRONG[index / 2 % WRONG.size()];
  record.name = "k" + std::to_string(1000 + index).substr(1) + "_" + record.law.kind;
  draw_scales(plan, random);
  draw_polynomial(plan, random);
  draw_shape(plan, random);
  draw_drive(plan, random);
  if (!(record.right ? moves(plan) : tune(plan, random.log_in(0.02, 0.5)))) return std::nullopt;
  draw_columns(plan, random);
  return std::move(record);
}

}  // namespace

Eigen::MatrixXd library_columns(const Signals& signals) {
  const ArrayXd &x = signals.x, &v = signals.v;
  Eigen::ArrayXXd columns(x.size(), signals.input.size() > 0 ? 12 : 11);
  columns.leftCols(11) << ArrayXd::Ones(x.size()), x, v, x.square(), x * v, v.square(), x.cube(), x.square() * v,
      x * v.square(), v.cube(), v.sign();
  if (columns.cols() > 11) columns.col(11) = signals.input;
  return columns.matrix().colwise().normalized();
}

Record draw_record(std::uint64_t seed, std::uint64_t index) {
  for (std::uint64_t attempt = 0; attempt < 400; ++attempt)
    if (std::optional<Record> record = drawn(seed, index, attempt)) return *std::move(record);
  throw std::runtime_error("no record of this kind in 400 draws");
}

}  // namespace kinds
