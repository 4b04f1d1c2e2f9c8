#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dsp/io/array_file.hpp"
#include "dsp/io/input_file.hpp"

namespace dsp {

/// A file in a ZIP archive, as its directory says.
struct ZipMember {
  std::string name;
  int method = 0;  ///< 0 stored, 8 packed
  std::uint32_t checksum = 0;
  std::uint64_t header_offset = 0, packed_bytes = 0, size = 0;
};

/// Of any size (ZIP64, too). Throws Fault (input): zip.truncated where the directory at its end is missing,
/// zip.damaged.
[[nodiscard]] std::vector<ZipMember> zip_members(const InputFile& file);

/// Bytes of a member, the archive's or unpacked.
class MemberBytes {
 public:
  MemberBytes(ArrayBytes bytes, std::uint64_t size) : bytes_(std::move(bytes)), size_(size) {}
  [[nodiscard]] const char* bytes(std::uint64_t offset, std::size_t count) const& { return bytes_(offset, count); }
  void bytes(std::uint64_t offset, std::size_t count) const&& = delete;
  /// Fewer at the end.
  [[nodiscard]] std::string text(std::uint64_t offset, std::size_t count) const;

 private:
  ArrayBytes bytes_;
  std::uint64_t size_;
};
/// A member whose checksum was verified; `file` must outlive it. `left`: bytes that members may still expand to, of
/// which it takes its part. Throws Fault (input): zip.damaged, zip.size, container.unsupported (another method).
[[nodiscard]] std::shared_ptr<MemberBytes> open_member(const InputFile& file, const ZipMember& member,
                                                       std::size_t& left);

}  // namespace dsp
