#pragma once

// Kaiser's window for filters: J. F. Kaiser, Nonrecursive digital filter design using the I0-sinh window function,
// 1974.

namespace dsp {

/// Shape for a stop band this far down; at least 21 dB, what a filter without window has.
[[nodiscard]] double kaiser_beta(double attenuation_db);

/// Length in samples of a filter whose band edges are transition_hz apart.
[[nodiscard]] double kaiser_length(double attenuation_db, double transition_hz, double sample_rate_hz);

/// The window over -1 <= u <= 1, 1 at its middle and zero outside.
class KaiserWindow {
 public:
  explicit KaiserWindow(double beta);
  [[nodiscard]] double operator()(double u) const;

 private:
  double beta_, crest_;
};

}  // namespace dsp
