#include "ident/identify.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "dsp/fault.hpp"
#include "ident/library/collinearity.hpp"
#include "ident/methods.hpp"
#include "ident/sensors/range_sensors.hpp"
#include "ident/validate/independent_rows.hpp"
#include "ident/validate/judge.hpp"

namespace ident {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr Index block_rows = 1024;

/// The rows of a range in these terms, read from the recordings' columns as they are needed.
class RowsOfTerms {
 public:
  RowsOfTerms(const std::vector<Row>& rows, const std::vector<Columns>& recordings, std::vector<Index> terms)
      : rows_(rows), recordings_(recordings), terms_(std::move(terms)) {}
  [[nodiscard]] Index size() const { return static_cast<Index>(rows_.size()); }
  [[nodiscard]] Index num_terms() const { return static_cast<Index>(terms_.size()); }
  /// Rows [first, first + block.rows()).
  void read(Index first, Eigen::Ref<MatrixXd> block) const {
    for (Index j = 0; j < block.cols(); ++j)
      for (Index i = 0; i < block.rows(); ++i) {
        const Row& row = rows_[static_cast<std::size_t>(first + i)];
        block(i, j) = recordings_[row.recording].phi(row.sample, terms_[static_cast<std::size_t>(j)]);
      }
  }
  /// Calls visit(first row, block) for all rows in order.
  template <class Visit>
  void for_each_block(Visit&& visit) const {
    MatrixXd block;
    for (Index first = 0; first < size(); first += block_rows) {
      block.resize(std::min(block_rows, size() - first), num_terms());
      read(first, block);
      visit(first, block);
    }
  }

 private:
  const std::vector<Row>& rows_;
  const std::vector<Columns>& recordings_;
  std::vector<Index> terms_;
};

std::vector<Index> first_integers(Index count) {
  std::vector<Index> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), Index{0});
  return all;
}

VectorXd target_of(const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  VectorXd target(static_cast<Index>(rows.size()));
  for (Index i = 0; i < target.size(); ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    target(i) = recordings[row.recording].target(row.sample);
  }
  return target;
}

/// The index in time of each row, the records one behind the other.
std::vector<Index> samples_in_time(const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  std::vector<Index> begin(recordings.size(), 0), samples;
  for (std::size_t r = 1; r < recordings.size(); ++r)
    begin[r] = begin[r - 1] + recordings[r - 1].signals->num_samples();
  samples.reserve(rows.size());
  for (const Row& row : rows) samples.push_back(begin[row.recording] + row.sample);
  return samples;
}

/// Of each column on the training rows.
struct ColumnExtent {
  VectorXd largest;  ///< magnitude
  std::vector<bool> is_constant;
};

ColumnExtent extent_of(const RowsOfTerms& rows) {
  constexpr double rounding = 1e-13;  // of a column that a filter or an expression leaves constant
  VectorXd lowest = VectorXd::Constant(rows.num_terms(), INFINITY), highest = -lowest;
  rows.for_each_block([&](Index, const MatrixXd& block) {
    lowest = lowest.cwiseMin(block.colwise().minCoeff().transpose());
    highest = highest.cwiseMax(block.colwise().maxCoeff().transpose());
  });
  ColumnExtent extent{lowest.cwiseAbs().cwiseMax(highest.cwiseAbs()), {}};
  for (Index j = 0; j < extent.largest.size(); ++j)
    extent.is_constant.push_back(highest(j) - lowest(j) <= rounding * extent.largest(j));
  return extent;
}

/// The terms that are neither dropped already nor zero on all rows; the latter are named.
std::vector<Index> terms_with_values(const CandidateLibrary& library, const ColumnExtent& extent,
                                     std::vector<DroppedTerm>& dropped) {
  const std::vector<DroppedTerm> known = dropped;
  std::vector<Index> kept;
  for (Index j = 0; j < extent.largest.size(); ++j) {
    const std::string& name = library.terms[static_cast<std::size_t>(j)].name;
    if (std::any_of(known.begin(), known.end(), [&](const DroppedTerm& term) { return term.name == name; })) continue;
    if (extent.largest(j) > 0.0)
      kept.push_back(j);
    else
      dropped.push_back({name, "zero on all training rows"});
  }
  return kept;
}

