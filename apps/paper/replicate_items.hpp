#pragma once
#include <string>
#include <vector>

#include "apps/paper/section4.hpp"
#include "apps/paper/section5.hpp"

// Which of the paper's tables and figures are asked for.

namespace apps {

/// What is wanted of a case of Section 4.
struct WantedCase {
  const Section4Case* definition = nullptr;
  bool table = false, figure = false;
};

/// What is wanted of Section 5.
struct WantedOfRig {
  std::vector<const Section5Case*> tables;
  bool errors = false, responses = false, states = false, identified = false;  ///< table-9, fig-11, fig-12, fig-13
  /// Table 9 and Figs. 12 and 13 need every regime.
  [[nodiscard]] std::vector<const Section5Case*> cases() const;
};

struct ReplicateItems {
  std::vector<WantedCase> cases;
  WantedOfRig rig;
};

/// A name is a case (duffing ... valanis-4, qzs-low ... qzs-mixed), qzs for all that is of the rig, table-1 ...
/// table-12, fig-2 ... fig-9, fig-11 ... fig-13, or all. Throws dsp::Fault (usage, "replicate.item") for another, and
/// for none.
[[nodiscard]] ReplicateItems items_of(const std::vector<std::string>& names);

}  // namespace apps
