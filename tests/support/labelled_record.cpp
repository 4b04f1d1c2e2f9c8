#include "support/labelled_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "support/labelled_oscillator.hpp"

namespace support {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double two_pi = 2.0 * std::numbers::pi;

/// Numbers from a seed, each written down under its name. The same on every machine.
class Draw {
 public:
  explicit Draw(std::uint32_t seed) : engine_(seed) {}
  double uniform(const char* name, double from, double to) { return noted(name, from + (to - from) * unit()); }
  double log_uniform(const char* name, double from, double to) {
    return noted(name, from * std::pow(to / from, unit()));
  }
  template <class T>
  T one_of(const char* name, const std::vector<T>& values) {
    const T value =
        values[std::min(values.size() - 1, static_cast<std::size_t>(unit() * static_cast<double>(values.size())))];
    text_ += fmt::format("{}{}={}", text_.empty() ? "" : " ", name, value);
    return value;
  }
  bool half(const char* name) { return one_of<int>(name, {0, 1}) == 1; }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  double unit() { return static_cast<double>(engine_()) / 4294967296.0; }
  double noted(const char* name, double value) {
    text_ += fmt::format("{}{}={:.4g}", text_.empty() ? "" : " ", name, value);
    return value;
  }
  std::mt19937 engine_;
  std::string text_;
};

/// Several tones around the resonance, or a slow sweep across it. Of a peak of one at most.
Drive drawn_drive(Draw& draw, double omega_n, double duration_s) {
  Drive drive;
  if (draw.half("sweep")) {
    double from = draw.uniform("sweep_from", 0.4, 0.7) * omega_n, to = draw.uniform("sweep_to", 1.3, 1.8) * omega_n;
    if (draw.half("sweep_down")) std::swap(from, to);
    drive.tones = {{1.0, from, 0.0, (to - from) / duration_s}};
    return drive;
  }
  const int count = draw.one_of<int>("tones", {3, 4, 5, 6});
  for (int i = 0; i < count; ++i)
    drive.tones.push_back({draw.uniform("amplitude", 0.3, 1.0) / count, draw.uniform("omega", 0.35, 1.7) * omega_n,
                           draw.uniform("phase", 0.0, two_pi), 0.0});
  return drive;
}

double highest_omega(const Drive& drive, double duration_s) {
  double highest = 0.0;
  for (const auto& tone : drive.tones) highest = std::max({highest, tone.omega, tone.omega + tone.sweep * duration_s});
  return highest;
}

/// What the parts of a draw share.
struct Sketch {
  Oscillator p;
  double zeta = 0.0, duration_s = 0.0, highest_hz = 0.0, cubic_fraction = 0.0, friction_fraction = 0.0;
};

enum class Family { duffing, decay, van_der_pol, friction, ground_friction, bouc_wen };

struct Scenario {
  const char* name;
  Family family;
  std::optional<ident::Cause> flaw;
};
const std::vector<Scenario> scenarios{
    {"duffing", Family::duffing, {}},
    {"duffing, f not recorded", Family::duffing, ident::Cause::missing_input},
    {"duffing, f no candidate", Family::duffing, ident::Cause::missing_input},
    {"free decay", Family::decay, {}},
    {"van der pol", Family::van_der_pol, {}},
    {"van der pol without x^2*v", Family::van_der_pol, ident::Cause::missing_term},
    {"friction", Family::friction, {}},
    {"friction without sgn(v)", Family::friction, ident::Cause::missing_term},
    {"friction on the ground", Family::ground_friction, {}},
    {"friction on the ground by sgn(v)", Family::ground_friction, ident::Cause::switch_variable},
    {"bouc-wen", Family::bouc_wen, {}},
    {"bouc-wen without z", Family::bouc_wen, ident::Cause::missing_term},
};

void draw_nonlinearity(Draw& draw, Family family, Sketch& s) {
  Oscillator& p = s.p;
  const double X = p.amplitude;
  p.k = p.omega * p.omega;
  p.c = 2.0 * s.zeta * p.omega;
  switch (family) {
    case Family::duffing:
    case Family::decay:
      s.cubic_fraction = draw.uniform("cubic_fraction", 0.05, 0.5);
      p.k3 = p.k * s.cubic_fraction / (1.0 - s.cubic_fraction) / (X * X);
      break;
    case Family::van_der_pol:  // its limit cycle has twice the x at which the damping changes sign
      p.c = -draw.log_uniform("mu", 0.05, 1.0) * p.omega;
      p.xxv = -p.c / (0.25 * X * X);
      break;
    case Family::friction:
      s.friction_fraction = draw.half("friction_small") ? draw.uniform("friction_fraction", 0.02, 0.08)
                                                        : draw.uniform("friction_fraction", 0.1, 0.4);
      break;
    case Family::ground_friction:
      s.friction_fraction = draw.uniform("friction_fraction", 0.1, 0.4);
      break;
    case Family::bouc_wen: {
      const double share = draw.uniform("stiffness_share_of_z", 0.3, 0.9);
      p.z_gain = p.force_gain;
      p.z_stiffness = share * p.k / p.z_gain;
      p.k *= 1.0 - share;
      p.z_bend = draw.uniform("amplitude_over_yield", 1.0, 4.0) / X;
      p.z_share = draw.uniform("z_share", 0.5, 1.0);
    }
  }
}

/// Scales the drive until the largest |x| is that which was drawn: a nonlinear oscillator has its own mind. Friction
/// goes with the drive; where it holds the body all along, whatever the scale, there is half as much.
dsp::Motion driven_to_amplitude(Sketch& s, double rate_hz) {
  Oscillator& p = s.p;
  p.drive.scale = (p.base ? 0.3 : 0.3 * p.omega * p.omega / p.force_gain) * p.amplitude;
  for (int round = 0;; ++round) {
    p.friction = s.friction_fraction * p.drive.scale * (p.base ? p.k : p.force_gain);
    dsp::Motion motion = motion_of(p, s.duration_s, rate_hz);
    const double ratio = motion.at("x").cwiseAbs().maxCoeff() / p.amplitude;
    if (round == 8 || (ratio > 0.8 && ratio < 1.05)) return motion;
    if (ratio == 0.0) {
      s.friction_fraction *= 0.5;
      continue;
    }
    p.drive.scale *= std::pow(0.92 / ratio, 0.8);
  }
}

double drawn_periods(Draw& draw, Family family, double zeta) {
  // A decay is recorded until a fiftieth is left of it.
  const double most = family == Family::decay ? std::clamp(std::log(50.0) / (two_pi * zeta), 10.0, 100.0) : 300.0;
  return draw.log_uniform("periods", 8.0, most);
}

Sketch drawn_sketch(Draw& draw, Family family) {
  Sketch s;
  Oscillator& p = s.p;
  p.base = family == Family::ground_friction;
  p.omega = draw.uniform("omega_n", 4.0, 12.0);
  s.zeta = draw.log_uniform("zeta", 0.005, 0.08);
  p.amplitude = draw.log_uniform("x_max", 2e-3, 2e-2);
  p.force_gain = 1.0 / draw.log_uniform("mass", 0.5, 5.0);
  s.duration_s = drawn_periods(draw, family, s.zeta) * two_pi / p.omega;
  draw_nonlinearity(draw, family, s);
  const double hardening = std::sqrt(1.0 + s.cubic_fraction / (1.0 - s.cubic_fraction));
  if (family == Family::decay || family == Family::van_der_pol) {
    p.x0 = (family == Family::decay ? 1.0 : draw.uniform("start", 0.1, 1.2)) * p.amplitude;
    s.highest_hz = 2.0 * hardening * p.omega / two_pi;  // a narrow band is to hold the third harmonic, which tells
                                                        // damping that depends on x from none on a limit cycle
  } else {
    p.drive = drawn_drive(draw, p.omega, s.duration_s);
    s.highest_hz = std::max(hardening * p.omega, highest_omega(p.drive, s.duration_s)) / two_pi;
  }
  return s;
}

std::vector<std::pair<std::string, double>> truth_of(const Oscillator& p) {
  std::vector<std::pair<std::string, double>> truth{{"x", -p.k}, {"v", -p.c}};
  const auto add = [&](const char* name, double value) {
    if (value != 0.0) truth.emplace_back(name, value);
  };
  add("x^3", -p.k3);
  add("x^2*v", -p.xxv);
  add(p.base ? "sgn(dy)" : "sgn(v)", -p.friction);
  if (p.base) add("ddr", -1.0);
  if (!p.base && !p.drive.tones.empty()) add("f", p.force_gain);
  add("z", -p.z_gain);
  return truth;
}

/// Candidates that a person would write down. What imitates a term that is missing on purpose on the one orbit that
/// the record shows (v^3 for x^2 v on a limit cycle) is missing with it.
ident::LibraryOptions drawn_library(Draw& draw, const Scenario& scenario, bool with_force) {
  ident::LibraryOptions library{.order = 3, .terms = {}};
  const bool no_damping = scenario.family == Family::van_der_pol && scenario.flaw;
  if (no_damping || draw.half("explicit_terms")) {
    library.order = 0;
    library.terms = {"x", "v", "x^2", "x^3", "abs(x)*x"};
    for (const char* more : {"x^2*v", "abs(v)*v", "v^3"})
      if (!no_damping) library.terms.emplace_back(more);
    if (no_damping) library.terms.insert(library.terms.end(), {"x*v", "v^2", "x*v^2"});
  }
  const bool dry = scenario.family != Family::friction || !scenario.flaw;
  const bool ground = scenario.family == Family::ground_friction;
  if (ground && !scenario.flaw) library.terms.emplace_back("sgn(dy)");
  if (ground ? scenario.flaw || draw.half("both_signs") : dry) library.terms.emplace_back("sgn(v)");
  if (ground) library.terms.emplace_back("ddr");
  if (with_force) library.terms.emplace_back("f");
  if (scenario.family == Family::bouc_wen && !scenario.flaw) library.terms.emplace_back("z");
  return library;
}

/// Makes every term of the truth a candidate.
void add_lacking(LabelledRecord& record) {
  const auto library = ident::make_library(record.library, "a", record.exact);
  for (const auto& [name, value] : record.truth)
    if (std::none_of(library.terms.begin(), library.terms.end(), [&](const auto& term) { return term.name == name; }))
      record.library.terms.push_back(name);
  record.flaw.reset();
}

}  // namespace