/// Of `terms`, whose R factor is `data`, the positions of those that can be told apart; the others are named. R has the
/// lengths and angles of the columns themselves.
std::vector<Index> distinct_positions(const CandidateLibrary& library, const std::vector<Index>& terms,
                                      const ColumnExtent& extent, const RFactor& data,
                                      std::vector<DroppedTerm>& dropped) {
  constexpr double rounding = 1e-13;  // of unit vectors that are sums over up to 1e6 rows
  const auto name = [&](Index position) -> const std::string& {
    return library.terms[static_cast<std::size_t>(terms[static_cast<std::size_t>(position)])].name;
  };
  MatrixXd unit(data.R.rows(), data.num_terms);
  std::vector<Index> kept;
  Index constant = -1;
  for (Index j = 0; j < data.num_terms; ++j) {
    unit.col(j) = data.R.col(j).stableNormalized();
    const bool is_constant = extent.is_constant[static_cast<std::size_t>(terms[static_cast<std::size_t>(j)])];
    const auto twin = std::find_if(kept.begin(), kept.end(), [&](Index i) {
      return (unit.col(j) - unit.col(i)).norm() <= rounding || (unit.col(j) + unit.col(i)).norm() <= rounding;
    });
    if (is_constant && constant >= 0) {
      dropped.push_back({name(j), fmt::format("constant on the training rows, as {} is", name(constant))});
    } else if (twin != kept.end()) {
      dropped.push_back({name(j), fmt::format("proportional to {} on the training rows", name(*twin))});
    } else {
      if (is_constant) constant = j;
      kept.push_back(j);
    }
  }
  return kept;
}

/// Greatest magnitude on these rows of each signal the library uses.
std::vector<std::pair<std::string, double>> largest_signals(const CandidateLibrary& library,
                                                            const std::vector<Row>& rows,
                                                            const std::vector<Columns>& recordings) {
  std::vector<std::pair<std::string, double>> largest;
  for (const Term& term : library.terms)
    for (const std::string& name : term.expression.signals()) {
      if (std::any_of(largest.begin(), largest.end(), [&](const auto& known) { return known.first == name; })) continue;
      largest.emplace_back(name, 0.0);
      for (const Row& row : rows)
        if (const dsp::Signal* signal = recordings[row.recording].signals->find(name))
          largest.back().second = std::max(largest.back().second, std::abs(signal->values(row.sample)));
    }
  return largest;
}

/// Sentences on the terms that least squares left out because others make them up.
void name_dependent(Fit& fit, const CandidateLibrary& library) {
  const auto name = [&](Index term) { return library.terms[static_cast<std::size_t>(term)].name; };
  for (const Dependent& dependent : fit.dependent) {
    std::vector<std::string> others;
    for (const Index term : dependent.of) others.push_back(name(term));
    fit.remarks.push_back(fmt::format("{} was left out: on the training rows it is a combination of {}",
                                      name(dependent.term), fmt::join(others, ", ")));
  }
}

Figure figure(double value, const char* reason_without) {
  return std::isfinite(value) ? Figure{value, {}} : Figure{nan, reason_without};
}

/// What the config left open, where one recording settles it: the end, and where testing begins.
void fill_in(dsp::RangeSpec& spec, const RangeRows& rows, int recording, const std::vector<Columns>& recordings) {
  if (recording == 0 && recordings.size() > 1) return;
  const dsp::Motion& signals = *recordings[recording == 0 ? 0 : static_cast<std::size_t>(recording) - 1].signals;
  spec.to_s = std::min(spec.to_s, static_cast<double>(signals.num_samples()) / signals.sample_rate_hz);
  if (!spec.train_to_s)
    spec.train_to_s =
        rows.test.empty() ? spec.to_s : static_cast<double>(rows.test.front().sample) / signals.sample_rate_hz;
}

