#include "sim/rig/base_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "dsp/values/constants.hpp"

namespace sim {
namespace {

using dsp::two_pi;

double fraction(double value) {
  return value - std::floor(value);
}

/// 0 below u = 0, 1 from u = 1 on, twice differentiable between.
double smooth_step(double u) {
  if (u <= 0.0) return 0.0;
  return u < 1.0 ? u * u * u * (10.0 + u * (-15.0 + 6.0 * u)) : 1.0;
}

}  // namespace

double ManualForce::window(double t) const {
  if (!(t > from_s && t < to_s)) return 0.0;
  if (grip_s <= 0.0) {
    const double s = std::sin(0.5 * two_pi * (t - from_s) / (to_s - from_s));
    return s * s;
  }
  return smooth_step((t - from_s) / grip_s) * smooth_step((to_s - t) / release_s);
}

Programme stepped_sine(const SteppedSine& test) {
  const auto positive = [](double frequency) { return frequency > 0.0 && std::isfinite(frequency); };
  if (test.frequencies_hz.empty() || !std::all_of(test.frequencies_hz.begin(), test.frequencies_hz.end(), positive))
    throw std::invalid_argument("stepped_sine: needs frequencies_hz, all positive");
  if (!(test.dwell_s >= 4.0 && std::isfinite(test.dwell_s) && std::isfinite(test.amplitude_m)))
    throw std::invalid_argument(
        fmt::format("stepped_sine: dwell_s must be at least 4 s and amplitude_m finite, got {} and {}", test.dwell_s,
                    test.amplitude_m));
  const double quarter = 0.25 * test.dwell_s;
  Programme programme{.name = "stepped sine", .nodes = {}, .manual = {}, .duration_s = 0.0};
  for (std::size_t step = 0; step < test.frequencies_hz.size(); ++step) {
    const double n = static_cast<double>(step) + 1.0;
    // Irrational turns spread the setting errors and the harmonics' phases evenly over the steps.
    const double spread = 2.0 * fraction(0.5 + n * 0.6180339887498949) - 1.0;
    const double psi2 = two_pi * fraction(n * 0.7548776662466927), psi3 = two_pi * fraction(n * 0.5698402909980532);
    for (int iteration = 0; iteration < 4; ++iteration) {
      const double residue = std::pow(0.35, iteration);
      programme.nodes.push_back({.t_s = test.dwell_s * static_cast<double>(step) + quarter * iteration,
                                 .transition_s = std::min(iteration == 0 ? 3.0 : 1.5, 0.8 * quarter),
                                 .frequency_hz = test.frequencies_hz[step],
                                 .harmonics_m = {test.amplitude_m * (1.0 + 0.04 * spread * residue),
                                                 std::polar(test.amplitude_m * (0.010 * residue + 0.0005), psi2),
                                                 std::polar(test.amplitude_m * (0.007 * residue + 0.0005), psi3)}});
    }
  }
  programme.duration_s = test.dwell_s * static_cast<double>(test.frequencies_hz.size());
  return programme;
}

Programme stepped_sine_down(double amplitude_m, double dwell_s) {
  SteppedSine test{.frequencies_hz = {}, .amplitude_m = amplitude_m, .dwell_s = dwell_s};
  for (int step = 0; step < 35; ++step) test.frequencies_hz.push_back(1.84 - 0.01 * step);
  for (const double late : {1.46, 1.41, 1.36, 1.31, 1.26, 1.21, 1.16, 1.09, 0.94, 0.80})
    test.frequencies_hz.push_back(late);
  Programme programme = stepped_sine(test);
  programme.name = "stepped sine, down";
  const double push_s = 22.625 * dwell_s, stop_s = 24.5 * dwell_s;
  programme.manual = {
      {.from_s = push_s, .to_s = push_s + 4.0, .by_base = -0.8, .why = "payload pushed by hand onto the upper branch"},
      {.from_s = stop_s, .to_s = stop_s + 4.0, .by_velocity_per_s = -4.8, .why = "payload held by hand"}};
  return programme;
}

Programme stepped_sine_up(double amplitude_m, double dwell_s) {
  SteppedSine test{.frequencies_hz = {}, .amplitude_m = amplitude_m, .dwell_s = dwell_s};
  for (int step = 0; step < 13; ++step) test.frequencies_hz.push_back(0.80 + 0.05 * step);
  for (int step = 1; step <= 20; ++step) test.frequencies_hz.push_back(1.40 + 0.01 * step);
  Programme programme = stepped_sine(test);
  programme.name = "stepped sine, up";
  return programme;
}

Programme free_decay(const Releases& releases) {
  if (!(releases.num_releases >= 1 && releases.num_releases <= 10000 && releases.dwell_s >= 8.0 &&
        std::isfinite(releases.dwell_s) && releases.amplitude_m > 0.0 && std::isfinite(releases.amplitude_m)))
    throw std::invalid_argument(
        fmt::format("free_decay: need 1 to 10000 releases, a positive amplitude_m and a dwell_s of at least 8 s, got "
                    "{}, {} and {}",
                    releases.num_releases, releases.amplitude_m, releases.dwell_s));
  constexpr double held_s = 4.0;
  Programme programme{.name = "free decay",
                      .nodes = {{.t_s = 0.0, .transition_s = 1.0, .frequency_hz = 1.0}},
                      .manual = {},
                      .duration_s = releases.dwell_s * releases.num_releases};
  for (int k = 0; k < releases.num_releases; ++k) {
    const double fraction = releases.num_releases > 1 ? 0.5 * k / (releases.num_releases - 1) : 0.0;
    const double from_s = releases.dwell_s * k + 0.5;
    // Firm enough to place the payload to a few per cent, damped beyond its own motion.
    programme.manual.push_back({.from_s = from_s,
                                .to_s = from_s + held_s,
                                .by_velocity_per_s = -80.0,
                                .stiffness_per_s2 = 2500.0,
                                .hold_at_m = (k % 2 == 0 ? 1.0 : -1.0) * releases.amplitude_m * (1.0 - fraction),
                                .grip_s = 2.0,
                                .release_s = 0.02,
                                .why = "payload held aside by hand, then let go"});
  }
  return programme;
}

Programme sine_steps(const SineSteps& steps) {
  if (steps.frequencies_hz.empty()) throw std::invalid_argument("sine_steps: frequencies_hz is empty");
  if (!(steps.transition_s > 0.0 && steps.dwell_s > steps.transition_s))
    throw std::invalid_argument(fmt::format("sine_steps: dwell_s must exceed transition_s and both 0, got {} and {}",
                                            steps.dwell_s, steps.transition_s));
  Programme programme{.name = "sine steps", .nodes = {}, .manual = {}, .duration_s = 0.0};
  for (const double frequency : steps.frequencies_hz) {
    programme.nodes.push_back({programme.duration_s, steps.transition_s, frequency, {steps.amplitude_m, 0.0, 0.0}});
    programme.duration_s += steps.dwell_s;
  }
  return programme;
}

BaseMotion::BaseMotion(const Programme& programme) : duration_s_(programme.duration_s) {
  const auto& nodes = programme.nodes;
  if (nodes.empty() || nodes.front().t_s != 0.0 || !(duration_s_ > nodes.back().t_s))
    throw std::invalid_argument("BaseMotion: a programme needs a node at 0 and a duration beyond its last node");
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double next = i + 1 < nodes.size() ? nodes[i + 1].t_s : duration_s_;
    if (!(nodes[i].transition_s > 0.0 && nodes[i].t_s + nodes[i].transition_s <= next))
      throw std::invalid_argument(fmt::format("BaseMotion: transition at {} s must end by {} s", nodes[i].t_s, next));
  }
  ProgrammeNode rest = nodes.front();
  rest.harmonics_m = {};
  first_ = pieces(programme, rest);
  again_ = pieces(programme, nodes.back());
  const auto whole = [this](const std::vector<Piece>& all) {
    return all.back().phase + all.back().turns(duration_s_ - all.back().t_s);
  };
  turns_first_ = whole(first_);
  turns_again_ = whole(again_);
}

