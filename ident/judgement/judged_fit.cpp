#include "ident/judgement/judged_fit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "dsp/values/constants.hpp"
#include "ident/equation/absolute_gains.hpp"
#include "ident/equation/interval_95.hpp"
#include "ident/evidence/likelihood.hpp"
#include "ident/judgement/coordinates.hpp"
#include "ident/judgement/findings.hpp"
#include "ident/judgement/fit_remarks.hpp"
#include "ident/judgement/judged_run.hpp"
#include "ident/ranges/rows_of_terms.hpp"
#include "ident/regression/collinearity.hpp"
#include "ident/regression/finish_fit.hpp"
#include "ident/regression/methods.hpp"
#include "ident/selection/ranked_models.hpp"
#include "ident/validate/closed_orbit.hpp"
#include "ident/validate/independent_rows.hpp"

namespace ident {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using dsp::nan;

Figure figure(double value, const char* reason_without) {
  return std::isfinite(value) ? Figure{value, {}} : Figure{nan, reason_without};
}

struct Prediction {
  VectorXd mean, variance;
};

Prediction predict(const Fit& fit, const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  const RowsOfTerms columns(rows, recordings, fit.relevant);
  Prediction result{VectorXd(columns.size()), VectorXd(columns.size())};
  columns.for_each_block([&](Index first, const MatrixXd& phi) {
    result.mean.segment(first, phi.rows()) = phi * fit.mean;
    result.variance.segment(first, phi.rows()) = predictive_variance(phi, fit.covariance, fit.noise_variance);
  });
  return result;
}

/// Covariance without the assumption that the residual is white; empty where no row is left to estimate the noise.
MatrixXd robust_covariance_of(const Fit& fit, const RangeData& range, const std::vector<Row>& rows,
                              const std::vector<Columns>& recordings, const VectorXd& residual) {
  if (fit.relevant.empty() || !fit.covariance.allFinite()) return {};
  const std::vector<Index> positions = positions_in(range, fit.relevant);
  BlockScores scores(static_cast<Index>(positions.size()), residual.size());
  RowsOfTerms(rows, recordings, fit.relevant).for_each_block([&](Index first, const MatrixXd& phi) {
    scores.add(phi, residual.segment(first, phi.rows()));
  });
  return robust_covariance(select(range.data, positions, 0), scores);
}

void judge_errors(JudgedFit& judged, const RangeData& range, const Prediction& train, const Prediction& test) {
  const bool tested = range.test.size() > 0;
  const char* no_test = tested ? nullptr : "no test rows";
  judged.train = figure(nmse(train.mean, range.train), "the target is zero on all training rows");
  judged.train_centred = figure(nmse_centred(train.mean, range.train), "the target is constant on the training rows");
  judged.test =
      figure(tested ? nmse(test.mean, range.test) : nan, tested ? "the target is zero on all test rows" : no_test);
  judged.test_centred = figure(tested ? nmse_centred(test.mean, range.test) : nan,
                               tested ? "the target is constant on the test rows" : no_test);
  judged.bands = band_fractions(test.mean, test.variance, range.test);
  judged.bands_reason = tested ? judged.fit.no_variance : no_test;
  judged.predicted.resize(range.train.size() + range.test.size());
  judged.predicted << train.mean, test.mean;
  judged.predicted_std.resize(judged.predicted.size());
  judged.predicted_std << train.variance.cwiseSqrt(), test.variance.cwiseSqrt();
}

/// Lets the sensors into predictions on these rows.
void add_sensors(Prediction& prediction, const SensorPosterior& posterior, const RangeSensors& sensors, const Fit& fit,
                 const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  prediction.mean += sensors.effect(rows, posterior.sensor_mean);
  RowsOfTerms(rows, recordings, fit.relevant).for_each_block([&](Index first, const MatrixXd& phi) {
    const Index n_s = posterior.sensor_mean.size();
    MatrixXd both(phi.rows(), n_s + phi.cols());
    sensors.read(rows, first, both.leftCols(n_s));
    both.rightCols(phi.cols()) = phi;
    prediction.variance.segment(first, phi.rows()) =
        predictive_variance(both, posterior.joint, posterior.noise_std * posterior.noise_std);
  });
}

/// Lets the sensors' values into model and predictions.
void judge_sensors(JudgedFit& judged, const RangeData& range, const EvidenceData* evidence,
                   const std::vector<Index>& positions, Prediction& train, Prediction& test, const RangeResult& result,
                   const std::vector<Columns>& recordings) {
  const RangeRows& rows = result.rows;
  judged.model.coordinates = coordinates_of(range, result.recording, recordings, nullptr);
  if (!range.sensors || positions.empty()) return;
  SensorPosterior posterior = sensors_beside(judged.fit, positions, range, rows.train, evidence,
                                             range.train - train.mean, judged.independent_fraction);
  if (const Fit& found = judged.fit; found.covariance.allFinite()) {
    const VectorXd widening = found.interval_covariance().diagonal().cwiseQuotient(found.covariance.diagonal());
    add_terms_left_out(posterior, widening.unaryExpr([](double by) { return by > 1.0 ? std::sqrt(by) : 1.0; }));
    set_sensor_posterior(judged.model, posterior);
  }
  add_sensors(train, posterior, *range.sensors, judged.fit, rows.train, recordings);
  add_sensors(test, posterior, *range.sensors, judged.fit, rows.test, recordings);
  const auto& parameters = range.sensors->parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto index = static_cast<Index>(i);
    judged.sensors.push_back({parameters[i].name, parameters[i].unit, parameters[i].std, posterior.sensor_mean(index),
                              posterior.sensor_std(index)});
  }
  judged.model.coordinates = coordinates_of(range, result.recording, recordings, &posterior);
}

