#pragma once
#include <string>
#include <vector>

#include "apps/output/output_folder.hpp"
#include "apps/paper/replicate_case.hpp"
#include "apps/process/console.hpp"
#include "ident/identify.hpp"

// Section 5 of [QZS23] on the rig's twins: the record is simulated at 25.6 kHz, written, read back and identified as a
// measured one would be.

namespace apps {

/// A regime of the record: "low", "high" or "mixed", and the table of its equation.
struct RigRegime {
  std::string name;
  int table = 0;
  [[nodiscard]] std::string case_name() const { return "qzs-" + name; }
};
[[nodiscard]] const std::vector<RigRegime>& rig_regimes();

/// A twin and a way of preparing its record; the first is the paper's recipe on T1.
struct RigWay {
  std::string name, twin, what;  ///< "T1 paper"; what: for a reader
  std::vector<std::string> set;  ///< of rig.toml, as --set
};
[[nodiscard]] const std::vector<RigWay>& rig_ways();

/// The fit of a regime's equation by the paper's recipe on T1, its candidates, the fast RVM and the first seed.
struct RigFit {
  ident::RangeResult result;
  Eigen::VectorXd time_s, x, v;  ///< of its rows
};

struct RigReplication {
  Json fits = Json::array(), free_run = Json::array(), sensors = Json::array();  ///< of replicate.json
  std::vector<RigFit> shown;
  std::string relations;  ///< of T1's sensors, first seed, in words
};

/// Simulates each twin for every seed into a folder inside `folder`, which is removed again (553 MB while it lasts),
/// and fits the regimes from the paper's candidates ("paper") and from cubic terms, sgn(v) and ddr ("all"). Throws
/// dsp::Fault, output where the folder cannot take it.
[[nodiscard]] RigReplication replicate_rig(const std::vector<RigRegime>& regimes, const ReplicateOptions& options,
                                           const OutputFolder& folder, Console& console);

/// A coefficient of the acceleration of a twin; 0 where there is no such term.
[[nodiscard]] double rig_truth(const std::string& twin, const std::string& term);

}  // namespace apps
