#include <algorithm>
#include <cmath>

#include "dsp/values/constants.hpp"
#include "ident/bodies/bodies.hpp"
#include "ident/bodies/statement.hpp"
#include "ident/state_space/fit.hpp"
#include "ident/state_space/output_error.hpp"
#include "ident/state_space/step.hpp"
#include "ident/validate/metrics.hpp"

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::size_t;

namespace {

/// Steps a sample, of fifth order: two follow motions below a tenth of the rate to 1e-7 of a step; each is no longer
/// than a lag, twice which still is stable.
int parts_of(const BodiesModel& model, double sample_rate_hz) {
  constexpr double least = 2.0, most = 1000.0;
  if (model.layout.inner != Inner::lag) return static_cast<int>(least);
  return static_cast<int>(std::clamp(std::ceil(model.mean(model.mean.size() - 1) / sample_rate_hz), least, most));
}

}  // namespace

MatrixXd run_free(const BodiesModel& model, const MatrixXd& inputs, double sample_rate_hz,
                  const std::vector<double>& state, double scale, double begin_s) {
  constexpr double far_away = 1e6;
  const std::vector<double> known(model.mean.begin(), model.mean.end());
  const state_space::Problem problem{
      .equations = equations_of(model.layout, model.terms, known), .channels = {}, .records = {}};
  const state_space::Model compiled(problem);
  const state_space::Inputs between(inputs, inputs.rows(), sample_rate_hz, begin_s);
  state_space::Stepper stepper(compiled, {}, 1.0 / sample_rate_hz, parts_of(model, sample_rate_hz));
  MatrixXd states = MatrixXd::Constant(inputs.rows(), model.layout.num_states(), dsp::nan);
  std::vector<double> now = state, next(state.size());
  const auto runs_away = [&] {
    if (model.layout.imposed) return false;
    for (int body = 0; body < model.layout.num_bodies; ++body)
      if (std::abs(now[static_cast<size_t>(2 * body)]) > far_away * scale) return true;
    return false;
  };
  for (Index k = 0; k < inputs.rows(); ++k) {
    states.row(k) = VectorXd::Map(now.data(), states.cols()).transpose();
    if (k + 1 == inputs.rows()) break;
    stepper.take(between, k, 1, now.data(), {}, {{next.data(), nullptr, nullptr}});
    std::swap(now, next);
    if (!std::all_of(now.begin(), now.end(), [](double value) { return std::isfinite(value); }) || runs_away()) break;
  }
  return states;
}

VectorXd rates_along(const BodiesModel& model, int state, const MatrixXd& states, const MatrixXd& inputs,
                     double sample_rate_hz, double begin_s) {
  const std::vector<double> known(model.mean.begin(), model.mean.end());
  const state_space::Model compiled(
      {.equations = equations_of(model.layout, model.terms, known), .channels = {}, .records = {}});
  state_space::Rates<1> rates(compiled);
  VectorXd along(states.rows());
  for (Index k = 0; k < states.rows(); ++k) {
    for (Index i = 0; i < states.cols(); ++i) *rates.state(static_cast<int>(i)) = states(k, i);
    for (Index i = 0; i < inputs.cols(); ++i) *rates.input(static_cast<int>(i)) = inputs(k, i);
    *rates.input(static_cast<int>(inputs.cols())) = begin_s + static_cast<double>(k) / sample_rate_hz;
    rates.take_sides();
    rates.evaluate({}, state_space::Slopes::none);
    along(k) = *rates.rate(state);
  }
  return along;
}

MatrixXd responses_of(const BodiesModel& model, const MatrixXd& states, const MatrixXd& inputs, double sample_rate_hz,
                      double begin_s) {
  if (model.layout.imposed) return rates_along(model, 0, states, inputs, sample_rate_hz, begin_s);
  if (model.layout.sensor_lags()) return states.col(model.layout.shown_state(1));
  return states(Eigen::all, Eigen::seqN(0, model.layout.num_bodies, 2));
}

RunErrors errors_of_run(const BodiesRecord& record, const MatrixXd& positions, Index first, Index from) {
  std::vector<Index> rows;
  for (const dsp::IndexRange& one : record.usable)
    for (Index k = std::max(one.first, from); k < std::min(one.last, first + positions.rows()); ++k)
      rows.push_back(k - first);
  RunErrors errors{static_cast<double>(rows.size()), VectorXd::Constant(positions.cols(), dsp::nan),
                   VectorXd::Constant(positions.cols(), dsp::nan)};
  for (Index body = 0; body < record.num_bodies && !rows.empty(); ++body) {
    const VectorXd recorded = record.samples.col(body).tail(record.samples.rows() - first)(rows);
    errors.nmse(body) = nmse_centred(positions.col(body)(rows), recorded);
    errors.squares(body) = (recorded.array() - recorded.mean()).square().sum();
  }
  return errors;
}

std::optional<std::vector<double>> first_state(const BodiesModel& model, const BodiesRecord& record,
                                               dsp::IndexRange over, int num_threads) {
  const std::vector<double> known(model.mean.begin(), model.mean.end());
  BodiesStatement statement = statement_of(record, model.layout, model.terms, known, {over}, 1);
  if (statement.problem.records.empty()) return std::nullopt;
  if (model.layout.imposed) {
    const auto fit = state_space::output_error(
        statement.problem, {.free_states = model.layout.inner == Inner::none ? std::vector<int>{} : std::vector<int>{1},
                            .num_threads = num_threads});
    if (!fit) return std::nullopt;
    return std::vector<double>(fit->point.states.front().begin(),
                               fit->point.states.front().begin() + model.layout.num_states());
  }
  statement.problem.steps = parts_of(model, record.sample_rate_hz) / 2;
  const state_space::Fit fit = state_space::fit(statement.problem, {.num_threads = num_threads});
  const auto& states = fit.point.states.front();
  const auto n = static_cast<std::ptrdiff_t>(model.layout.num_states());
  if (!std::all_of(states.begin(), states.begin() + n, [](double value) { return std::isfinite(value); }))
    return std::nullopt;
  return std::vector<double>(states.begin(), states.begin() + n);
}

}  // namespace ident
