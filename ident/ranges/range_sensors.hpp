#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/columns/sensor_columns.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/sensors/sensor_parameters.hpp"

namespace ident {

/// From the first to the last row of each recording; of none: empty, its end before its start.
[[nodiscard]] std::vector<dsp::Stretch> stretches_of(const RangeRows& rows, const std::vector<Columns>& recordings);

/// The sensor parameters of all recordings that a range covers, one after the other, that change something between its
/// first and last row, and their columns. The recordings must outlive it.
class RangeSensors {
 public:
  /// `stretches`: of the range's rows of each recording.
  RangeSensors(const Range& range, const std::vector<dsp::Stretch>& stretches, const std::vector<Columns>& recordings);
  [[nodiscard]] const std::vector<SensorParameter>& parameters() const& { return parameters_; }
  void parameters() const&& = delete;
  /// Forms the columns with this equation.
  void form(const WeightedTerms& equation, const std::string& target, const std::function<void()>& poll);
  /// The columns on rows [first, first + block.rows()) of these; zero where a row is of another recording.
  void read(const std::vector<Row>& rows, Eigen::Index first, Eigen::Ref<Eigen::MatrixXd> block) const;
  /// Mean of each column over these blocks of a recording, ahead of the column filter.
  [[nodiscard]] Eigen::RowVectorXd mean(std::size_t recording, const std::vector<Eigen::Index>& blocks) const;
  /// Greatest magnitude of each column on these rows.
  [[nodiscard]] Eigen::RowVectorXd largest(const std::vector<Row>& rows) const;
  /// What these values of the parameters make on these rows.
  [[nodiscard]] Eigen::VectorXd effect(const std::vector<Row>& rows, const Eigen::VectorXd& values) const;
  /// Which parameter is this coordinate of a recording (0-based); none: it is known.
  [[nodiscard]] std::optional<Eigen::Index> coordinate(std::size_t recording, Coordinate coordinate) const;

 private:
  struct Part {
    const Columns* columns = nullptr;  ///< null: no parameters
    Eigen::Index first = 0;
    dsp::Stretch stretch;                                    ///< of the rows
    std::vector<SensorParameter> sensors;                    ///< that change something on the rows
    std::vector<std::shared_ptr<const SensorShape>> shapes;  ///< theirs, each once
    std::vector<Eigen::Index> shape_of;                      ///< of each sensor
    SensorColumns psi;                                       ///< of the shapes
  };
  template <class Visit>
  void for_each_value(const Row& row, Visit&& visit) const;

  std::vector<Part> parts_;  ///< one for each recording
  std::vector<SensorParameter> parameters_;
};

}  // namespace ident
