#include "apps/identify.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>

#include "apps/process/interrupt.hpp"
#include "apps/regimes.hpp"
#include "dsp/fault.hpp"
#include "ident/library/collinearity.hpp"
#include "ident/regression/multi_rvm.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

dsp::Fault range_fault(const dsp::RangeSpec& spec, std::string name, const std::string& what) {
  const std::string place = spec.place.empty() ? "" : spec.place + ": ";
  return {dsp::FaultKind::usage, std::move(name), fmt::format("{}range '{}': {}.", place, spec.name, what)};
}

/// The samples of one recording between two times of the range, those that may be used at all, and those `where` keeps.
struct Samples {
  std::vector<Index> usable, kept;
};

Samples samples_of(const Range& range, const Columns& columns, const std::vector<unsigned char>& where) {
  const dsp::RangeSpec& spec = range.spec;
  const dsp::Motion& signals = *columns.signals;
  Samples result;
  const Index length = signals.num_samples();
  for (Index i = signals.edge_samples; i < length - signals.edge_samples; ++i) {
    const double t = static_cast<double>(i) / signals.sample_rate_hz;
    const auto place = static_cast<std::size_t>(i);
    if (t < spec.from_s || t >= spec.to_s || (!signals.excluded.empty() && signals.excluded[place] != 0)) continue;
    if (!columns.regimes.empty() && !range.regime.holds(columns.regimes[place])) continue;
    result.usable.push_back(i);
    if (where.empty() || where[place] != 0) result.kept.push_back(i);
  }
  return result;
}

std::vector<unsigned char> condition_rows(const dsp::RangeSpec& spec, const dsp::Motion& signals) {
  if (spec.where.empty()) return {};
  std::vector<std::string> names;
  for (const dsp::Signal& signal : signals.signals) names.push_back(signal.name);
  try {
    return ident::rows_where(ident::Expression(spec.where, names), signals);
  } catch (const dsp::Fault& fault) {
    throw dsp::Fault(fault.kind(), fault.name(), fmt::format("{}: where: {}", spec.place, fault.what()));
  }
}

/// First sample that is tested: train_to, or the first after the training share of the rows.
Index split_sample(const Range& range, const dsp::Motion& signals, const std::vector<Index>& kept) {
  const dsp::RangeSpec& spec = range.spec;
  if (spec.train_to_s) return static_cast<Index>(std::ceil(*spec.train_to_s * signals.sample_rate_hz - 1e-9));
  const auto num_train = static_cast<std::size_t>(std::llround(range.train_share * static_cast<double>(kept.size())));
  return num_train < kept.size() ? kept[num_train] : signals.num_samples();
}

void add_stretches(const std::vector<Index>& samples, Index from, Index to, double rate_hz,
                   std::vector<dsp::Interval>& into) {
  Index previous = -2;
  for (const Index i : samples) {
    if (i < from || i >= to) continue;
    if (i != previous + 1) into.push_back({static_cast<double>(i) / rate_hz, 0.0, {}});
    into.back().to_s = static_cast<double>(i + 1) / rate_hz;
    previous = i;
  }
}

bool covers(int recording, std::size_t index) {
  return recording == 0 || static_cast<std::size_t>(recording) == index + 1;
}

MatrixXd gather(const std::vector<Row>& rows, const std::vector<Columns>& recordings, const std::vector<Index>& terms) {
  MatrixXd phi(static_cast<Index>(rows.size()), static_cast<Index>(terms.size()));
  for (Index j = 0; j < phi.cols(); ++j)
    for (Index i = 0; i < phi.rows(); ++i) {
      const Row& row = rows[static_cast<std::size_t>(i)];
      phi(i, j) = recordings[row.recording].phi(row.sample, terms[static_cast<std::size_t>(j)]);
    }
  return phi;
}

VectorXd gather_target(const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  VectorXd target(static_cast<Index>(rows.size()));
  for (Index i = 0; i < target.size(); ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    target(i) = recordings[row.recording].target(row.sample);
  }
  return target;
}

