#include "kinds/record.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "kinds/drive.hpp"
#include "kinds/random_stream.hpp"

namespace kinds {
namespace {

constexpr double TURN = 2.0 * std::numbers::pi;

double rms(const double* values, std::size_t count) {
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) sum += values[i] * values[i];
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(count, 1)));
}
double rms(const std::vector<double>& values) {
  return rms(values.data(), values.size());
}

/// A record in the making: what acts on it, on the grid of half steps, which begins `margin` before the record.
struct Plan {
  Record record;
  State start{};
  std::vector<Drive> drive;
  std::vector<double> early, base;
  int steps = 2;
  [[nodiscard]] std::size_t stride() const { return 2 * static_cast<std::size_t>(steps); }
  [[nodiscard]] double half_step() const { return 0.5 / (record.rate_hz * steps); }
};

bool is(const Law& law, std::initializer_list<const char*> kinds) {
  return std::any_of(kinds.begin(), kinds.end(), [&](const char* kind) { return law.kind == kind; });
}

void draw_scales(Plan& plan, RandomStream& random) {
  Record& record = plan.record;
  Law& law = record.law;
  const bool driven = is(law, {"late_input", "second_force"});
  const bool decay = !driven && random.uniform() < 0.25;
  record.natural_hz = random.log_uniform(0.5, decay ? 6.0 : 20.0);
  law.omega = TURN * record.natural_hz;
  law.duration = std::round(std::max(random.log_uniform(20.0, 120.0), 15.0 / record.natural_hz));
  do record.rate_hz = random.pick(std::array{50.0, 100.0, 125.0, 200.0, 250.0, 256.0, 400.0, 500.0});
  while (record.rate_hz < 12.0 * record.natural_hz);
  law.x_scale = std::clamp(random.log_uniform(0.3, 30.0) / (law.omega * law.omega), 1e-4, 0.2);
  record.noise = random.uniform() < 0.15 ? 0.0 : random.log_uniform(5e-4, 0.02);
  record.mass_kg = random.log_uniform(0.2, 50.0);
  record.excitation = decay ? "none" : random.uniform() < 0.55 ? "force" : "base";
  record.drive = decay ? "decay" : random.pick(std::array{"noise", "multisine", "sweep", "steps"});
  law.input_gain = decay ? 0.0 : record.excitation == "force" ? 1.0 / record.mass_kg : -1.0;
  const double stiffest = law.kind == "hard_stop" ? 12.0 : 3.0;
  plan.steps = std::max(2, static_cast<int>(std::ceil(stiffest * law.omega / record.rate_hz / 0.12)));
}

/// The part of the law that candidates hold. In a decay damping is such that motion lasts about as long as the record.
void draw_polynomial(Law& law, bool decay, RandomStream& random) {
  const double w = law.omega, x = law.x_scale, turns = w * law.duration / TURN;
  const double lasting = 1.0 / (w * law.duration);
  auto& p = law.polynomial;
  p[1] = -w * w;
  p[2] = -2.0 * w * (decay ? random.uniform(1.5, 4.0) * lasting : random.log_uniform(0.008, 0.1));
  if (law.kind == "drifting_damper" && !decay) p[2] = -2.0 * w * random.uniform(0.02, 0.1);
  if (is(law, {"hardening", "hardening_coulomb"})) p[6] = -w * w / (x * x) * random.log_uniform(0.1, 3.0);
  if (law.kind == "softening") p[6] = w * w / (x * x) * random.uniform(0.05, 0.18);
  if (law.kind == "asymmetric") {
    p[3] = w * w / x * random.sign() * random.uniform(0.15, 0.6);
    p[6] = -w * w / (x * x) * random.uniform(0.15, 0.6);
  }
  if (law.kind == "bistable") {
    p[1] = w * w;
    p[6] = -w * w / (x * x) * random.uniform(0.5, 1.5);
  }
  if (is(law, {"coulomb", "hardening_coulomb", "stribeck"}))
    law.friction = -w * w * x * (decay ? 0.25 / (turns * random.uniform(0.4, 1.0)) : random.log_uniform(0.03, 0.25));
  if (law.kind == "cubic_damping")
    p[9] = -(decay ? random.uniform(3.0, 25.0) * lasting : random.log_uniform(0.03, 0.3)) / (w * x * x);
  if (law.kind == "amplitude_damping")
    p[7] = -w / (x * x) * (decay ? random.uniform(8.0, 80.0) * lasting : random.log_uniform(0.05, 0.5));
  if (law.kind == "self_excited") {
    p[2] = 2.0 * w * random.uniform(0.02, 0.15);
    p[7] = -4.0 * p[2] / (x * x) * random.uniform(0.7, 1.4);
  }
  const bool wrong = std::find(RIGHT.begin(), RIGHT.end(), law.kind) == RIGHT.end();
  if (wrong && random.uniform() < 0.3) p[6] = -w * w / (x * x) * random.uniform(0.1, 0.6);
}

