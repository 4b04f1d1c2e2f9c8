#pragma once
#include "dsp/io/sidecar.hpp"
#include "dsp/regimes/regime.hpp"

namespace apps {

/// Rows that are fitted together: stretches of time, of one recording or of all, in one amplitude regime or in any.
struct Range {
  dsp::RangeSpec spec;
  int recording = 0;         ///< 1-based; 0: all
  dsp::RegimeSet regime;     ///< of its samples
  double train_share = 0.6;  ///< of its rows, where its train_to is left out
};

}  // namespace apps
