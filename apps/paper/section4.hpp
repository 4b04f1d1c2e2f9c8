#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/sensors/motion.hpp"
#include "ident/library/library.hpp"
#include "ident/regression/fit.hpp"
#include "ident/regression/r_factor.hpp"
#include "sim/simulate.hpp"
#include "sim/systems.hpp"

// The regressions of Section 4 of [QZS23]. Every record runs 25 s from rest, 2501 samples at 100 Hz; those of the
// training ratios follow one another. Noise is white, on the targets only, a fraction of each target's standard
// deviation over the whole training set: what the printed coefficients of variation agree with.

namespace apps {

/// A case of Section 4: a system, the ratios omega / omega_n of its records, and the candidate terms, as cases.toml has
/// them.
struct Section4Case {
  std::string name;    ///< "duffing" ... "valanis-4"; "bouc-wen-2": two states, the hysteretic force not measured
  std::string system;  ///< of sim::make_experiment
  int table = 0, figure = 0;
  std::vector<double> training_ratios, held_out_ratios;
  std::vector<std::string> variables;  ///< an equation for each; all products of them up to `order` are candidates
  int order = 2;
  std::vector<std::string> further_terms;
  std::vector<std::string> last_row_where;      ///< conditions under which the last row is fitted apart; empty: as one
  int row_without_truth = 0;                    ///< 0: none
  std::vector<std::string> figure_x, figure_y;  ///< signals of each panel
  double otherwise_without = 0.0;               ///< another origin of the print: without this ratio (0: with all) ...
  std::vector<std::string> otherwise_beside;    ///< ... or fitted with these terms as well
  std::string otherwise;                        ///< that origin in words; empty: none is known
  std::string inner;  ///< of a state that was not measured: its kind, "hysteresis"; empty: none
  [[nodiscard]] int num_rows() const { return static_cast<int>(variables.size()); }
};
/// The noise that Section 4 states, a fraction of each target's standard deviation.
[[nodiscard]] double stated_noise();
[[nodiscard]] const std::vector<Section4Case>& section4_cases();
/// nullptr if there is none of that name.
[[nodiscard]] const Section4Case* find_section4_case(std::string_view name);

/// One record of a system: the motion has signals t, x, v, (z), f, dx, a, (dz); all exact.
struct Section4Record {
  double ratio = 0.0;
  sim::Simulation simulation;
  dsp::Motion motion;
};
[[nodiscard]] Section4Record section4_record(const Section4Case& definition, double ratio);

/// One equation wanted: a target and what is true of it.
struct Section4Row {
  int row = 1;                              ///< of the state equation, from 1
  std::string target;                       ///< "dx", "a", "dz"
  std::string where;                        ///< condition on the rows; empty: all
  Eigen::VectorXd values;                   ///< m, noise-free
  double std = 0.0;                         ///< of the target over the whole training set
  bool truth_known = false;                 ///< false: an equivalent model is sought
  Eigen::VectorXd truth;                    ///< b coefficients, zero for terms that are not there
  [[nodiscard]] std::string label() const;  ///< "2", "3 (v >= 0)"
};

/// Rows that share their samples and with them their columns: one R factor for all their targets.
struct Section4Regression {
  Eigen::MatrixXd phi;                ///< m x b, noise-free
  std::vector<Eigen::Index> samples;  ///< m, of the whole training set
  std::vector<Section4Row> rows;
};

struct Section4Study {
  const Section4Case* definition = nullptr;
  ident::CandidateLibrary library;
  dsp::Motion training;  ///< all training records end to end
  std::vector<Section4Regression> regressions;
};
/// Throws dsp::Fault (numerics) if a record cannot be simulated.
[[nodiscard]] Section4Study section4_study(const Section4Case& definition);

/// Samples where a condition on the motion's signals holds.
[[nodiscard]] std::vector<Eigen::Index> samples_where(const std::string& condition, const dsp::Motion& motion);
/// These columns of the library on a record.
[[nodiscard]] Eigen::MatrixXd columns_on(const Section4Study& study, const std::vector<Eigen::Index>& terms,
                                         const dsp::Motion& motion);
/// With white noise: of these samples, so that a value's draw does not depend on which others are taken.
[[nodiscard]] Eigen::VectorXd noisy(const Eigen::VectorXd& values, const std::vector<Eigen::Index>& samples,
                                    double noise_std, std::uint64_t seed, std::uint64_t sequence);

/// The R factor of the columns and all targets of `regression`, noise (a fraction of each target's standard deviation)
/// added to the targets. The draw depends on seed, case and row only: noise levels of one seed are scaled copies.
[[nodiscard]] ident::RFactor section4_factor(const Section4Study& study, const Section4Regression& regression,
                                             double noise, std::uint64_t seed);
/// The same data for one of its rows, in the order of regression.rows.
[[nodiscard]] ident::RFactor row_factor(const ident::RFactor& data, std::size_t row);

/// Terms of a fit that are not true, and true ones it lacks.
struct SupportError {
  std::vector<Eigen::Index> false_terms, missing_terms;
  [[nodiscard]] bool exact() const { return false_terms.empty() && missing_terms.empty(); }
};
[[nodiscard]] SupportError support_error(const ident::Fit& fit, const Eigen::VectorXd& truth);

/// Root L of the covariance L L^T of least-squares coefficients of these terms for noise of standard deviation 1; their
/// standard deviations are the norms of its rows.
[[nodiscard]] Eigen::MatrixXd unit_root(const Section4Regression& regression, const std::vector<Eigen::Index>& terms);
/// Index of a term in the library, its size where it is not there; and the names of several.
[[nodiscard]] Eigen::Index column_of(const Section4Study& study, std::string_view term);
[[nodiscard]] std::vector<std::string> names_of(const Section4Study& study, const std::vector<Eigen::Index>& terms);

/// A true term that a draw of the noise can hide.
struct WeakTerm {
  std::string row, term;
  double t = 0.0;                    ///< true coefficient over the standard deviation of its estimate
  double kept_fraction = 0.0;        ///< of draws in which its gain exceeds tau
  double best_exact_fraction = 0.0;  ///< of draws in which the row can be exact, at the best threshold there is
};
/// Those with t below 5, for uncorrelated false terms: the estimate is N(t, 1), a false term's gain that of chi^2_1.
[[nodiscard]] std::vector<WeakTerm> weak_terms(const Section4Study& study, double noise, double tau);

}  // namespace apps