void draw_shape(Law& law, RandomStream& random) {
  if (law.kind == "one_sided_spring") law.shape = random.uniform(-0.2, 0.5);
  if (law.kind == "gap") law.shape = random.uniform(0.1, 0.6);
  if (law.kind == "hard_stop") law.shape = random.log_uniform(20.0, 150.0);
  if (law.kind == "stribeck") law.shape = random.uniform(0.05, 0.3);
  if (is(law, {"bouc_wen", "tanh_friction"})) law.shape = random.uniform(0.1, 0.8);
  if (is(law, {"drifting_spring", "x_abs_x", "saturated_sensor"})) law.shape = random.sign();
  if (law.kind == "mathieu") law.shape = random.uniform(0.2, 2.5);
  if (law.kind == "hidden_mass") law.shape = random.uniform(0.5, 2.5);
  if (law.kind == "magnet") law.shape = random.uniform(1.3, 2.5);
}

/// The input of which a linear oscillator's x would have an rms of `wanted` scales.
void draw_drive(Plan& plan, RandomStream& random) {
  Record& record = plan.record;
  Law& law = record.law;
  const auto samples = static_cast<std::size_t>(law.duration * record.rate_hz) + 1;
  const auto margin = static_cast<std::size_t>(0.5 / record.natural_hz / plan.half_step());
  const std::size_t count = (samples - 1) * plan.stride() + 3;
  plan.drive.assign(count, {});
  const double unit = law.omega * law.omega * law.x_scale;
  if (record.excitation != "none") {
    const double low = record.natural_hz * random.uniform(0.2, 0.6),
                 high = record.natural_hz * random.uniform(1.4, 3.0);
    Signal signal = draw_signal(record.drive, random, low, high, plan.half_step(), count + margin);
    for (std::size_t i = 0; i < count; ++i) plan.drive[i].input = signal.value[i + margin];
    Law linear{"linear", {}, 0.0, law.input_gain, 0.0, 0.0, law.x_scale, law.omega, law.duration};
    linear.polynomial[1] = -law.omega * law.omega;
    linear.polynomial[2] = -std::max(std::abs(law.polynomial[2]), 0.03 * law.omega);
    linear.x_scale = 1e300;
    const double level = random.uniform(0.4, 0.9) * law.x_scale /
                         rms(integrate(linear, {}, plan.drive, 1.0 / record.rate_hz, plan.steps).x);
    for (Drive& drive : plan.drive) drive.input *= level;
    for (double& value : signal.value) value *= level;
    for (double& value : signal.twice_integrated) value *= level;
    plan.early = std::move(signal.value);
    if (record.excitation == "base" && random.uniform() < 0.5) plan.base = std::move(signal.twice_integrated);
  }
  std::vector<double> hidden;
  if (law.kind == "second_force")
    hidden = draw_signal(random.pick(std::array{"noise", "multisine", "steps"}), random, 0.3 * record.natural_hz,
                         2.5 * record.natural_hz, plan.half_step(), count)
                 .value;
  if (law.kind == "impacts")
    hidden = draw_pushes(random, random.uniform(5.0, 25.0) / record.natural_hz, plan.half_step(), count);
  for (std::size_t i = 0; i < hidden.size(); ++i) plan.drive[i].hidden = unit * hidden[i];
  const double away = law.kind == "self_excited" ? 0.2 : random.uniform(1.0, 1.5);
  if (record.excitation == "none") plan.start[0] = random.sign() * away * law.x_scale;
  if (law.kind == "bistable" && record.excitation == "none") plan.start[0] *= random.uniform(1.0, 2.0);
  if (law.kind == "hidden_mass") plan.start[2] = plan.start[0];
}

