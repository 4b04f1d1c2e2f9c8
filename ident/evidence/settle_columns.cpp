#include "ident/evidence/settle_columns.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "dsp/values/for_each_index.hpp"
#include "dsp/values/memory_limit.hpp"
#include "ident/evidence/likelihood.hpp"
#include "ident/ranges/rows_of_terms.hpp"
#include "ident/records/terms_by_record.hpp"
#include "ident/regression/methods.hpp"
#include "ident/switches/anderson_mixing.hpp"
#include "ident/switches/exact_switches.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A fit with the terms it keeps, by their numbers in the library.
struct Present {
  Fit fit;
  std::vector<Index> terms;
  WeightedTerms equation;
};

Present present_fit(const RangeData& range, const CandidateLibrary& library, const IdentifyOptions& options) {
  Present present{fit(range.data, with_poll(options.methods.front(), options.poll)), {}, {}};
  for (std::size_t i = 0; i < present.fit.relevant.size(); ++i) {
    const Index term = range.terms[static_cast<std::size_t>(present.fit.relevant[i])];
    present.terms.push_back(term);
    present.equation.emplace_back(library.terms[static_cast<std::size_t>(term)].expression,
                                  present.fit.mean(static_cast<Index>(i)));
  }
  return present;
}

/// What the noise beside candidates and sensors counts for: that of as many white rows as the residual is worth. More
/// weight would let sensors explain, against what is known of them, what the equation does not.
double effective_noise(const RangeData& range, const Present& present, const RangeResult& result,
                       const std::vector<Columns>& recordings) {
  const std::vector<Index> positions = positions_in(range, present.terms);
  if (positions.size() < present.terms.size()) return range.noise_std;  // of other terms: says nothing of these
  VectorXd residual = range.train;
  RowsOfTerms(result.rows.train, recordings, present.terms).for_each_block([&](Index first, const MatrixXd& phi) {
    residual.segment(first, phi.rows()) -= phi * present.fit.mean;
  });
  double fraction = 1.0;
  return sensors_beside(present.fit, positions, range, result.rows.train, nullptr, residual, fraction).noise_std /
         std::sqrt(fraction);
}

/// The regression of the range's terms with its sensors.
void form_joint(RangeData& range, const RangeResult& result, const std::vector<Columns>& recordings,
                const IdentifyOptions& options) {
  const auto n_s = std::ssize(range.sensors->parameters());
  const std::vector<Row>& rows = result.rows.train;
  const RowsOfTerms columns(rows, recordings, range.terms);
  Eigen::RowVectorXd largest(n_s + columns.num_terms() + 1);
  largest << range.sensors->largest(rows), range.scale(range.terms).transpose(), range.train.cwiseAbs().maxCoeff();
  range.joint.joint = r_factor(
      columns.size(), n_s + columns.num_terms(), largest,
      [&](Index first, Eigen::Ref<MatrixXd> block) {
        if (options.poll) options.poll();
        range.sensors->read(rows, first, block.leftCols(n_s));
        columns.read(first, block.middleCols(n_s, columns.num_terms()));
        block.rightCols(1) = range.train.segment(first, block.rows());
      },
      options.num_threads);
  range.means = mean_rows(rows, recordings, range.terms, *range.sensors);
  add_rows(range.joint, range.means.rows);
  range.noise_std = noise_beside_all(range.joint);
}

/// Lets the sensors take part, whose columns are formed.
void add_sensors(RangeData& range, RangeSensors sensors, const Present& present, const RangeResult& result,
                 const std::vector<Columns>& recordings, const IdentifyOptions& options) {
  if (sensors.parameters().empty()) return;
  const auto n_s = static_cast<Index>(sensors.parameters().size());
  range.joint.prior_std.resize(n_s);
  for (Index i = 0; i < n_s; ++i) {
    const SensorParameter& parameter = sensors.parameters()[static_cast<std::size_t>(i)];
    range.joint.prior_std(i) = parameter.std;
    range.joint.sources.push_back(parameter.source);
  }
  range.sensors.emplace(std::move(sensors));
  form_joint(range, result, recordings, options);
  range.data = without_sensors(range.joint, effective_noise(range, present, result, recordings));
}

/// The terms of a fit that jump, as they make an acceleration jump; none where the equation holds no acceleration.
struct SwitchedFit {
  WeightedTerms terms;
  std::vector<double> stds;
  std::vector<Index> of_library;
};

