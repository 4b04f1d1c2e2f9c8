#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ident/evidence/evidence_data.hpp"
#include "ident/ranges/mean_rows.hpp"
#include "ident/ranges/range_sensors.hpp"
#include "ident/sensors/sensor_fit.hpp"
#include "ident/validate/free_run.hpp"
#include "ident/validate/independent_rows.hpp"
#include "ident/validate/range_result.hpp"

namespace ident {

/// All that the methods have in common on one range.
struct RangeData {
  std::vector<Eigen::Index> terms;  ///< of the library, that can be distinguished on the training rows
  Eigen::VectorXd scale;            ///< largest magnitude of each column of the library on them
  RFactor data;                     ///< of `terms` and the target, the sensors integrated out
  std::optional<RangeSensors> sensors;
  SensorRegression joint;                               ///< of sensors, `terms` and target
  MeanRows means;                                       ///< which `joint` has, too
  double noise_std = 0.0;                               ///< of the target, beside all terms and sensors
  Eigen::VectorXd train, test;                          ///< target
  std::vector<Eigen::Index> train_samples;              ///< the records one behind the other
  std::vector<Eigen::Index> first_rows;                 ///< of each record with training rows
  std::shared_ptr<const IndependentRows> independence;  ///< of the training rows; filled in by iterate_columns, once
  EvidenceData evidence;                                ///< filled in by iterate_columns where a method asks for it
  CandidateLibrary library;     ///< that `terms` are of: as given, or with terms of one recording each
  RangeFactors factors;         ///< in terms of the library given; without blocks
  std::vector<Course> courses;  ///< of the test rows
  std::vector<std::pair<std::string, double>> largest;  ///< of the signals the library looks at
};

/// Where these terms of the library are among range.terms; those that are not there are left out.
[[nodiscard]] std::vector<Eigen::Index> positions_in(const RangeData& range, const std::vector<Eigen::Index>& terms);

/// What the sensors are beside a fit, whose terms have these positions among range.terms and which leaves this residual
/// on the training rows without them: at the noise of what both leave. `evidence`: as which the rows were fitted; null:
/// all count in full. `independent_fraction`: of the rows, by the same.
[[nodiscard]] SensorPosterior sensors_beside(const Fit& found, const std::vector<Eigen::Index>& positions,
                                             const RangeData& range, const std::vector<Row>& train,
                                             const EvidenceData* evidence,
                                             const Eigen::Ref<const Eigen::VectorXd>& residual_without,
                                             double& independent_fraction);

/// These rows of each recording as ranges of its usable samples to run through, in which they count.
[[nodiscard]] std::vector<Course> courses_of(const std::vector<Row>& rows,
                                             const std::vector<std::vector<Eigen::Index>>& usable,
                                             const std::vector<Columns>& recordings);

/// Of the columns as they are, without sensors. Terms that cannot be used are named in result.dropped. Throws as
/// identify does.
[[nodiscard]] RangeData range_data(RangeResult& result, const std::vector<Columns>& recordings,
                                   const CandidateLibrary& library, const IdentifyOptions& options);

}  // namespace ident
