#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/values/fault.hpp"

namespace dsp {

class InputFile;

/// What the chunks of a sound file promise against what is there: libsndfile silently lowers the frame count of a file
/// that is shorter than its header says, and reads 1 % of a WAV whose 32-bit sizes have wrapped.
struct SoundHeader {
  enum class State {
    complete,
    streamed,    ///< sizes left open by the writer: the data reach to the end of the file
    truncated,   ///< more promised than there is
    unfinished,  ///< 0 promised, data behind it: the recorder died
    wrapped,     ///< more there than promised: sizes beyond 4 GiB do not fit 32 bits
  };
  std::string container;  ///< "WAV", "RF64", "W64", "CAF", "AIFF"
  State state = State::complete;
  std::uint64_t data_offset = 0, promised_bytes = 0, present_bytes = 0, frame_bytes = 0;
  std::uint64_t size_offset = 0;        ///< of the size of the samples,
  std::string real_size;                ///< and what should stand there; empty where it does
  int sample_bits = 0, valid_bits = 0;  ///< as WAV, RF64 and W64 say them; 0: not said. Valid ones are the upper of
                                        ///< those a sample has
  double rate_hz = 0.0;  ///< where the container holds it as a real number (CAF, AIFF), which libsndfile rounds; else 0
  std::vector<Check> checks;
};

/// First bytes of one of the containers above, or of a FLAC.
[[nodiscard]] bool is_sound(std::string_view head);

/// Throws Fault container.damaged (input) with the byte where the chunks stop making sense.
[[nodiscard]] SoundHeader read_sound_header(const InputFile& file);

}  // namespace dsp
