#include "ident/sensors/range_sensors.hpp"

#include <algorithm>
#include <limits>

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

RangeSensors::RangeSensors(const Range& range, const RangeRows& rows, const std::vector<Columns>& recordings)
    : parts_(recordings.size()) {
  const bool alone = range.recording != 0 || recordings.size() == 1;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (!range.covers(r) || recordings[r].sensors.empty()) continue;
    double first_s = std::numeric_limits<double>::infinity(), last_s = -first_s;
    for (const auto* part : {&rows.train, &rows.test})
      for (const Row& row : *part) {
        if (row.recording != r) continue;
        const double t_s = static_cast<double>(row.sample) / recordings[r].signals->sample_rate_hz;
        first_s = std::min(first_s, t_s), last_s = std::max(last_s, t_s);
      }
    Part& part = parts_[r];
    part.columns = &recordings[r];
    part.first = static_cast<Index>(parameters_.size());
    for (const SensorParameter& parameter : recordings[r].sensors) {
      if (parameter.from_s >= last_s || parameter.to_s <= first_s) continue;
      part.sensors.push_back(parameter);
      parameters_.push_back(parameter);
      if (alone) continue;
      parameters_.back().name = recordings[r].name + ": " + parameter.name;
      parameters_.back().source = recordings[r].name + ": " + parameter.source;
    }
  }
}

void RangeSensors::form(const WeightedTerms& equation, const std::string& target, const std::function<void()>& poll) {
  for (Part& part : parts_)
    if (part.columns != nullptr)
      part.psi = sensor_columns(*part.columns->prepared, part.sensors, equation, target, poll);
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
  const auto count = static_cast<Index>(part.sensors.size());
  return corrected(part.columns->prepared->signals, part.sensors, values.segment(part.first, count));
}

}  // namespace ident