/// The test part of each recording as stretches to run through, and the rows that count.
std::vector<Course> courses_of(const RangeRows& rows, const std::vector<Columns>& recordings) {
  std::vector<Course> courses;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const dsp::Motion& signals = *recordings[r].signals;
    Course course{&signals, {}, std::vector<unsigned char>(static_cast<std::size_t>(signals.num_samples()), 0)};
    Index first_test = signals.num_samples();
    for (const Row& row : rows.test)
      if (row.recording == r) {
        course.scored[static_cast<std::size_t>(row.sample)] = 1;
        first_test = std::min(first_test, row.sample);
      }
    Index previous = -2;
    for (const Index i : rows.usable[r]) {
      if (i < first_test) continue;
      // A stretch begins at a row that counts: its state is measured where the equation is said to hold.
      const bool continues = i == previous + 1;
      if (!continues && course.scored[static_cast<std::size_t>(i)] == 0) continue;
      if (!continues) course.stretches.push_back({i, i});
      course.stretches.back().last = i + 1;
      previous = i;
    }
    if (!course.stretches.empty()) courses.push_back(std::move(course));
  }
  return courses;
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// All that the methods have in common on one range.
struct RangeData {
  std::vector<Index> terms;  ///< of the library, that can be told apart on the training rows
  VectorXd scale;            ///< largest magnitude of each column of the library on them
  RFactor data;              ///< of `terms` and the target, the sensors integrated out
  std::optional<RangeSensors> sensors;
  SensorProblem joint;                 ///< of sensors, `terms` and target
  MatrixXd sensor_train, sensor_test;  ///< the sensors' columns on the rows
  VectorXd train, test;                ///< target
  std::vector<Index> train_samples;
  std::vector<Course> courses;
  std::vector<std::pair<std::string, double>> largest;  ///< of the signals the library looks at
};

RangeData range_data(RangeResult& result, const std::vector<Columns>& recordings, const CandidateLibrary& library,
                     const IdentifyOptions& options) {
  RangeData range;
  const std::vector<Row>& rows = result.rows.train;
  const ColumnExtent extent = extent_of({rows, recordings, first_integers(static_cast<Index>(library.terms.size()))});
  range.scale = extent.largest;
  range.train = target_of(rows, recordings);
  range.test = target_of(result.rows.test, recordings);
  range.terms = terms_with_values(library, extent, result.dropped);
  if (range.terms.empty())
    throw dsp::Fault(dsp::FaultKind::numerics, "library.nothing_left",
                     fmt::format("range '{}': every candidate term was dropped; the first, {}, is {}.",
                                 result.spec.name, result.dropped.front().name, result.dropped.front().reason));
  const RowsOfTerms columns(rows, recordings, range.terms);
  range.data = r_factor(
      columns.size(), columns.num_terms(), 1,
      [&](Index first, Eigen::Ref<MatrixXd> block) {
        columns.read(first, block.leftCols(columns.num_terms()));
        block.rightCols(1) = range.train.segment(first, block.rows());
      },
      options.num_threads);
  const std::vector<Index> kept = distinct_positions(library, range.terms, extent, range.data, result.dropped);
  if (kept.size() < range.terms.size()) {
    range.data = select(range.data, kept, 0);
    std::vector<Index> terms;
    for (const Index position : kept) terms.push_back(range.terms[static_cast<std::size_t>(position)]);
    range.terms = std::move(terms);
  }
  range.train_samples = samples_in_time(rows, recordings);
  if (options.free_run) range.courses = courses_of(result.rows, recordings);
  range.largest = largest_signals(library, rows, recordings);
  return range;
}

/// The terms of a fit on the range's data.
WeightedTerms equation_of(const Fit& found, const RangeData& range, const CandidateLibrary& library) {
  WeightedTerms equation;
  for (std::size_t i = 0; i < found.relevant.size(); ++i) {
    const Index term = range.terms[static_cast<std::size_t>(found.relevant[i])];
    equation.emplace_back(library.terms[static_cast<std::size_t>(term)].expression, found.mean(static_cast<Index>(i)));
  }
  return equation;
}

