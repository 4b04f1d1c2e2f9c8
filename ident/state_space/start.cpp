#include "ident/state_space/start.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "dsp/filter/power_density.hpp"
#include "dsp/filter/spectral.hpp"

namespace ident::state_space {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

double std_of(const VectorXd& values) {
  return std::sqrt((values.array() - values.mean()).square().mean());
}

VectorXd longest_run(const VectorXd& values) {
  Index first = 0, best_first = 0, best = 0;
  for (Index k = 0; k <= values.size(); ++k) {
    if (k < values.size() && !std::isnan(values(k))) continue;
    if (k - first > best) best = k - first, best_first = first;
    first = k + 1;
  }
  return values.segment(best_first, best);
}

/// A channel's motion, derived `order` times (below zero: integrated, from five cycles a record on) below a cut-off.
VectorXd derived(const VectorXd& signal, double rate_hz, int order, double to_hz) {
  const double from_hz = 5.0 * rate_hz / static_cast<double>(signal.size());
  const dsp::SpectralBand band{to_hz, std::min(1.25 * to_hz, 0.5 * rate_hz)};
  return dsp::ExtendedSpectrum(signal, rate_hz).filtered([&](double f) -> std::complex<double> {
    if (order < 0 && f < from_hz) return 0.0;
    return std::pow(std::complex<double>(0.0, 2.0 * std::numbers::pi * f), order) * band.gain(f);
  });
}

/// What the upper end of a channel's spectrum makes of its noise, and what the channel itself is: mean squares.
struct Floor {
  double square = 0.0, own = 0.0, samples = 0.0;
  void add(const Floor& other) {
    const double sum = samples + other.samples;
    if (sum == 0.0) return;
    square += (other.square - square) * other.samples / sum, own += (other.own - own) * other.samples / sum;
    samples = sum;
  }
};

Floor floor_of(const Record& record, std::size_t channel, const Problem& problem) {
  constexpr double from = 0.25, to = 0.45;
  const VectorXd run = longest_run(record.channels.col(static_cast<Index>(channel)));
  if (run.size() == 0) return {};
  const double to_hz = std::min(to * problem.sample_rate_hz, problem.flat_to_hz);
  const double density = dsp::PowerDensity(run, problem.sample_rate_hz).between(from / to * to_hz, to_hz);
  return {density * 0.5 * problem.sample_rate_hz, std_of(run) * std_of(run), static_cast<double>(run.size())};
}

/// How often a position has been differentiated for a channel to record it: 0 to 2; nothing where it does not.
std::optional<int> order_of(const Channel& channel, int position, int speed) {
  const bool of_speed = channel.state == speed;
  if (channel.state != position && !of_speed) return {};
  return (of_speed ? 1 : 0) + (channel.rate ? 1 : 0);
}

/// Whether a state follows another with a lag of first order.
bool follows(const Equations& equations, int state, int other) {
  const std::string lag = lag_term(equations.states[as_size(other)], equations.states[as_size(state)]);
  return std::any_of(equations.terms.begin(), equations.terms.end(),
                     [&](const Term& term) { return term.state == state && term.text == lag; });
}

}  // namespace

VectorXd filled(VectorXd values) {
  Index last = -1;
  for (Index k = 0; k < values.size(); ++k) {
    if (std::isnan(values(k))) continue;
    for (Index i = last + 1; i < k; ++i) {
      const double part = last < 0 ? 1.0 : static_cast<double>(i - last) / static_cast<double>(k - last);
      values(i) = last < 0 ? values(k) : values(last) + part * (values(k) - values(last));
    }
    last = k;
  }
  for (Index i = last + 1; i < values.size(); ++i) values(i) = last < 0 ? 0.0 : values(last);
  return values;
}

double cutoff_hz(const VectorXd& signal, double rate_hz, double noise_std) {
  constexpr double above_noise = 3.0, beyond = 1.3;
  constexpr Index samples_an_ordinate = 100;  // so that a mean of ordinates is steady
  const dsp::PowerDensity density(signal, rate_hz);
  const VectorXd& ordinates = density.ordinates();
  const double floor = above_noise * noise_std * noise_std / (0.5 * rate_hz);
  const auto width = std::max<Index>(3, signal.size() / samples_an_ordinate);
  double highest = 5.0 * density.step_hz(), sum = 0.0;
  for (Index k = 0; k < ordinates.size(); ++k) {
    sum += ordinates(k) - (k >= width ? ordinates(k - width) : 0.0);
    if (sum > floor * static_cast<double>(width))
      highest = std::max(highest, static_cast<double>(k) * density.step_hz());
  }
  return std::min(beyond * highest, 0.45 * rate_hz);
}

