#include "dsp/samples/hold_length.hpp"

#include <limits>
#include <numeric>

namespace dsp {

void HoldLength::note_change() {
  if (last_change_ > 0) {
    length_ = std::gcd(length_, place_ - last_change_);
    span_ += place_ - last_change_;
    ++num_changes_;
  }
  last_change_ = place_;
}

int HoldLength::samples() const {
  constexpr std::int64_t least_changes = 64;
  if (length_ < 2 || num_changes_ < least_changes || 10 * num_changes_ * length_ < 9 * span_) return 1;
  return length_ < std::numeric_limits<int>::max() ? static_cast<int>(length_) : 1;
}

}  // namespace dsp
