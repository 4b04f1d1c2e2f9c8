#include "ident/validate/unexplained.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "dsp/values/constants.hpp"
#include "dsp/values/linear.hpp"
#include "dsp/values/signals.hpp"
#include "ident/ranges/rows_of_terms.hpp"
#include "ident/regression/collinearity.hpp"
#include "ident/selection/best_subsets.hpp"
#include "ident/selection/ranked_models.hpp"
#include "ident/validate/independent_rows.hpp"
#include "ident/validate/modulation.hpp"
#include "ident/validate/motion_score.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double by_chance = 1e-3;  // that any of all that is tried explains as much of noise

/// What may explain a residual, formed from the signals of a recording.
struct Probe {
  Explanation as;  ///< what it is, without a fraction
  std::vector<std::string> signals;
  Index num_series = 1;
  std::function<MatrixXd(const Columns&)> series;  ///< a column each
};

/// A sign as a library would have it, switched where v passes zero and behind the target's filter: noise of v that
/// turns it around between two samples, and what the filter rounds, would hide it.
Probe probe_of(const std::string& term, Cause cause, bool is_recorded, const std::string& target) {
  const Expression expression(term);
  const std::vector<Switch> switches = expression.all_switches();
  const bool jumps =
      std::any_of(switches.begin(), switches.end(), [](const Switch& one) { return one.kind == SwitchKind::sign; });
  Explanation as;
  as.what = expression.text();
  as.cause = cause;
  as.is_recorded = is_recorded;
  return {as, expression.signals(), 1, [=](const Columns& of) -> MatrixXd {
            return jumps ? column_beside(of, term, target) : expression.evaluate(*of.signals);
          }};
}

/// Forces of springs in series with sliders (Jenkins elements), over their stiffness: each follows x up to a part of
/// its amplitude to either side of where it slid to last. Their sum is hysteresis of any shape (Iwan, J. Appl. Mech.
/// 33, 1966); octaves of that part are as many as a record tells apart.
constexpr std::array slips{1.0 / 16, 1.0 / 8, 1.0 / 4, 1.0 / 2};
MatrixXd sliding_springs(const VectorXd& x, double amplitude) {
  MatrixXd forces(x.size(), std::ssize(slips));
  for (Index j = 0; j < forces.cols(); ++j) {
    const double slip = slips[static_cast<std::size_t>(j)] * amplitude;
    double now = 0.0;
    for (Index i = 0; i < x.size(); ++i) {
      if (i > 0) now = std::clamp(now + x(i) - x(i - 1), -slip, slip);
      forces(i, j) = now;
    }
  }
  return forces;
}

/// Half of what x spans on these rows.
double amplitude_of_x(const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (Index first = 0, end = 0; first < std::ssize(rows); first = end) {
    end = end_of_stretch(rows, first, std::ssize(rows));
    const Row& row = rows[static_cast<std::size_t>(first)];
    const dsp::Signal* x = recordings[row.recording].signals->find("x");
    if (x == nullptr) continue;
    lowest = std::min(lowest, x->values.segment(row.sample, end - first).minCoeff());
    highest = std::max(highest, x->values.segment(row.sample, end - first).maxCoeff());
  }
  return 0.5 * (highest - lowest);
}

/// Not abs: abs(v)*v is no friction.
bool has_sign(const std::vector<std::string>& terms, const std::string& argument) {
  return std::any_of(terms.begin(), terms.end(), [&](const std::string& text) {
    const std::vector<Switch> own = Expression(text).all_switches();
    return std::any_of(own.begin(), own.end(), [&](const Switch& one) {
      return one.kind == SwitchKind::sign && one.argument.text() == argument;
    });
  });
}

std::vector<Probe> recorded_probes(const Model& model, const std::vector<std::string>& terms,
                                   const dsp::Motion& motion) {
  std::vector<Probe> result;
  for (const dsp::SignalInfo& info : dsp::signal_table()) {
    const std::string name(info.name);
    if (!info.in_default_library || name == model.target || motion.find(name) == nullptr) continue;
    const bool used = std::any_of(model.terms.begin(), model.terms.end(), [&](const ModelTerm& term) {
      const Expression expression(term.name);
      const auto& own = expression.signals();
      return std::find(own.begin(), own.end(), name) != own.end();
    });
    // A hysteretic force is a state of the system's own.
    if (!used)
      result.push_back(
          probe_of(name, info.role == dsp::Role::z ? Cause::missing_term : Cause::missing_input, true, model.target));
  }
  for (const auto& [one, other] : {std::pair("v", "dy"), std::pair("dy", "v")})
    if (motion.find(one) != nullptr && motion.find("r") != nullptr && !has_sign(terms, one) && has_sign(terms, other))
      result.push_back(probe_of(fmt::format("sgn({})", one), Cause::switch_variable, true, model.target));
  return result;
}

