#include "dsp/samples/sample_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dsp/values/constants.hpp"

namespace dsp {

// A function of its own: among calls the compiler keeps the sums in memory, where each addition waits for the one
// before.
[[gnu::noinline]] SampleStatistics::Sums SampleStatistics::added(Sums sums, std::span<const SampleCell> cells,
                                                                 double origin, double first_index) {
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const SampleCell& cell = cells[k];
    sums.low = std::min(sums.low, cell.low);
    sums.high = std::max(sums.high, cell.high);
    const double level = cell.mean - origin;
    sums.level += level;
    sums.squares += level * level;
    sums.moment += level * (first_index + static_cast<double>(k));
  }
  return sums;
}

void SampleStatistics::follow(std::span<const SampleCell> cells, std::span<const double> steps,
                              const StepScale& scale) {
  if (num_cells_ == 0 && !cells.empty()) origin_ = cells.front().mean;
  constexpr double beyond = 10.0;
  const double threshold = beyond * std::max(scale.large, scale.smallest);
  for (std::size_t k = 0; k < cells.size() && few_values(); ++k) {
    note_value(cells[k].low);
    note_value(cells[k].high);
  }
  sums_ = added(sums_, cells, origin_, static_cast<double>(num_cells_));
  const SampleCell* last = &last_;
  bool quiet = burst_.num_cells == 0;
  for (const SampleCell& cell : cells) {
    if (!quiet || cell.step > threshold) {
      look_for_spikes(*last, cell, threshold);
      quiet = burst_.num_cells == 0;
    }
    last = &cell;
    ++num_cells_;
  }
  last_ = *last;
  for (const double step : steps) {
    num_changes_ += step > scale.floor;
    if (step > 0.0) note_step(step);
  }
  num_steps_ += static_cast<std::int64_t>(steps.size());
}

void SampleStatistics::note_value(double value) {
  if (values_.size() <= max_values && std::find(values_.begin(), values_.end(), value) == values_.end())
    values_.push_back(value);
}

void SampleStatistics::note_step(double step) {
  constexpr double rounding = 0.01;
  if (step < (1.0 - rounding) * quantum_) {
    quantum_ = step;
    num_multiples_ = num_others_ = 0;
  }
  const double ratio = step / quantum_;
  ++(std::abs(ratio - std::round(ratio)) < rounding ? num_multiples_ : num_others_);
}

// A spike sticks out of its surroundings by about one step, there and back, within three cells; a burst rings longer, a
// pulse takes many steps to rise, a jump does not come back.
void SampleStatistics::look_for_spikes(const SampleCell& last, const SampleCell& cell, double threshold) {
  if (cell.step > threshold) {
    if (burst_.num_cells == 0) {
      burst_.before = last;
      burst_.hull = cell;
    }
    burst_.hull.low = std::min(burst_.hull.low, cell.low);
    burst_.hull.high = std::max(burst_.hull.high, cell.high);
    burst_.hull.step = std::max(burst_.hull.step, cell.step);
    ++burst_.num_cells;
  } else {
    const auto& [before, hull, num_cells] = burst_;
    const double out =
        std::max(hull.high - std::max(before.high, cell.high), std::min(before.low, cell.low) - hull.low);
    const bool back = std::abs(before.mean - cell.mean) <= 0.25 * hull.step;
    if (num_cells <= 3 && back && out >= 0.5 * hull.step && out <= 2.0 * hull.step) {
      const Eigen::Index first_cell = num_cells_ - num_cells;
      if (spike_.count++ == 0) spike_.first_cell = first_cell;
      if (out > spike_.largest) {
        spike_.largest = out;
        spike_.largest_cell = first_cell;
      }
    }
    burst_.num_cells = 0;
  }
}

double SampleStatistics::repeats() const {
  return static_cast<double>(std::max<std::int64_t>(num_steps_, 1)) /
         static_cast<double>(std::max<std::int64_t>(num_changes_, 1));
}

