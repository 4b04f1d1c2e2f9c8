#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "dsp/io/input_file.hpp"
#include "dsp/io/sample_source.hpp"
#include "dsp/io/tdms_bytes.hpp"

// TDMS as National Instruments describe it ("TDMS File Format Internal Structure"): segments of a lead-in of 28 bytes,
// metadata, and raw data in chunks.

namespace dsp {

/// Values at even distances: `num_segments` segments, `segment_step` bytes from one to the next, of `num_chunks` chunks
/// of `count` rows. A row is of `row_bytes`, in which the value begins at `offset_in_row`.
struct TdmsRun {
  std::uint64_t first_value = 0;  ///< how many are before it
  std::uint64_t offset = 0;       ///< of the first row
  std::uint64_t count = 0, row_bytes = 0, offset_in_row = 0, num_chunks = 0, chunk_step = 0, num_segments = 1,
                segment_step = 0;
  bool is_big = false;
  [[nodiscard]] std::uint64_t num_values() const { return count * num_chunks * num_segments; }
};

/// The file, a group or a channel.
struct TdmsObject {
  std::string group, name;  ///< of a group the name is empty, of the file both
  bool is_channel = false;
  std::map<std::string, TdmsValue> properties{};  ///< those that say clock, unit or scale, as they are in the end
  std::uint32_t type = 0;
  bool has_several_types = false;  ///< from segment to segment
  std::uint64_t num_values = 0;
  std::vector<TdmsRun> runs{};  ///< where they are; none for text
};

struct TdmsContents {
  std::vector<TdmsObject> objects;
  std::string cut{};  ///< how the file ends before its time; empty: it does not
};

/// Walks over the metadata of all segments; equal ones that follow one another are one run. Throws Fault (input):
/// container.truncated where the last segment is not whole (with options.salvage `cut` says so instead), tdms.damaged,
/// container.unsupported for digital lines of DAQmx, and memory.limit where the metadata need more than is allowed.
[[nodiscard]] TdmsContents read_tdms_segments(const InputFile& file, const OpenOptions& options);

}  // namespace dsp