std::vector<Probe> form_probes(const std::string& target, const std::vector<std::string>& terms,
                               const dsp::Motion& motion, const std::vector<Row>& rows,
                               const std::vector<Columns>& recordings) {
  std::vector<Probe> result;
  if (motion.find("x") == nullptr || motion.find("v") == nullptr) return result;
  if (!has_sign(terms, "v") && !has_sign(terms, "dy"))
    result.push_back(probe_of("sgn(v)", Cause::missing_term, false, target));
  for (const char* text : {"x", "v", "x^2", "x*v", "v^2", "x^3", "x^2*v", "x*v^2", "v^3", "abs(v)*v"})
    if (std::find(terms.begin(), terms.end(), text) == terms.end())
      result.push_back(probe_of(text, Cause::missing_term, false, target));
  if (motion.find("z") != nullptr) return result;
  Explanation as;
  as.what = "hysteresis of x (springs in series with sliders)";
  as.cause = Cause::missing_term;
  as.is_recorded = as.is_term = false;
  result.push_back({as, {"x"}, std::ssize(slips), [amplitude = amplitude_of_x(rows, recordings)](const Columns& of) {
                      return sliding_springs(of.signals->at("x"), amplitude);
                    }});
  return result;
}

/// Empty where a recording lacks one of its signals.
MatrixXd on_rows(const Probe& probe, const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  MatrixXd result(std::ssize(rows), probe.num_series);
  MatrixXd values;
  for (Index i = 0, end = 0; i < result.rows(); i = end) {
    end = end_of_stretch(rows, i, result.rows());
    const Row& row = rows[static_cast<std::size_t>(i)];
    if (i == 0 || row.recording != rows[static_cast<std::size_t>(i - 1)].recording) {
      const dsp::Motion& motion = *recordings[row.recording].signals;
      for (const std::string& name : probe.signals)
        if (motion.find(name) == nullptr) return {};
      values = probe.series(recordings[row.recording]);
    }
    result.middleRows(i, end - i) = values.middleRows(row.sample, end - i);
  }
  return result;
}

/// A stiffness that follows a clock.
Probe swing_probe(double rad_s) {
  Explanation as;
  as.parts = {fmt::format("x*cos({:.7g}*t)", rad_s), fmt::format("x*sin({:.7g}*t)", rad_s)};
  as.what = fmt::format("{} with {}", as.parts[0], as.parts[1]);
  as.cause = Cause::missing_term;
  as.is_recorded = false;
  return {as, {"x", "t"}, std::ssize(as.parts), [rad_s](const Columns& of) {
            const Eigen::ArrayXd x = of.signals->at("x").array(), angle = rad_s * of.signals->at("t").array();
            MatrixXd series(x.size(), 2);
            series << x * angle.cos(), x * angle.sin();
            return series;
          }};
}

/// What the kept columns have of series: products with an orthonormal basis of them.
MatrixXd part_in_kept(const Eigen::Ref<const MatrixXd>& values, const Model& model, const RFactor& kept,
                      const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  const Index k = std::ssize(model.terms);
  std::vector<Index> columns;
  for (const ModelTerm& term : model.terms) columns.push_back(term.column);
  MatrixXd products = MatrixXd::Zero(k, values.cols());
  RowsOfTerms(rows, recordings, columns).for_each_block([&](Index first, const MatrixXd& phi) {
    products += phi.transpose() * values.middleRows(first, phi.rows());
  });
  return dsp::solve_transposed(kept.R.topLeftCorner(k, k), products);
}

/// A residual beside the kept columns.
struct Residual {
  const Model& model;
  const std::vector<std::string>& terms;
  const RFactor& kept;
  const std::vector<Row>& rows;
  const std::vector<Columns>& recordings;
  Eigen::Ref<const VectorXd> values;
  const IndependentRows& independence;
  const Poll& poll;
  VectorXd in_kept = part_in_kept(values, model, kept, rows, recordings);
  VectorXd autocorrelation = independence.autocorrelation(values);

