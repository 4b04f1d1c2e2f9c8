#include "dsp/io/zip_archive.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>

#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

constexpr std::string_view end_mark("PK\5\6", 4), wide_end_mark("PK\6\6", 4), entry_mark("PK\1\2", 4),
    local_mark("PK\3\4", 4);
constexpr std::uint64_t end_bytes = 22, entry_bytes = 46, local_bytes = 30, wide_end_bytes = 56;

// Little-endian; 0 where there is none.
std::uint64_t number_at(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = count; i-- > 0 && at + count <= bytes.size();)
    value = 256 * value + static_cast<unsigned char>(bytes[at + i]);
  return value;
}

Fault damaged(const InputFile& file, const std::string& what) {
  return Fault(FaultKind::input, "zip.damaged",
               fmt::format("{}: {}. Copy the file from its source again", file.name(), what));
}

struct Directory {
  std::uint64_t offset = 0, bytes = 0;
};

// At the end, behind which there may be a remark.
Directory find_directory(const InputFile& file) {
  constexpr std::uint64_t longest_remark = 65535, wide_mark_bytes = 20;
  const std::uint64_t from = file.size() - std::min(file.size(), end_bytes + longest_remark);
  const std::string tail = file.text(from, static_cast<std::size_t>(file.size() - from));
  const auto at = tail.rfind(end_mark);
  if (at == tail.npos || tail.size() - at < end_bytes)
    throw Fault(FaultKind::input, "zip.truncated",
                fmt::format("{}: is a ZIP archive that was cut: the list of its files, which is at its end, is missing "
                            "({} bytes are there). Copy the file from its source again",
                            file.name(), file.size()));
  Directory found{number_at(tail, at + 16, 4), number_at(tail, at + 12, 4)};
  if (found.offset == 0xffffffff || found.bytes == 0xffffffff) {
    const std::uint64_t end = from + at;
    const std::string locator = end < wide_mark_bytes ? "" : file.text(end - wide_mark_bytes, wide_mark_bytes);
    const std::string wide = file.text(number_at(locator, 8, 8), wide_end_bytes);
    if (!wide.starts_with(wide_end_mark)) throw damaged(file, "the end of its list of files is damaged");
    found = {number_at(wide, 48, 8), number_at(wide, 40, 8)};
  }
  if (found.offset > file.size() || found.bytes > file.size() - found.offset)
    throw damaged(file, "its list of files is not where its end says");
  return found;
}

// Sizes that do not fit 32 bits are in a field of their own, in this order, those that do not alone.
void read_wide(std::string_view extra, ZipMember& member) {
  while (extra.size() >= 4) {
    const auto size = static_cast<std::size_t>(number_at(extra, 2, 2));
    if (number_at(extra, 0, 2) == 1) {
      std::size_t at = 4;
      for (std::uint64_t* value : {&member.size, &member.packed_bytes, &member.header_offset})
        if (*value == 0xffffffff) {
          *value = number_at(extra.substr(0, 4 + size), at, 8);
          at += 8;
        }
    }
    extra.remove_prefix(std::min(extra.size(), 4 + size));
  }
}

std::uint64_t data_offset(const InputFile& file, const ZipMember& member) {
  const std::string local = file.text(member.header_offset, local_bytes);
  if (!local.starts_with(local_mark))
    throw damaged(file, fmt::format("'{}' is not where its list of files says", clean_name(member.name)));
  const std::uint64_t begin = member.header_offset + local_bytes + number_at(local, 26, 2) + number_at(local, 28, 2);
  if (begin > file.size() || member.packed_bytes > file.size() - begin)
    throw damaged(file, fmt::format("'{}' goes beyond the end of the file", clean_name(member.name)));
  return begin;
}

// In pieces; `use` takes each.
template <typename Use>
void for_each_piece(const InputFile& file, std::uint64_t offset, std::uint64_t count, Use&& use) {
  constexpr std::uint64_t piece_bytes = 1 << 20;
  for (std::uint64_t done = 0; done < count;) {
    std::string piece = file.text(offset + done, static_cast<std::size_t>(std::min(piece_bytes, count - done)));
    if (piece.empty()) throw damaged(file, "became shorter while it was read");
    done += piece.size();
    use(piece);
  }
}