/// The same where the likelihood has found them with the coefficients.
void take_channels(JudgedFit& judged, const Likelihood& likelihood, const RangeData& range, Prediction& train,
                   Prediction& test, const RangeResult& result, const std::vector<Columns>& recordings) {
  judged.sensors = likelihood.sensors;
  judged.model.coordinates = coordinates_of(range, result.recording, recordings, nullptr);
  for (Coordinates& one : judged.model.coordinates) {
    one.zero += likelihood.zero.mean, one.zero_std = likelihood.zero.std;
    one.lead_s = -likelihood.lag_s.mean, one.lead_std_s = likelihood.lag_s.std;
  }
  if (!range.sensors) return;
  VectorXd values = VectorXd::Zero(std::ssize(range.sensors->parameters()));
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (const auto at = range.sensors->coordinate(r, Coordinate::zero_of_x)) values(*at) = -likelihood.zero.mean;
    if (const auto at = range.sensors->coordinate(r, Coordinate::lead_of_f)) values(*at) = -likelihood.lag_s.mean;
  }
  train.mean += range.sensors->effect(result.rows.train, values);
  test.mean += range.sensors->effect(result.rows.test, values);
}

/// Recordings of one range are of the same sensors.
void judge_calibration(Model& model, const RangeResult& result, const std::vector<Columns>& recordings,
                       const CandidateLibrary& library) {
  const Columns& first = recordings[result.rows.train.front().recording];
  if (first.prepared == nullptr || !result.uncalibrated.empty()) return;
  constexpr std::size_t enough = 10'000;  // to tell a term's degree
  set_calibration(model, library, absolute_gains(*first.prepared),
                  some_samples(result.rows.train, result.rows.train.front().recording, recordings, enough));
}

/// Terms that never make up a millionth of the target are rounding, on data without noise: no recorder has 120 dB.
/// Those that never make up more than sensors add that are not linear are dropped if their interval includes zero.
void drop_negligible(Fit& found, const RFactor& data, const RangeData& range, const MethodOptions& method,
                     const Poll& poll) {
  constexpr double of_target = 1e-6;
  if (!weighs_rows(method)) return;
  const double largest = range.train.cwiseAbs().maxCoeff();
  const VectorXd std = found.interval_covariance().diagonal().cwiseSqrt();
  std::vector<Index> terms;
  for (std::size_t i = 0; i < found.relevant.size(); ++i) {
    const Index term = range.terms[static_cast<std::size_t>(found.relevant[i])];
    const auto at = static_cast<Index>(i);
    const double size = std::abs(found.mean(at)), share = size * range.scale(term) / largest;
    if (!(share <= of_target || (share * share <= sensor_linearity && size < interval_95 * std(at))))
      terms.push_back(found.relevant[i]);
  }
  if (terms.empty() || terms.size() == found.relevant.size()) return;
  Fit fewer = fit_on_terms(data, terms, method, poll);
  fewer.remarks = std::move(found.remarks);
  found = std::move(fewer);
}