SwitchedFit switched_fit(const Present& present, const CandidateLibrary& library, const IdentifyOptions& options) {
  const auto is_acceleration = [](const std::string& name) { return name == "a" || name == "ddy"; };
  const auto mean = [&](std::size_t i) { return present.equation[i].second; };
  double of_acceleration = is_acceleration(options.target) ? 1.0 : 0.0;
  if (of_acceleration == 0.0)  // 0 = -target + m a + other terms
    for (std::size_t i = 0; i < present.terms.size(); ++i)
      if (is_acceleration(library.terms[static_cast<std::size_t>(present.terms[i])].name)) of_acceleration = -mean(i);
  SwitchedFit result;
  for (std::size_t i = 0; of_acceleration != 0.0 && i < present.terms.size(); ++i) {
    const auto index = static_cast<Index>(i);
    if (present.equation[i].first.all_switches().empty()) continue;
    result.terms.emplace_back(present.equation[i].first, mean(i) / of_acceleration);
    result.stds.push_back(std::sqrt(present.fit.covariance(index, index)) / std::abs(of_acceleration));
    result.of_library.push_back(present.terms[i]);
  }
  return result;
}

/// The equations under which switches are placed, from pass to pass.
class SwitchPlacement {
 public:
  /// `scale`: largest magnitude of each column of the library; of one that cannot be formed, anything.
  explicit SwitchPlacement(const VectorXd& scale)
      : last_(VectorXd::Zero(scale.size())),
        mixing_(scale.unaryExpr([](double one) { return std::isfinite(one) ? one : 0.0; })) {}
  /// The one to try behind this fit under the last, of the terms that it has.
  [[nodiscard]] WeightedTerms next(const SwitchedFit& found) {
    VectorXd coefficients = VectorXd::Zero(last_.size());
    for (std::size_t i = 0; i < found.terms.size(); ++i) coefficients(found.of_library[i]) = found.terms[i].second;
    // The first equation is a guess, made without switches: what it leads to says nothing of later steps.
    const VectorXd mixed = is_first_ ? coefficients : mixing_.next(last_, coefficients);
    is_first_ = false;
    last_.setZero();
    WeightedTerms equation = found.terms;
    for (std::size_t i = 0; i < equation.size(); ++i)
      last_(found.of_library[i]) = equation[i].second = mixed(found.of_library[i]);
    return equation;
  }

 private:
  VectorXd last_;
  AndersonMixing mixing_;
  bool is_first_ = true;
};

/// The same range with a term for each recording in place of each whose coefficients differ between them.
RangeData data_by_record(RangeData pooled, RangeResult& result, std::vector<Columns>& recordings,
                         const IdentifyOptions& options) {
  const EvidenceData& found = pooled.evidence;
  const auto of_library = [&](Index position) { return pooled.terms[static_cast<std::size_t>(position)]; };
  std::vector<Index> differing, model;
  std::vector<std::size_t> present;
  for (const Index position : found.differing) differing.push_back(of_library(position));
  for (const RecordRows& record : found.weighting.records) present.push_back(record.recording);
  CandidateLibrary library = terms_by_record(std::move(pooled.library), differing, present, recordings);
  for (const Index position : *found.terms)
    if (!std::binary_search(differing.begin(), differing.end(), of_library(position)))
      model.push_back(of_library(position));
  for (Index j = 0; j < std::ssize(library.terms); ++j)
    if (library.terms[static_cast<std::size_t>(j)].recording > 0) model.push_back(j);

  RangeData data = range_data(result, recordings, library, options);
  data.independence = std::move(pooled.independence);
  if (pooled.sensors) {
    data.sensors = std::move(pooled.sensors);
    data.joint.prior_std = pooled.joint.prior_std;
    data.joint.sources = pooled.joint.sources;
    form_joint(data, result, recordings, options);
    data.data = without_sensors(data.joint, data.noise_std / std::sqrt(found.size.fraction()));
  }
  data.library = std::move(library);
  data.factors = std::move(pooled.factors);
  data.evidence = evidence_by_record(found, positions_in(data, model), data, result, recordings, options);
  data.evidence.path = found.path;
  return data;
}

/// What forming the sensors' columns takes: signals as they change, of the longest recording.
double sensor_bytes(const std::vector<Columns>& recordings) {
  double largest = 0.0;
  for (const Columns& columns : recordings) {
    if (columns.prepared == nullptr) continue;
    const dsp::Motion& motion = columns.prepared->intermediate;
    largest = std::max(largest, static_cast<double>(motion.signals.size()) * static_cast<double>(motion.num_samples()));
  }
  return sizeof(double) * largest;
}

bool has_settled(const WeightedTerms& before, const SwitchedFit& now) {
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

/// Whether the sensors' columns formed with one equation do for another, of terms as large as `scale` says. A sensor is
/// off by about a hundredth at most, so that a thousandth of its columns is 1e-5 of a signal: what the times of
/// switches are exact to.
bool forms_like(const WeightedTerms& before, const Present& now, const VectorXd& scale) {
  constexpr double of_largest = 1e-3;
  if (before.size() != now.equation.size()) return false;
  double largest = 0.0, change = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i].first.text() != now.equation[i].first.text()) return false;
    const double size = scale(now.terms[i]), mean = now.equation[i].second;
    largest = std::max(largest, std::abs(mean) * size);
    change = std::max(change, std::abs(mean - before[i].second) * size);
  }
  return change <= of_largest * largest;
}

