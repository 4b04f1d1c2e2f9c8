#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "dsp/samples/sample_cells.hpp"
#include "dsp/samples/standstill.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// What is worth saying of one channel's samples as a whole, gathered cell by cell.
class SampleStatistics {
 public:
  /// `steps`: single steps between neighbouring samples, drawn evenly from the same range.
  void follow(std::span<const SampleCell> cells, std::span<const double> steps, const StepScale& scale);
  [[nodiscard]] bool constant() const { return sums_.low == sums_.high; }
  /// A switch, a counter, a channel that is off: at most eight values. It stands still by nature.
  [[nodiscard]] bool few_values() const { return values_.size() <= max_values; }
  [[nodiscard]] double low() const { return sums_.low; }
  [[nodiscard]] double high() const { return sums_.high; }
  /// How many samples in a row have one value, on average.
  [[nodiscard]] double repeats() const;
  /// sample.constant, or sample.spike, sample.quantised, sample.repeated (these two if so), sample.offset,
  /// sample.drift.
  [[nodiscard]] std::vector<Check> checks(const Channel& channel, double cell_s, double sample_rate_hz) const;

 private:
  static constexpr std::size_t max_values = 8;
  // Extremes of the samples; sums over cells of their means less the first, of its squares and of it times the index.
  struct Sums {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    double level = 0.0, squares = 0.0, moment = 0.0;
  };
  [[nodiscard]] static Sums added(Sums sums, std::span<const SampleCell> cells, double origin, double first_index);
  struct Spike {
    std::int64_t count = 0;
    Eigen::Index first_cell = 0, largest_cell = 0;
    double largest = 0.0;
  };
  // Cells with steps far beyond the usual, not yet closed by a calm one.
  struct Burst {
    SampleCell before, hull;
    Eigen::Index num_cells = 0;
  };
  void note_value(double value);
  void note_step(double step);
  void look_for_spikes(const SampleCell& last, const SampleCell& cell, double threshold);

  Sums sums_;
  Eigen::Index num_cells_ = 0;
  double origin_ = 0.0;         // the first cell's mean
  std::vector<double> values_;  // distinct, at most max_values + 1
  double quantum_ = std::numeric_limits<double>::infinity();
  std::int64_t num_multiples_ = 0, num_others_ = 0;  // of the quantum, since it was met
  std::int64_t num_steps_ = 0, num_changes_ = 0;
  SampleCell last_;
  Burst burst_;
  Spike spike_;
};

/// The line of a [[channel]] by which a mean of such size is gravity: `unit` is g, m/s^2, mg or mm/s^2, or the counts
/// of a usual converter make 1 g; empty where it is none of them.
[[nodiscard]] std::string line_of_gravity(double mean);

}  // namespace dsp
