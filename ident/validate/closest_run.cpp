#include "ident/validate/closest_run.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "dsp/linear.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// 99 % of the chi-square distribution of k degrees of freedom, by Wilson and Hilferty.
double chi_square_99(Index k) {
  const double v = 2.0 / (9.0 * static_cast<double>(k));
  return static_cast<double>(k) * std::pow(1.0 - v + 2.326 * std::sqrt(v), 3);
}

/// W with W W' = covariance: of the correlations, since coefficients differ by many powers of ten.
MatrixXd root_of(const MatrixXd& covariance) {
  const VectorXd std = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const VectorXd inverse = std.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const dsp::Axes axes = dsp::eigen_symmetric(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  return std.asDiagonal() * axes.vectors * axes.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// A run through both, with its errors at the scored samples.
struct Run {
  ClosestRun runs;
  VectorXd errors;
  double relative = 0.0;  ///< the larger NMSE of the two
};

class Search {
 public:
  Search(const Model& model, const std::vector<Course>& test, const std::vector<Course>& training,
         const FreeRunOptions& options)
      : model_(model), test_(test), training_(training), options_(options), root_(root_of(model.covariance)) {
    options_.keep_series = true;
  }

  /// Nothing where it diverges or there is no figure. z: of the coefficients, in standard deviations.
  [[nodiscard]] std::optional<Run> at(const VectorXd& z) const {
    Model model = model_;
    const VectorXd change = root_ * z;
    for (Index i = 0; i < change.size(); ++i) model.terms[static_cast<std::size_t>(i)].mean += change(i);
    Run result{{free_run(model, test_, options_), {}}, {}, 0.0};
    if (!training_.empty()) result.runs.training = free_run(model, training_, options_);
    std::vector<double> errors;
    for (const auto& [run, courses] :
         {std::pair(&result.runs.test, &test_), std::pair(&result.runs.training, &training_)}) {
      if (courses->empty()) continue;
      if (!run->reason.empty() || !std::isfinite(run->nmse_centred)) return std::nullopt;
      result.relative = std::max(result.relative, run->nmse_centred);
      append_errors(*run, *courses, errors);
      run->series.clear();
    }
    result.errors = Eigen::Map<const VectorXd>(errors.data(), std::ssize(errors));
    return result;
  }

  /// d(errors)/dz, by differences of a tenth of a standard deviation to whichever side there is a run.
  [[nodiscard]] MatrixXd slopes_at(const VectorXd& z, const Run& here) const {
    MatrixXd slopes = MatrixXd::Zero(here.errors.size(), z.size());
    for (Index j = 0; j < z.size(); ++j)
      for (const double step : {0.1, -0.1}) {
        VectorXd beside = z;
        beside(j) += step;
        const std::optional<Run> run = at(beside);
        if (!run) continue;
        slopes.col(j) = (run->errors - here.errors) / step;
        break;
      }
    return slopes;
  }

 private:
  /// Over what x is about its mean, so that their squares sum to about the NMSE, of long rows and of short ones.
  static void append_errors(const FreeRun& run, const std::vector<Course>& courses, std::vector<double>& errors) {
    double count = 0.0;
    for (const Course& course : courses)
      count += static_cast<double>(std::count(course.scored.begin(), course.scored.end(), 1));
    const double scale = 1.0 / std::sqrt(run.mean_square * count);
    for (std::size_t c = 0; c < courses.size(); ++c)
      for (Index i = 0; i < run.series[c].predicted.size(); ++i) {
        const double error = run.series[c].predicted(i) - run.series[c].measured(i);
        if (courses[c].scored[static_cast<std::size_t>(i)] != 0)
          errors.push_back(std::isfinite(error) ? scale * error : 0.0);
      }
  }

  const Model& model_;
  const std::vector<Course>&test_, &training_;
  FreeRunOptions options_;
  MatrixXd root_;
};

/// The z within the radius at which errors that change by these slopes are least.
VectorXd least_within(double radius, const VectorXd& z, const VectorXd& errors, const MatrixXd& slopes) {
  const MatrixXd normal = slopes.transpose() * slopes;
  const VectorXd right = normal * z - slopes.transpose() * errors;
  const auto at = [&](double damping) -> VectorXd {
    return dsp::solve_symmetric(normal + damping * MatrixXd::Identity(z.size(), z.size()), right);
  };
  const double scale = normal.diagonal().maxCoeff();
  if (!(scale > 0.0)) return z;
  double low = 1e-12 * scale, high = low;
  if (at(low).norm() <= radius) return at(low);
  while (at(high).norm() > radius) high *= 10.0;
  for (int i = 0; i < 40; ++i) (at(std::sqrt(low * high)).norm() > radius ? low : high) = std::sqrt(low * high);
  return at(high);
}

/// From z on to a local minimum, or as far as `enough`; z: where that is.
Run descended(const Search& search, Run here, VectorXd& z, double enough) {
  constexpr int most_rounds = 10;
  constexpr double progress = 0.02;  // less is no news
  const double radius = std::sqrt(chi_square_99(z.size()));
  for (int round = 0; round < most_rounds && here.relative > enough; ++round) {
    const VectorXd towards = least_within(radius, z, here.errors, search.slopes_at(z, here)) - z;
    const double before = here.errors.squaredNorm();
    for (const double part : {1.0, 0.5, 0.25, 0.1}) {
      std::optional<Run> next = search.at(z + part * towards);
      if (!next || next->errors.squaredNorm() >= before) continue;
      z += part * towards;
      here = std::move(*next);
      break;
    }
    if (here.errors.squaredNorm() > (1.0 - progress) * before) break;
  }
  return here;
}

}  // namespace

ClosestRun closest_run(const Model& model, const std::vector<Course>& test, const std::vector<Course>& training,
                       double enough, const FreeRunOptions& options) {
  const Index k = std::ssize(model.terms);
  const bool known = k > 0 && model.covariance.rows() == k && model.covariance.allFinite();
  const auto itself = [&] { return ClosestRun{free_run(model, test, options), free_run(model, training, options)}; };
  if (!known) return itself();
  const Search search(model, test, training, options);
  VectorXd z = VectorXd::Zero(k);
  std::optional<Run> here = search.at(z);
  if (!here) return itself();
  // Over many periods a phase that runs away hides which way is better; over one it does not.
  if (std::isfinite(options.periods_alone) && here->runs.test.alone) {
    FreeRunOptions short_options = options;
    short_options.periods_alone = 1.0;
    const Search over_one(model, test, training, short_options);
    VectorXd start = z;
    if (std::optional<Run> short_run = over_one.at(start)) {
      descended(over_one, std::move(*short_run), start, 0.0);
      std::optional<Run> from_there = search.at(start);
      if (from_there && from_there->errors.squaredNorm() < here->errors.squaredNorm()) {
        z = start;
        here = std::move(from_there);
      }
    }
  }
  return descended(search, std::move(*here), z, enough).runs;
}

}  // namespace ident
