#pragma once
#include <optional>
#include <vector>

#include "ident/regression/fit.hpp"
#include "ident/selection/effective_size.hpp"
#include "ident/selection/row_weighting.hpp"
#include "ident/sensors/sensor_fit.hpp"

namespace ident {

struct CandidateLibrary;
struct Columns;
struct IdentifyOptions;
struct RangeData;
struct RangeResult;

/// The rows of a range as evidence for its terms (Selection::evidence): whitened where their noise is an
/// autoregression, and weighted down to their effective size; of several records, each by its own noise.
struct EvidenceData {
  RFactor data;        ///< of the range's terms and target, the sensors integrated out; num_samples: n_eff
  EffectiveSize size;  ///< of the model that the terms settled on
  std::optional<std::vector<Eigen::Index>> terms;  ///< the model, where misfit and not noise limits the rows, and of
                                                   ///< several records
  std::vector<Eigen::Index> differing;             ///< of the model's terms, those with a coefficient for each record
  std::vector<ModelOfSize> path;  ///< that were compared, from no term on, in terms of the library; empty: too few rows
  SensorRegression joint;         ///< as of the range, weighted
  double noise_std = 0.0;         ///< of the weighted target
  RowWeighting weighting;
  [[nodiscard]] bool as_they_are() const;  ///< all rows count as they are: the residual is white, of one record
};

/// `range`: with its sensors. Models are settled on by select_size; of several records with training rows, what of
/// them is common by record_coefficients.
[[nodiscard]] EvidenceData evidence_data(const RangeData& range, const RangeResult& result,
                                         const std::vector<Columns>& recordings, const CandidateLibrary& library,
                                         const IdentifyOptions& options);

/// The same rows in the terms of another range, whose library has the differing terms one for each record: `terms` of
/// these are the model.
[[nodiscard]] EvidenceData evidence_by_record(const EvidenceData& found, const std::vector<Eigen::Index>& terms,
                                              const RangeData& range, const RangeResult& result,
                                              const std::vector<Columns>& recordings, const IdentifyOptions& options);

}  // namespace ident