std::vector<int> speeds_of(const Equations& equations) {
  std::vector<int> speeds(equations.states.size(), -1);
  for (const Term& term : equations.terms) {
    const auto named = std::find(equations.states.begin(), equations.states.end(), term.text);
    const bool alone = std::count_if(equations.terms.begin(), equations.terms.end(),
                                     [&](const Term& other) { return other.state == term.state; }) == 1;
    if (term.known == 1.0 && alone && named != equations.states.end())
      speeds[static_cast<std::size_t>(term.state)] = static_cast<int>(named - equations.states.begin());
  }
  return speeds;
}

std::vector<InnerForce> inner_forces(const Equations& equations) {
  const std::vector<int> speeds = speeds_of(equations);
  std::vector<InnerForce> forces;
  for (const Term& term : equations.terms) {
    const auto named = std::find(equations.states.begin(), equations.states.end(), term.text);
    const auto state = static_cast<int>(named - equations.states.begin());
    const auto is_speed = [&](int one) { return std::find(speeds.begin(), speeds.end(), one) != speeds.end(); };
    if (named == equations.states.end() || !term.known || *term.known == 0.0 || !is_speed(term.state)) continue;
    if (speeds[as_size(state)] < 0 && !is_speed(state)) forces.push_back({state, term.state, *term.known});
  }
  return forces;
}

std::vector<double> noise_floors(const Problem& problem) {
  constexpr double least = 1e-6;
  std::vector<double> floors;
  for (std::size_t j = 0; j < problem.channels.size(); ++j) {
    floors.push_back(problem.channels[j].noise_std);
    if (floors.back() > 0.0) continue;
    double square = 0.0, own = 0.0, samples = 0.0;
    for (const Record& record : problem.records) {
      const Floor one = floor_of(record, j, problem);
      const double factor = record.noise_factor(j);
      square += one.samples * one.square / (factor * factor), own += one.samples * one.own / (factor * factor);
      samples += one.samples;
    }
    floors.back() = std::sqrt(std::max(square, least * least * own) / samples);
    if (floors.back() == 0.0) floors.back() = least;  // a channel that does not move
  }
  return floors;
}

void tell_noise_apart(Problem& problem, const std::vector<std::size_t>& recording_of) {
  constexpr double allowed = 4.0;
  for (std::size_t j = 0; j < problem.channels.size(); ++j) {
    std::map<std::size_t, Floor> floors;
    Floor all;
    for (std::size_t i = 0; i < problem.records.size(); ++i) {
      const Floor one = floor_of(problem.records[i], j, problem);
      floors[recording_of[i]].add(one), all.add(one);
    }
    const bool differ = std::any_of(floors.begin(), floors.end(), [&](const auto& recording) {
      const Floor& one = recording.second;
      return one.samples > 0.0 &&
             std::abs(one.square / all.square - 1.0) > allowed * std::sqrt(variance_of_floor / one.samples);
    });
    if (!differ || problem.channels[j].noise_std > 0.0) continue;
    for (std::size_t i = 0; i < problem.records.size(); ++i) {
      const Floor& own = floors[recording_of[i]];
      std::vector<double>& factors = problem.records[i].noise_factors;
      factors.resize(problem.channels.size(), 1.0);
      if (own.square > 0.0) factors[j] = std::sqrt(own.square / all.square);
    }
  }
}

Input without_noise(const VectorXd& signal, double rate_hz) {
  constexpr double from = 0.25, to = 0.45, most = 0.1;
  const double noise = dsp::PowerDensity(signal, rate_hz).between(from * rate_hz, to * rate_hz) * 0.5 * rate_hz,
               own = std_of(signal);
  if (!(noise < most * own * own)) return {signal, 0.0, 0.5 * rate_hz};
  const double to_hz = cutoff_hz(signal, rate_hz, std::sqrt(noise));
  return {derived(signal, rate_hz, 0, to_hz), std::sqrt(noise), 1.25 * to_hz};
}