/// Lets the sensors take part, their columns formed with this equation.
void add_sensors(RangeData& range, RangeSensors sensors, const WeightedTerms& equation, const RangeResult& result,
                 const std::vector<Columns>& recordings, const IdentifyOptions& options) {
  if (sensors.parameters().empty()) return;
  const auto n_s = static_cast<Index>(sensors.parameters().size());
  range.joint.prior_std.resize(n_s);
  for (Index i = 0; i < n_s; ++i) {
    const SensorParameter& parameter = sensors.parameters()[static_cast<std::size_t>(i)];
    range.joint.prior_std(i) = parameter.std;
    range.joint.sources.push_back(parameter.source);
  }
  sensors.form(equation, options.target, options.poll);
  range.sensor_train = sensors.on(result.rows.train);
  range.sensor_test = sensors.on(result.rows.test);
  const RowsOfTerms columns(result.rows.train, recordings, range.terms);
  range.joint.joint = r_factor(
      columns.size(), n_s + columns.num_terms(), 1,
      [&](Index first, Eigen::Ref<MatrixXd> block) {
        block.leftCols(n_s) = range.sensor_train.middleRows(first, block.rows());
        columns.read(first, block.middleCols(n_s, columns.num_terms()));
        block.rightCols(1) = range.train.segment(first, block.rows());
      },
      options.num_threads);
  range.data = without_sensors(range.joint, noise_beside_all(range.joint));
  range.sensors.emplace(std::move(sensors));
}

/// The terms of a fit that jump, as they make an acceleration jump; none where the equation holds no acceleration.
struct SwitchedFit {
  WeightedTerms terms;
  std::vector<double> stds;
};

SwitchedFit switched_fit(const Fit& found, const RangeData& range, const CandidateLibrary& library,
                         const IdentifyOptions& options) {
  const auto term_of = [&](std::size_t i) -> const Term& {
    return library.terms[static_cast<std::size_t>(range.terms[static_cast<std::size_t>(found.relevant[i])])];
  };
  const auto is_acceleration = [](const std::string& name) { return name == "a" || name == "ddy"; };
  double of_acceleration = is_acceleration(options.target) ? 1.0 : 0.0;
  if (of_acceleration == 0.0)  // 0 = -target + m a + other terms
    for (std::size_t i = 0; i < found.relevant.size(); ++i)
      if (is_acceleration(term_of(i).name)) of_acceleration = -found.mean(static_cast<Index>(i));
  SwitchedFit result;
  for (std::size_t i = 0; of_acceleration != 0.0 && i < found.relevant.size(); ++i) {
    const auto place = static_cast<Index>(i);
    if (term_of(i).expression.all_switches().empty()) continue;
    result.terms.emplace_back(term_of(i).expression, found.mean(place) / of_acceleration);
    result.stds.push_back(std::sqrt(found.covariance(place, place)) / std::abs(of_acceleration));
  }
  return result;
}

bool settled(const WeightedTerms& before, const SwitchedFit& now) {
  constexpr double of_std = 0.1;     // moves no other coefficient by more than about that
  constexpr double relative = 1e-5;  // of a coefficient without error: what the times are exact to
  if (before.size() != now.terms.size()) return false;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double mean = now.terms[i].second, limit = std::fmax(of_std * now.stds[i], relative * std::abs(mean));
    if (before[i].first.text() != now.terms[i].first.text() || !(std::abs(mean - before[i].second) <= limit))
      return false;
  }
  return true;
}

