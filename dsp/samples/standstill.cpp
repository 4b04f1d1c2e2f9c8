#include "dsp/samples/standstill.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "dsp/order_statistics.hpp"

namespace dsp {
namespace {

using Eigen::Index;

constexpr double false_alarms = 1e-3;  ///< a record and channel: the probability that chance makes a fault
constexpr double max_habit = 0.2;      ///< of a record: what stands still for longer rests
constexpr double rarest = 1e-12;       ///< of a channel that never stood still
constexpr Index least_cells = 4;
constexpr double noise_over_floor = 1.5;  ///< noise may span so many floors, motion none
/// Gaussian noise steps 8 times as far as its median step once in 10^7 samples.
constexpr double jump_ratio = 8.0;
/// In steps of the resolution. A crest (a parabola) or a stop by friction (half of one) that is rounded to one level
/// for four cells leaves it by 3 steps over two cells, and by up to two more where both ends are rounded.
constexpr double least_rise = 6.0;

}  // namespace

void StepScale::learn(std::span<const SampleCell> cells, std::span<const double> steps) {
  constexpr double noise_floor = 8.0;  // of the median step between samples that only noise parts
  std::vector<double> values;
  std::copy_if(steps.begin(), steps.end(), std::back_inserter(values), [](double step) { return step > 0.0; });
  // Of those that are not zero: there are many zeros where a channel is clipped.
  const double candidate = 2 * values.size() >= steps.size() ? noise_floor * quantile_in_place(values, 0.5) : 0.0;
  const auto share_above = [&](const auto& items, const auto& step_of) {
    const auto above = std::count_if(items.begin(), items.end(), [&](const auto& x) { return step_of(x) > candidate; });
    return static_cast<double>(above) / static_cast<double>(items.size());
  };
  // Single steps are small, cells have a large one: values repeated, with noise on top.
  if (candidate == 0.0 || (share_above(steps, [](double x) { return x; }) <= 0.2 &&
                           share_above(cells, [](const SampleCell& cell) { return cell.step; }) >= 0.5))
    floor = candidate;

  double smallest = std::numeric_limits<double>::infinity();
  for (const double step : values) smallest = std::min(smallest, step);
  values.clear();
  const std::size_t stride = cells.size() >= 2048 ? 8 : 1;  // an eighth of them is as good
  for (std::size_t i = 0; i < cells.size(); i += stride) values.push_back(cells[i].step);
  large = quantile_in_place(values, 0.9);
  std::erase_if(values, [&](double step) { return step <= floor; });
  if (values.empty()) return;
  typical = quantile_in_place(values, 0.5);
  if (floor > 0.0) {
    std::erase_if(values, [&](double step) { return step <= noise_over_floor * floor; });  // rare noise
    smallest = std::numeric_limits<double>::infinity();
  }
  for (const double step : values) smallest = std::min(smallest, step);
  if (std::isfinite(smallest)) resolution = smallest;
}

bool StillRun::jumps(const Beside& side) const {
  const double usual = std::max({side[1].step, side[2].step, scale.typical});
  return usual > 0.0 && side[0].step >= jump_ratio * usual;
}

bool StillRun::is_cut(const Beside& side) const {
  return scale.resolution > 0.0 && std::abs(level - side[1].mean) >= least_rise * scale.resolution;
}

bool StillRun::is_cut_crest() const {
  return is_cut(before) && is_cut(after) && (before[1].mean < level) == (after[1].mean < level);
}

void RunLengths::add(Index num_cells) {
  num_still_ += num_cells;
  ++counts_[static_cast<std::size_t>(std::min(num_cells, static_cast<Index>(counts_.size()) - 1))];
}

Index RunLengths::least_improbable(Index cells_in_all, double share) const {
  double still = 0.0, runs = 0.0;  // of shorter runs
  for (std::size_t length = 1; length < counts_.size(); ++length) {
    const double goes_on = std::max({share, still / static_cast<double>(cells_in_all), rarest});
    const double least = std::log(false_alarms / (runs + 1.0)) / std::log(goes_on);
    const double longer = static_cast<double>(num_still_) - still;
    if (static_cast<double>(length) >= std::max(least, static_cast<double>(least_cells)) &&
        longer <= max_habit * static_cast<double>(cells_in_all))
      return static_cast<Index>(length);
    runs += static_cast<double>(counts_[length]);
    still += static_cast<double>(counts_[length]) * static_cast<double>(length);
  }
  return std::numeric_limits<Index>::max();
}

Index RunLengths::usual(Index cells_in_all) const {
  Index cells = cells_in_all - num_still_;
  std::size_t length = 1;
  for (; 2 * cells < cells_in_all && length + 1 < counts_.size(); ++length)
    cells += counts_[length] * static_cast<Index>(length);
  return static_cast<Index>(length);
}

void Standstill::follow(std::span<const SampleCell> cells, const StepScale& scale) {
  for (std::size_t i = context; i < cells.size(); ++i, ++cell_) {
    const SampleCell& cell = cells[i];
    const double drift = is_open_ ? std::abs(cell.mean - open_.level) : 0.0;
    const bool still = cell_ > 0 && cell.step <= scale.floor &&
                       std::max(cell.high - cell.low, drift) <= noise_over_floor * scale.floor;
    if (num_beside_ < context) take_beside(cell);
    if (still && !is_open_)
      open_ = {cell_, cell_, cell.mean, {cells[i - 1], cells[i - 2], cells[i - 3]}, {}, scale};
    else if (!still && is_open_) {
      close();
      take_beside(cell);
    }
    is_open_ = still;
  }
}

void Standstill::take_beside(const SampleCell& cell) {
  ripening_.after[num_beside_++] = cell;
  if (num_beside_ == context) judge(ripening_);
}

void Standstill::close() {
  while (num_beside_ < context) take_beside(ripening_.after[num_beside_ - 1]);  // the next run came soon
  open_.last = cell_;
  ripening_ = open_;
  num_beside_ = 0;
}

void Standstill::judge(const StillRun& run) {
  if (run.num_cells() >= least_cells)
    runs_.push_back(run);
  else
    short_runs_.add(run.num_cells());
}

void Standstill::finish() {
  if (is_open_) close();
  is_open_ = false;
  const double level = ripening_.level;
  while (num_beside_ < context) take_beside({level, level, level, 0.0});
}

}  // namespace dsp
