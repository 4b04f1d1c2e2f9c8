#pragma once
#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "dsp/prepare.hpp"
#include "dsp/prepare/power_check.hpp"
#include "dsp/segment_regimes.hpp"
#include "ident/columns/block_means.hpp"
#include "ident/library/library.hpp"
#include "ident/sensors/sensor_parameters.hpp"

namespace ident {

class ChannelNoise;
class ExactSwitches;

/// A candidate that could not be used, and why, with the first offending row and value.
struct DroppedTerm {
  std::string name, reason;
};

/// Where a term of a library is in phi.
struct TermColumn {
  Eigen::Index column = 0;
  int recording = 0;  ///< 1-based: zero on the rows of others; 0: of all
};

/// Columns of terms outside the library, computed on first use, by one thread.
class ColumnCache {
 public:
  const Eigen::VectorXd& of(const std::string& term, const std::function<Eigen::VectorXd()>& form) & {
    const std::lock_guard lock(mutex_);
    const auto known = columns_.find(term);
    return known != columns_.end() ? known->second : columns_.emplace(term, form()).first->second;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, Eigen::VectorXd> columns_;
};

/// The candidate columns and the target of one recording at the regression rate, all samples of it: ranges pick rows.
/// The matrix of a regression is kept here alone: 8 N b bytes, and 8 N for each sign that is tried beside it.
struct Columns {
  std::string name;                      ///< of the recording
  const dsp::Motion* signals;            ///< at the regression rate; not owned
  double band_hz = 0.0;                  ///< the columns' pass band ends here
  Eigen::MatrixXd phi;                   ///< N x b; a column that could not be formed holds NaN
  Eigen::VectorXd target;                ///< N
  std::vector<dsp::Regime> regimes;      ///< per sample; empty: not looked for
  std::optional<dsp::PowerCheck> power;  ///< of its sensors; none: there was nothing to check
  std::vector<DroppedTerm> dropped;
  const dsp::Prepared* prepared = nullptr;                ///< what they were formed from; not owned; none: a table
  std::vector<SensorParameter> sensors = {};              ///< of the recording, which take part in every fit
  std::shared_ptr<const dsp::Motion> accelerations = {};  ///< of sensor_columns; none: a table
  std::shared_ptr<ExactSwitches> switches = {};           ///< of recipe "matched"; else none
  std::shared_ptr<const ChannelNoise> noise = {};         ///< of its channels; none: a table
  std::vector<TermColumn> term_columns = {};              ///< of the library; empty: one behind the other
  std::shared_ptr<ColumnCache> beside = std::make_shared<ColumnCache>();  ///< of column_beside; copies share it
  double zero = 0.0;                                                      ///< of its x, as of Record
  BlockMeans means = {};  ///< of the terms, then the target, ahead of the column filter; none where it keeps them
};

/// 0 where it is not finite.
[[nodiscard]] Eigen::VectorXd finite(Eigen::VectorXd values);

/// What phi takes for this many terms.
[[nodiscard]] double column_bytes(const dsp::Motion& signals, std::size_t num_terms);

/// "matched": each term is formed with exact switches (exact_switches.hpp) and passes the target's filter; "paper":
/// terms are evaluated on the filtered signals, sgn(g) at the point. Sample i of the result is sample i of
/// prepared.signals; `prepared` must outlive it. `poll` is called before each column, by any of the threads, and may
/// throw to stop. Throws std::invalid_argument for a target that is no signal.
[[nodiscard]] Columns form_columns(const CandidateLibrary& library, const std::string& target,
                                   const dsp::Prepared& prepared, const std::function<void()>& poll = {},
                                   int num_threads = 1);

/// The column that form_columns would make of one more term of these signals, without what else it makes: switches as
/// they are before an equation settles them. Each is formed once. Throws as make_library for a term of other signals.
[[nodiscard]] Eigen::VectorXd column_beside(const Columns& columns, const std::string& term, const std::string& target);

/// Forms the columns again that depend on where an equation's switches are; none: as form_columns left them. Columns of
/// no recipe "matched" stay as they are. `library` is the one they were formed of.
void place_switches(Columns& columns, const CandidateLibrary& library, const WeightedTerms& equation,
                    const std::function<void()>& poll = {});

/// Columns whose switches can be placed without moving those of the others.
[[nodiscard]] Columns with_own_switches(Columns columns);

/// A plain table: terms are evaluated row by row, sgn(g) at the point. The table must outlive the result.
[[nodiscard]] Columns form_columns(const CandidateLibrary& library, const std::string& target, const dsp::Motion& table,
                                   const std::string& name, const std::function<void()>& poll = {});

}  // namespace ident
