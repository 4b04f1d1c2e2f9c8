#include "ident/state_space/fitter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "ident/state_space/scatter.hpp"

namespace ident::state_space {

using std::size_t;

Fitter::Fitter(const Problem& problem, int num_threads)
    : start_(start_of(Linearisation(problem))),
      problem_(with_origins(problem, start_.scales)),
      floors_(noise_floors(problem_.problem())),
      num_threads_(num_threads),
      parts_(problem.steps),
      num_given_channels_(problem.channels.size()) {
  for (const int speed : speeds_of(problem.equations))
    if (speed >= 0) speeds_.push_back(speed);
  for (const Term& term : problem.equations.terms)
    for (const std::string& input : problem.equations.inputs)
      if (term.text == lag_term(input, problem.equations.states[as_size(term.state)])) followers_.push_back(term.state);
  all_parameters_.resize(as_size(layout().num_coefficients));
  std::iota(all_parameters_.begin(), all_parameters_.end(), 0);
  if (!inner_forces(problem.equations).empty()) least_damping_ = 0.03;
  const std::vector<Prior> priors = priors_of(problem_.problem());
  for (int i = layout().num_coefficients; i < layout().size(); ++i)
    if (priors[as_size(i)].std > 0.0) all_parameters_.push_back(i);
  for (const Prior& prior : priors) point_.parameters.push_back(prior.mean);
  noise_.channel = floors_;
  noise_.process = start_.scales;
  for (size_t j = 0; j < problem.channels.size(); ++j)
    if (const Channel& channel = problem.channels[j]; channel.wanders) {
      const int state = problem_.model().output_state(static_cast<int>(j));
      wanders_.push_back({state, static_cast<int>(j)});
      noise_.process[as_size(state)] = channel.wander_std > 0.0 ? channel.wander_std : floors_[j];
    }
  // Where a position is not recorded, only steps this hard tie it to what is; an acceleration gives a good start.
  const bool has_rates = std::any_of(problem.channels.begin(), problem.channels.end(),
                                     [](const Channel& channel) { return channel.rate; });
  if (has_rates || floors_.size() > num_given_channels_ + wanders_.size()) softest_ = soft_scale;
  soften(hardest);
}

void Fitter::seek(std::vector<int> coefficients) {
  std::sort(coefficients.begin(), coefficients.end());
  if (std::any_of(coefficients.begin(), coefficients.end(),
                  [&](int i) { return i < 0 || i >= layout().num_coefficients; }))
    throw std::invalid_argument("state_space: a term that is not there");
  parameters_ = coefficients;
  for (int i = 0; i < layout().num_coefficients; ++i)
    if (!std::binary_search(coefficients.begin(), coefficients.end(), i)) point_.parameters[as_size(i)] = 0.0;
  for (const int i : all_parameters_)
    if (i >= layout().num_coefficients) parameters_.push_back(i);
}

void Fitter::begin(const FitOptions& options) {
  most_linearised_ = options.most_linearised;
  const std::vector<double>& coefficients = options.coefficients;
  if (!coefficients.empty() && coefficients.size() != as_size(layout().num_coefficients))
    throw std::invalid_argument("state_space: another number of coefficients");
  for (size_t i = 0; i < coefficients.size(); ++i)
    if (std::binary_search(parameters_.begin(), parameters_.end(), static_cast<int>(i)))
      point_.parameters[i] = coefficients[i];
  take_last_states(options.last_states);
  point_.states = start_.states;
  if (!coefficients.empty()) return;
  regress();
  const std::vector<InnerForce> forces = inner_forces(problem_.problem().equations);
  if (forces.empty() || !look()) return;
  // An inner force begins as what the other terms leave of the rate that it acts on.
  const size_t ns = start_.scales.size();
  for (const InnerForce& force : forces)
    for (size_t r = 0; r < linear_->records.size(); ++r) {
      const std::vector<double>& defect = linear_->records[r].defect;
      std::vector<double>& states = point_.states[r];
      for (size_t k = 0; k < states.size() / ns; ++k)
        states[k * ns + as_size(force.state)] =
            defect[std::min(k, states.size() / ns - 2) * ns + as_size(force.speed)] *
            problem_.problem().sample_rate_hz / force.coefficient;
    }
  regress();
}

void Fitter::take_last_states(const std::vector<Eigen::MatrixXd>& values) {
  if (values.empty()) return;
  const size_t ns = start_.scales.size(), of_equations = problem_.problem().equations.states.size();
  const auto count = values.front().cols();
  std::vector<double> squares(as_size(count), 0.0);
  double rows = 0.0;
  for (size_t r = 0; r < values.size(); ++r) {
    if (values.size() != start_.states.size() || as_size(values[r].rows()) * ns != start_.states[r].size() ||
        values[r].cols() != count || as_size(count) > of_equations)
      throw std::invalid_argument("state_space: another number of values of the last states");
    for (Eigen::Index i = 0; i < count; ++i) {
      const size_t state = of_equations - as_size(count - i);
      for (Eigen::Index k = 0; k < values[r].rows(); ++k) start_.states[r][as_size(k) * ns + state] = values[r](k, i);
      squares[as_size(i)] += values[r].col(i).squaredNorm();
    }
    rows += static_cast<double>(values[r].rows());
  }
  for (size_t i = 0; i < squares.size(); ++i)
    if (squares[i] > 0.0) start_.scales[of_equations - squares.size() + i] = std::sqrt(squares[i] / rows);
}

/// Parameters by least squares on steps and outputs of the states as they are.
void Fitter::regress() {
  soften(softest_);
  if (!look()) return;
  Triangle triangle(static_cast<int>(parameters_.size()));
  std::vector<double> row(parameters_.size() + 1);
  const auto add = [&](const double* slopes, double residual, double weight) {
    for (size_t j = 0; j < parameters_.size(); ++j) row[j] = weight * slopes[j];
    row.back() = weight * residual;
    triangle.add(row.data());
  };
  const size_t ns = start_.scales.size(), m = floors_.size(), p = parameters_.size();
  for (const LinearRecord& record : linear_->records) {
    for (size_t i = 0; i < record.defect.size() - ns; ++i)
      add(record.by_parameter.data() + i * p, record.defect[i], 1.0 / noise_.process[i % ns]);
    for (size_t i = 0; i < record.residual.size(); ++i)
      if (!std::isnan(record.residual[i]))
        add(record.output_by_parameter.data() + i * p, record.residual[i], 1.0 / noise_.channel[i % m]);
  }
  for (size_t j = 0; j < p; ++j) {
    std::fill(row.begin(), row.end(), 0.0);
    row[j] = linear_->prior_weights[j], row.back() = linear_->prior_residuals[j];
    triangle.add(row.data());
  }
  triangle.fold();
  const std::vector<double> step = triangle.solve();
  for (size_t j = 0; j < p; ++j) point_.parameters[as_size(parameters_[j])] += step[j];
}

std::vector<double> Fitter::sought(const std::vector<double>& of_layout) const {
  std::vector<double> values;
  if (!of_layout.empty())
    for (const int i : parameters_) values.push_back(of_layout[as_size(i)]);
  return values;
}

double Fitter::linear_part(const Point& point) const {
  double sum = 0.0;
  if (!gradient_.empty())
    for (const int i : parameters_) sum += gradient_[as_size(i)] * point.parameters[as_size(i)];
  return sum;
}

double Fitter::J_of(const Smoothed& smoothed) const {
  if (gradient_.empty()) return smoothed.J();
  const std::vector<double> here(parameters_.size(), 0.0);
  return smoothed.parameters.value(here) + smoothed.log_determinant + smoothed.log_noise;
}

bool Fitter::look() {
  ++num_linearised_;
  linear_ = problem_.about(point_, parameters_, parts_, num_threads_);
  if (!linear_) return false;
  smoothed_ = smooth(*linear_, noise_, true, num_threads_);
  return std::isfinite(smoothed_.cost);
}

Point Fitter::moved(Point point, const std::vector<double>& step, const std::vector<std::vector<double>>& states,
                    double factor) const {
  for (size_t j = 0; j < step.size(); ++j) point.parameters[as_size(parameters_[j])] += factor * step[j];
  for (size_t r = 0; r < states.size(); ++r)
    for (size_t i = 0; i < states[r].size(); ++i) point.states[r][i] += factor * states[r][i];
  return point;
}

bool Fitter::try_step(const std::vector<double>& step) {
  const auto states = states_step(smoothed_.eliminated, step, true, num_threads_);
  const double merit = smoothed_.cost + linear_part(point_);
  const std::vector<double> none(step.size(), 0.0);
  for (const double factor : {1.0, 0.5, 0.2}) {
    Point point = moved(point_, step, states, factor);
    // Where steps are hard the states lie in a narrow valley that bends: one step of theirs alone leads back to it.
    for (const bool corrected : {false, true}) {
      ++num_linearised_;
      std::optional<Linear> about = problem_.about(point, parameters_, parts_, num_threads_);
      if (!about) break;
      Smoothed there = smooth(*about, noise_, true, num_threads_);
      if (there.cost + linear_part(point) <= merit + 1e-9 * std::abs(merit)) {
        point_ = std::move(point), linear_ = std::move(about), smoothed_ = std::move(there);
        return true;
      }
      if (!corrected) point = moved(point, none, states_step(there.eliminated, none, true, num_threads_), 1.0);
    }
  }
  return false;
}

bool Fitter::iterate(int most, double tolerance) {
  constexpr int most_dampings = 8;
  if (!look()) return false;
  const std::vector<double> linear = sought(gradient_);
  const double least = tolerance > of_rest ? least_damping_ : 0.0;
  double damping = least;
  for (int i = 0, dampings = 0; i < most && dampings <= most_dampings && !is_spent();) {
    const Triangle& triangle = smoothed_.parameters;
    const std::vector<double> step = (damping > 0.0 ? triangle.damped(damping) : triangle).solve(linear);
    if (smoothed_.cost - triangle.value(step, linear) < tolerance) return true;
    if (try_step(step)) {
      damping = damping > 1e-6 ? std::max(least, 0.1 * damping) : least;
      ++i, dampings = 0;
    } else {
      damping = 10.0 * std::max(damping, 1e-4);
      ++dampings;
    }
  }
  return false;
}

void Fitter::stand(const Standing& at) {
  point_ = at.point, noise_ = at.noise, gradient_ = at.gradient;
}

bool Fitter::refine_steps() {
  constexpr int most_parts = 16;
  constexpr double allowed = 0.1;  // standard deviations
  while (true) {
    const std::vector<double> step = smoothed_.parameters.solve(sought(gradient_));
    const auto finer = problem_.about(point_, parameters_, 2 * parts_, num_threads_);
    if (!finer) return false;
    const Smoothed there = smooth(*finer, noise_, false, num_threads_);
    const std::vector<double> covariance = there.parameters.covariance(),
                              step_there = there.parameters.solve(sought(gradient_));
    double largest = 0.0;
    for (size_t j = 0; j < step.size(); ++j)
      largest = std::max(largest, std::abs(step_there[j] - step[j]) / std::sqrt(covariance[j * (step.size() + 1)]));
    if (largest < allowed) return true;
    if (parts_ == most_parts) return false;
    parts_ *= 2;
    if (!iterate(15, of_rest)) return false;
  }
}

bool Fitter::refit() {
  return iterate(15, of_rest);
}

bool Fitter::refit_softly() {
  const Noise noise = noise_;
  const std::vector<double> gradient = gradient_;
  (void)harden(soft_scale, hardest);
  noise_ = noise, gradient_ = gradient;
  return refit();
}

Triangle Fitter::freed() {
  const std::optional<Linear> linear = problem_.about(point_, all_parameters_, parts_, num_threads_);
  if (!linear) throw std::range_error("state_space: a candidate without a finite value");
  std::vector<double> values;
  for (const int i : all_parameters_) values.push_back(point_.parameters[as_size(i)]);
  freed_ = smooth(*linear, noise_, true, num_threads_);
  return freed_.parameters.from(values);
}

void Fitter::move_to(const std::vector<int>& coefficients, const std::vector<double>& values) {
  std::vector<double> step;
  for (size_t j = 0; j < values.size(); ++j) step.push_back(values[j] - point_.parameters[as_size(all_parameters_[j])]);
  const std::vector<std::vector<double>> states = states_step(freed_.eliminated, step, true, num_threads_);
  parameters_ = all_parameters_;
  point_ = moved(point_, step, states, 1.0);
  seek(coefficients);
}

bool Fitter::at_floor(const std::vector<double>& residual_std) const {
  constexpr double of_squares = 2.0, allowed = 4.0;
  for (size_t j = 0; j < residual_std.size(); ++j) {
    double samples = 0.0;
    for (const Record& record : problem_.problem().records)
      samples += static_cast<double>((!record.channels.col(static_cast<Eigen::Index>(j)).array().isNaN()).count());
    const double ratio = residual_std[j] / floors_[j];
    if (ratio * ratio > 1.0 + allowed * std::sqrt((variance_of_floor + of_squares) / samples)) return false;
  }
  return true;
}

bool Fitter::is_hopeless() const {
  constexpr double far_above = 5.0;  // a floor is known within a factor of e, and noise need not be white
  if (!linear_) return false;
  const std::vector<double> residual_std = residual_stds();
  for (size_t j = 0; j < residual_std.size(); ++j)
    if (residual_std[j] > far_above * floors_[j]) return true;
  // The spectrum of a random walk ends in the noise of half its step: a floor is no less than half a true one.
  return std::any_of(wanders_.begin(), wanders_.end(), [&](const Wander& wander) {
    return steps_of(wander) > far_above * floors_[as_size(wander.channel)];
  });
}

double Fitter::steps_of(const Wander& wander) const {
  const size_t n = noise_.process.size(), own = as_size(wander.state),
               moved = as_size(problem_.problem().channels[as_size(wander.channel)].state);
  double squares = 0.0, count = 0.0;
  for (const std::vector<double>& states : point_.states)
    for (size_t k = n; k < states.size(); k += n) {
      const double step = states[k + own] - states[k + moved] - states[k - n + own] + states[k - n + moved];
      squares += step * step, ++count;
    }
  return std::sqrt(squares / std::max(count, 1.0));
}

std::vector<double> Fitter::residual_stds() const {
  const size_t m = floors_.size();
  std::vector<double> squares(m, 0.0), samples(m, 0.0), stds;
  if (linear_)
    for (const LinearRecord& record : linear_->records)
      for (size_t i = 0; i < record.residual.size(); ++i)
        if (!std::isnan(record.residual[i]))
          squares[i % m] += record.residual[i] * record.residual[i], ++samples[i % m];
  for (size_t j = 0; j < num_given_channels_; ++j)
    stds.push_back(linear_ ? std::sqrt(squares[j] / samples[j]) : std::nan(""));
  return stds;
}

Fit Fitter::result() const {
  Fit fit{.parameters = parameters_,
          .point = point_,
          .covariance = smoothed_.parameters.covariance(),
          .noise = noise_,
          .floors = floors_,
          .residual_std = residual_stds(),
          .J = J(),
          .gain_of_process_noise = gain_of_process_noise_,
          .parts = parts_,
          .settled = settled_};
  if (linear_ && gain_of_process_noise_ > 0.0) fit.scattered = scatter_covariance(*linear_, noise_, fit.covariance);
  fit.at_floor = linear_ && at_floor(fit.residual_std);
  return fit;
}

double Fit::std(size_t i) const {
  return std::sqrt(covariance[i * (parameters.size() + 1)]);
}

std::vector<double> Fit::wider() const {
  const size_t p = parameters.size();
  std::vector<double> by(p, 1.0), result = covariance;
  for (size_t i = 0; i < p && !scattered.empty(); ++i)
    by[i] = std::sqrt(std::max(1.0, scattered[i * (p + 1)] / covariance[i * (p + 1)]));
  for (size_t i = 0; i < p * p; ++i) result[i] *= by[i / p] * by[i % p];
  return result;
}

Fit fit(const Problem& problem, const FitOptions& options) {
  Fitter fitter(problem, options.num_threads);
  std::vector<int> terms = options.terms;
  if (terms.empty()) {
    terms.resize(as_size(fitter.layout().num_coefficients));
    std::iota(terms.begin(), terms.end(), 0);
  }
  fitter.seek(terms);
  fitter.begin(options);
  fitter.settle();
  return fitter.result();
}

}  // namespace ident::state_space
