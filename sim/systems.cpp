#include "sim/systems.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "sim/ode/friction.hpp"

namespace sim {
namespace {

template <typename P>
struct Field {
  const char* name;
  double P::*member;
};

// The parameters by name, for settings and for the record of what was run.
template <typename P>
constexpr auto fields_of();
#define FIELD(P, name) \
  Field<P> {           \
#name, &P::name    \
  }
template <>
constexpr auto fields_of<Linear>() {
  using P = Linear;
  return std::array{FIELD(P, omega_n), FIELD(P, zeta), FIELD(P, force_n), FIELD(P, ratio), FIELD(P, x0), FIELD(P, v0)};
}
template <>
constexpr auto fields_of<Duffing>() {
  using P = Duffing;
  return std::array{FIELD(P, omega_n), FIELD(P, zeta), FIELD(P, epsilon), FIELD(P, force_n),
                    FIELD(P, ratio),   FIELD(P, x0),   FIELD(P, v0)};
}
template <>
constexpr auto fields_of<Coulomb>() {
  using P = Coulomb;
  return std::array{FIELD(P, m),       FIELD(P, c),     FIELD(P, k),  FIELD(P, c_f),
                    FIELD(P, force_n), FIELD(P, ratio), FIELD(P, x0), FIELD(P, v0)};
}
template <>
constexpr auto fields_of<BoucWen>() {
  using P = BoucWen;
  return std::array{FIELD(P, m),       FIELD(P, k),     FIELD(P, a),  FIELD(P, alpha), FIELD(P, delta), FIELD(P, gamma),
                    FIELD(P, force_n), FIELD(P, ratio), FIELD(P, x0), FIELD(P, v0),    FIELD(P, z0)};
}
template <>
constexpr auto fields_of<Valanis1>() {
  using P = Valanis1;
  return std::array{FIELD(P, m),       FIELD(P, k),     FIELD(P, e1), FIELD(P, e2), FIELD(P, alpha),
                    FIELD(P, force_n), FIELD(P, ratio), FIELD(P, x0), FIELD(P, v0), FIELD(P, z0)};
}
template <typename P>
constexpr auto fields_with_beta() {
  return std::array{FIELD(P, m),       FIELD(P, k),     FIELD(P, e1), FIELD(P, e2), FIELD(P, alpha), FIELD(P, beta),
                    FIELD(P, force_n), FIELD(P, ratio), FIELD(P, x0), FIELD(P, v0), FIELD(P, z0)};
}
template <>
constexpr auto fields_of<Valanis2>() {
  return fields_with_beta<Valanis2>();
}
template <>
constexpr auto fields_of<Valanis3>() {
  return fields_with_beta<Valanis3>();
}
template <>
constexpr auto fields_of<Valanis4>() {
  using P = Valanis4;
  return std::array{FIELD(P, m),       FIELD(P, k),     FIELD(P, e1), FIELD(P, e2), FIELD(P, alpha1), FIELD(P, alpha2),
                    FIELD(P, force_n), FIELD(P, ratio), FIELD(P, x0), FIELD(P, v0), FIELD(P, z0)};
}
#undef FIELD

template <typename P>
std::vector<std::pair<std::string, double>> values_of(const P& p) {
  std::vector<std::pair<std::string, double>> values;
  for (const auto& field : fields_of<P>()) values.emplace_back(field.name, p.*field.member);
  return values;
}

template <typename P>
Experiment make_with(std::string_view name, const std::vector<std::pair<std::string, double>>& set,
                     const Forcing& drive) {
  P parameters;
  parameters.drive = drive;
  for (const auto& [key, value] : set) {
    constexpr auto fields = fields_of<P>();
    const auto* field =
        std::find_if(fields.begin(), fields.end(), [&key = key](const auto& f) { return key == f.name; });
    if (field == fields.end()) {
      std::vector<std::string> names;
      for (const auto& f : fields) names.emplace_back(f.name);
      throw std::invalid_argument(
          fmt::format("{}: no parameter \"{}\"; there are {}", name, key, fmt::join(names, ", ")));
    }
    parameters.*field->member = value;
  }
  return make_experiment(parameters);
}

/// Signs of v and z in a mode of a system whose switches they are.
struct Signs {
  double v = 1.0, z = 1.0;
};
Signs signs_of(int mode) {
  double sides[2];
  sides_of(mode, 2, sides);
  return {sides[0] < 0.0 ? -1.0 : 1.0, sides[1] < 0.0 ? -1.0 : 1.0};
}

/// Switches v (and z if `with_z`) of y = (x, v, z), which nothing holds: the acceleration does not depend on the signs.
void add_sign_switches(System& system, bool with_z) {
  add_switches(system, {.count = with_z ? 2 : 1,
                        .value = [](int i, double, const double* y) { return y[i + 1]; },
                        .rates_at_zero = [rhs = system.rhs](int i, double t, const double* y,
                                                            const double* sides) -> std::optional<RatesAtZero> {
                          if (i == 1) return RatesAtZero{sides[0], sides[0]};  // z' = k v (1 - ...) near z = 0
                          double dydt[3];
                          rhs(t, y, 0, dydt);
                          return RatesAtZero{dydt[1], dydt[1]};
                        },
                        .settle = [](int i, int, double, double* y) { y[i + 1] = 0.0; }});
}

Forcing cosine(double omega) {
  return [omega](double t) { return std::cos(omega * t); };
}
Forcing sine(double omega) {
  return [omega](double t) { return std::sin(omega * t); };
}

const TrueTerm velocity_row{1, "v", "v", 1.0};

}  // namespace

Experiment make_experiment(const Linear& p) {
  Duffing cubic{p.omega_n, p.zeta, 0.0, p.force_n, p.ratio, p.x0, p.v0, p.drive};
  Experiment e = make_experiment(cubic);
  e.system.name = "linear";
  e.parameters = values_of(p);
  std::erase_if(e.truth, [](const TrueTerm& term) { return term.name == "x^3"; });
  return e;
}

Experiment make_experiment(const Duffing& p) {
  Experiment e;
  e.omega_n = p.omega_n;
  const double k = p.omega_n * p.omega_n, c = 2.0 * p.zeta * p.omega_n, k3 = p.epsilon * k, force = p.force_n;
  const Forcing f = p.drive ? p.drive : cosine(p.ratio * p.omega_n);
  e.system = {.name = "duffing", .states = {"x", "v"}, .rhs = [=](double t, const double* y, int, double* dydt) {
                dydt[0] = y[1];
                dydt[1] = force * f(t) - c * y[1] - k * y[0] - k3 * y[0] * y[0] * y[0];
              }};
  e.system.forcing = f;
  e.initial = Eigen::Vector2d(p.x0, p.v0);
  e.parameters = values_of(p);
  e.truth = {velocity_row, {2, "a", "f", force}, {2, "a", "v", -c}, {2, "a", "x", -k}, {2, "a", "x^3", -k3}};
  return e;
}

Experiment make_experiment(const Coulomb& p) {
  Experiment e;
  e.omega_n = std::sqrt(p.k / p.m);
  const Forcing f = p.drive ? p.drive : cosine(p.ratio * e.omega_n);
  // Mode: the sign of v, 0 for stick.
  const auto pull = [=](double t, const double* y) { return p.force_n * f(t) - p.k * y[0]; };
  e.system = {.name = "coulomb", .states = {"x", "v"}, .rhs = [=](double t, const double* y, int mode, double* dydt) {
                dydt[0] = mode == 0 ? 0.0 : y[1];
                dydt[1] = mode == 0 ? 0.0 : (pull(t, y) - p.c * y[1] - mode * p.c_f) / p.m;
              }};
  add_switches(e.system, velocity_switch([=](double t, const double* y) {
                 const double force = pull(t, y);
                 return RatesAtZero{force - p.c_f, force + p.c_f};
               }));
  e.system.max_step_s = 0.3 / (std::max(p.ratio, 1.0) * e.omega_n);
  e.system.forcing = f;
  e.initial = Eigen::Vector2d(p.x0, p.v0);
  e.parameters = values_of(p);
  e.truth = {velocity_row,
             {2, "a", "f", p.force_n / p.m},
             {2, "a", "v", -p.c / p.m},
             {2, "a", "x", -p.k / p.m},
             {2, "a", "sgn(v)", -p.c_f / p.m}};
  return e;
}

Experiment make_experiment(const BoucWen& p) {
  if (!(p.alpha > 0.0)) throw std::invalid_argument(fmt::format("bouc-wen: alpha must be positive, got {}", p.alpha));
  Experiment e;
  e.omega_n = std::sqrt(p.k / p.m);
  const Forcing f = p.drive ? p.drive : cosine(p.ratio * e.omega_n);
  // With the force s = k z: s' = k v - delta s |s|^(alpha-1) k^(1-alpha) |v| - gamma |s|^alpha k^(1-alpha) v.
  const double scale = std::pow(p.k, 1.0 - p.alpha), delta = p.delta * scale, gamma = p.gamma * scale;
  e.system = {
      .name = "bouc-wen", .states = {"x", "v", "z"}, .rhs = [=](double t, const double* y, int mode, double* dydt) {
        const auto [v_sign, s_sign] = signs_of(mode);
        const double abs_v = v_sign * y[1], abs_s = s_sign * y[2];
        // Inside a step |s| may come out negative by an iteration's error: a power of that is not a number.
        const double power = p.alpha == 1.0 ? abs_s : std::pow(std::max(abs_s, 0.0), p.alpha);
        dydt[0] = y[1];
        dydt[1] = (p.force_n * f(t) - p.a * p.k * y[0] - (1.0 - p.a) * y[2]) / p.m;
        dydt[2] = p.k * y[1] - power * (delta * s_sign * abs_v + gamma * y[1]);
      }};
  add_sign_switches(e.system, true);
  e.system.forcing = f;
  e.initial = Eigen::Vector3d(p.x0, p.v0, p.k * p.z0);
  e.parameters = values_of(p);
  const bool plain = p.alpha == 1.0;
  const std::string power = fmt::format("{}", p.alpha), less = fmt::format("{}", p.alpha - 1.0);
  e.truth = {velocity_row,
             {2, "a", "f", p.force_n / p.m},
             {2, "a", "z", -(1.0 - p.a) / p.m},
             {3, "dz", "v", p.k},
             {3, "dz", plain ? "z*abs(v)" : "z*abs(z)^" + less + "*abs(v)", -delta},
             {3, "dz", plain ? "abs(z)*v" : "abs(z)^" + power + "*v", -gamma}};
  if (p.a != 0.0) e.truth.push_back({2, "a", "x", -p.a * p.k / p.m});
  return e;
}

namespace {

/// P(x, v) must be smooth for a given sign of v.
template <typename P, typename Restoring>
Experiment valanis(const P& p, const char* name, Restoring restoring) {
  Experiment e;
  e.omega_n = std::sqrt(p.k / p.m);
  const Forcing f = p.drive ? p.drive : sine(p.ratio * e.omega_n);
  e.system = {.name = name, .states = {"x", "v", "z"}, .rhs = [=](double t, const double* y, int mode, double* dydt) {
                const double v_sign = signs_of(mode).v;
                dydt[0] = y[1];
                dydt[1] = (p.force_n * f(t) - p.k * y[0] - y[2]) / p.m;
                dydt[2] = (p.e1 + v_sign * (restoring(y[0], y[1], v_sign) - p.e2 * y[2])) * y[1];
              }};
  add_sign_switches(e.system, false);
  e.system.forcing = f;
  e.initial = Eigen::Vector3d(p.x0, p.v0, p.z0);
  e.parameters = values_of(p);
  e.truth = {velocity_row, {2, "a", "f", p.force_n / p.m}, {2, "a", "x", -p.k / p.m}, {2, "a", "z", -1.0 / p.m}};
  return e;
}

/// The third row as one equation in |v|.
void add_third_row(Experiment& e, double e1, double e2, const std::vector<std::pair<const char*, double>>& rest) {
  e.truth.push_back({3, "dz", "v", e1});
  e.truth.push_back({3, "dz", "abs(v)*z", -e2});
  for (const auto& [name, value] : rest) e.truth.push_back({3, "dz", name, value});
}

}  // namespace

Experiment make_experiment(const Valanis1& p) {
  auto e = valanis(p, "valanis-1", [=](double x, double, double) { return p.alpha * x; });
  add_third_row(e, p.e1, p.e2, {{"abs(v)*x", p.alpha}});
  return e;
}

Experiment make_experiment(const Valanis2& p) {
  auto e = valanis(p, "valanis-2",
                   [=](double x, double v, double v_sign) { return p.alpha * x + p.beta * x * x * v_sign * v; });
  add_third_row(e, p.e1, p.e2, {{"abs(v)*x", p.alpha}, {"x^2*v^2", p.beta}});
  return e;
}

Experiment make_experiment(const Valanis3& p) {
  auto e = valanis(p, "valanis-3", [=](double x, double v, double) { return p.alpha * x + p.beta * std::exp(x) * v; });
  add_third_row(e, p.e1, p.e2, {{"abs(v)*x", p.alpha}, {"exp(x)*v*abs(v)", p.beta}});
  return e;
}

Experiment make_experiment(const Valanis4& p) {
  auto e = valanis(p, "valanis-4", [=](double x, double, double v_sign) {
    return v_sign > 0.0 ? p.alpha1 * std::sin(x) : p.alpha2 * x;
  });
  const std::string up = "v >= 0", down = "v < 0";
  e.truth.insert(e.truth.end(), {{3, "dz", "v", p.e1, up},
                                 {3, "dz", "v*sin(x)", p.alpha1, up},
                                 {3, "dz", "v*z", -p.e2, up},
                                 {3, "dz", "v", p.e1, down},
                                 {3, "dz", "x*v", -p.alpha2, down},
                                 {3, "dz", "v*z", p.e2, down}});
  return e;
}

namespace {

using Make = Experiment (*)(std::string_view, const std::vector<std::pair<std::string, double>>&, const Forcing&);
constexpr std::array<std::pair<std::string_view, Make>, 8> experiments = {{{"linear", make_with<Linear>},
                                                                           {"duffing", make_with<Duffing>},
                                                                           {"coulomb", make_with<Coulomb>},
                                                                           {"bouc-wen", make_with<BoucWen>},
                                                                           {"valanis-1", make_with<Valanis1>},
                                                                           {"valanis-2", make_with<Valanis2>},
                                                                           {"valanis-3", make_with<Valanis3>},
                                                                           {"valanis-4", make_with<Valanis4>}}};

}  // namespace

std::vector<std::string> experiment_names() {
  std::vector<std::string> names;
  for (const auto& [name, make] : experiments) names.emplace_back(name);
  return names;
}

Experiment make_experiment(std::string_view name, const std::vector<std::pair<std::string, double>>& set,
                           const Forcing& drive) {
  for (const auto& [known, make] : experiments)
    if (name == known) {
      Experiment experiment = make(name, set, drive);
      if (!experiment.initial.allFinite())
        throw std::invalid_argument(
            fmt::format("{}: an initial value is beyond what a double holds. Lower x0, v0, z0 or k", name));
      return experiment;
    }
  throw std::invalid_argument(fmt::format("no system \"{}\"; there are {}", name, fmt::join(experiment_names(), ", ")));
}

}  // namespace sim