const std::vector<std::string>& scenario_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Scenario& scenario : scenarios) all.emplace_back(scenario.name);
    return all;
  }();
  return names;
}

LabelledRecord labelled_record(std::uint32_t seed, bool mended) {
  Draw draw(seed);
  std::vector<int> indices;
  for (std::size_t i = 0; i < scenarios.size(); ++i) indices.push_back(static_cast<int>(i));
  const Scenario& scenario = scenarios[static_cast<std::size_t>(draw.one_of("scenario", indices))];
  Sketch sketch = drawn_sketch(draw, scenario.family);
  // Long records at the lowest rate, so that none has more than some 40000 samples.
  const double rate_hz = sketch.duration_s > 100.0 ? 100.0 : draw.one_of<double>("rate_hz", {100.0, 200.0, 400.0});
  LabelledRecord result{.scenario = scenario.name, .seed = seed};
  result.exact = sketch.p.drive.tones.empty() ? motion_of(sketch.p, sketch.duration_s, rate_hz)
                                              : driven_to_amplitude(sketch, rate_hz);
  result.flaw = scenario.flaw;
  result.truth = truth_of(sketch.p);
  result.periods = sketch.duration_s * sketch.p.omega / two_pi;
  result.noise = draw.one_of<double>("noise", {0.0, 0.01, 0.02, 0.05, 0.1, 0.2});
  result.wide_band = draw.half("wide_band");
  const double bands = result.wide_band ? draw.uniform("bands", 10.0, 20.0) : 3.0;
  result.prepare.cutoff_hz = std::min(bands * sketch.highest_hz, 0.4 * rate_hz);
  const bool forced = !sketch.p.base && !sketch.p.drive.tones.empty();
  const bool has_force_channel = forced && (mended || result.scenario != "duffing, f not recorded");
  std::vector<std::string> names = sketch.p.base ? std::vector<std::string>{"y", "r"} : std::vector<std::string>{"x"};
  if (draw.half("accelerometers"))
    for (const char* more : sketch.p.base ? std::vector<const char*>{"ddy", "ddr"} : std::vector<const char*>{"v", "a"})
      names.emplace_back(more);
  if (has_force_channel) names.emplace_back("f");
  if (scenario.family == Family::bouc_wen && (mended || !scenario.flaw)) names.emplace_back("z");
  result.recording = recorded(result.exact, names, result.noise, seed);
  result.library = drawn_library(draw, scenario, has_force_channel && result.scenario != "duffing, f no candidate");
  if (mended) add_lacking(result);
  result.drawn = draw.text();
  return result;
}

}  // namespace support
