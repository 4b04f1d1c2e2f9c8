#pragma once
#include "apps/paper/replicate_case.hpp"
#include "apps/paper/rig.hpp"
#include "apps/text/svg_plot.hpp"

namespace apps {

/// The paper's figure of a case of Section 4: true against identified responses at the held-out ratios.
[[nodiscard]] PlotFigure case_figure(const CaseReplication& replication);
/// Fig. 11: amplitude against frequency of both twins, up and down.
[[nodiscard]] PlotFigure rig_sweeps();
/// Fig. 12: the measured states of each regime.
[[nodiscard]] PlotFigure rig_states(const RigReplication& replication);
/// Fig. 13: measured and identified acceleration of each regime, whole and a few seconds of the test part.
[[nodiscard]] PlotFigure rig_responses(const RigReplication& replication);

}  // namespace apps
