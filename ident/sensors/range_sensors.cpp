#include "ident/sensors/range_sensors.hpp"

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

RangeSensors::RangeSensors(const Range& range, const std::vector<Columns>& recordings) : parts_(recordings.size()) {
  const bool alone = range.recording != 0 || recordings.size() == 1;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (!range.covers(r) || recordings[r].sensors.empty()) continue;
    parts_[r] = {&recordings[r], static_cast<Index>(parameters_.size()), {}};
    for (SensorParameter parameter : recordings[r].sensors) {
      if (!alone) parameter.name = recordings[r].name + ": " + parameter.name;
      if (!alone) parameter.source = recordings[r].name + ": " + parameter.source;
      parameters_.push_back(std::move(parameter));
    }
  }
}

void RangeSensors::form(const WeightedTerms& equation, const std::string& target, const std::function<void()>& poll) {
  for (Part& part : parts_)
    if (part.columns != nullptr)
      part.psi = sensor_columns(*part.columns->prepared, part.columns->sensors, equation, target, poll);
}

MatrixXd RangeSensors::on(const std::vector<Row>& rows) const {
  MatrixXd psi = MatrixXd::Zero(static_cast<Index>(rows.size()), static_cast<Index>(parameters_.size()));
  for (Index i = 0; i < psi.rows(); ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    const Part& part = parts_[row.recording];
    if (part.columns != nullptr) psi.row(i).segment(part.first, part.psi.cols()) = part.psi.row(row.sample);
  }
  return psi;
}

void RangeSensors::drop_columns() {
  for (Part& part : parts_) part.psi.resize(0, 0);
}

dsp::Motion RangeSensors::corrected_signals(std::size_t recording, const VectorXd& values) const {
  const Part& part = parts_[recording];
  const auto count = static_cast<Index>(part.columns->sensors.size());
  return corrected(part.columns->prepared->signals, part.columns->sensors, values.segment(part.first, count));
}

}  // namespace ident
