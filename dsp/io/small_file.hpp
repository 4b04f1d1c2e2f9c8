#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "dsp/values/fault.hpp"

namespace dsp {

/// A file that is read whole, and the fault where it cannot be.
struct SmallFile {
  FaultKind kind = FaultKind::input;
  std::string fault;                       ///< name of the fault: "config.file"
  std::string wanted = {};                 ///< its message ends in "; want ..." unless this is empty
  std::uint64_t most_bytes = 16ull << 20;  ///< more than a person writes
};

/// All bytes of a regular file. Throws Fault of the kind and name that `as` gives where the file is missing, may not be
/// read, is no regular file (a pipe or a device is never waited for), is too long, or changes while it is read.
[[nodiscard]] std::string read_small_file(const std::filesystem::path& file, const SmallFile& as);

}  // namespace dsp