/// The likelihood takes the place of the first method that weighs rows and leaves the choice to it: others stay a
/// second opinion.
bool speaks_for(const RangeResult& result, const MethodOptions& method) {
  return result.likelihood.speaks() && weighs_rows(method) && !has_own_tau(method) &&
         std::none_of(result.fits.begin(), result.fits.end(), [](const JudgedFit& fit) { return fit.by_likelihood; });
}

/// The terms and coefficients of the likelihood. Nothing where the rows do not tell its terms apart.
std::optional<Fit> fit_by(const Likelihood& likelihood, const RFactor& data, const RangeData& range,
                          const MethodOptions& method, const Poll& poll) {
  const std::vector<Index> positions = positions_in(range, likelihood.terms);
  Fit found = fit_on_terms(data, positions, method, poll);
  if (found.relevant != positions) return std::nullopt;
  found.mean = likelihood.mean;
  found.covariance = likelihood.covariance;
  found.covariance_weak.resize(0, 0);
  found.no_variance.clear();
  found.evidence_gain.resize(std::ssize(range.terms));
  for (std::size_t i = 0; i < range.terms.size(); ++i)
    found.evidence_gain(static_cast<Index>(i)) = likelihood.gain(range.terms[i]);
  found.tau = likelihood.price;
  return found;
}

/// Of the method alone: on the terms of the evidence where it has settled on them.
Fit fit_of_rows(const RFactor& data, const RangeData& range, const MethodOptions& method, const Poll& poll) {
  const bool settled = weighs_rows(method) && range.evidence.terms && !has_own_tau(method);
  Fit found = settled ? fit_on_terms(data, *range.evidence.terms, method, poll) : fit(data, with_poll(method, poll));
  drop_negligible(found, data, range, method, poll);
  return found;
}

/// Every model beside the one that was settled on; none where there is nothing to explain.
std::optional<ModelRanking> ranking_of(const RFactor& data, const Fit& found, const Poll& poll) {
  if (!std::isfinite(found.log_evidence)) return std::nullopt;
  return ranked_models(unit_problem(data, poll), found.relevant);
}

/// What cannot be said of coefficients where misfit and not noise limits them; `nmse`: of the training rows.
void judge_size(JudgedFit& judged, const CandidateLibrary& library, double nmse) {
  Fit& fit = judged.fit;
  const EffectiveSize& size = judged.size;
  const auto k = static_cast<double>(fit.relevant.size());
  // A library whose best model leaves more than this, most of it a function of the state, lacks what the target needs.
  constexpr double mostly = 0.5, much = 0.1;
  const bool lacks = size.structural_fraction > mostly && nmse > much;
  if (size.num_effective() - k < 2.0 || lacks) {
    fit.covariance.setConstant(nan);
    fit.covariance_weak.resize(0, 0);
    if (!lacks)
      fit.no_variance = fmt::format("the {:.0f} rows count as {:.0f} independent ones: too few for {:.0f} coefficients",
                                    size.num_rows, size.num_effective(), k);
    else
      fit.no_variance = fmt::format(
          "an NMSE of {:.2g} is left over and is not noise ({:.0f} % of it is a function of the state; the {:.0f} rows "
          "count as {:.0f} independent ones): a term is missing from the candidates",
          nmse, 100.0 * size.structural_fraction, size.num_rows, size.num_effective());
    return;
  }
  const double known = std::min(size.num_uncorrelated, size.num_states);
  if (!(known > 0.0) || !(known < size.num_effective())) return;
  const double threshold =
      gain_threshold(Selection::evidence, -1.0, std::max<Index>(2, std::lround(known)), std::ssize(library.terms));
  std::vector<std::string> small;
  for (std::size_t j = 0; j < fit.relevant.size(); ++j) {
    const auto index = static_cast<Index>(j);
    const double t2 = fit.mean(index) * fit.mean(index) / fit.covariance(index, index);
    if (evidence_gain(t2 * known / size.num_effective()) < threshold)
      small.push_back(library.terms[static_cast<std::size_t>(fit.relevant[j])].label());
  }
  const bool white = size.num_effective() >= 0.5 * size.num_rows;
  if (!small.empty() && !white)
    fit.remarks.push_back(fmt::format("small enough to be an error of the model: {}", fmt::join(small, ", ")));
}

