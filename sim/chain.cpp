#include "sim/chain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "sim/noise.hpp"
#include "sim/ode/friction.hpp"

namespace sim {
namespace {

using std::size_t;

constexpr int most_masses = max_switches;

struct Line {
  double omega, cosine, sine;
};

/// A chain with its drive, as the integration asks for it.
struct DrivenChain {
  Chain chain;
  Drive drive;

  [[nodiscard]] size_t size() const { return chain.masses.size(); }
  [[nodiscard]] double base(int order, double t) const {
    if (!chain.base_driven) return 0.0;
    return order == 0 ? drive.value(t) : order == 1 ? drive.rate(t) : drive.acceleration(t);
  }
  [[nodiscard]] double stretch(size_t link, double t, const double* y) const {
    return y[link] - (link == 0 ? base(0, t) : y[link - 1]);
  }
  [[nodiscard]] double stretch_rate(size_t link, double t, const double* y) const {
    const double* v = y + size();
    return v[link] - (link == 0 ? base(1, t) : v[link - 1]);
  }
  /// Pull of a link on the body above it; of friction only what has a side.
  [[nodiscard]] double force(size_t i, double t, const double* y, double side) const {
    const Link& link = chain.links[i];
    const double d = stretch(i, t, y);
    return -(link.stiffness * d + link.damping * stretch_rate(i, t, y) + link.cubic * d * d * d + link.friction * side);
  }
  /// Bodies whose links are held (side 0, and friction there is) go on as one.
  void accelerations(double t, const double* y, const double* sides, double* a) const {
    const size_t n = size();
    for (size_t first = 0; first < n;) {
      const auto held = [&](size_t i) { return chain.links[i].friction > 0.0 && sides[i] == 0.0; };
      const bool on_base = held(first);
      size_t behind = first + 1;
      while (behind < n && held(behind)) ++behind;
      double pull = on_base ? 0.0 : force(first, t, y, sides[first]), mass = 0.0;
      if (behind < n) pull -= force(behind, t, y, sides[behind]);
      for (size_t i = first; i < behind; ++i) mass += chain.masses[i];
      const auto driven = static_cast<size_t>(chain.driven - 1);
      if (!chain.base_driven && driven >= first && driven < behind) pull += drive.value(t);
      std::fill(a + first, a + behind, on_base ? base(2, t) : pull / mass);
      first = behind;
    }
  }
};

void add_friction(System& system, const DrivenChain& driven) {
  const auto n = static_cast<int>(driven.size());
  if (std::none_of(driven.chain.links.begin(), driven.chain.links.end(),
                   [](const Link& link) { return link.friction > 0.0; }))
    return;
  add_switches(
      system,
      {.count = n,
       .value = [driven](int i, double t,
                         const double* y) { return driven.stretch_rate(static_cast<size_t>(i), t, y); },
       .rates_at_zero = [driven](int i, double t, const double* y, const double* sides) -> std::optional<RatesAtZero> {
         const auto link = static_cast<size_t>(i);
         std::array<double, most_masses> own{}, a{};
         std::copy_n(sides, driven.size(), own.begin());
         const auto rate_on = [&](double side) {
           own[link] = side;
           driven.accelerations(t, y, own.data(), a.data());
           return a[link] - (link == 0 ? driven.base(2, t) : a[link - 1]);
         };
         const double above = rate_on(1.0);
         return RatesAtZero{above, rate_on(-1.0)};
       },
       .settle =
           [driven](int i, int, double t, double* y) {
             const auto link = static_cast<size_t>(i);
             double* v = y + driven.size();
             v[link] = link == 0 ? driven.base(1, t) : v[link - 1];
           }});
}

/// "x1", of the base "r"; "v1", "dr".
std::string coordinate(const char* letter, const char* of_base, size_t body) {
  return body == 0 ? of_base : fmt::format("{}{}", letter, body);
}

/// The terms that a link brings into the equation of body `of`, whose side of it counts with this factor.
void add_link_terms(std::vector<TrueTerm>& truth, const Chain& chain, size_t link, size_t of, double factor) {
  const Link& one = chain.links[link];
  const bool on_ground = link == 0 && !chain.base_driven;
  const std::string d =
      on_ground ? "x1" : fmt::format("({} - {})", coordinate("x", "r", link + 1), coordinate("x", "r", link));
  const std::string rate =
      on_ground ? "v1" : fmt::format("({} - {})", coordinate("v", "dr", link + 1), coordinate("v", "dr", link));
  const std::string sign = on_ground ? "sgn(v1)" : "sgn" + rate;
  for (const auto& [name, value] :
       {std::pair{d, one.stiffness}, {rate, one.damping}, {d + "^3", one.cubic}, {sign, one.friction}})
    if (value != 0.0) truth.push_back({2 * static_cast<int>(of + 1), fmt::format("a{}", of + 1), name, factor * value});
}

std::vector<TrueTerm> truth_of(const Chain& chain) {
  std::vector<TrueTerm> truth;
  for (size_t i = 0; i < chain.masses.size(); ++i) {
    const double mass = chain.masses[i];
    truth.push_back({2 * static_cast<int>(i) + 1, fmt::format("v{}", i + 1), fmt::format("v{}", i + 1), 1.0});
    add_link_terms(truth, chain, i, i, -1.0 / mass);
    if (i + 1 < chain.masses.size()) add_link_terms(truth, chain, i + 1, i, 1.0 / mass);
    if (!chain.base_driven && static_cast<int>(i) + 1 == chain.driven)
      truth.push_back({2 * static_cast<int>(i) + 2, fmt::format("a{}", i + 1), "f", 1.0 / mass});
  }
  return truth;
}

void require_sound(const Chain& chain) {
  const auto n = std::ssize(chain.masses);
  if (n < 1 || n > most_masses || std::ssize(chain.links) != n)
    throw std::invalid_argument(fmt::format("chain: 1 to {} masses are wanted, got {}", most_masses, n));
  if (std::any_of(chain.masses.begin(), chain.masses.end(), [](double m) { return !(m > 0.0) || !std::isfinite(m); }))
    throw std::invalid_argument("chain: every mass must be positive");
  if (std::any_of(chain.links.begin(), chain.links.end(), [](const Link& link) {
        return !(link.friction >= 0.0) || !std::isfinite(link.stiffness + link.damping + link.cubic + link.friction);
      }))
    throw std::invalid_argument("chain: friction must not be negative, and every coefficient finite");
  if (!chain.base_driven && (chain.driven < 1 || chain.driven > n))
    throw std::invalid_argument(fmt::format("chain: driven = {}, want a body from 1 to {}", chain.driven, n));
}

/// Member and number of "mass_2" or "mass".
double* find_coefficient(Chain& chain, const std::string& name, size_t body) {
  Link& link = chain.links[body];
  return name == "mass"        ? &chain.masses[body]
         : name == "stiffness" ? &link.stiffness
         : name == "damping"   ? &link.damping
         : name == "cubic"     ? &link.cubic
         : name == "friction"  ? &link.friction
                               : nullptr;
}

/// "mass_2" as mass and 2; of "mass" 0.
std::pair<std::string, size_t> split_name(const std::string& name) {
  const size_t bar = name.rfind('_');
  if (bar == std::string::npos || bar + 1 == name.size() || name.size() > bar + 3) return {name, 0};
  size_t number = 0;
  for (size_t i = bar + 1; i < name.size(); ++i) {
    if (name[i] < '0' || name[i] > '9') return {name, 0};
    number = 10 * number + static_cast<size_t>(name[i] - '0');
  }
  return {name.substr(0, bar), number};
}

std::vector<std::pair<std::string, double>> parameters_of(const Chain& chain) {
  std::vector<std::pair<std::string, double>> all{{"masses", static_cast<double>(chain.masses.size())},
                                                  {"base", chain.base_driven ? 1.0 : 0.0},
                                                  {"driven", chain.base_driven ? 0.0 : chain.driven}};
  for (size_t i = 0; i < chain.masses.size(); ++i) {
    const Link& link = chain.links[i];
    for (const auto& [name, value] : {std::pair{"mass", chain.masses[i]},
                                      {"stiffness", link.stiffness},
                                      {"damping", link.damping},
                                      {"cubic", link.cubic},
                                      {"friction", link.friction}})
      all.emplace_back(fmt::format("{}_{}", name, i + 1), value);
  }
  return all;
}

}  // namespace

Drive random_drive(std::uint64_t seed, double from_hz, double to_hz, double rms) {
  constexpr int count = 64;
  constexpr std::uint64_t of_drive = 2000;
  const Noise draw(seed, of_drive);
  std::vector<Line> lines;
  double square = 0.0;
  for (std::uint64_t j = 0; j < count; ++j) {
    // Evenly apart but for a fraction: no period within any record that a person would make.
    const double place = (static_cast<double>(j) + 0.5 + 0.1 * std::sin(draw.normal(3 * j))) / count;
    lines.push_back({2.0 * std::numbers::pi * (from_hz + (to_hz - from_hz) * place), draw.normal(3 * j + 1),
                     draw.normal(3 * j + 2)});
    square += 0.5 * (lines.back().cosine * lines.back().cosine + lines.back().sine * lines.back().sine);
  }
  for (Line& line : lines) line.cosine *= rms / std::sqrt(square), line.sine *= rms / std::sqrt(square);
  const auto derivative = [lines](int order) {
    return [lines, order](double t) {
      double sum = 0.0;
      for (const Line& line : lines) {
        const double phase = line.omega * t + order * 0.5 * std::numbers::pi;
        sum += std::pow(line.omega, order) * (line.cosine * std::cos(phase) + line.sine * std::sin(phase));
      }
      return sum;
    };
  };
  return {derivative(0), derivative(1), derivative(2)};
}

Drive recorded_drive(std::vector<double> samples, double sample_rate_hz) {
  if (samples.size() < 4 || !(sample_rate_hz > 0.0))
    throw std::invalid_argument("--drive: want 4 samples and more, at a positive rate");
  const auto shared = std::make_shared<const std::vector<double>>(std::move(samples));  // a system copies its functions
  const auto derivative = [&](int order) {
    return [shared, sample_rate_hz, order](double t) {
      const auto n = static_cast<std::ptrdiff_t>(shared->size());
      const double at = std::clamp(t * sample_rate_hz, 0.0, static_cast<double>(n - 1));
      const auto k = std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(at), n - 2);
      const auto value = [&](std::ptrdiff_t i) {
        return (*shared)[static_cast<size_t>(std::clamp<std::ptrdiff_t>(i, 0, n - 1))];
      };
      const double p = value(k), q = value(k + 1), dp = 0.5 * (q - value(k - 1)), dq = 0.5 * (value(k + 2) - p),
                   u = at - static_cast<double>(k), c2 = 3.0 * (q - p) - 2.0 * dp - dq, c3 = 2.0 * (p - q) + dp + dq;
      return order == 0   ? p + u * (dp + u * (c2 + u * c3))
             : order == 1 ? sample_rate_hz * (dp + u * (2.0 * c2 + 3.0 * u * c3))
                          : sample_rate_hz * sample_rate_hz * (2.0 * c2 + 6.0 * u * c3);
    };
  };
  return {derivative(0), derivative(1), derivative(2)};
}