Problem with_origins(Problem problem, const std::vector<double>& scales) {
  constexpr double stds = 3.0;
  const std::vector<int> speeds = speeds_of(problem.equations);
  const auto add = [&](int state, Index num_samples) {
    problem.channels.push_back({.name = "(origin)", .state = state, .noise_std = stds * scales[as_size(state)]});
    for (Record& record : problem.records) {
      record.channels.conservativeResize(Eigen::NoChange, record.channels.cols() + 1);
      record.channels.rightCols(1).setConstant(std::numeric_limits<double>::quiet_NaN());
      record.channels.rightCols(1).topRows(std::min(num_samples, record.channels.rows())).setZero();
    }
  };
  // Where a zero begins is as open as the motion is large.
  for (std::size_t j = 0, given = problem.channels.size(); j < given; ++j)
    if (problem.channels[j].wanders) add(problem.channels[j].state, 1);
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const auto state = static_cast<int>(i);
    const bool fixed = std::any_of(problem.channels.begin(), problem.channels.end(), [&](const Channel& channel) {
      return (channel.state == state || follows(problem.equations, channel.state, state)) && !channel.rate &&
             channel.corner_rad_s.mean == 0.0;
    });
    if (speeds[i] < 0 || fixed) continue;
    add(state, std::numeric_limits<Index>::max());
  }
  return problem;
}

Start start_of(const Linearisation& problem) {
  const Problem& given = problem.problem();
  const std::vector<int> speeds = speeds_of(given.equations);
  const std::vector<InnerForce> forces = inner_forces(given.equations);
  const std::vector<double> floors = noise_floors(given);
  const auto ns = static_cast<std::size_t>(problem.model().num_states());
  Start start{.scales = std::vector<double>(ns, 0.0)};
  double samples = 0.0;
  for (const Record& record : given.records) {
    const auto n = static_cast<std::size_t>(record.channels.rows());
    std::vector<double>& states = start.states.emplace_back(n * ns, 0.0);
    const auto write = [&](std::size_t state, const VectorXd& values) {
      for (std::size_t k = 0; k < n; ++k) states[k * ns + state] = values(static_cast<Index>(k));
      start.scales[state] += static_cast<double>(n) * std_of(values) * std_of(values);
    };
    samples += static_cast<double>(n);
    for (std::size_t i = 0; i < speeds.size(); ++i) {
      if (speeds[i] < 0) continue;
      std::optional<std::size_t> best;
      int order = 3;
      for (std::size_t j = 0; j < given.channels.size(); ++j) {
        const std::optional<int> of = order_of(given.channels[j], static_cast<int>(i), speeds[i]);
        if (of && *of < order) best = j, order = *of;
      }
      if (!best) continue;
      const VectorXd signal = filled(record.channels.col(static_cast<Index>(*best)));
      const double to_hz = cutoff_hz(signal, given.sample_rate_hz, floors[*best]);
      write(i, derived(signal, given.sample_rate_hz, -order, to_hz));
      write(static_cast<std::size_t>(speeds[i]), derived(signal, given.sample_rate_hz, 1 - order, to_hz));
      const double a = std_of(derived(signal, given.sample_rate_hz, 2 - order, to_hz));
      for (const InnerForce& force : forces)
        if (force.speed == speeds[i]) start.scales[as_size(force.state)] += static_cast<double>(n) * a * a;
    }
    for (std::size_t j = 0; j < given.channels.size(); ++j) {
      const auto of = static_cast<std::size_t>(given.channels[j].state),
                 coupled = static_cast<std::size_t>(problem.model().output_state(static_cast<int>(j)));
      if (of == coupled) continue;
      VectorXd values(static_cast<Index>(n));
      for (std::size_t k = 0; k < n; ++k) values(static_cast<Index>(k)) = states[k * ns + of];
      write(coupled, values.array() - (given.channels[j].wanders ? 0.0 : values.mean()));
    }
  }
  for (double& scale : start.scales) scale = scale > 0.0 ? std::sqrt(scale / samples) : 1.0;
  return start;
}

}  // namespace ident::state_space
