#include <algorithm>
#include <cmath>
#include <limits>

#include "ident/state_space/fitter.hpp"

// How much noise a fit stands on: from soft to hard, the levels of most likelihood, and the log-determinant.

namespace ident::state_space {

using std::size_t;

void Fitter::soften(double factor) {
  const std::vector<double> before = noise_.process;
  noise_.process = start_.scales;
  for (double& std : noise_.process) std *= factor;
  for (const Wander& wander : wanders_) noise_.process[as_size(wander.state)] = before[as_size(wander.state)];
  for (const int state : followers_)
    noise_.process[as_size(state)] = std::max(noise_.process[as_size(state)], process_floor(state));
}

double Fitter::process_floor(int state) const {
  const Problem& problem = problem_.problem();
  double square = 0.0;
  int coefficient = 0;
  for (const Term& term : problem.equations.terms) {
    const double value = term.known ? *term.known : point_.parameters[as_size(coefficient++)];
    if (term.state != state) continue;
    const std::string& own = problem.equations.states[as_size(state)];
    for (size_t i = 0; i < problem.input_noise_std.size(); ++i)
      if (const std::string& input = problem.equations.inputs[i];
          term.text == input || term.text == lag_term(input, own))
        square += std::pow(value * problem.input_noise_std[i] / problem.sample_rate_hz, 2);
  }
  return std::max(std::sqrt(square), hardest * start_.scales[as_size(state)]);
}

bool Fitter::raise_to_floor() {
  bool raised = false;
  for (const std::vector<int>* states : {&speeds_, &followers_})
    for (const int state : *states) {
      double& std = noise_.process[as_size(state)];
      if (std >= process_floor(state)) continue;
      std = process_floor(state), raised = true;
    }
  return !raised || iterate(15, of_rest);
}

bool Fitter::harden(double from, double to) {
  constexpr double usual = 4.0, least = 1.3;  // factor from stage to stage; below, it stands still
  constexpr double hopeless = 1e3;            // a rise of J that no later stage makes good, and that settles the matter
  gradient_.clear();
  std::optional<Standing> good;
  double at = from, factor = usual, lowest = std::numeric_limits<double>::infinity();
  while (true) {
    soften(at);
    const bool last = at <= to;
    const bool rests = iterate(good ? 15 : 40, at <= hardest ? of_rest : 1.0);
    if (rests && at >= soft_scale) soft_ = standing();
    if (last && rests) return true;
    if (!rests && good && factor > least && !is_spent()) {
      stand(*good);
      factor = std::sqrt(factor);
      at = std::max(to, noise_.process.front() / start_.scales.front() / factor);
      continue;
    }
    if (last || !linear_ || is_spent()) return false;
    if (rests && !soft_) soft_ = standing();
    if (rests && J() > lowest + hopeless) return false;
    lowest = std::min(lowest, J());
    good = standing();
    at = std::max(to, at / factor);
    factor = std::min(usual, factor * 1.3);
  }
}

std::vector<Fitter::Level> Fitter::levels(bool with_process) {
  std::vector<Level> all;
  if (with_process)
    for (const int speed : speeds_)
      all.push_back({&noise_.process[as_size(speed)], process_floor(speed), start_.scales[as_size(speed)]});
  for (const Wander& wander : wanders_)
    if (const auto j = as_size(wander.channel); problem_.problem().channels[j].wander_std == 0.0)
      all.push_back(
          {&noise_.process[as_size(wander.state)], least_wander * floors_[j], start_.scales[as_size(wander.state)]});
  const double e = std::exp(1.0);
  for (size_t j = 0; j < floors_.size(); ++j)
    if (const Channel& channel = problem_.problem().channels[j]; channel.noise_std == 0.0)
      all.push_back({&noise_.channel[j], floors_[j] / (channel.wanders ? e * e * e : e), floors_[j] * e});
  return all;
}

/// One parabola for each level, in logarithms.
void Fitter::search(const std::vector<Level>& levels, std::vector<double>& widths) {
  const auto J_here = [&] {
    const Smoothed there = smooth(*linear_, noise_, false, num_threads_);
    return J_of(there) + there.parameters.log_determinant();
  };
  double best = J_here();
  for (size_t j = 0; j < levels.size(); ++j) {
    const Level& level = levels[j];
    const double start = std::log(*level.std);
    double at = start;
    const auto try_at = [&](double log_std) {
      const double before = *level.std;
      *level.std = std::exp(std::clamp(log_std, std::log(level.low), std::log(level.high)));
      const double J = J_here(), tried = std::log(*level.std);
      if (J < best)
        best = J, at = tried;
      else
        *level.std = before;
      return std::pair{tried, J};
    };
    const double here = best;
    const auto [above, J_above] = try_at(start + widths[j]);
    const auto [below, J_below] = try_at(start - widths[j]);
    if (above > start && below < start) {
      const double up = (J_above - here) / (above - start), down = (here - J_below) / (start - below),
                   curvature = (up - down) / (0.5 * (above - below)),
                   slope = (up * (start - below) + down * (above - start)) / (above - below);
      if (curvature > 0.0)
        (void)try_at(std::clamp(start - slope / curvature, start - 4.0 * widths[j], start + 4.0 * widths[j]));
    }
    const double change = std::abs(at - start);
    widths[j] = std::clamp(change > 0.03 ? 1.5 * change : 0.2 * widths[j], 0.02, 2.5);
  }
}

bool Fitter::settle_noise(bool with_process) {
  constexpr int most_rounds = 15;
  constexpr double of_rest_J = 0.05;
  const std::vector<Level> all = levels(with_process);
  constexpr double unsure_of_process = 1.0,
                   unsure_of_channel = 0.1;  // a factor of e; a spectrum's floor is better known
  std::vector<double> widths(all.size(), unsure_of_channel);
  std::fill_n(widths.begin(), std::min(all.size(), (with_process ? speeds_.size() : 0) + wanders_.size()),
              unsure_of_process);
  if (!look()) return false;
  double before = marginal_J();
  for (int round = 0; round < most_rounds; ++round) {
    search(all, widths);
    if (!iterate(15, of_rest)) return false;
    if (round > 0 && std::abs(before - marginal_J()) < of_rest_J) return true;
    before = marginal_J();
  }
  return false;
}

bool Fitter::exceeds_floor() const {
  constexpr double above_floor = 1.1;
  return std::any_of(speeds_.begin(), speeds_.end(),
                     [&](int speed) { return noise_.process[as_size(speed)] > above_floor * process_floor(speed); });
}

bool Fitter::has_process_noise() const {
  constexpr double above_floor = 10.0;
  return std::any_of(speeds_.begin(), speeds_.end(), [&](int speed) {
    return noise_.process[as_size(speed)] > above_floor * hardest * start_.scales[as_size(speed)];
  });
}

double Fitter::log_determinant(const Point& point) {
  ++num_linearised_;
  const std::optional<Linear> linear = problem_.about(point, {}, parts_, num_threads_);
  return linear ? smooth(*linear, noise_, false, num_threads_).log_determinant : std::nan("");
}

bool Fitter::follow_log_determinant() {
  constexpr int most_rounds = 20, rounds_of_noise = 3;
  constexpr double width = 0.05, of_rest_std = 0.05, of_rest_J = 0.05;  // the first two: standard deviations
  if (!has_process_noise()) return true;
  const std::vector<Level> all = levels(true);
  std::vector<double> widths(all.size(), 0.2);
  const size_t p = parameters_.size();
  double J_before = marginal_J();
  for (int round = 0; round < most_rounds; ++round) {
    const std::vector<double> covariance = smoothed_.parameters.covariance();
    std::vector<double> gradient(point_.parameters.size(), 0.0);
    for (size_t j = 0; j < p; ++j) {
      const double std = std::sqrt(covariance[j * (p + 1)]);
      if (!std::isfinite(std)) return false;
      std::vector<double> step(p, 0.0);
      step[j] = width * std;
      const auto states = states_step(smoothed_.eliminated, step, false, num_threads_);
      gradient[as_size(parameters_[j])] =
          (log_determinant(moved(point_, step, states, 1.0)) - log_determinant(moved(point_, step, states, -1.0))) /
          (2.0 * step[j]);
      if (!std::isfinite(gradient[as_size(parameters_[j])])) return false;
    }
    // The mean of all rounds: steps of their own go to and fro where the determinant bends.
    for (size_t i = 0; i < gradient.size() && round > 0; ++i)
      gradient[i] = gradient_[i] + (gradient[i] - gradient_[i]) / (round + 1);
    gradient_ = gradient;
    const std::vector<double> before = sought(point_.parameters);
    if (!iterate(15, of_rest)) return false;
    const std::vector<double> now = sought(point_.parameters);
    double largest = 0.0;
    for (size_t j = 0; j < p; ++j)
      largest = std::max(largest, std::abs(now[j] - before[j]) / std::sqrt(covariance[j * (p + 1)]));
    if (round < rounds_of_noise) search(all, widths);
    if (!look() || is_spent()) return false;
    if (largest < of_rest_std && std::abs(J_before - marginal_J()) < of_rest_J) return true;
    J_before = marginal_J();
  }
  return false;
}

void Fitter::settle() {
  (void)harden(softest_, soft_scale);
  if (is_hopeless()) return;
  const Hard hard = hard_end(harden(soft_ ? soft_scale : softest_, hardest) && settle_noise(false) && refine_steps() &&
                             raise_to_floor());
  if (soft_) stand(*soft_);
  soften(hardest);
  for (const int speed : speeds_) noise_.process[as_size(speed)] = soft_scale * start_.scales[as_size(speed)];
  compare_with(hard, soft_ && settle_noise(true) && refine_steps(), problem_.problem().equations.inputs.empty());
}

void Fitter::settle_again() {
  begin_anew();
  const bool stands = settle_noise(true) && refine_steps();
  if (!exceeds_floor()) {
    gain_of_process_noise_ = 0.0;
    settled_ = stands && may_follow_log_determinant();
    return;
  }
  const Standing here = standing();
  const Hard hard = hard_end(harden(soft_scale, hardest) && settle_noise(false) && raise_to_floor());
  stand(here);
  compare_with(hard, look() && stands, true);
}

/// Where the hard end was not reached, J of the last stage, which it would exceed.
Fitter::Hard Fitter::hard_end(bool reached) const {
  return {standing(), linear_ ? marginal_J() : std::numeric_limits<double>::infinity(), reached};
}

/// The log-determinant matters less than noise where inputs drive the motion: there a search that does not come to rest
/// with it, as in chaos, does without.
bool Fitter::may_follow_log_determinant() {
  const Standing here = standing();
  if (follow_log_determinant()) return true;
  if (problem_.problem().equations.inputs.empty()) return false;
  stand(here);
  return look();
}

/// Keeps what stands, or the hard end where that is as likely.
void Fitter::compare_with(const Hard& hard, bool stands, bool follows) {
  gain_of_process_noise_ = stands ? std::max(0.0, hard.J - marginal_J()) : 0.0;
  settled_ = true;
  if (!(gain_of_process_noise_ > 0.0)) {
    stand(hard.at);
    settled_ = look() && hard.reached;
  }
  if (follows) settled_ = settled_ && may_follow_log_determinant();
}

}  // namespace ident::state_space