/// The data of a range with the switches where its own equation has them and the sensors' columns of that equation:
/// fitted, formed and fitted again.
RangeData settled_data(const Range& range, RangeResult& result, std::vector<Columns>& recordings,
                       const CandidateLibrary& library, const IdentifyOptions& options) {
  constexpr int most_passes = 4;  // each leaves less than a tenth of the error
  const std::vector<DroppedTerm> dropped = result.dropped;
  const auto data_under = [&](const WeightedTerms& equation) {
    for (std::size_t r = 0; r < recordings.size(); ++r)
      if (result.recording == 0 || static_cast<std::size_t>(result.recording) == r + 1)
        place_switches(recordings[r], library, equation, options.poll);
    result.dropped = dropped;
    return range_data(result, recordings, library, options);
  };
  RangeData data = data_under({});
  const RangeSensors sensors(range, recordings);
  const bool matched = std::any_of(recordings.begin(), recordings.end(),
                                   [](const Columns& columns) { return columns.switches != nullptr; });
  // Coefficients without the sensors are a few per cent off, and so are the columns formed with them: not twice.
  const int least_passes = sensors.parameters().empty() ? 0 : 2;
  WeightedTerms equation;
  for (int pass = 0; matched && !options.methods.empty() && pass < most_passes; ++pass) {
    const Fit found = fit(data.data, options.methods.front());
    const SwitchedFit now = switched_fit(found, data, library, options);
    if (settled(equation, now) && pass >= least_passes) break;
    equation = now.terms;
    const WeightedTerms present = equation_of(found, data, library);
    data = data_under(equation);
    add_sensors(data, sensors, present, result, recordings, options);
  }
  return data;
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

/// Covariance without the assumption that the residual is white; empty where nothing tells the noise.
MatrixXd robust_covariance_of(const Fit& fit, const RangeData& range, const std::vector<Row>& rows,
                              const std::vector<Columns>& recordings, const VectorXd& residual) {
  if (fit.relevant.empty() || !fit.covariance.allFinite()) return {};
  std::vector<Index> positions;
  for (const Index term : fit.relevant)
    positions.push_back(std::lower_bound(range.terms.begin(), range.terms.end(), term) - range.terms.begin());
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
  judged.bands = band_shares(test.mean, test.variance, range.test);
  judged.bands_reason = !tested                                    ? no_test
                        : std::isfinite(judged.fit.noise_variance) ? ""
                                                                   : "no row is left to tell the noise";
  judged.predicted.resize(range.train.size() + range.test.size());
  judged.predicted << train.mean, test.mean;
  judged.predicted_std.resize(judged.predicted.size());
  judged.predicted_std << train.variance.cwiseSqrt(), test.variance.cwiseSqrt();
}

/// The free run of an equation, or that of an earlier method which found the same one.
FreeRun free_run_of(const JudgedFit& judged, const std::vector<JudgedFit>& earlier, const RangeData& range,
                    const std::vector<Course>& courses, const IdentifyOptions& options) {
  const auto twin = std::find_if(earlier.begin(), earlier.end(),
                                 [&](const JudgedFit& other) { return same_equation(other.model, judged.model); });
  FreeRun run;
  run.nmse = nan;
  if (!options.free_run)
    run.reason = "the rows of a table are no time response";
  else if (range.test.size() == 0)
    run.reason = "no test rows";
  else
    run = twin != earlier.end() ? twin->free_run : free_run(judged.model, courses, {.poll = options.poll});
  run.applies = options.free_run && (options.target == "a" || options.target == "ddy");  // else no equation of motion
  return run;
}

/// What the sensors are found to be beside a fit, and what the coefficients are known to with them.
SensorPosterior posterior_with_sensors(const Fit& found, const RangeData& range, const std::vector<Index>& positions,
                                       const VectorXd& residual_without, double& fraction) {
  fraction = 1.0;
  SensorPosterior posterior;
  for (int pass = 0; pass < 2; ++pass) {  // the sensors, hence the residual, hence its colour, hence the deviations
    posterior = sensor_posterior(range.joint, positions, found.mean, found.noise_variance, fraction);
    fraction = independent_fraction(residual_without - range.sensor_train * posterior.sensor_mean, range.train_samples);
  }
  return sensor_posterior(range.joint, positions, found.mean, found.noise_variance, fraction);
}

/// Lets the sensors' values into model, predictions and the signals of the free run.
void judge_sensors(JudgedFit& judged, const RangeData& range, const std::vector<Index>& positions, Prediction& train,
                   Prediction& test, std::vector<dsp::Motion>& corrected, std::vector<Course>& courses,
                   const std::vector<Columns>& recordings) {
  if (!range.sensors || positions.empty() || !judged.fit.covariance.allFinite()) return;
  const SensorPosterior posterior =
      posterior_with_sensors(judged.fit, range, positions, range.train - train.mean, judged.independent_fraction);
  set_sensor_deviations(judged.model, posterior);
  train.mean += range.sensor_train * posterior.sensor_mean;
  test.mean += range.sensor_test * posterior.sensor_mean;
  const auto& parameters = range.sensors->parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto place = static_cast<Index>(i);
    judged.sensors.push_back({parameters[i].name, parameters[i].unit, parameters[i].std, posterior.sensor_mean(place),
                              posterior.sensor_std(place)});
  }
  corrected.reserve(courses.size());  // the courses point at them
  for (Course& course : courses)
    for (std::size_t r = 0; r < recordings.size(); ++r)
      if (course.signals == recordings[r].signals && !recordings[r].sensors.empty()) {
        corrected.push_back(range.sensors->corrected_signals(r, posterior.sensor_mean));
        course.signals = &corrected.back();
        break;
      }
}