  [[nodiscard]] std::optional<Explanation> best_of(const std::vector<Probe>& probes) const {
    std::optional<Explanation> best;
    double most = 0.0;
    for (const Probe& probe : probes) {
      if (poll) poll();
      const auto [fraction, adjusted, chance] = explained_by(probe);
      if (!(chance * static_cast<double>(probes.size()) < by_chance) || (best && most >= adjusted)) continue;
      best = probe.as;
      most = adjusted;
      best->fraction = std::min(1.0, fraction);
      best->candidate = std::find(terms.begin(), terms.end(), best->what) != terms.end();
    }
    return best;
  }

  /// The further term with which the best-scoring subset of it and the kept terms scores best.
  [[nodiscard]] std::optional<Explanation> better(const std::vector<Probe>& forms) const {
    std::optional<Explanation> best;
    double least = std::numeric_limits<double>::infinity();
    for (const Probe& form : forms) {
      const std::optional<Equation> found = best_with(form);
      if (!found || found->rss < exact || found->score >= least) continue;
      least = found->score;
      best = form.as;
      best->fraction = found->fraction;
      best->instead_of = found->without;
    }
    return best;
  }

  /// What has the highest score at the frequencies of the motion, beyond chance, and whether that is in doubt.
  [[nodiscard]] std::pair<std::optional<Explanation>, bool> at_motion(const std::vector<Probe>& probes,
                                                                      const std::vector<LeftOut>& left_out) const {
    const MotionScore score(model, rows, recordings, values);
    if (!score.can_tell()) return {};
    // Chi-square of one degree of freedom exceeds it once in a hundred. Doubt is no claim: of the ten to twenty that
    // are tried, which share most of what they are, some one exceeds it in one right equation of thirty.
    constexpr double doubtful = 6.635;
    // What is named is beyond chance: a normal deviate exceeds z, either way, with a probability below exp(-z^2 / 2).
    double most = 2.0 * std::log(static_cast<double>(probes.size() + left_out.size()) / by_chance);
    std::optional<Explanation> best;
    bool may_lack = false;
    const auto try_as = [&](const Explanation& as, const Eigen::Ref<const VectorXd>& series) {
      if (poll) poll();
      const MotionScore::Score found = score.of(series);
      may_lack = may_lack || found.gain > doubtful;
      if (!(found.gain > most)) return;
      most = found.gain;
      best = as;
      best->fraction = found.fraction;
      best->at_motion = true;
      best->candidate =
          std::any_of(left_out.begin(), left_out.end(), [&](const LeftOut& term) { return term.name == as.what; });
    };
    for (const Probe& probe : probes)
      if (const MatrixXd series = on_rows(probe, rows, recordings); series.cols() == 1 && series.allFinite())
        try_as(probe.as, series.col(0));
    VectorXd column(std::ssize(rows));
    for (const LeftOut& term : left_out) {
      RowsOfTerms(rows, recordings, {term.column}).read(0, column);
      try_as({.what = term.name, .cause = Cause::missing_term, .is_recorded = false}, column);
    }
    return {best, may_lack};
  }

  /// The kept equation is better with this sign in place of all terms with that of the other motion. Where it has none
  /// the sign is a further term, which costs more.
  [[nodiscard]] bool takes_place_of_other(const Probe& sign) const {
    const std::optional<RFactor> data = beside(sign);
    if (!data) return false;
    const std::string other = sign.signals.front() == "v" ? "dy" : "v";
    const Index k = std::ssize(model.terms);
    std::vector<Index> instead;
    for (Index i = 0; i < k; ++i)
      if (!has_sign({model.terms[static_cast<std::size_t>(i)].name}, other)) instead.push_back(i);
    instead.push_back(k);
    const auto n = static_cast<double>(data->num_samples);
    const double gain = n * std::log(rss_of(*data, all_columns(k)) / rss_of(*data, instead));
    return gain > undecided_evidence + (std::ssize(instead) > k ? std::log(n) : 0.0);
  }

  /// The stiffness that follows a clock, whose frequency is the one at which it explains most beside the kept terms.
  [[nodiscard]] std::vector<Probe> swing() const {
    const std::optional<double> about = modulation_rad_s(values, rows, recordings);
    if (!about) return {};
    constexpr int thirds = 25;  // to 1e-5 of a spectral line
    const dsp::Motion& motion = *recordings[rows.front().recording].signals;
    const double line =
        dsp::two_pi * motion.sample_rate_hz / static_cast<double>(rows.back().sample - rows.front().sample + 1);
    double low = *about - 0.5 * line, high = *about + 0.5 * line;
    for (int k = 0; k < thirds; ++k) {
      if (poll) poll();
      const double a = (2.0 * low + high) / 3.0, b = (low + 2.0 * high) / 3.0;
      if (part_of(swing_probe(a)).second < part_of(swing_probe(b)).second)
        low = a;
      else
        high = b;
    }
    return {swing_probe(0.5 * (low + high))};
  }