/// The place in time of each row, the records one behind the other.
std::vector<Index> places_of(const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  std::vector<Index> begin(recordings.size(), 0), places;
  for (std::size_t r = 1; r < recordings.size(); ++r)
    begin[r] = begin[r - 1] + recordings[r - 1].signals->num_samples();
  places.reserve(rows.size());
  for (const Row& row : rows) places.push_back(begin[row.recording] + row.sample);
  return places;
}

/// The terms that can be told apart on these rows; the others are named with the reason.
std::vector<Index> distinct_terms(const ident::CandidateLibrary& library, const MatrixXd& phi,
                                  const std::vector<DroppedTerm>& known, std::vector<DroppedTerm>& dropped) {
  constexpr double rounding = 1e-13;  // of unit vectors that are sums over up to 1e6 rows
  std::vector<Index> kept;
  MatrixXd unit(phi.rows(), phi.cols());
  Index constant = -1;
  for (Index j = 0; j < phi.cols(); ++j) {
    const std::string& name = library.terms[static_cast<std::size_t>(j)].name;
    const auto drop = [&](std::string reason) { dropped.push_back({name, std::move(reason)}); };
    if (std::any_of(known.begin(), known.end(), [&](const DroppedTerm& term) { return term.name == name; })) continue;
    const double largest = phi.col(j).cwiseAbs().maxCoeff();
    if (!(largest > 0.0)) {
      drop("zero on all training rows");
      continue;
    }
    unit.col(j) = phi.col(j).stableNormalized();
    const bool is_constant = (phi.col(j).array() - phi(0, j)).abs().maxCoeff() <= rounding * largest;
    const auto twin = std::find_if(kept.begin(), kept.end(), [&](Index i) {
      return (unit.col(j) - unit.col(i)).norm() <= rounding || (unit.col(j) + unit.col(i)).norm() <= rounding;
    });
    if (is_constant && constant >= 0) {
      drop(fmt::format("constant on the training rows, as {} is",
                       library.terms[static_cast<std::size_t>(constant)].name));
    } else if (twin != kept.end()) {
      drop(fmt::format("proportional to {} on the training rows", library.terms[static_cast<std::size_t>(*twin)].name));
    } else {
      if (is_constant) constant = j;
      kept.push_back(j);
    }
  }
  return kept;
}

ident::Fit fit_by(ident::Method method, const ident::RFactor& data, const IdentifyOptions& options) {
  switch (method) {
    case ident::Method::fast_rvm:
      return ident::fit_fast_rvm(data, {.selection = options.selection, .tau = options.tau});
    case ident::Method::slow_rvm:
      return ident::fit_slow_rvm(data, {.selection = options.selection, .tau = options.tau});
    case ident::Method::stlsq:
      return ident::fit_stlsq(data, {.threshold = options.threshold, .unit_norm = options.unit_norm_threshold});
    case ident::Method::lasso:
      return ident::fit_lasso(data, {.lambda = options.lasso_lambda});
    case ident::Method::ridge:
      return ident::fit_ridge(data, {.lambda = options.ridge_lambda});
    case ident::Method::multi_rvm:
      return ident::fit_multi_rvm(data, {.selection = options.selection, .tau = options.tau}).rows.front();
    case ident::Method::ols:
      break;
  }
  return ident::fit_ols(data);
}