JudgedFit judged_fit(const MethodOptions& method, const RangeResult& result, const RangeData& range,
                     const std::vector<Columns>& recordings, const CandidateLibrary& library,
                     const IdentifyOptions& options) {
  JudgedFit judged;
  const auto start = Clock::now();
  judged.fit = fit(range.data, method);
  judged.solve_s = seconds_since(start);
  std::vector<const Term*> terms;
  for (const Index j : range.terms) terms.push_back(&library.terms[static_cast<std::size_t>(j)]);
  for (std::string& remark : collinearity_remarks(range.data, judged.fit, terms, range.largest))
    judged.fit.remarks.push_back(std::move(remark));
  const std::vector<Index> positions = judged.fit.relevant;
  renumber(judged.fit, range.terms, static_cast<Index>(library.terms.size()));
  name_dependent(judged.fit, library);
  Prediction train = predict(judged.fit, result.rows.train, recordings),
             test = predict(judged.fit, result.rows.test, recordings);
  judged.model = make_model(
      library, judged.fit, options.target, options.target_unit, range.scale,
      range.sensors ? MatrixXd()
                    : robust_covariance_of(judged.fit, range, result.rows.train, recordings, range.train - train.mean));
  std::vector<dsp::Motion> corrected;
  std::vector<Course> courses = range.courses;
  judge_sensors(judged, range, positions, train, test, corrected, courses, recordings);
  const VectorXd residual = range.train - train.mean;
  const Columns& first = recordings[result.recording == 0 ? 0 : static_cast<std::size_t>(result.recording) - 1];
  judged.whiteness = residual_whiteness(residual, range.train_samples, first.signals->sample_rate_hz, first.band_hz);
  judge_errors(judged, range, train, test);
  judged.free_run = free_run_of(judged, result.fits, range, courses, options);
  return judged;
}

}  // namespace

RangeResult identify(const Range& range, std::vector<Columns>& recordings, const CandidateLibrary& library,
                     const IdentifyOptions& options) {
  RangeResult result;
  result.spec = range.spec;
  result.recording = range.recording;
  result.regime = range.regime;
  for (const Term& term : library.terms) result.terms.push_back(term.name);
  result.rows = range_rows(range, recordings);
  fill_in(result.spec, result.rows, range.recording, recordings);
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (!range.covers(r)) continue;
    result.dropped.insert(result.dropped.end(), recordings[r].dropped.begin(), recordings[r].dropped.end());
    for (const std::string& channel : recordings[r].signals->uncalibrated)
      result.uncalibrated.push_back(recordings[r].name + ": " + channel);
    if (recordings[r].power)
      result.power_balance = std::fmax(
          result.power_balance, largest_balance(*recordings[r].power, range.regime, &dsp::RegimePower::corrected));
  }
  const auto start = Clock::now();
  const RangeData data = settled_data(range, result, recordings, library, options);
  result.accumulate_s = seconds_since(start);
  result.target.resize(data.train.size() + data.test.size());
  result.target << data.train, data.test;
  for (const MethodOptions& method : options.methods) {
    if (options.poll) options.poll();
    result.fits.push_back(judged_fit(method, result, data, recordings, library, options));
  }
  return result;
}

std::vector<RangeResult> identify(Record record, const LibraryOptions& library, IdentifyOptions options) {
  const std::vector<Range> ranges = default_ranges({&record});
  if (record.prepared.x_is_difference)
    dsp::set_displacement_zero(record.prepared, mean_of_first_range(record, ranges, 1));
  const dsp::Motion& signals = record.prepared.signals;
  const CandidateLibrary compiled = make_library(library, options.target, signals);
  std::vector<Columns> columns{form_columns(compiled, options.target, record.prepared, options.poll)};
  columns.front().regimes = record.regimes;
  columns.front().power = record.power;
  columns.front().sensors = sensor_parameters(record);
  options.target_unit = signals.find(options.target)->unit;
  std::vector<RangeResult> results;
  for (const Range& range : ranges) results.push_back(identify(range, columns, compiled, options));
  judge(results);
  return results;
}

}  // namespace ident