 private:
  struct Equation {
    std::vector<std::string> without;               ///< kept terms
    double score = 0.0, fraction = 0.0, rss = 0.0;  ///< rss: of the target's power
  };
  static constexpr Index widest = 12;     ///< of the kept terms: every subset of them is scored
  static constexpr double exact = 1e-10;  ///< of the target's power: what is less is the rounding of exact data
  /// The best-scoring subset of the kept terms and a form; nothing where it is without the form, or not by much.
  [[nodiscard]] std::optional<Equation> best_with(const Probe& form) const {
    const Index k = std::ssize(model.terms);
    if (k > widest || form.num_series > 1) return std::nullopt;
    if (poll) poll();
    const std::optional<RFactor> data = beside(form);
    if (!data) return std::nullopt;
    const ModelRanking ranking = ranked_models(unit_problem(*data, poll), all_columns(k));
    const RankedModel& found = ranking.best.front();
    const bool has_form = !found.terms.empty() && found.terms.back() == k;
    const double decided = 1.0 / (1.0 + std::exp(-0.5 * undecided_evidence));
    if (!has_form || ranking.inclusion(k) < decided) return std::nullopt;
    const auto n = static_cast<double>(data->num_samples);
    Equation best{.score = n * std::log(found.rss) + model_cost(n, k + 1, found.terms.size()), .rss = found.rss};
    std::vector<Index> others;
    for (Index i = 0; i < k; ++i) {
      const bool is_in = std::binary_search(found.terms.begin(), found.terms.end(), i);
      if (is_in)
        others.push_back(i);
      else
        best.without.push_back(model.terms[static_cast<std::size_t>(i)].name);
    }
    best.fraction = 1.0 - found.rss / rss_of(*data, others);
    return best;
  }

  /// R of [kept terms, form, target], the target being what the model and the residual make of it, with as many samples
  /// as the rows are worth beside what all of these leave. Nothing where the form is made up of kept terms.
  [[nodiscard]] std::optional<RFactor> beside(const Probe& form) const {
    const Index k = std::ssize(model.terms);
    const MatrixXd probe = on_rows(form, rows, recordings);
    if (probe.size() == 0 || !probe.allFinite()) return std::nullopt;
    const VectorXd probe_in_kept = part_in_kept(probe, model, kept, rows, recordings);
    const double power = probe.squaredNorm() - probe_in_kept.squaredNorm();
    if (!(power > rounding * probe.squaredNorm())) return std::nullopt;
    const double product = (probe.col(0).dot(values) - probe_in_kept.dot(in_kept)) / std::sqrt(power);
    const VectorXd left = values - product / std::sqrt(power) * beyond_kept(probe, probe_in_kept);
    const double num_effective = static_cast<double>(values.size()) * independence.fraction(left);
    RFactor data{MatrixXd::Zero(k + 2, k + 2), k + 1, static_cast<Index>(std::lround(num_effective))};
    if (data.num_samples < k + 4) return std::nullopt;
    data.R.topLeftCorner(k, k) = kept.R.topLeftCorner(k, k);
    data.R.col(k).head(k) = probe_in_kept;
    data.R(k, k) = std::sqrt(power);
    data.R.col(k + 1).head(k) = data.R.topLeftCorner(k, k) * means_of(model) + in_kept;
    data.R(k, k + 1) = product;
    data.R(k + 1, k + 1) = std::sqrt(std::max(0.0, values.squaredNorm() - in_kept.squaredNorm() - product * product));
    return data;
  }

  /// What the kept columns do not make up of a series.
  [[nodiscard]] VectorXd beyond_kept(const VectorXd& series, const VectorXd& in_kept_basis) const {
    const Index k = std::ssize(model.terms);
    const VectorXd coefficients = dsp::solve_upper(kept.R.topLeftCorner(k, k), in_kept_basis);
    std::vector<Index> columns;
    for (const ModelTerm& term : model.terms) columns.push_back(term.column);
    VectorXd rest = series;
    RowsOfTerms(rows, recordings, columns).for_each_block([&](Index first, const MatrixXd& phi) {
      rest.segment(first, phi.rows()) -= phi * coefficients;
    });
    return rest;
  }