/// Greatest magnitude on these rows of each signal the library uses.
std::vector<std::pair<std::string, double>> largest_signals(const ident::CandidateLibrary& library,
                                                            const std::vector<Row>& rows,
                                                            const std::vector<Columns>& recordings) {
  std::vector<std::pair<std::string, double>> largest;
  for (const ident::Term& term : library.terms)
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
void name_dependent(ident::Fit& fit, const ident::CandidateLibrary& library) {
  const auto name = [&](Index term) { return library.terms[static_cast<std::size_t>(term)].name; };
  for (const ident::Dependent& dependent : fit.dependent) {
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
std::vector<ident::Course> courses_of(const RangeRows& rows, const std::vector<Columns>& recordings,
                                      const std::vector<std::vector<Index>>& usable) {
  std::vector<ident::Course> courses;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const dsp::Motion& signals = *recordings[r].signals;
    ident::Course course{&signals, {}, std::vector<unsigned char>(static_cast<std::size_t>(signals.num_samples()), 0)};
    Index first_test = signals.num_samples();
    for (const Row& row : rows.test)
      if (row.recording == r) {
        course.scored[static_cast<std::size_t>(row.sample)] = 1;
        first_test = std::min(first_test, row.sample);
      }
    Index previous = -2;
    for (const Index i : usable[r]) {
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

struct SplitSamples {
  RangeRows rows;
  std::vector<std::vector<Index>> usable;  ///< per recording
};

SplitSamples split_range(const Range& range, const std::vector<Columns>& recordings) {
  const dsp::RangeSpec& spec = range.spec;
  SplitSamples result;
  result.usable.resize(recordings.size());
  double longest_s = 0.0;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (!covers(range.recording, r)) continue;
    const dsp::Motion& signals = *recordings[r].signals;
    longest_s = std::max(longest_s, static_cast<double>(signals.num_samples()) / signals.sample_rate_hz);
    const Samples samples = samples_of(range, recordings[r], condition_rows(spec, signals));
    const Index split = split_sample(range, signals, samples.kept);
    for (const Index i : samples.kept) (i < split ? result.rows.train : result.rows.test).push_back({r, i});
    add_stretches(samples.usable, 0, split, signals.sample_rate_hz, result.rows.train_s);
    add_stretches(samples.usable, split, signals.num_samples(), signals.sample_rate_hz, result.rows.test_s);
    result.usable[r] = samples.usable;
  }
  if (spec.from_s >= longest_s || (std::isfinite(spec.to_s) && spec.to_s > longest_s * (1.0 + 1e-9) + 1e-9))
    throw range_fault(spec, "range.outside",
                      fmt::format("got {:g} to {:g} s, want it inside the recording, 0 to {:.9g} s", spec.from_s,
                                  spec.to_s, longest_s));
  if (result.rows.train.empty())
    throw range_fault(spec, "range.empty",
                      "no training row is left. Widen it, lower what `where` asks, or move train_to");
  return result;
}

}  // namespace

RangeRows range_rows(const Range& range, const std::vector<Columns>& recordings) {
  return split_range(range, recordings).rows;
}

RangeResult identify(const Range& range, const std::vector<Columns>& recordings, const ident::CandidateLibrary& library,
                     const IdentifyOptions& options) {
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  RangeResult result;
  const dsp::RangeSpec& spec = range.spec;
  const int recording = range.recording;
  result.spec = spec;
  result.recording = recording;
  result.regime = range.regime;
  for (const ident::Term& term : library.terms) result.terms.push_back(term.name);
  SplitSamples split = split_range(range, recordings);
  result.rows = std::move(split.rows);
  fill_in(result.spec, result.rows, recording, recordings);
  const Index num_train = static_cast<Index>(result.rows.train.size()),
              num_test = static_cast<Index>(result.rows.test.size());
  const Index num_terms = static_cast<Index>(library.terms.size());
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (!covers(recording, r)) continue;
    result.dropped.insert(result.dropped.end(), recordings[r].dropped.begin(), recordings[r].dropped.end());
    for (const std::string& channel : recordings[r].signals->uncalibrated)
      result.uncalibrated.push_back(recordings[r].name + ": " + channel);
  }

  const auto start = Clock::now();
  std::vector<Index> all(static_cast<std::size_t>(num_terms));
  for (Index j = 0; j < num_terms; ++j) all[static_cast<std::size_t>(j)] = j;
  MatrixXd phi = gather(result.rows.train, recordings, all);
  const std::vector<Index> terms = distinct_terms(library, phi, std::vector(result.dropped), result.dropped);
  if (terms.empty())
    throw dsp::Fault(dsp::FaultKind::numerics, "library.nothing_left",
                     fmt::format("range '{}': every candidate term was dropped; the first, {}, is {}.", spec.name,
                                 result.dropped.front().name, result.dropped.front().reason));
  VectorXd scale = VectorXd::Constant(num_terms, nan);
  for (const Index j : terms) scale(j) = phi.col(j).cwiseAbs().maxCoeff();
  const VectorXd train = gather_target(result.rows.train, recordings),
                 test = gather_target(result.rows.test, recordings);
  const ident::RFactor data = ident::r_factor(phi(Eigen::all, terms), train, options.num_threads);
  result.accumulate_s = seconds_since(start);
  result.target.resize(num_train + num_test);
  result.target << train, test;
  const std::vector<Index> places = places_of(result.rows.train, recordings);
  const std::vector<ident::Course> courses =
      options.free_run ? courses_of(result.rows, recordings, split.usable) : std::vector<ident::Course>();
  const auto largest = largest_signals(library, result.rows.train, recordings);
  std::vector<const ident::Term*> fitted_terms;
  for (const Index j : terms) fitted_terms.push_back(&library.terms[static_cast<std::size_t>(j)]);
  const Columns& first = recordings[recording == 0 ? 0 : static_cast<std::size_t>(recording) - 1];

  for (const ident::Method method : options.methods) {
    check_interrupted();
    JudgedFit judged;
    const auto solve_start = Clock::now();
    judged.fit = fit_by(method, data, options);
    judged.solve_s = seconds_since(solve_start);
    for (std::string& remark : ident::collinearity_remarks(data, judged.fit, fitted_terms, largest))
      judged.fit.remarks.push_back(std::move(remark));
    ident::renumber(judged.fit, terms, num_terms);
    name_dependent(judged.fit, library);
    const bool has_noise = std::isfinite(judged.fit.noise_variance);
    const MatrixXd kept_train = phi(Eigen::all, judged.fit.relevant),
                   kept_test = gather(result.rows.test, recordings, judged.fit.relevant);
    const VectorXd fitted = kept_train * judged.fit.mean, forecast = kept_test * judged.fit.mean;
    judged.model = ident::make_model(library, judged.fit, options.target, options.target_unit, scale,
                                     has_noise ? ident::robust_covariance(kept_train, train - fitted) : MatrixXd());
    judged.whiteness = ident::residual_whiteness(train - fitted, places, first.signals->sample_rate_hz, first.band_hz);
    const char* no_test = num_test == 0 ? "no test rows" : nullptr;
    judged.train = figure(ident::nmse(fitted, train), "the target is zero on all training rows");
    judged.train_centred = figure(ident::nmse_centred(fitted, train), "the target is constant on the training rows");
    judged.test = figure(num_test == 0 ? nan : ident::nmse(forecast, test),
                         no_test ? no_test : "the target is zero on all test rows");
    judged.test_centred = figure(num_test == 0 ? nan : ident::nmse_centred(forecast, test),
                                 no_test ? no_test : "the target is constant on the test rows");
    judged.predicted.resize(num_train + num_test);
    judged.predicted << fitted, forecast;
    judged.predicted_std.resize(num_train + num_test);
    const VectorXd test_variance =
        ident::predictive_variance(kept_test, judged.fit.covariance, judged.fit.noise_variance);
    judged.predicted_std
        << ident::predictive_variance(kept_train, judged.fit.covariance, judged.fit.noise_variance).cwiseSqrt(),
        test_variance.cwiseSqrt();
    judged.bands = ident::band_shares(forecast, test_variance, test);
    judged.bands_reason = no_test ? no_test : has_noise ? "" : "no row is left to tell the noise";
    judged.free_run.nmse = nan;
    judged.free_run.applies = options.free_run;
    const auto twin = std::find_if(result.fits.begin(), result.fits.end(), [&](const JudgedFit& earlier) {
      return ident::same_equation(earlier.model, judged.model);
    });
    if (!options.free_run)
      judged.free_run.reason = "the rows of a table are no time response";
    else if (num_test == 0)
      judged.free_run.reason = no_test;
    else
      judged.free_run = twin != result.fits.end()
                            ? twin->free_run
                            : ident::free_run(judged.model, courses, {.before_stretch = check_interrupted});
    if (options.target != "a" && options.target != "ddy") judged.free_run.applies = false;  // no equation of motion
    result.fits.push_back(std::move(judged));
  }
  return result;
}

}  // namespace apps