/// level * tanh(value / level), at every value.
void saturate(std::vector<double>& values, double level) {
  for (double& value : values) value = level * std::tanh(value / level);
}

/// u = L tanh(x / L) with its derivatives, which is what a saturated displacement sensor sees move.
void saturate_motion(Signals& signals, double level) {
  for (std::size_t i = 0; i < signals.x.size(); ++i) {
    const double u = std::tanh(signals.x[i] / level), slope = 1.0 - u * u, v = signals.v[i];
    signals.x[i] = level * u;
    signals.a[i] = slope * signals.a[i] - 2.0 * u * slope / level * v * v;
    signals.v[i] = slope * v;
  }
}

Signals recorded(Plan& plan) {
  Record& record = plan.record;
  const Law& law = record.law;
  Signals signals{record.motion.x, record.motion.v, record.motion.a, {}, {}};
  const std::size_t margin = plan.early.empty() ? 0 : plan.early.size() - plan.drive.size();
  const double lag = law.kind == "late_input" ? law.strength * 0.1 / record.natural_hz / plan.half_step() : 0.0;
  const std::size_t shift = std::min(margin, static_cast<std::size_t>(lag + 0.5));
  record.lag_s = static_cast<double>(shift) * plan.half_step();
  for (std::size_t i = 0; i < signals.x.size() && !plan.early.empty(); ++i) {
    signals.input.push_back(plan.early[margin + i * plan.stride() - shift]);
    if (!plan.base.empty()) signals.base.push_back(plan.base[margin + i * plan.stride() - shift]);
  }
  if (law.kind == "saturated_sensor") {
    const bool input = law.shape > 0.0 && record.excitation == "force";
    const double level = (input ? rms(signals.input) : law.x_scale) / law.strength;
    input ? saturate(signals.input, level) : saturate_motion(signals, level);
  }
  return signals;
}

/// Motion under the law as it stands; false: it runs away, sticks, ends early, or reaches the magnet.
bool moves(Plan& plan) {
  Record& record = plan.record;
  record.motion = integrate(record.law, plan.start, plan.drive, 1.0 / record.rate_hz, plan.steps);
  if (!record.motion.finite) return false;
  record.signals = recorded(plan);
  const std::vector<double>& x = record.motion.x;
  const std::vector<double>& v = record.motion.v;
  record.share_term = rms(record.motion.missing) / rms(record.motion.a);
  record.share_left = left_over_share(library_columns(record.signals), record.signals.a);
  if (record.law.kind == "magnet" &&
      *std::max_element(x.begin(), x.end()) > 0.85 * record.law.shape * record.law.x_scale)
    return false;
  if (record.excitation != "none") return record.motion.stuck_share < 0.1;
  return rms(&v[v.size() / 3], v.size() / 3) > 0.04 * rms(v.data(), v.size() / 10);
}