Drive lagged(const Drive& drive, double lag_s, double duration_s) {
  constexpr double least_s = 1e-4, most_s = 1e4, longest_step_s = 5e-4, steps_a_lag = 20.0, most_steps = 1e8;
  if (!(lag_s >= least_s && lag_s <= most_s))
    throw std::invalid_argument(fmt::format("--lag {}, want seconds from {} to {}", lag_s, least_s, most_s));
  const double step_s = std::min(lag_s / steps_a_lag, longest_step_s), u = step_s / lag_s, stays = std::exp(-u),
               of_new = 1.0 - (1.0 - stays) / u;  // exact where the drive is a straight line
  const double num_steps = std::max(duration_s / step_s, 4.0) + 1.0;
  if (!(num_steps < most_steps))
    throw std::invalid_argument(
        fmt::format("--lag {} over {} s takes too many steps. Shorten --duration", lag_s, duration_s));
  std::vector<double> z{drive.value(0.0)};
  z.reserve(static_cast<size_t>(num_steps) + 1);
  double before = z.back();
  for (double k = 1.0; k <= num_steps; ++k) {
    const double now = drive.value(k * step_s);
    z.push_back(stays * z.back() + (1.0 - stays - of_new) * before + of_new * now);
    before = now;
  }
  return recorded_drive(std::move(z), 1.0 / step_s);
}

