#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dsp/prepare.hpp"
#include "dsp/segment_regimes.hpp"
#include "dsp/sensors/power_check.hpp"
#include "ident/library.hpp"

namespace ident {

/// A candidate that could not be used, and why, with the first offending row and value.
struct DroppedTerm {
  std::string name, reason;
};

/// The candidate columns and the target of one recording at the regression rate, all samples of it: ranges pick rows.
/// The one place where the matrix of a regression is kept: 8 N b bytes.
struct Columns {
  std::string name;                      ///< of the recording
  const dsp::Motion* signals;            ///< at the regression rate; not owned
  double band_hz = 0.0;                  ///< the columns' pass band ends here
  Eigen::MatrixXd phi;                   ///< N x b; a column that could not be formed holds NaN
  Eigen::VectorXd target;                ///< N
  std::vector<dsp::Regime> regimes;      ///< per sample; empty: not looked for
  std::optional<dsp::PowerCheck> power;  ///< of its sensors; none: there was nothing to check
  std::vector<DroppedTerm> dropped;
};

/// What phi takes for this many terms.
[[nodiscard]] double column_bytes(const dsp::Motion& signals, std::size_t num_terms);

/// "matched": each term is evaluated at the intermediate rate and passes the target's filter; "paper": terms are
/// evaluated on the filtered signals. Sample i of the result is sample i of prepared.signals, which must outlive it.
/// `poll` is called before each column and may throw to stop. Throws std::invalid_argument for a target that is no
/// signal.
[[nodiscard]] Columns form_columns(const CandidateLibrary& library, const std::string& target,
                                   const dsp::Prepared& prepared, const std::function<void()>& poll = {});

/// A plain table: terms are evaluated row by row, sgn(g) at the point. The table must outlive the result.
[[nodiscard]] Columns form_columns(const CandidateLibrary& library, const std::string& target, const dsp::Motion& table,
                                   const std::string& name, const std::function<void()>& poll = {});

}  // namespace ident
