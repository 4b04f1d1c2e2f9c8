#include "ident/ranges/range_sensors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<dsp::Stretch> stretches_of(const RangeRows& rows, const std::vector<Columns>& recordings) {
  constexpr double never = std::numeric_limits<double>::infinity();
  std::vector<dsp::Stretch> stretches(recordings.size(), {never, -never});
  for (const auto* part : {&rows.train, &rows.test})
    for (const Row& row : *part) {
      const double t_s = static_cast<double>(row.sample) / recordings[row.recording].signals->sample_rate_hz;
      dsp::Stretch& stretch = stretches[row.recording];
      stretch.from_s = std::min(stretch.from_s, t_s), stretch.to_s = std::max(stretch.to_s, t_s);
    }
  return stretches;
}

RangeSensors::RangeSensors(const Range& range, const std::vector<dsp::Stretch>& stretches,
                           const std::vector<Columns>& recordings)
    : parts_(recordings.size()) {
  const bool alone = range.recording != 0 || recordings.size() == 1;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (!range.covers(r) || recordings[r].sensors.empty()) continue;
    Part& part = parts_[r];
    part.columns = &recordings[r];
    part.stretch = stretches[r];
    part.first = static_cast<Index>(parameters_.size());
    for (const SensorParameter& parameter : recordings[r].sensors) {
      if (parameter.from_s >= part.stretch.to_s || parameter.to_s <= part.stretch.from_s) continue;
      part.sensors.push_back(parameter);
      const auto shape = std::find(part.shapes.begin(), part.shapes.end(), parameter.shape);
      part.shape_of.push_back(shape - part.shapes.begin());
      if (shape == part.shapes.end()) part.shapes.push_back(parameter.shape);
      parameters_.push_back(parameter);
      if (alone) continue;
      parameters_.back().name = recordings[r].name + ": " + parameter.name;
      parameters_.back().source = recordings[r].name + ": " + parameter.source;
    }
  }
}

void RangeSensors::form(const WeightedTerms& equation, const std::string& target, const std::function<void()>& poll) {
  for (Part& part : parts_)
    if (const Columns* columns = part.columns; columns != nullptr)
      part.psi = sensor_columns(*columns->prepared, *columns->accelerations, part.shapes, equation, target,
                                part.stretch, poll);
}

/// Calls visit(parameter, value of its column) for what is not zero.
template <class Visit>
void RangeSensors::for_each_value(const Row& row, Visit&& visit) const {
  const Part& part = parts_[row.recording];
  if (part.columns == nullptr) return;
  const double t_s = static_cast<double>(row.sample) / part.columns->signals->sample_rate_hz;
  for (std::size_t k = 0; k < part.sensors.size(); ++k)
    if (const double course = part.sensors[k].course_at(t_s); course != 0.0)
      visit(part.first + static_cast<Index>(k), course * part.psi.values(row.sample, part.shape_of[k]));
}

void RangeSensors::read(const std::vector<Row>& rows, Index first, Eigen::Ref<MatrixXd> block) const {
  block.setZero();
  for (Index i = 0; i < block.rows(); ++i)
    for_each_value(rows[static_cast<std::size_t>(first + i)], [&](Index k, double value) { block(i, k) = value; });
}

Eigen::RowVectorXd RangeSensors::mean(std::size_t recording, const std::vector<Index>& blocks) const {
  Eigen::RowVectorXd result = Eigen::RowVectorXd::Zero(std::ssize(parameters_));
  const Part& part = parts_[recording];
  if (part.columns == nullptr || part.psi.means.size == 0) return result;
  const double block_s = static_cast<double>(part.psi.means.size) / part.columns->prepared->intermediate.sample_rate_hz;
  for (std::size_t k = 0; k < part.sensors.size(); ++k) {
    double& sum = result(part.first + static_cast<Index>(k));
    for (const Index block : blocks)
      sum += part.sensors[k].course_at((static_cast<double>(block) + 0.5) * block_s) *
             part.psi.means.values(block, part.shape_of[k]);
  }
  return result / static_cast<double>(std::max<std::size_t>(1, blocks.size()));
}

Eigen::RowVectorXd RangeSensors::largest(const std::vector<Row>& rows) const {
  Eigen::RowVectorXd result = Eigen::RowVectorXd::Zero(std::ssize(parameters_));
  for (const Row& row : rows)
    for_each_value(row, [&](Index k, double value) { result(k) = std::max(result(k), std::abs(value)); });
  return result;
}

VectorXd RangeSensors::effect(const std::vector<Row>& rows, const VectorXd& values) const {
  VectorXd result = VectorXd::Zero(std::ssize(rows));
  for (Index i = 0; i < result.size(); ++i)
    for_each_value(rows[static_cast<std::size_t>(i)], [&](Index k, double value) { result(i) += value * values(k); });
  return result;
}

std::optional<Index> RangeSensors::coordinate(std::size_t recording, Coordinate coordinate) const {
  const Part& part = parts_[recording];
  for (std::size_t k = 0; k < part.sensors.size(); ++k)
    if (part.sensors[k].coordinate == coordinate) return part.first + static_cast<Index>(k);
  return std::nullopt;
}

}  // namespace ident