Experiment make_experiment(const Chain& chain, const Drive& drive) {
  require_sound(chain);
  const DrivenChain driven{chain, drive};
  const size_t n = driven.size();
  Experiment e;
  e.system.name = "chain";
  for (size_t i = 0; i < n; ++i) e.system.states.push_back(fmt::format("x{}", i + 1));
  for (size_t i = 0; i < n; ++i) e.system.states.push_back(fmt::format("v{}", i + 1));
  e.system.rhs = [driven, n](double t, const double* y, int mode, double* dydt) {
    std::array<double, most_masses> sides{};
    sides_of(mode, static_cast<int>(n), sides.data());
    std::copy_n(y + n, n, dydt);
    driven.accelerations(t, y, sides.data(), dydt + n);
  };
  add_friction(e.system, driven);
  e.system.forcing = drive.value;
  const auto count = static_cast<Eigen::Index>(n);
  e.initial = Eigen::VectorXd::Zero(2 * count);
  e.initial.head(count).setConstant(driven.base(0, 0.0));
  e.initial.tail(count).setConstant(driven.base(1, 0.0));
  double fastest = 0.0;
  for (size_t i = 0; i < n; ++i) {
    const double above = i + 1 < n ? chain.links[i + 1].stiffness : 0.0;
    fastest = std::max(fastest, std::sqrt(std::abs(chain.links[i].stiffness + above) / chain.masses[i]));
  }
  e.omega_n = fastest;
  if (e.system.num_switches > 0 && fastest > 0.0) e.system.max_step_s = 0.3 / fastest;
  e.parameters = parameters_of(chain);
  e.truth = truth_of(chain);
  return e;
}

