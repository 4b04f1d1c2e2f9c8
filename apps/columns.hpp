#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "dsp/prepare.hpp"
#include "dsp/segment_regimes.hpp"
#include "ident/candidate_library.hpp"

namespace apps {

/// A candidate that could not be used, and why, with the first offending row and value.
struct DroppedTerm {
  std::string name, reason;
};

/// The candidate columns and the target of one recording at the regression rate, all samples of it: ranges pick rows.
struct Columns {
  std::string name;                  ///< of the recording
  const dsp::Motion* signals;        ///< at the regression rate; not owned
  double band_hz = 0.0;              ///< the columns' pass band ends here
  Eigen::MatrixXd phi;               ///< num_samples x b; a column that could not be formed holds NaN
  Eigen::VectorXd target;            ///< num_samples
  std::vector<dsp::Regime> regimes;  ///< per sample; empty: not looked for
  std::vector<DroppedTerm> dropped;
};

/// "matched": each term is evaluated on the bus and passes the target's filter; "paper": terms are evaluated on the
/// filtered signals. Sample i of the result is sample i of prepared.signals.
[[nodiscard]] Columns form_columns(const ident::CandidateLibrary& library, const std::string& target,
                                   const dsp::Prepared& prepared);

/// A plain table: terms are evaluated row by row, sgn(g) at the point.
[[nodiscard]] Columns form_columns(const ident::CandidateLibrary& library, const std::string& target,
                                   const dsp::Motion& table, const std::string& name);

}  // namespace apps