/// On one closed orbit with fewer equations than candidates: what is known of the coefficients beside all equations
/// that fit it as well; nothing where any would.
std::optional<VectorXd> judge_orbit(Fit& fit, const std::optional<ClosedOrbit>& orbit,
                                    const std::vector<Index>& positions) {
  if (!orbit || positions.empty()) return std::nullopt;
  std::optional<VectorXd> stds = stds_of_orbit(*orbit, positions, fit.mean);
  if (stds) return stds;
  fit.covariance.setConstant(nan);
  fit.covariance_weak.resize(0, 0);
  fit.no_variance = fmt::format(
      "the record is one closed orbit of {} independent equations, which as many terms with any coefficients fit",
      orbit->num_equations());
  return std::nullopt;
}

void widen(Model& model, const VectorXd& stds) {
  VectorXd factors = VectorXd::Ones(stds.size());
  for (Index i = 0; i < stds.size(); ++i) {
    ModelTerm& term = model.terms[static_cast<std::size_t>(i)];
    if (!(stds(i) > term.std)) continue;
    factors(i) = stds(i) / term.std;
    term.std = stds(i);
  }
  model.covariance = factors.asDiagonal() * model.covariance * factors.asDiagonal();
}

/// Candidates of all recordings that are not in a model, by any of its coefficients.
std::vector<LeftOut> left_out(const Model& model, const RangeData& range, const CandidateLibrary& library) {
  std::vector<LeftOut> result;
  for (const Index j : range.terms) {
    const Term& term = library.terms[static_cast<std::size_t>(j)];
    const bool kept = std::any_of(model.terms.begin(), model.terms.end(),
                                  [&](const ModelTerm& one) { return one.name == term.name; });
    if (!kept && term.recording == 0) result.push_back({term.name, j});
  }
  return result;
}

/// What may be wrong with an equation however well it fits.
void judge_doubts(JudgedFit& judged, const RangeData& range, const RangeResult& result,
                  const std::vector<Columns>& recordings, const std::vector<Index>& positions, const VectorXd& residual,
                  const CandidateLibrary& library, const IdentifyOptions& options) {
  // Of the columns as they are: range.data is what the sensors leave of them.
  std::vector<Index> columns = positions;
  if (range.sensors)
    for (Index& column : columns) column += range.joint.num_sensors();
  const RFactor kept = select(range.sensors ? range.joint.joint : range.data, columns, 0);
  judged.noise = regressor_noise(judged.model, kept, result.rows.train, recordings, residual, options.poll);
  if (judged.by_likelihood) {
    judged.noise.bias.resize(0);  // of least squares
    const std::optional<Explanation>& missing = result.likelihood.missing;
    (missing && missing->is_recorded ? judged.explanations.recorded : judged.explanations.better) = missing;
    if (!result.likelihood.has_unexplained()) return;
    judged.explanations.form = swing_of(judged.model, result.terms, kept, result.rows.train, recordings, residual,
                                        *range.independence, options.poll);
    judged.band = band_split(judged.model, judged.fit.relevant, result.rows.train, recordings, residual, options.poll);
    return;
  }
  judged.explanations = explanations(judged.model, result.terms, left_out(judged.model, range, library), kept,
                                     result.rows.train, recordings, residual, *range.independence, options.poll);
  judged.band = band_split(judged.model, judged.fit.relevant, result.rows.train, recordings, residual, options.poll);
  if (judged.band && !judged.band->term.empty())
    judged.fit.remarks.push_back(fmt::format(
        "the record does not follow one equation in the whole band: below {:.3g} Hz {} has {}, in all of it "
        "{}, and the difference is more than its interval allows. A lower prepare.cutoff_hz may mend it",
        0.5 * judged.band->stop_hz, judged.band->term, number(judged.band->lower_mean), number(judged.band->mean)));
}

/// Of x that was integrated there is no free run to compare with.
void judge_recorded_run(JudgedFit& judged, const RangeResult& result, const RangeData& range,
                        const std::vector<Columns>& recordings, const IdentifyOptions& options) {
  if (result.rows.test.empty() || !judged.free_run.applies) return;
  const Columns& first = recordings[result.rows.test.front().recording];
  const bool integrated = first.prepared != nullptr && first.prepared->integrated();
  const bool misses = !result.likelihood.has_unexplained() && judged.free_run.larger_nmse() > follows_in_part;
  if (!integrated && !misses) return;
  judged.recorded_run = run_through(result.likelihood, {result.spec, result.recording, result.regime}, result.rows.test,
                                    range, recordings, options.num_threads);
  if (!integrated || !judged.recorded_run) return;
  judged.free_run = {.nmse = nan, .alone = judged.free_run.alone, .reason = "x was not recorded"};
}

}  // namespace