std::uint32_t checksum_of(std::uint32_t before, std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32(before, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

class Inflater {
 public:
  explicit Inflater(std::string& into) : into_(into) {
    if (inflateInit2(&stream_, -MAX_WBITS) != Z_OK) throw std::bad_alloc();
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() { inflateEnd(&stream_); }
  // Up to the size that was promised.
  void take(std::string& piece) {
    stream_.next_in = reinterpret_cast<Bytef*>(piece.data());
    stream_.avail_in = static_cast<uInt>(piece.size());
    while (status_ == Z_OK && stream_.avail_in > 0 && done_ < into_.size()) {
      constexpr std::size_t most_at_once = std::size_t{1} << 30;
      const std::size_t room = std::min(most_at_once, into_.size() - done_);
      stream_.next_out = reinterpret_cast<Bytef*>(into_.data() + done_);
      stream_.avail_out = static_cast<uInt>(room);
      status_ = inflate(&stream_, Z_NO_FLUSH);
      done_ += room - stream_.avail_out;
    }
  }
  [[nodiscard]] bool is_whole() const { return done_ == into_.size(); }

 private:
  std::string& into_;
  z_stream stream_{};
  std::size_t done_ = 0;
  int status_ = Z_OK;
};

}  // namespace

std::string MemberBytes::text(std::uint64_t offset, std::size_t count) const {
  const auto there = static_cast<std::size_t>(std::min<std::uint64_t>(count, size_ - std::min(size_, offset)));
  return there == 0 ? "" : std::string(bytes_(offset, there), there);
}

std::vector<ZipMember> zip_members(const InputFile& file) {
  constexpr std::uint64_t most_bytes = 1 << 24;
  const Directory directory = find_directory(file);
  if (directory.bytes > most_bytes) throw damaged(file, "its list of files is too long");
  const std::string list = file.text(directory.offset, static_cast<std::size_t>(directory.bytes));
  std::vector<ZipMember> members;
  for (std::size_t at = 0; at + entry_bytes <= list.size();) {
    const std::string_view entry = std::string_view(list).substr(at);
    if (!entry.starts_with(entry_mark)) throw damaged(file, "its list of files is damaged");
    const auto name = static_cast<std::size_t>(number_at(entry, 28, 2)),
               extra = static_cast<std::size_t>(number_at(entry, 30, 2)),
               remark = static_cast<std::size_t>(number_at(entry, 32, 2));
    if (entry.size() < entry_bytes + name + extra) throw damaged(file, "its list of files is cut");
    ZipMember member{std::string(entry.substr(entry_bytes, name)),
                     static_cast<int>(number_at(entry, 10, 2)),
                     static_cast<std::uint32_t>(number_at(entry, 16, 4)),
                     number_at(entry, 42, 4),
                     number_at(entry, 20, 4),
                     number_at(entry, 24, 4)};
    read_wide(entry.substr(entry_bytes + name, extra), member);
    members.push_back(std::move(member));
    at += entry_bytes + name + extra + remark;
  }
  return members;
}

std::shared_ptr<MemberBytes> open_member(const InputFile& file, const ZipMember& member, std::size_t& left) {
  const std::string name = clean_name(member.name);
  const std::uint64_t offset = data_offset(file, member);
  std::uint32_t checksum = 0;
  ArrayBytes bytes;
  if (member.method == 0) {
    if (member.packed_bytes != member.size) throw damaged(file, fmt::format("'{}' has two sizes", name));
    for_each_piece(file, offset, member.size,
                   [&](const std::string& piece) { checksum = checksum_of(checksum, piece); });
    bytes = read_from(file, offset);
  } else if (member.method == Z_DEFLATED) {
    constexpr std::uint64_t most_packed = 1100;  // times: what deflate reaches is 1032
    if (member.size > left)
      throw Fault(FaultKind::input, "zip.size",
                  fmt::format("{}: '{}' expands to {} bytes, {} are allowed (--max-memory)", file.name(), name,
                              member.size, left));
    if (member.size / most_packed > member.packed_bytes)
      throw damaged(file, fmt::format("'{}' promises more than it can hold", name));
    left -= static_cast<std::size_t>(member.size);
    const auto data = std::make_shared<std::string>(static_cast<std::size_t>(member.size), '\0');
    Inflater inflater(*data);
    for_each_piece(file, offset, member.packed_bytes, [&](std::string& piece) { inflater.take(piece); });
    if (!inflater.is_whole()) throw damaged(file, fmt::format("'{}' is damaged", name));
    constexpr std::size_t piece_bytes = std::size_t{1} << 30;
    for (std::size_t at = 0; at < data->size(); at += piece_bytes)
      checksum = checksum_of(checksum, std::string_view(*data).substr(at, piece_bytes));
    bytes = [data](std::uint64_t at, std::size_t) { return data->data() + at; };
  } else {
    throw Fault(FaultKind::input, "container.unsupported",
                fmt::format("{}: '{}' is packed by method {}, which is not read. Save it with numpy.savez", file.name(),
                            name, member.method));
  }
  if (checksum != member.checksum) throw damaged(file, fmt::format("the checksum of '{}' is wrong", name));
  return std::make_shared<MemberBytes>(std::move(bytes), member.size);
}

}  // namespace dsp
