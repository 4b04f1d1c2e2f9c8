// A recording of any container, through the whole read path: content, header, samples, bridged gaps.
#include "dsp/io/read_recording.hpp"

#include <stdexcept>

#include "dsp/values/fault.hpp"
#include "fuzz/harness.hpp"

namespace {

void read(const std::filesystem::path& file, dsp::ReadOptions options) {
  options.uncalibrated = true;
  options.max_memory_bytes = std::size_t{16} << 20;  // a limit that small inputs can reach
  dsp::RecordingReader reader(file, options);
  dsp::FrameBlock block;
  std::int64_t num_read = 0;
  while (const auto count = reader.read(block, 1000)) num_read += count;
  if (num_read != reader.num_frames()) throw std::logic_error("not the frames that were promised");
}

}  // namespace

void fuzz::run(const std::string& input) {
  const MemoryFile file(input), rate("rate = 250\n");
  try {
    read(file.path(), {});
  } catch (const dsp::Fault&) {  // it may want what only a person knows, or be cut
    read(file.path(), {.sidecar = rate.path(), .salvage = true});
  }
}