JudgedFit judged_fit(const MethodOptions& method, const RangeResult& result, const RangeData& range,
                     const std::vector<Columns>& recordings, const CandidateLibrary& library,
                     const IdentifyOptions& options) {
  JudgedFit judged;
  const auto start = Clock::now();
  const EvidenceData* evidence = weighs_rows(method) ? &range.evidence : nullptr;
  const bool weighed = evidence != nullptr && !evidence->as_they_are();
  RFactor data = weighed ? evidence->data : range.data;
  data.degree = degrees(library, range.terms);
  std::optional<Fit> recorded;
  if (speaks_for(result, method)) recorded = fit_by(result.likelihood, data, range, method, options.poll);
  judged.by_likelihood = recorded.has_value();
  judged.fit = recorded ? std::move(*recorded) : fit_of_rows(data, range, method, options.poll);
  judged.size.num_rows = judged.size.num_uncorrelated = static_cast<double>(range.train.size());
  if (evidence != nullptr) {
    judged.size = evidence->size;
    judged.path = evidence->path;
    const double rho = evidence->size.autoregression;
    judged.fit.noise_variance /= 1.0 - rho * rho;  // of the target itself
  }
  judged.solve_s = std::chrono::duration<double>(Clock::now() - start).count();
  std::vector<const Term*> terms;
  for (const Index j : range.terms) terms.push_back(&library.terms[static_cast<std::size_t>(j)]);
  for (std::string& remark : collinearity_remarks(data, judged.fit, terms, range.largest, options.poll))
    judged.fit.remarks.push_back(std::move(remark));
  if (evidence != nullptr) {
    name_ties(judged, data, range, library, options.poll);
    if (!recorded) judged.fit.ranking = ranking_of(data, judged.fit, options.poll);
  }
  const std::vector<Index> positions = judged.fit.relevant;
  renumber(judged.fit, range.terms, static_cast<Index>(library.terms.size()));
  name_dependent(judged.fit, library);
  name_undecided(judged.fit, library);
  Prediction train = predict(judged.fit, result.rows.train, recordings),
             test = predict(judged.fit, result.rows.test, recordings);
  const std::optional<VectorXd> orbit_stds = judge_orbit(judged.fit, result.orbit, positions);
  if (weighed && !recorded) judge_size(judged, library, nmse_centred(train.mean, range.train));
  if (!judged.fit.no_variance.empty())
    judged.fit.remarks.push_back("no standard deviations: " + judged.fit.no_variance);
  judged.model = make_model(
      library, judged.fit, options.target, options.target_unit, range.scale,
      range.sensors || weighed || recorded
          ? MatrixXd()
          : robust_covariance_of(judged.fit, range, result.rows.train, recordings, range.train - train.mean));
  if (recorded)
    take_channels(judged, result.likelihood, range, train, test, result, recordings);
  else
    judge_sensors(judged, range, evidence, positions, train, test, result, recordings);
  if (orbit_stds) widen(judged.model, *orbit_stds);
  judged.model.extents = extents_of(judged.model, result.rows.train, recordings);
  judge_calibration(judged.model, result, recordings, library);
  const VectorXd residual = range.train - train.mean;
  const Columns& first = recordings[result.recording == 0 ? 0 : static_cast<std::size_t>(result.recording) - 1];
  judged.whiteness = residual_whiteness(residual, range.train_samples, first.signals->sample_rate_hz, first.band_hz);
  judge_errors(judged, range, train, test);
  train = test = {};  // kept in `judged`
  judge_doubts(judged, range, result, recordings, positions, residual, library, options);
  std::vector<dsp::Motion> moved;
  std::vector<Course> courses = range.courses;
  run_in_coordinates(judged.model, recordings, moved, courses);
  judged.free_run = judged_run(judged, result, range, courses, recordings, options);
  if (recorded) judge_recorded_run(judged, result, range, recordings, options);
  return judged;
}

}  // namespace ident