std::vector<Check> SampleStatistics::checks(const Channel& channel, double cell_s, double sample_rate_hz) const {
  if (constant())
    return {
        {"sample.constant", channel.name, CheckStatus::warning, sums_.low, 0.0,
         sums_.low == 0.0 ? "all values are zero" : fmt::format("all values are {:.6g} {}", sums_.low, channel.unit)}};
  const auto n = static_cast<double>(num_cells_);
  const double mean = sums_.level / n, spread = std::sqrt(std::max(0.0, sums_.squares / n - mean * mean));
  const double offset = origin_ + mean;
  const double drift =
      n > 1 ? (12 * sums_.moment - 6 * (n - 1) * sums_.level) / (n * n - 1) : 0.0;  // slope times n cells
  std::vector<Check> checks;
  checks.push_back({"sample.offset", channel.name,
                    std::abs(offset) > 0.1 * spread ? CheckStatus::note : CheckStatus::ok, offset, 0.1 * spread,
                    fmt::format("mean {:.6g} {}", offset, channel.unit)});
  if (const std::string line = line_of_gravity(offset);
      channel.unit_is_assumed && info_of(channel.role).order == 2 && !line.empty() && line != "unit = \"m/s^2\"")
    checks.push_back({"sample.gravity", channel.name, CheckStatus::warning, offset, 0.0,
                      fmt::format("its mean is {:.5g}, which may be gravity, but {} was assumed. If it is gravity, "
                                  "write {} under its [[channel]] in the sidecar",
                                  offset, channel.unit, line)});
  checks.push_back(
      {"sample.drift", channel.name, std::abs(drift) > 0.1 * spread ? CheckStatus::note : CheckStatus::ok, drift,
       0.1 * spread,
       fmt::format("a straight line through the record changes by {:.6g} {} from end to end", drift, channel.unit)});
  if (const auto num = num_multiples_ + num_others_; num >= 20 && 20 * num_others_ <= num) {
    constexpr double least_bits = 7.0;
    const double bits = std::log2((sums_.high - sums_.low) / quantum_ + 1.0);
    checks.push_back({"sample.quantised", channel.name, bits < least_bits ? CheckStatus::warning : CheckStatus::ok,
                      bits, least_bits,
                      fmt::format("in steps of {:.6g} {}: {:.1f} effective bits", quantum_, channel.unit, bits)});
  }
  if (repeats() > 1.5)
    checks.push_back({"sample.repeated", channel.name, CheckStatus::note, repeats() / sample_rate_hz, 0.0,
                      fmt::format("a value is repeated {:.1f} times on average", repeats())});
  checks.push_back(
      {"sample.spike", channel.name, spike_.count > 0 ? CheckStatus::note : CheckStatus::ok,
       static_cast<double>(spike_.count), 0.0,
       spike_.count == 0
           ? "none"
           : fmt::format("{} of up to {:.6g} {}, the first at {:.6g} s, the largest at {:.6g} s; left in", spike_.count,
                         spike_.largest, channel.unit, static_cast<double>(spike_.first_cell) * cell_s,
                         static_cast<double>(spike_.largest_cell) * cell_s)});
  return checks;
}

std::string line_of_gravity(double mean) {
  constexpr double off = 0.05;  // of gravity: a cheap sensor's error and the place on earth
  const auto is = [&](double reading) { return std::abs(std::abs(mean) / reading - 1.0) < off; };
  using Reading = std::pair<const char*, double>;
  for (const auto& [unit, reading] : {Reading{"g", 1.0}, {"m/s^2", gravity}, {"mg", 1e3}, {"mm/s^2", 1e3 * gravity}})
    if (is(reading)) return fmt::format("unit = \"{}\"", unit);
  for (const double counts : {256.0, 512.0, 1024.0, 2048.0, 4096.0, 8192.0, 16384.0})
    if (is(counts)) return fmt::format("full_scale = \"{:.9g} g\"", 1.0 / counts);
  return "";
}

}  // namespace dsp
