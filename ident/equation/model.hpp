#pragma once
#include <Eigen/Core>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "ident/library/library.hpp"
#include "ident/regression/fit.hpp"
#include "ident/sensors/sensor_fit.hpp"

namespace ident {

struct ModelTerm {
  std::string name, unit;              ///< the candidate term; the unit of its coefficient (SI, may be empty)
  Eigen::Index column = 0;             ///< its index in the library
  double mean = 0.0;                   ///< posterior on the kept terms (Eq. 12 of [QZS23])
  double std = 0.0;                    ///< total: of noise of any colour, terms too weak to be kept, and sensors
  double std_noise = 0.0;              ///< of white noise alone, on the kept terms with the sensors known (Eq. 13)
  double scale = 0.0;                  ///< largest magnitude of the column over the training rows
  double evidence_gain = 0.0;          ///< 2 dL; NaN for methods without an evidence
  double inclusion_probability = 0.0;  ///< 1 / (1 + exp((tau - gain) / 2)); NaN likewise
  /// Sources of the variance and by what fraction it would fall were they known ("noise": what would be left were all
  /// sensors known); empty where no sensor takes part.
  std::vector<std::pair<std::string, double>> budget = {};
  /// Calibrations of the model that the coefficient changes with: by this power of 1 + e where their scale is 1 + e
  /// times what is written.
  std::vector<std::pair<std::string, double>> gain_exponents = {};
  int recording = 0;                                      ///< 1-based: in the equation of this one alone; 0: of all
  std::string recording_name = {};                        ///< empty: of all
  [[nodiscard]] double coefficient_of_variation() const;  ///< std / |mean|
  [[nodiscard]] double t() const;                         ///< mean / std
};

/// "sgn(v)", "sgn(v) in run2".
[[nodiscard]] std::string label(const ModelTerm& term);

/// A candidate that was not kept.
struct RejectedTerm {
  std::string name;
  double inclusion_probability = 0.0;  ///< as of ModelTerm
};

/// Where the equation's x and f are in a recording that it was fitted to.
struct Coordinates {
  std::string recording;                  ///< its name
  std::string of, unit;                   ///< the displacement, "y - r" or "the displacement"; its unit
  double zero = 0.0, zero_std = 0.0;      ///< x is the displacement as recorded less this, in its unit
  double prepared_zero = 0.0;             ///< what the x of the prepared signals is less than it
  double lead_s = 0.0, lead_std_s = 0.0;  ///< f is what was recorded so much later
};

/// The least and the greatest value of a signal of the equation over the training rows.
struct Extent {
  std::string signal;
  double lowest = 0.0, highest = 0.0;
};

/// The identified equation: target = sum of mean_i term_i, in SI units, in the coordinates it states.
struct Model {
  std::string target, target_unit;
  std::vector<ModelTerm> terms;
  double noise_std = 0.0;              ///< of the target
  Eigen::MatrixXd covariance;          ///< of the coefficients, in the order of terms: total, its diagonal is std^2
  std::vector<RejectedTerm> rejected;  ///< in the order of the library; empty for methods without an evidence
  std::vector<Coordinates> coordinates = {};  ///< of each recording that was fitted; empty: of a table
  std::vector<Extent> extents = {};           ///< of x and v where they were recorded, in these coordinates
  /// What all coefficients share and no covariance holds: gains that nothing in the record can tell, each with its
  /// relative standard deviation (absolute_gains.hpp). None that no coefficient changes with.
  std::vector<std::pair<std::string, double>> calibration = {};
};

/// `column_scale` (b): largest magnitude of each library column over the training rows. `robust`: covariance from
/// robust_covariance, or empty; a coefficient's standard deviation is that where it is the larger one.
[[nodiscard]] Model make_model(const CandidateLibrary& library, const Fit& fit, const std::string& target,
                               const std::string& target_unit, const Eigen::VectorXd& column_scale,
                               const Eigen::MatrixXd& robust);

/// A candidate that has a coefficient for each recording.
struct OwnCoefficients {
  std::string name, symbol;             ///< "sgn(v)"; "c1", which stands for them in the equation
  std::vector<const ModelTerm*> terms;  ///< of the model, one for each recording
  /// Too many recordings to name each: more than six.
  [[nodiscard]] bool are_many() const { return terms.size() > 6; }
  [[nodiscard]] std::pair<const ModelTerm*, const ModelTerm*> extremes() const;  ///< the least, the greatest
};
[[nodiscard]] std::vector<OwnCoefficients> own_coefficients(const Model& model);

/// The coefficients, in the order of its terms.
[[nodiscard]] Eigen::VectorXd means_of(const Model& model);

/// Whether some terms have a coefficient for each recording.
[[nodiscard]] bool differs_by_recording(const Model& model);
/// The equation of one recording (1-based) of those that were fitted together: the terms of all and its own, in the
/// order of the library; a term that was not kept for it is none of its equation. 0, for another recording than those
/// fitted: with the mean of their coefficients; variance: theirs about it and that of the mean.
[[nodiscard]] Model equation_of(const Model& model, int recording);

/// Gives the coefficients the standard deviations of noise and sensors together, with their budget, instead of the
/// noise's alone.
void set_sensor_posterior(Model& model, const SensorPosterior& posterior);

/// Six significant digits at most, no trailing zeros: "-57.3912", "8.87e+04".
[[nodiscard]] std::string number(double value);
/// One line: "a = -50.2 x - 0.791 v - 0.0797 sgn(v)"; "a = 0" for no terms; with coefficients for each recording
/// "a = -50.2 x + c1 sgn(v), c1 = -0.08 in run1, -0.16 in run2"; of many "c1 = -0.2 to -0.1 in 30 recordings".
[[nodiscard]] std::string to_text(const Model& model);
/// The same as LaTeX, each coefficient with its coefficient of variation underneath, as the paper prints it.
[[nodiscard]] std::string to_latex(const Model& model);

/// The same terms, coefficients apart by next to nothing (a hundredth) of their standard deviations. An equation
/// without terms is like no other.
[[nodiscard]] bool same_equation(const Model& a, const Model& b);

/// What two equations of one library do not agree on: one sentence a term.
struct Disagreement {
  std::string term, sentence;
};
/// A term in one and not in the other, of opposite sign, or further apart than `limit` combined standard deviations.
/// Coefficients of the same term must be comparable: same library, same units.
[[nodiscard]] std::vector<Disagreement> disagreements(const Model& a, const std::string& name_a, const Model& b,
                                                      const std::string& name_b, double limit = 5.0);

}  // namespace ident