/// The strength with which the share is within a third of the wanted one.
bool tune(Plan& plan, double wanted) {
  Law& law = plan.record.law;
  const double most = law.kind == "drifting_spring" ? (law.shape < 0.0 ? 0.85 : 3.0)
                      : law.kind == "mathieu"       ? 1.5
                                                    : 30.0;
  law.strength = 0.3;
  for (int trial = 0; trial < 8; ++trial) {
    const double share = moves(plan) ? plan.record.share_left : 2.0 * wanted;
    if (share == plan.record.share_left && share >= 0.02 && share <= 0.5 && std::abs(std::log(share / wanted)) < 0.3)
      return true;
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

/// Columns as a laboratory may write them, each with white noise of `noise` times the rms of its signal.
void draw_columns(Plan& plan, RandomStream& random) {
  Record& record = plan.record;
  const Signals& signals = record.signals;
  const auto style = static_cast<int>(random.uniform(0.0, 3.0));
  const auto headed = [&](const std::string& name, const std::string& unit) {
    return style == 0 ? name + "_" + unit : style == 1 ? name + " [" + unit + "]" : name + " (" + unit + ")";
  };
  const auto add = [&](const char* name, const Unit& unit, std::vector<double> values, double reference) {
    for (double& value : values) value = unit.per_si * (value + record.noise * reference * random.normal());
    record.columns.push_back({headed(name, unit.name), std::move(values)});
  };
  const auto sum = [](std::vector<double> left, const std::vector<double>& right) {
    for (std::size_t i = 0; i < left.size(); ++i) left[i] += right[i];
    return left;
  };
  const bool ms = random.uniform() < 0.15;
  std::vector<double> time(signals.x.size());
  for (std::size_t i = 0; i < time.size(); ++i) time[i] = static_cast<double>(i) / record.rate_hz * (ms ? 1e3 : 1.0);
  record.columns.push_back({headed(random.pick(std::array{"time", "t"}), ms ? "ms" : "s"), std::move(time)});
  const Unit length = random.pick(LENGTHS), gravity = random.pick(ACCELERATIONS);
  const double moved = rms(signals.x);
  const bool accelerometer = random.uniform() < 0.4 && !(record.law.kind == "saturated_sensor");
  if (!signals.base.empty()) {
    add("base", length, signals.base, moved);
    add("payload", length, sum(signals.x, signals.base), moved);
    return;
  }
  if (record.excitation == "base") {
    add(random.pick(std::array{"x", "rel_disp"}), length, signals.x, moved);
    add("base_acceleration", gravity, signals.input, rms(signals.input));
    if (accelerometer) add("payload_acceleration", gravity, sum(signals.a, signals.input), rms(signals.a));
    return;
  }
  add(random.pick(std::array{"x", "displacement", "Weg"}), length, signals.x, moved);
  if (record.excitation == "force")
    add(random.pick(std::array{"f", "force", "Kraft"}), random.pick(FORCES), signals.input, rms(signals.input));
  if (accelerometer) add("acceleration", gravity, signals.a, rms(signals.a));
}

std::optional<Plan> drawn(std::uint64_t seed, std::uint64_t index, std::uint64_t attempt) {
  RandomStream random(seed, index, attempt);
  Plan plan;
  Law& law = plan.record.law;
  plan.record.right = index % 2 == 0;
  law.kind = plan.record.right ? RIGHT[index / 2 % RIGHT.size()] : WRONG[index / 2 % WRONG.size()];
  draw_scales(plan, random);
  draw_polynomial(law, plan.record.excitation == "none", random);
  draw_shape(law, random);
  draw_drive(plan, random);
  if (!(plan.record.right ? moves(plan) : tune(plan, random.log_uniform(0.02, 0.5)))) return std::nullopt;
  draw_columns(plan, random);
  return plan;
}

}  // namespace

double left_over_share(std::vector<std::vector<double>> columns, std::vector<double> target) {
  const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  };
  const auto without = [&](std::vector<double>& a, const std::vector<double>& direction) {
    const double along = dot(a, direction);
    for (std::size_t i = 0; i < a.size(); ++i) a[i] -= along * direction[i];
  };
  const double whole = rms(target);
  std::vector<std::vector<double>> directions;
  for (std::vector<double>& column : columns) {
    const double before = std::sqrt(dot(column, column));
    for (int pass = 0; pass < 2; ++pass)
      for (const auto& direction : directions) without(column, direction);
    const double length = std::sqrt(dot(column, column));
    if (!(length > 1e-9 * before)) continue;  // a combination of the others, but for rounding
    for (double& value : column) value /= length;
    directions.push_back(column);
    without(target, column);
  }
  return rms(target) / whole;
}

std::vector<std::vector<double>> library_columns(const Signals& signals) {
  const std::size_t count = signals.x.size();
  std::vector<std::vector<double>> columns(11, std::vector<double>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const auto values = polynomial_values(signals.x[i], signals.v[i]);
    for (std::size_t j = 0; j < values.size(); ++j) columns[j][i] = values[j];
    columns[10][i] = signals.v[i] > 0.0 ? 1.0 : signals.v[i] < 0.0 ? -1.0 : 0.0;
  }
  if (!signals.input.empty()) columns.push_back(signals.input);
  return columns;
}

Record draw_record(std::uint64_t seed, std::uint64_t index) {
  for (std::uint64_t attempt = 0; attempt < 400; ++attempt) {
    if (std::optional<Plan> plan = drawn(seed, index, attempt)) {
      std::string number = std::to_string(1000 + index).substr(1);
      plan->record.name = "k" + number + "_" + plan->record.law.kind;
      return std::move(plan->record);
    }
  }
  throw std::runtime_error("no record of this kind in 400 draws");
}

}  // namespace kinds
