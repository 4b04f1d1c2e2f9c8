#pragma once
#include <cstdint>

namespace dsp {

/// For how many samples a channel holds each of its values, where that is one number throughout: what a recorder
/// writes of a sensor slower than its clock. Values come one by one; one that the sensor itself repeats counts as a
/// hold of several.
class HoldLength {
 public:
  void push(double value) {
    if (length_ == 1) return;
    ++place_;
    if (place_ > 1 && value != last_) note_change();
    last_ = value;
  }
  /// What comes next does not follow what came.
  void restart() { place_ = last_change_ = 0; }
  /// Whether it holds none, which is final.
  [[nodiscard]] bool holds_none() const { return length_ == 1; }
  /// 1: none. 64 changes are asked for, which fall on every second sample by chance once in 2^63, and nine in ten of
  /// those that could be: steps of a resolution are met at any sample.
  [[nodiscard]] int samples() const;

 private:
  void note_change();

  double last_ = 0.0;
  std::int64_t place_ = 0, last_change_ = 0;              // counted from 1; 0: there was none
  std::int64_t length_ = 0, span_ = 0, num_changes_ = 0;  // length_: common divisor of the times between changes
};

}  // namespace dsp
