#pragma once
#include <optional>
#include <vector>

#include "ident/fit.hpp"
#include "ident/selection/effective_size.hpp"
#include "ident/sensors/sensor_fit.hpp"

namespace ident {

struct CandidateLibrary;
struct Columns;
struct IdentifyOptions;
struct RangeData;
struct RangeResult;

/// The rows of a range as evidence for its terms (Selection::evidence): whitened where their noise is an
/// autoregression, and weighted down to their effective size.
struct EvidenceData {
  RFactor data;        ///< of the range's terms and target, the sensors integrated out; num_samples: n_eff
  EffectiveSize size;  ///< of the model that the terms settled on
  std::optional<std::vector<Eigen::Index>> terms;  ///< the model, where misfit and not noise limits the rows
  std::vector<ModelOfSize> path;  ///< that were compared, from no term on; terms are the range's; empty: too few rows
  SensorRegression joint;         ///< as of the range, whitened
  double noise_std = 0.0;         ///< of the whitened target
  std::vector<unsigned char> begins;       ///< of runs of consecutive rows
  [[nodiscard]] bool as_they_are() const;  ///< all rows count as they are: the residual is white
};

/// `range`: with its sensors. Models of each size are tried: from that settled on, to the next larger whose gain
/// (n_eff - k') ln(rss / rss') exceeds that of their cost k ln n_eff + 2 ln (b over k), at the effective size of the
/// larger model.
[[nodiscard]] EvidenceData evidence_data(const RangeData& range, const RangeResult& result,
                                         const std::vector<Columns>& recordings, const CandidateLibrary& library,
                                         const IdentifyOptions& options);

}  // namespace ident
