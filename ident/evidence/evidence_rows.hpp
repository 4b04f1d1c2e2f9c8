#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/selection/record_problems.hpp"
#include "ident/selection/row_weighting.hpp"
#include "ident/sensors/sensor_fit.hpp"

namespace ident {

struct IdentifyOptions;
struct RangeData;
struct RangeResult;

/// The candidates and the target on the training rows of a range, beside its sensors, whose values are integrated out.
/// What it is made of must outlive it.
struct EvidenceRows {
  const RangeData& range;
  const RangeResult& result;
  const std::vector<Columns>& recordings;
  const IdentifyOptions& options;
  RowWeighting weighting;                     ///< that makes them evidence
  std::vector<SensorRegression> regressions;  ///< of each record, so weighted: to be formed anew when that changes
  double noise_std = 0.0;                     ///< of the weighted target, at which the sensors are integrated out

  EvidenceRows(const RangeData& its_range, const RangeResult& its_result, const std::vector<Columns>& its_recordings,
               const IdentifyOptions& its_options);
  [[nodiscard]] Eigen::Index size() const;
  [[nodiscard]] Eigen::Index num_terms() const;
  [[nodiscard]] const std::vector<RecordRows>& records() const& { return weighting.records; }
  void records() const&& = delete;
  /// Rows of [Phi t], as they are.
  [[nodiscard]] RowReader reader(const Eigen::VectorXd& target) const;
  /// Greatest magnitude in each of their columns.
  [[nodiscard]] Eigen::RowVectorXd largest(const Eigen::VectorXd& target) const;
  /// R of [Psi front Phi t], weighted, `read_front` writing the columns in front of the candidates. Of all rows, or of
  /// one record.
  [[nodiscard]] SensorRegression regression(Eigen::Index num_front, const RowReader& read_front,
                                            const Eigen::RowVectorXd& largest_front,
                                            const RecordRows* record = nullptr) const;
  /// Forms the regressions. The noise is that of rows that count by a fraction, beside all candidates and sensors:
  /// more weight would let sensors explain, against what is known of them, what no candidate does.
  void form();
  void count_by(double fraction);
  /// Each record's candidates and target without its sensors.
  [[nodiscard]] RecordProblems problems() const;
  /// Of a term of the library, weighted.
  [[nodiscard]] Eigen::VectorXd column(Eigen::Index term) const;
  /// What least squares on these candidates beside the sensors leaves in each record, weighted.
  [[nodiscard]] Eigen::VectorXd residual(const RecordProblems& problems,
                                         const std::vector<Eigen::Index>& positions) const;
  /// The target without what the sensors make of it in each record beside these candidates.
  [[nodiscard]] Eigen::VectorXd target_beside_sensors(const RecordProblems& problems,
                                                      const std::vector<Eigen::Index>& positions) const;

 private:
  /// The rows of means of the range's joint regression, of all records or of one; nothing of the columns in front.
  void add_means(SensorRegression& formed, Eigen::Index num_front, const RecordRows* record) const;
  [[nodiscard]] std::vector<Eigen::VectorXd> coefficients(const RecordProblems& problems,
                                                          const std::vector<Eigen::Index>& positions) const;
};

}  // namespace ident
