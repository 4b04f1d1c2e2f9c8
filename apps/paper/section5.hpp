#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "apps/process/console.hpp"
#include "apps/process/output_folder.hpp"
#include "dsp/sensors/power_check.hpp"
#include "dsp/sensors/sensor_consistency.hpp"
#include "ident/identify.hpp"

// Section 5 of [QZS23] on the rig's twins: the record is simulated at 25.6 kHz, written, read back and identified as a
// measured one would be.

namespace apps {

/// A regime of the record, as the paper cuts and trains it.
struct Section5Case {
  std::string name, regime;  ///< "qzs-low", "low"
  int table = 0;             ///< of its equation
  double from_s = 0.0, to_s = 0.0, train_to_s = 0.0;
  int order = 0;  ///< the paper's candidates: polynomials in x and v up to this degree, and `terms`
  std::vector<std::string> terms;
};
[[nodiscard]] const std::vector<Section5Case>& section5_cases();

/// A twin and a way of preparing its record.
struct Section5Way {
  std::string name, twin, what;  ///< "T1 paper"; what: for a reader
  dsp::Recipe recipe = dsp::Recipe::matched;
  bool equalise = true;
};
/// The first is the paper's recipe on T1; "T1 columns" matches columns but leaves the sensors as they are.
[[nodiscard]] const std::vector<Section5Way>& section5_ways();

struct Section5Options {
  int num_seeds = 1;
  std::uint64_t first_seed = 1;
  double noise = 1.0;                                             ///< times the sensors' own
  ident::Selection selection = ident::Selection::evidence_white;  ///< the paper counts every row in full
  double tau = -1.0;                                              ///< negative: the selection's own
};

/// What is fitted from: the paper's candidates for the regime, or "all": cubic in x and v, sgn(v), ddr.
inline constexpr const char *paper_candidates = "paper", *all_candidates = "all";

/// One regime, one way, one library, one seed; its fits are those of fast_rvm, slow_rvm and sindy in this order.
struct Section5Fit {
  std::uint64_t seed = 0;
  const Section5Case* definition = nullptr;
  const Section5Way* way = nullptr;
  std::string candidates;
  ident::RangeResult result;  ///< rows, targets and predictions of the first seed only
};

/// What is known of the sensors of one record.
struct Section5Sensors {
  std::uint64_t seed = 0;
  const Section5Way* way = nullptr;
  dsp::PowerCheck power;
  std::vector<dsp::SensorRelation> relations;
};

/// x and v of one regime's rows, by the paper's recipe on T1, first seed.
struct Section5States {
  const Section5Case* definition = nullptr;
  Eigen::VectorXd time_s, x, v;
};

struct Section5Replication {
  std::vector<Section5Fit> fits;
  std::vector<Section5Sensors> sensors;
  std::vector<Section5States> states;
};

/// Simulates each twin for every seed into a folder inside `folder`, which is removed again (553 MB while it lasts),
/// and fits `cases`. Throws dsp::Fault, output where the folder cannot take it.
[[nodiscard]] Section5Replication replicate_section5(const std::vector<const Section5Case*>& cases,
                                                     const Section5Options& options, const OutputFolder& folder,
                                                     Console& console);

}  // namespace apps
