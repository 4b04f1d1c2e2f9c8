#include "dsp/samples/standstill.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "dsp/values/order_statistics.hpp"

namespace dsp {
namespace {

constexpr Eigen::Index least_cells = 8;

}  // namespace

void StepScale::learn(std::span<const SampleCell> cells, std::span<const double> steps) {
  std::vector<double> values;
  std::copy_if(steps.begin(), steps.end(), std::back_inserter(values), [](double step) { return step > 0.0; });
  // Of those that are not zero: there are many zeros where a channel is clipped.
  const double candidate = 2 * values.size() >= steps.size() ? jump_ratio * quantile_in_place(values, 0.5) : 0.0;
  const auto fraction_above = [&](const auto& items, const auto& step_of) {
    const auto above = std::count_if(items.begin(), items.end(), [&](const auto& x) { return step_of(x) > candidate; });
    return static_cast<double>(above) / static_cast<double>(items.size());
  };
  const auto step_of = [](const SampleCell& cell) { return cell.step; };
  if (candidate > 0.0 && fraction_above(steps, [](double x) { return x; }) <= 0.2 &&
      fraction_above(cells, step_of) >= 0.5)
    floor = candidate;  // single steps are small, cells have a large one: values repeated, with noise on top
  else if (candidate == 0.0)
    floor = 0.0;

  for (const double step : values) smallest = std::min(smallest, step);
  values.clear();
  const std::size_t stride = cells.size() >= 2048 ? 8 : 1;  // an eighth of them is as good
  for (std::size_t i = 0; i < cells.size(); i += stride) values.push_back(cells[i].step);
  for (const double step : values)
    if (step > 0.0) smallest = std::min(smallest, step);
  large = quantile_in_place(values, 0.9);
  std::erase_if(values, [&](double step) { return step <= floor; });
  if (values.empty()) return;
  typical = quantile_in_place(values, 0.5);
  std::erase_if(values, [&](double step) { return step <= 1.5 * floor; });  // rare noise
  if (!values.empty()) least = *std::min_element(values.begin(), values.end());
}

void Standstill::follow(std::span<const SampleCell> cells, const StepScale& scale) {
  // Slower than this it comes to rest by degrees.
  const double pace = std::max({0.5 * scale.typical, 2.0 * scale.smallest, 3.0 * scale.floor});
  while (!cells.empty()) {
    if (const std::size_t count = num_moving(cells, scale.floor); count > 0) {
      pass(cells.first(count));
      cells = cells.subspan(count);
      continue;
    }
    const auto& cell = cells.front();
    cells = cells.subspan(1);
    const bool still = cell.step <= scale.floor && cell_ > 0;
    if (ripening_ > 0 && --ripening_ == 0) {
      const double after = std::max({cell.step, steps_[0], steps_[1], scale.typical});
      if (after > 0.0) runs_.back().jump_out = step_out_ / after;
    }
    if (still && !is_open_) {
      const double before = std::max({steps_[1], steps_[2], steps_[3]});
      open_ = {.first = cell_, .level = cell.mean, .level_in = levels_before_[1]};
      if (scale.typical > 0.0) open_.jump_in = steps_[0] / std::max(before, scale.typical);
      open_.abrupt = std::max(before, steps_[0]) >= pace;
      if (scale.least > 0.0) open_.rise = std::abs(cell.mean - levels_before_[1]) / scale.least;
      is_open_ = true;
    } else if (!still && is_open_) {
      open_.abrupt = open_.abrupt || cell.step >= pace;
      open_.level_out = cell.mean;
      step_out_ = cell.step;
      close(scale);
    }
    if (!still) ++cells_in_runs_[1];
    if (still && cell.step == 0.0) {
      ++open_.num_equal;
      ++num_equal_;
    }
    if (scale.floor > 0.0 && cell.step <= jump_ratio * scale.typical) {
      levels_.add(cell.mean, still);
      low_ = std::min(low_, cell.mean);
      high_ = std::max(high_, cell.mean);
    }
    if (scale.floor > 0.0 && !is_open_) note_extreme(cell);
    note(cell);
    ++cell_;
  }
}

// How many cells only have to be counted: an open run, one still ripening, and levels take more.
std::size_t Standstill::num_moving(std::span<const SampleCell> cells, double floor) const {
  if (is_open_ || ripening_ > 0 || floor > 0.0) return 0;
  const auto still = std::find_if(cells.begin(), cells.end(), [](const auto& cell) { return cell.step <= 0.0; });
  return static_cast<std::size_t>(still - cells.begin());
}

void Standstill::pass(std::span<const SampleCell> moving) {
  const auto count = static_cast<Eigen::Index>(moving.size());
  cells_in_runs_[1] += count;
  cell_ += count;
  for (const auto& cell : moving.last(std::min(moving.size(), steps_.size()))) note(cell);
}

void Standstill::note(const SampleCell& cell) {
  steps_ = {cell.step, steps_[0], steps_[1], steps_[2]};
  levels_before_ = {cell.mean, levels_before_[0]};
}

// A crest may be at a limit for less than a cell, or a part of two.
void Standstill::note_extreme(const SampleCell& cell) {
  const double reach = 2.0 * levels_.resolution();
  if (cell.high >= high_ - reach)
    extreme_runs_.push_back({.first = cell_, .last = cell_ + 1, .level = cell.high});
  else if (cell.low <= low_ + reach)
    extreme_runs_.push_back({.first = cell_, .last = cell_ + 1, .level = cell.low});
}

void Standstill::close(const StepScale& scale) {
  is_open_ = false;
  open_.last = cell_;
  const auto length = std::min(open_.num_cells(), static_cast<Eigen::Index>(cells_in_runs_.size()) - 1);
  cells_in_runs_[static_cast<std::size_t>(length)] += open_.num_cells();
  const double reach = 2.0 * levels_.resolution();
  if (scale.floor > 0.0 && (open_.level >= high_ - reach || open_.level <= low_ + reach))
    extreme_runs_.push_back(open_);
  if (open_.num_cells() < least_cells && open_.num_equal < least_equal_cells) return;
  runs_.push_back(open_);
  ripening_ = static_cast<Eigen::Index>(steps_.size()) - 1;
}

void Standstill::finish() {
  if (is_open_) close({});
  ripening_ = 0;
}

Eigen::Index Standstill::usual_cells() const {
  std::int64_t sum = 0;
  for (std::size_t length = 1; length < cells_in_runs_.size(); ++length)
    if ((sum += cells_in_runs_[length]) * 2 >= cell_) return static_cast<Eigen::Index>(length);
  return static_cast<Eigen::Index>(cells_in_runs_.size());
}

}  // namespace dsp
