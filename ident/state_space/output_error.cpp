#include "ident/state_space/output_error.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "dsp/values/linear.hpp"
#include "ident/state_space/step.hpp"

namespace ident::state_space {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A problem whose states follow from coefficients and first values.
class Simulation {
 public:
  Simulation(const Problem& problem, const OutputErrorOptions& options)
      : linearisation_(problem), options_(options), parameters_(as_size(layout().size())) {
    for (const int state : options.free_states)
      if (state < 0 || state >= linearisation_.model().num_states())
        throw std::invalid_argument("state_space: first value of a state that there is not");
    const std::vector<Prior> priors = priors_of(problem);
    for (std::size_t i = 0; i < parameters_.size(); ++i) parameters_[i] = priors[i].mean;
    for (const Record& record : problem.records)
      inputs_.emplace_back(record.inputs, record.channels.rows(), problem.sample_rate_hz, record.begin_s);
    for (int i = 0; i < layout().num_coefficients; ++i) sought_.push_back(i);
  }
  [[nodiscard]] const Layout& layout() const& { return linearisation_.model().layout(); }
  void layout() const&& = delete;
  [[nodiscard]] Index num_free() const {
    return layout().num_coefficients + std::ssize(inputs_) * std::ssize(options_.free_states);
  }
  /// Run with these values, slopes and all; nothing where a state runs away.
  [[nodiscard]] std::optional<OutputError> run(const VectorXd& free) const;

 private:
  [[nodiscard]] std::optional<Point> point(const VectorXd& free) const;
  void add_outputs(const LinearRecord& record, std::size_t index, Index row, OutputError& into) const;

  Linearisation linearisation_;
  const OutputErrorOptions& options_;
  std::vector<double> parameters_;
  std::vector<Inputs> inputs_;
  std::vector<int> sought_;
};

std::optional<Point> Simulation::point(const VectorXd& free) const {
  const Problem& problem = linearisation_.problem();
  Point point{.parameters = parameters_, .states = {}};
  std::copy_n(free.begin(), layout().num_coefficients, point.parameters.begin());
  Stepper stepper(linearisation_.model(), {}, 1.0 / problem.sample_rate_hz, problem.steps);
  const std::size_t num_states = as_size(linearisation_.model().num_states());
  for (std::size_t r = 0; r < inputs_.size(); ++r) {
    const Index count = inputs_[r].size();
    std::vector<double> states(num_states * as_size(count), 0.0);
    for (std::size_t i = 0; i < options_.free_states.size(); ++i)
      states[as_size(options_.free_states[i])] =
          free(layout().num_coefficients + static_cast<Index>(r * options_.free_states.size() + i));
    for (Index k = 0; k + 1 < count; ++k) {
      double* const now = states.data() + as_size(k) * num_states;
      double* const next = now + num_states;
      stepper.take(inputs_[r], k, 1, now, point.parameters, {{next, nullptr, nullptr}});
      if (!std::all_of(next, next + num_states, [](double value) { return std::isfinite(value); })) return std::nullopt;
    }
    point.states.push_back(std::move(states));
  }
  return point;
}

// By the chain rule from sample to sample: where a step ends changes with where it begins and with the coefficients.
void Simulation::add_outputs(const LinearRecord& record, std::size_t index, Index row, OutputError& into) const {
  const Index num_states = linearisation_.model().num_states(), p = layout().num_coefficients,
              num_channels = layout().num_channels, of_first = std::ssize(options_.free_states);
  RowMajor S = RowMajor::Zero(num_states, num_free());
  for (Index i = 0; i < of_first; ++i)
    S(options_.free_states[as_size(i)], p + static_cast<Index>(index) * of_first + i) = 1.0;
  const auto block = [](const std::vector<double>& values, Index at, Index rows, Index cols) {
    return Eigen::Map<const RowMajor>(values.data() + at * rows * cols, rows, cols);
  };
  for (Index k = 0; k < record.num_samples; ++k) {
    RowMajor by = block(record.output_by_state, k, num_channels, num_states) * S;
    by.leftCols(p) += block(record.output_by_parameter, k, num_channels, p);
    const Index at = row + k * num_channels;
    for (Index j = 0; j < num_channels; ++j) {
      const double residual = record.residual[as_size(k * num_channels + j)];
      into.residual(at + j) = std::isnan(residual) ? 0.0 : residual;
      if (std::isnan(residual)) by.row(j).setZero();
    }
    into.slopes.middleRows(at, num_channels) = by;
    if (k + 1 == record.num_samples) break;
    S = (block(record.by_state, k, num_states, num_states) * S).eval();
    S.leftCols(p) += block(record.by_parameter, k, num_states, p);
  }
}

std::optional<OutputError> Simulation::run(const VectorXd& free) const {
  std::optional<Point> at = point(free);
  if (!at) return std::nullopt;
  const std::optional<Linear> linear =
      linearisation_.about(*at, sought_, linearisation_.problem().steps, options_.num_threads);
  if (!linear) return std::nullopt;
  OutputError result{.point = std::move(*at), .slopes = {}, .residual = {}};
  Index rows = 0;
  for (const LinearRecord& record : linear->records) rows += record.num_samples * linear->num_channels;
  result.slopes.resize(rows, num_free());
  result.residual.resize(rows);
  rows = 0;
  for (std::size_t r = 0; r < linear->records.size(); ++r) {
    add_outputs(linear->records[r], r, rows, result);
    rows += linear->records[r].num_samples * linear->num_channels;
  }
  if (!result.slopes.allFinite() || !result.residual.allFinite()) return std::nullopt;
  return result;
}

/// The step of a run, damped by so much of each column's size.
VectorXd damped_step(const OutputError& run, double damping) {
  const Index n = run.slopes.cols();
  MatrixXd stacked(run.slopes.rows() + n, n + 1);
  stacked << run.slopes, run.residual, MatrixXd(n, n + 1).setZero();
  for (Index j = 0; j < n; ++j) stacked(run.slopes.rows() + j, j) = std::sqrt(damping) * run.slopes.col(j).norm();
  const MatrixXd R = dsp::Qr(std::move(stacked)).triangle();
  return dsp::least_squares(R.topLeftCorner(n, n), R.col(n).head(n));
}

}  // namespace

std::optional<OutputError> output_error(const Problem& problem, const OutputErrorOptions& options) {
  constexpr int most_steps = 60, most_trials = 12;
  constexpr double at_rest = 1e-7;  // of the squares: far below what one coefficient is known to
  const Simulation simulation(problem, options);
  VectorXd free = VectorXd::Zero(simulation.num_free());
  if (!options.coefficients.empty())
    free.head(simulation.layout().num_coefficients) =
        VectorXd::Map(options.coefficients.data(), simulation.layout().num_coefficients);
  std::optional<OutputError> best = simulation.run(free);
  if (best && free.size() == 0) best->settled = true;
  double damping = 1e-3;
  for (int step = 0; best && step < most_steps && !best->settled; ++step) {
    bool fell = false;
    for (int trial = 0; trial < most_trials && !fell; ++trial) {
      const VectorXd next = free + damped_step(*best, damping);
      std::optional<OutputError> run = simulation.run(next);
      fell = run && run->squares() < best->squares();
      damping = std::clamp(fell ? damping / 9.0 : 4.0 * damping, 1e-12, 1e6);
      if (!fell) continue;
      const bool rests = best->squares() - run->squares() < at_rest * best->squares();
      free = next, best = std::move(run), best->settled = rests;
    }
    if (!fell) best->settled = true;  // no shorter step lowers it
  }
  return best;
}

}  // namespace ident::state_space
