#include "ident/state_space/linear.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/values/for_each_index.hpp"
#include "ident/state_space/step.hpp"

namespace ident::state_space {
namespace {

using Eigen::Index;
constexpr Index samples_a_task = 1024;  // some milliseconds

const Problem& sound(const Problem& problem) {
  require_sound(problem);
  return problem;
}

bool all_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

/// y = gain (q - lag dq/dt) + offset of one channel at one point, and its derivatives. Of an acceleration's lag the
/// change of its second derivative is left out, of the order of lag times frequency.
struct Output {
  const Model& model;
  Rates<1>& rates;
  const std::vector<double>& parameters;
  const std::vector<Model::Column>& columns;
  int channel, state;
  bool of_rate;

  [[nodiscard]] double parameter(int at) const { return parameters[as_size(at)]; }
  [[nodiscard]] double value() const { return of_rate ? *rates.rate(state) : *rates.state(state); }
  [[nodiscard]] double slope(int j) const { return of_rate ? *rates.slope(state, j) : (j == state ? 1.0 : 0.0); }
  [[nodiscard]] double pace() const {
    if (!of_rate) return *rates.rate(state);
    double sum = *rates.slope(state, model.num_states());
    for (int j = 0; j < model.num_states(); ++j) sum += *rates.slope(state, j) * *rates.rate(j);
    return sum;
  }
  double computed(double* by_state, double* by_parameter, const std::vector<int>& sought) const {
    const Layout& at = model.layout();
    const double gain = parameter(at.gain(channel)), lag = parameter(at.lag(channel)), delayed = value() - lag * pace();
    for (int j = 0; j < model.num_states(); ++j)
      by_state[j] = gain * (slope(j) - (of_rate ? 0.0 : lag * *rates.slope(state, j)));
    for (const Model::Column& column : columns)
      if (column.state == state)
        by_parameter[column.column] += gain * (of_rate ? 1.0 : -lag) * column.factor * *rates.value(column.value);
    for (std::size_t c = 0; c < sought.size(); ++c) {
      if (sought[c] == at.gain(channel)) by_parameter[c] = delayed;
      if (sought[c] == at.offset(channel)) by_parameter[c] = 1.0;
      if (sought[c] == at.lag(channel)) by_parameter[c] = -gain * pace();
    }
    return gain * delayed + parameter(at.offset(channel));
  }
};

}  // namespace

Linearisation::Linearisation(const Problem& problem)
    : problem_(sound(problem)), model_(problem_), priors_(priors_of(problem_)) {
  for (const Record& record : problem_.records)
    inputs_.emplace_back(record.inputs, record.channels.rows(), problem_.sample_rate_hz, record.begin_s);
  for (const Channel& channel : problem_.channels)
    looks_at_rates_ = looks_at_rates_ || channel.rate || channel.lag_s.mean != 0.0 || channel.lag_s.std > 0.0;
}

Model Linearisation::model_of(const Point& point, const std::vector<int>& parameters) const {
  std::vector<char> wanted;
  int coefficient = 0;
  for (const Term& term : problem_.equations.terms) {
    const int at = term.known ? -1 : coefficient++;
    wanted.push_back(at < 0 || point.parameters[as_size(at)] != 0.0 ||
                     std::find(parameters.begin(), parameters.end(), at) != parameters.end());
  }
  return {problem_, wanted};
}

void Linearisation::steps(const Model& model, std::size_t record, Index first, Index last, const Point& point,
                          int parts, Linear& into) const {
  const auto ns = as_size(model.num_states()), p = into.parameters.size();
  LinearRecord& to = into.records[record];
  const double* states = point.states[record].data();
  Stepper stepper(model, into.parameters, 1.0 / problem_.sample_rate_hz, parts);
  std::vector<double> ends(side_by_side * ns);
  std::vector<Ends> where(side_by_side);
  for (Index k = first; k < std::min(last, to.num_samples - 1); k += side_by_side) {
    const auto count = static_cast<int>(std::min({Index{side_by_side}, last - k, to.num_samples - 1 - k}));
    for (std::size_t l = 0; l < as_size(count); ++l)
      where[l] = {&ends[l * ns], &to.by_state[(as_size(k) + l) * ns * ns],
                  to.by_parameter.data() + (as_size(k) + l) * ns * p};
    stepper.take(inputs_[record], k, count, states + as_size(k) * ns, point.parameters, where);
    const double* next = states + as_size(k + 1) * ns;
    for (std::size_t i = 0; i < as_size(count) * ns; ++i) to.defect[as_size(k) * ns + i] = next[i] - ends[i];
  }
}

void Linearisation::outputs(const Model& model, std::size_t record, Index first, Index last, const Point& point,
                            Linear& into) const {
  const auto ns = as_size(model.num_states()), p = into.parameters.size(), m = problem_.channels.size();
  LinearRecord& to = into.records[record];
  Rates<1> rates(model);
  const std::vector<Model::Column> columns = model.columns(into.parameters);
  const Inputs::Place at_sample(0.0);
  for (Index k = first; k < last; ++k) {
    for (std::size_t i = 0; i < ns; ++i) *rates.state(static_cast<int>(i)) = point.states[record][as_size(k) * ns + i];
    if (looks_at_rates_) {
      inputs_[record].at(k, at_sample, rates.input(0), rates.input_rate(0), model.num_states() + 2);
      rates.take_sides();
      rates.evaluate(point.parameters, Slopes::by_states_and_time);
    }
    for (std::size_t j = 0; j < m; ++j) {
      const std::size_t at = as_size(k) * m + j;
      const Output output{model,
                          rates,
                          point.parameters,
                          columns,
                          static_cast<int>(j),
                          model.output_state(static_cast<int>(j)),
                          problem_.channels[j].rate};
      const double computed =
          output.computed(&to.output_by_state[at * ns], to.output_by_parameter.data() + at * p, into.parameters);
      const double by = 1.0 / problem_.records[record].noise_factor(j);
      to.residual[at] = by * (problem_.records[record].channels(k, static_cast<Index>(j)) - computed);
      if (by == 1.0) continue;
      for (std::size_t i = 0; i < ns; ++i) to.output_by_state[at * ns + i] *= by;
      for (std::size_t i = 0; i < p; ++i) to.output_by_parameter[at * p + i] *= by;
    }
  }
}

std::optional<Linear> Linearisation::about(const Point& point, const std::vector<int>& parameters, int parts,
                                           int num_threads) const {
  const auto ns = as_size(model_.num_states()), p = parameters.size(), m = problem_.channels.size();
  Linear linear{.parameters = parameters, .num_states = static_cast<int>(ns), .num_channels = static_cast<int>(m)};
  struct Task {
    std::size_t record;
    Index first, last;
  };
  std::vector<Task> tasks;
  for (std::size_t r = 0; r < problem_.records.size(); ++r) {
    const Index rows = problem_.records[r].channels.rows();
    const auto n = as_size(rows);
    linear.records.push_back({rows, std::vector<double>(n * ns * ns), std::vector<double>(n * ns * p),
                              std::vector<double>(n * ns), std::vector<double>(n * m * ns),
                              std::vector<double>(n * m * p), std::vector<double>(n * m)});
    for (Index first = 0; first < rows; first += samples_a_task)
      tasks.push_back({r, first, std::min(rows, first + samples_a_task)});
  }
  const Model model = model_of(point, parameters);
  dsp::for_each_index(tasks.size(), num_threads, [&](std::size_t i) {
    const auto [record, first, last] = tasks[i];
    steps(model, record, first, last, point, parts, linear);
    outputs(model, record, first, last, point, linear);
  });
  for (const int parameter : parameters) {
    const auto [mean, std] = priors_[as_size(parameter)];
    const double weight = std > 0.0 && std::isfinite(std) ? 1.0 / std : 0.0;
    linear.prior_weights.push_back(weight);
    linear.prior_residuals.push_back(weight * (mean - point.parameters[as_size(parameter)]));
  }
  for (const LinearRecord& record : linear.records)
    if (!all_finite(record.by_state) || !all_finite(record.defect) || !all_finite(record.output_by_state)) return {};
  return linear;
}

}  // namespace ident::state_space