  /// What least squares on these terms leaves of a target of unit norm.
  static double rss_of(const RFactor& data, const std::vector<Index>& terms) {
    const UnitProblem problem = unit_problem(data);
    return posterior(problem, terms, VectorXd::Constant(std::ssize(terms), flat_lambda)).residual(0, 0);
  }

  static constexpr double rounding = 1e-10;  // of a probe that the kept columns make up
  struct Explained {
    double fraction = 0.0, adjusted = 0.0;  ///< for the number of series
    double chance = 1.0;
  };
  /// What series of the form explain, and the fraction of the residual's power.
  [[nodiscard]] std::pair<VectorXd, double> part_of(const Probe& of) const {
    MatrixXd probe = on_rows(of, rows, recordings);
    if (probe.size() == 0 || !probe.allFinite()) return {};
    probe.rowwise() -= probe.colwise().mean();
    const VectorXd scale = probe.colwise().norm().cwiseMax(std::numeric_limits<double>::min());
    probe.array().rowwise() /= scale.transpose().array();
    const MatrixXd probe_in_kept = part_in_kept(probe, model, kept, rows, recordings);
    const MatrixXd power = probe.transpose() * probe - probe_in_kept.transpose() * probe_in_kept;
    const VectorXd product = probe.transpose() * values - probe_in_kept.transpose() * in_kept;
    if (!(power.diagonal().minCoeff() > rounding)) return {};
    const VectorXd coefficients = dsp::solve_symmetric(power, product);
    return {probe * coefficients, std::clamp(product.dot(coefficients) / values.squaredNorm(), 0.0, 1.0)};
  }

  [[nodiscard]] Explained explained_by(const Probe& of) const {
    const auto [part, fraction] = part_of(of);
    if (part.size() == 0) return {};
    const double independent = static_cast<double>(values.size()) * independence.fraction_beside(autocorrelation, part);
    const double spare = std::max(1.0, independent - 1.0 - static_cast<double>(of.num_series));
    return {fraction, 1.0 - (1.0 - fraction) * std::max(1.0, independent - 1.0) / spare,
            chance_of(fraction, of.num_series, independent)};
  }

  /// That `num_series` explain as much of noise, or more: R^2 has the distribution beta(k / 2, (n - 1 - k) / 2), whose
  /// tail this is for an even number; that of one is below (1 - R^2)^((n - 2) / 2).
  static double chance_of(double fraction, Index num_series, double independent) {
    const double half = 0.5 * std::max(0.0, independent - 1.0 - static_cast<double>(num_series));
    double term = std::pow(1.0 - fraction, half), sum = term;
    for (Index j = 1; 2 * j < num_series; ++j) {
      term *= fraction * (half + static_cast<double>(j) - 1.0) / static_cast<double>(j);
      sum += term;
    }
    return std::min(1.0, sum);
  }
};

}  // namespace

Explanations explanations(const Model& model, const std::vector<std::string>& terms,
                          const std::vector<LeftOut>& left_out, const RFactor& kept, const std::vector<Row>& rows,
                          const std::vector<Columns>& recordings, const Eigen::Ref<const VectorXd>& residual,
                          const IndependentRows& independence, const Poll& poll) {
  const dsp::Motion& motion = *recordings[rows.front().recording].signals;
  std::vector<Probe> recorded = recorded_probes(model, terms, motion);
  const Residual left{model, terms, kept, rows, recordings, residual, independence, poll};
  std::vector<Probe> forms = form_probes(model.target, terms, motion, rows, recordings);
  for (const Probe& swing : left.swing()) forms.push_back(swing);
  std::erase_if(recorded, [&](const Probe& probe) {
    return probe.as.cause == Cause::switch_variable && !left.takes_place_of_other(probe);
  });
  std::vector<Probe> all = recorded;
  all.insert(all.end(), forms.begin(), forms.end());
  const auto [at_motion, may_lack] = left.at_motion(all, left_out);
  return {left.best_of(recorded), left.best_of(forms), left.better(forms), at_motion, may_lack};
}

std::optional<Explanation> swing_of(const Model& model, const std::vector<std::string>& terms, const RFactor& kept,
                                    const std::vector<Row>& rows, const std::vector<Columns>& recordings,
                                    const Eigen::Ref<const VectorXd>& residual, const IndependentRows& independence,
                                    const Poll& poll) {
  const Residual left{model, terms, kept, rows, recordings, residual, independence, poll};
  return left.best_of(left.swing());
}

}  // namespace ident