/// The second stage on these data, which are by record where neither it nor the rows have one equation for all.
RangeData with_likelihood(RangeData data, const std::vector<DroppedTerm>& dropped, const Range& range,
                          RangeResult& result, std::vector<Columns>& recordings, const IdentifyOptions& options) {
  const bool is_of_motion =
      options.target == "a" ||
      (options.target == "ddy" && recordings[result.rows.train.front().recording].signals->find("ddr") == nullptr);
  if (options.stage == Stage::likelihood && is_of_motion)
    result.likelihood = likelihood_of(range, result.rows, data, recordings, options);
  else
    result.likelihood.silent_because =
        is_of_motion ? "fit.stage is \"regression\"" : options.target + " is not the second derivative of x";
  // Noise on a derivative makes coefficients seem to differ. Where one equation explains all samples, they do not.
  const bool is_common = result.likelihood.speaks() && !result.likelihood.has_unexplained();
  if (data.evidence.differing.empty() || is_common) return data;
  result.likelihood = {.silent_because = "coefficients differ between the recordings"};
  result.dropped = dropped;
  return data_by_record(std::move(data), result, recordings, options);
}

}  // namespace

RangeData iterate_columns(const Range& range, RangeResult& result, std::vector<Columns>& recordings,
                          const CandidateLibrary& library, const IdentifyOptions& options) {
  columns_of_library(recordings);
  const std::vector<dsp::Stretch> stretches = stretches_of(result.rows, recordings);
  for (std::size_t r = 0; r < recordings.size(); ++r)
    if (recordings[r].switches != nullptr) recordings[r].switches->limit_to(stretches[r]);
  constexpr int most_passes = 8;  // friction of one level takes three; beyond, terms near the threshold come and go
  const std::vector<DroppedTerm> dropped = result.dropped;
  std::shared_ptr<const IndependentRows> independence;  // of rows that stay from pass to pass
  const auto data_under = [&](const WeightedTerms& equation) {
    for (std::size_t r = 0; r < recordings.size(); ++r)
      if (result.recording == 0 || static_cast<std::size_t>(result.recording) == r + 1)
        place_switches(recordings[r], library, equation, options.poll);
    result.dropped = dropped;
    RangeData formed = range_data(result, recordings, library, options);
    if (!independence) independence = std::make_shared<IndependentRows>(formed.train_samples, formed.first_rows);
    formed.independence = independence;
    return formed;
  };
  RangeData data = data_under({});
  const RangeSensors sensors(range, stretches, recordings);
  const bool matched = std::any_of(recordings.begin(), recordings.end(),
                                   [](const Columns& columns) { return columns.switches != nullptr; });
  // Coefficients without the sensors are a few per cent off, and so are the columns formed with them: not twice.
  const int least_passes = sensors.parameters().empty() ? 0 : 2;
  const int num_threads = dsp::threads_within_memory(sensor_bytes(recordings), options.num_threads);
  WeightedTerms equation, formed_with;
  SwitchPlacement placement(data.scale);
  for (int pass = 0; matched && !options.methods.empty() && pass < most_passes; ++pass) {
    const Present present = present_fit(data, library, options);
    const SwitchedFit now = switched_fit(present, library, options);
    if (has_settled(equation, now) && pass >= least_passes) break;
    equation = placement.next(now);
    const bool formed_already = data.sensors && forms_like(formed_with, present, data.scale);
    RangeSensors formed = sensors;
    if (formed_already) formed = std::move(*data.sensors);
    data = {};  // before there is another
    dsp::for_each_index(2, num_threads, [&](std::size_t i) {
      if (i == 0)
        data = data_under(equation);
      else if (!formed_already && !formed.parameters().empty())
        formed.form(present.equation, options.target, options.poll);
    });
    if (!formed_already) formed_with = present.equation;
    add_sensors(data, std::move(formed), present, result, recordings, options);
  }
  for (Columns& columns : recordings)
    if (columns.switches != nullptr) columns.switches->release();
  data.library = library;
  data.factors = {data.terms, data.scale(data.terms), data.data, {}, {}, {}};
  if (std::none_of(options.methods.begin(), options.methods.end(), weighs_rows)) return data;
  data.evidence = evidence_data(data, result, recordings, library, options);
  data.factors.evidence = data.evidence.data;
  data.factors.size = data.evidence.size;
  return with_likelihood(std::move(data), dropped, range, result, recordings, options);
}

}  // namespace ident