std::vector<BaseMotion::Piece> BaseMotion::pieces(const Programme& programme, const ProgrammeNode& before) {
  std::vector<Piece> result;
  const ProgrammeNode* last = &before;
  double phase = 0.0;
  for (const auto& node : programme.nodes) {
    if (!result.empty()) phase = fraction(phase + result.back().turns(node.t_s - result.back().t_s));
    result.push_back({node.t_s, node.transition_s, last->frequency_hz, node.frequency_hz, phase, last->harmonics_m,
                      node.harmonics_m});
    last = &node;
  }
  return result;
}

double BaseMotion::Piece::turns(double d) const {
  if (d >= transition_s) return 0.5 * (f0_hz + f1_hz) * transition_s + f1_hz * (d - transition_s);
  const double u = d / transition_s;
  return f0_hz * d + (f1_hz - f0_hz) * transition_s * u * u * u * u * (2.5 + u * (-3.0 + u));
}

BaseState BaseMotion::state(const Piece& piece, double d, double phase) {
  double frequency = piece.f1_hz, frequency_rate = 0.0;  // Hz, Hz/s
  double s = 1.0, ds = 0.0, dds = 0.0;                   // fraction of the way, and its derivatives
  if (d < piece.transition_s) {
    const double u = d / piece.transition_s, rate = 1.0 / piece.transition_s;
    s = u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
    ds = 30.0 * rate * u * u * (1.0 - u) * (1.0 - u);
    dds = 60.0 * rate * rate * u * (1.0 - u) * (1.0 - 2.0 * u);
    frequency = piece.f0_hz + (piece.f1_hz - piece.f0_hz) * s;
    frequency_rate = (piece.f1_hz - piece.f0_hz) * ds;
  }
  const double angle = two_pi * fraction(phase + piece.turns(d));
  const double c1 = std::cos(angle), s1 = std::sin(angle);
  const double w = two_pi * frequency, dw = two_pi * frequency_rate;
  BaseState base;
  double cosine = 1.0, sine = 0.0;
  for (int h = 0; h < 3; ++h) {
    const double turned = cosine * c1 - sine * s1;
    sine = cosine * s1 + sine * c1;
    cosine = turned;
    // Z = a + i b and its derivatives; r'' = Re[(Z'' + 2 i h w Z' + (i h w' - h^2 w^2) Z) e^{i h phi}].
    const auto& z1 = piece.z1[static_cast<std::size_t>(h)];
    const double hw = (h + 1) * w, hdw = (h + 1) * dw;
    double a = z1.real(), b = z1.imag(), da = 0.0, db = 0.0, dda = 0.0, ddb = 0.0;
    if (d < piece.transition_s) {
      const auto& z0 = piece.z0[static_cast<std::size_t>(h)];
      const double ga = a - z0.real(), gb = b - z0.imag();
      a = z0.real() + ga * s, b = z0.imag() + gb * s;
      da = ga * ds, db = gb * ds, dda = ga * dds, ddb = gb * dds;
    }
    base.r_m += a * cosine - b * sine;
    base.dr_m_per_s += (da - hw * b) * cosine - (db + hw * a) * sine;
    base.ddr_m_per_s2 +=
        (dda - 2.0 * hw * db - hdw * b - hw * hw * a) * cosine - (ddb + 2.0 * hw * da + hdw * a - hw * hw * b) * sine;
  }
  return base;
}

BaseState BaseMotion::at(double t, std::size_t& near) const {
  if (t < 0.0) return {};
  const double cycle = std::floor(t / duration_s_), inside = t - cycle * duration_s_;
  const auto& all = cycle == 0.0 ? first_ : again_;
  near = std::min(near, all.size() - 1);
  while (near > 0 && inside < all[near].t_s) --near;
  while (near + 1 < all.size() && inside >= all[near + 1].t_s) ++near;
  const double before = cycle == 0.0 ? 0.0 : fraction(turns_first_ + fraction(turns_again_) * (cycle - 1.0));
  const Piece& piece = all[near];
  return state(piece, inside - piece.t_s, before + piece.phase);
}

BaseState BaseMotion::at(double t) const {
  std::size_t near = 0;
  return at(t, near);
}

}  // namespace sim
