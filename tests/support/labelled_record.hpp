#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dsp/prepare.hpp"
#include "ident/equation/verdict.hpp"
#include "ident/library/library.hpp"

namespace support {

/// A record of an oscillator drawn at random, as a stranger would bring it, with the equation that it truly follows.
/// Channels have a mean of nearly zero, so that no offset of x changes the true terms.
struct LabelledRecord {
  std::string scenario;  ///< one of scenario_names
  std::uint32_t seed = 0;
  std::string drawn;     ///< all that was drawn, as "name=value name=value"
  double noise = 0.0;    ///< standard deviation of each channel's white noise over the rms of the channel
  double periods = 0.0;  ///< of the small undamped motion, in the record
  bool wide_band = false;
  dsp::Recording recording;
  dsp::PrepareOptions prepare;
  ident::LibraryOptions library;
  std::vector<std::pair<std::string, double>> truth;  ///< of a; all its terms, whether the library has them or not
  dsp::Motion exact;                                  ///< x, v, a and what drives them, at every sample
  /// Set where no equation of the library can be right, and why.
  std::optional<ident::Cause> flaw;
};

[[nodiscard]] const std::vector<std::string>& scenario_names();

/// Everything follows from the seed: the scenario, the oscillator, its drive, sensors, noise, band and library.
/// `mended`: the same without its flaw, what it lacks recorded and a candidate.
[[nodiscard]] LabelledRecord labelled_record(std::uint32_t seed, bool mended = false);

}  // namespace support