Chain make_chain(const std::vector<std::pair<std::string, double>>& set) {
  Chain chain;
  const auto whole = [](const std::string& name, double value, int most) {
    if (value != std::floor(value) || value < 0.0 || value > most)
      throw std::invalid_argument(fmt::format("chain: {} = {}, want a whole number up to {}", name, value, most));
    return static_cast<int>(value);
  };
  for (const auto& [name, value] : set) {
    if (name == "base") chain.base_driven = whole(name, value, 1) == 1;
    if (name == "driven") chain.driven = whole(name, value, most_masses);
    if (name != "masses") continue;
    chain.masses.assign(static_cast<size_t>(whole(name, value, most_masses)), 1.0);
    chain.links.assign(chain.masses.size(), {.cubic = 1e4});
    if (!chain.links.empty()) chain.links.front().cubic = 0.0;
  }
  for (const bool of_all : {true, false})
    for (const auto& [name, value] : set) {
      if (name == "base" || name == "driven" || name == "masses") continue;
      const auto [coefficient, body] = split_name(name);
      Chain any;
      if (find_coefficient(any, coefficient, 0) == nullptr)
        throw std::invalid_argument(
            fmt::format("chain: no parameter \"{}\"; there are masses, base, driven, mass, stiffness, damping, cubic, "
                        "friction, and of one body mass_1, stiffness_1 ...; from_hz, to_hz, rms of the drive",
                        name));
      if (body > chain.masses.size())
        throw std::invalid_argument(fmt::format("chain: {} of {} masses", name, chain.masses.size()));
      for (size_t i = 0; i < chain.masses.size(); ++i)
        if ((body == 0) == of_all && (body == 0 || body == i + 1)) *find_coefficient(chain, coefficient, i) = value;
    }
  require_sound(chain);
  return chain;
}

}  // namespace sim
