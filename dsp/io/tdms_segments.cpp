#include "dsp/io/tdms_segments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>

#include "dsp/fault.hpp"
#include "dsp/io/table_header.hpp"
#include "dsp/memory_limit.hpp"
#include "dsp/names.hpp"

namespace dsp {
namespace {

constexpr std::uint64_t lead_in_bytes = 28, unknown_offset = ~std::uint64_t{0};
constexpr std::uint32_t text_values = 0x20, time_values = 0x44;

enum SegmentContents : std::uint32_t {  // what a segment says it has
  has_metadata = 1U << 1,
  has_new_list = 1U << 2,
  has_raw_data = 1U << 3,
  is_interleaved = 1U << 5,
  is_big_endian = 1U << 6,
  has_daqmx = 1U << 7
};

const std::map<std::uint32_t, TdmsType>& tdms_types() {
  static const std::map<std::uint32_t, TdmsType> types{
      {0x01, {"int8", {'i', 1}, 1}},
      {0x02, {"int16", {'i', 2}, 2}},
      {0x03, {"int32", {'i', 4}, 4}},
      {0x04, {"int64", {'i', 8}, 8}},
      {0x05, {"uint8", {'u', 1}, 1}},
      {0x06, {"uint16", {'u', 2}, 2}},
      {0x07, {"uint32", {'u', 4}, 4}},
      {0x08, {"uint64", {'u', 8}, 8}},
      {0x09, {"single", {'f', 4}, 4}},
      {0x0a, {"double", {'f', 8}, 8}},
      {0x19, {"single", {'f', 4}, 4}},  // with a unit, which is a property
      {0x1a, {"double", {'f', 8}, 8}},
      {text_values, {"text", {'f', 0}, 0}},
      {0x21, {"logical", {'u', 1}, 1}},
      {time_values, {"time stamps", {'f', 0}, 16}},
      {0x08000c, {"complex single", {'f', 0}, 8}},
      {0x10000d, {"complex double", {'f', 0}, 16}},
  };
  return types;
}

/// Reads metadata up to their end, a piece at a time.
class MetadataBytes {
 public:
  MetadataBytes(const InputFile& file, std::uint64_t from, std::uint64_t to, bool is_big)
      : file_(file), at_(from), to_(to), is_big_(is_big) {}

  template <typename T>
  T number() {
    std::array<char, sizeof(T)> bytes{};
    take(bytes.data(), bytes.size());
    if (is_big_ == (std::endian::native == std::endian::little)) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<T>(bytes);
  }

  /// Beyond `most` bytes it is skipped and empty.
  std::string text(std::size_t most) {
    const auto size = number<std::uint32_t>();
    if (size > to_ - at_) throw damaged(fmt::format("a text of {} bytes goes beyond the metadata", size));
    std::string text(size > most ? 0 : size, '\0');
    if (size > most)
      at_ += size;
    else
      take(text.data(), text.size());
    return text;
  }

  void skip(std::uint64_t count) {
    if (count > to_ - at_) throw damaged("the metadata end too early");
    at_ += count;
  }

  [[nodiscard]] bool is_big() const { return is_big_; }
  [[nodiscard]] Fault damaged(const std::string& what) const {
    return Fault(FaultKind::input, "tdms.damaged",
                 fmt::format("{}: at byte {}: {}. Copy the file from its source again", file_.name(), at_, what));
  }

 private:
  void take(char* into, std::size_t count) {
    if (count > to_ - at_) throw damaged("the metadata end too early");
    if (at_ < begin_ || at_ + count > begin_ + piece_.size()) {
      constexpr std::size_t piece_bytes = std::size_t{1} << 16;
      begin_ = at_;
      piece_ =
          file_.text(at_, std::max(count, static_cast<std::size_t>(std::min<std::uint64_t>(piece_bytes, to_ - at_))));
      if (piece_.size() < count) throw damaged("the file became shorter while it was read");
    }
    std::memcpy(into, piece_.data() + (at_ - begin_), count);
    at_ += count;
  }

  const InputFile& file_;
  std::uint64_t at_, to_, begin_ = 0;
  std::string piece_;
  bool is_big_;
};

double property_number(std::uint32_t type, MetadataBytes& bytes) {
  switch (type) {
    case 0x01:
      return bytes.number<std::int8_t>();
    case 0x02:
      return bytes.number<std::int16_t>();
    case 0x03:
      return bytes.number<std::int32_t>();
    case 0x04:
      return static_cast<double>(bytes.number<std::int64_t>());
    case 0x05:
    case 0x21:
      return bytes.number<std::uint8_t>();
    case 0x06:
      return bytes.number<std::uint16_t>();
    case 0x07:
      return bytes.number<std::uint32_t>();
    case 0x08:
      return static_cast<double>(bytes.number<std::uint64_t>());
    case 0x09:
    case 0x19:
      return bytes.number<float>();
    default:
      return bytes.number<double>();
  }
}

// Seconds come first where the most significant byte does.
TdmsTime property_time(MetadataBytes& bytes) {
  TdmsTime time;
  if (bytes.is_big()) time.seconds = bytes.number<std::int64_t>();
  time.fraction = std::ldexp(static_cast<double>(bytes.number<std::uint64_t>()), -64);
  if (!bytes.is_big()) time.seconds = bytes.number<std::int64_t>();
  return time;
}

bool is_used_property(const std::string& property) {
  return property.starts_with("wf_") || property.starts_with("NI_Scal") || property == "unit_string" ||
         is_step_key(property);
}

// "/'group'/'channel'", in which a quotation mark is written twice. False where it is none.
bool parse_object_path(std::string_view path, TdmsObject& object) {
  std::vector<std::string> names;
  while (!path.empty() && path != "/") {
    if (!path.starts_with("/'")) return false;
    path.remove_prefix(2);
    std::string name;
    while (true) {
      const auto mark = path.find('\'');
      if (mark == path.npos) return false;
      name += path.substr(0, mark);
      path.remove_prefix(mark + 1);
      if (!path.starts_with('\'')) break;
      name += '\'';
      path.remove_prefix(1);
    }
    names.push_back(std::move(name));
  }
  if (names.size() > 2) return false;
  object.is_channel = names.size() == 2;
  if (!names.empty()) object.group = names[0];
  if (object.is_channel) object.name = names[1];
  return true;
}

class TdmsSegments {
 public:
  TdmsSegments(const InputFile& file, const OpenOptions& options)
      : file_(file), max_memory_bytes_(options.max_memory_bytes) {
    try {
      for (std::uint64_t at = 0; at < file_.size();) at = read_segment(at);
    } catch (const Cut& cut) {
      if (!options.salvage)
        throw Fault(FaultKind::input, "container.truncated",
                    fmt::format("{}: {}. Try --salvage to read what is whole before it", file_.name(), cut.what));
      contents_.cut = cut.what;
    }
  }
  TdmsContents take() { return std::move(contents_); }

 private:
  struct Cut {
    std::string what;
  };
  /// What an object has in a chunk; values that are no more than counted have a size alone.
  struct Index {
    std::uint32_t type = 0;
    std::uint64_t count = 0, bytes = 0;
  };
  struct Lead {
    std::uint32_t contents = 0;
    std::uint64_t raw_begin = 0, end = 0;
    bool is_whole = true;
    [[nodiscard]] bool has(SegmentContents what) const { return (contents & what) != 0; }
  };

  std::uint64_t read_segment(std::uint64_t at) {
    const Lead lead = read_lead(at);
    if (lead.has(has_metadata)) read_metadata(at, lead);
    if (lead.has(has_raw_data) && lead.end > lead.raw_begin) place_data(at, lead);
    if (!lead.is_whole)
      throw Cut{
          fmt::format("its last segment, at byte {}, is not whole: the recorder stopped or the file was cut", at)};
    return lead.end;
  }

  Lead read_lead(std::uint64_t at) {
    const std::string bytes = file_.text(at, lead_in_bytes);
    if (!bytes.starts_with("TDSm"))
      throw Cut{fmt::format("want the mark TDSm of a segment at byte {}, got {}", at,
                            file_.quoted(std::string_view(bytes).substr(0, 4)))};
    if (bytes.size() < lead_in_bytes) throw Cut{fmt::format("ends in the first bytes of a segment, at byte {}", at)};
    Lead lead;
    lead.contents = MetadataBytes(file_, at + 4, at + 8, false).number<std::uint32_t>();
    MetadataBytes offsets(file_, at + 12, at + lead_in_bytes, lead.has(is_big_endian));
    const auto next = offsets.number<std::uint64_t>(), raw = offsets.number<std::uint64_t>();
    const std::uint64_t begin = at + lead_in_bytes, left = file_.size() - begin;
    if (next != unknown_offset && raw > next) throw offsets.damaged("raw data begin behind the end of their segment");
    lead.is_whole = next <= left;
    lead.end = lead.is_whole ? begin + next : file_.size();
    if (raw > left) throw Cut{fmt::format("ends in the metadata of the segment at byte {}", at)};
    lead.raw_begin = begin + raw;
    if (lead.has(has_daqmx) && lead.has(has_raw_data)) throw daqmx();
    return lead;
  }

  [[nodiscard]] Fault daqmx() const {
    const std::string name = file_.path().filename().string();
    return Fault(FaultKind::input, "container.unsupported",
                 fmt::format("{}: raw data of DAQmx (the driver's own log) are not read. Make a table of it, with pip "
                             "install npTDMS pandas: python3 -c \"from nptdms import TdmsFile; "
                             "TdmsFile.read('{}').as_dataframe(time_index=True).to_csv('{}.csv', "
                             "index_label='time_s')\"",
                             file_.name(), clean_name(name), clean_name(name)));
  }

  void read_metadata(std::uint64_t at, const Lead& lead) {
    if (lead.has(has_new_list)) {
      for (const std::size_t one : active_) index_of_[one].is_active = false;
      active_.clear();
    }
    MetadataBytes bytes(file_, at + lead_in_bytes, lead.raw_begin, lead.has(is_big_endian));
    const auto count = bytes.number<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) read_object(bytes);
  }

  void read_object(MetadataBytes& bytes) {
    constexpr std::size_t longest_path = 1 << 16;
    const std::size_t which = find_object(bytes.text(longest_path), bytes);
    Placed& placed = index_of_[which];
    constexpr std::uint32_t none = 0xffffffff, same = 0, daqmx_changing = 0x1269, daqmx_digital = 0x1369;
    const auto kind = bytes.number<std::uint32_t>();
    if (kind == daqmx_changing || kind == daqmx_digital) throw daqmx();
    if (kind == same && !placed.has_index) throw bytes.damaged("an object has no earlier index to be like");
    if (kind != none && kind != same) {
      placed.index = read_index(bytes);
      placed.has_index = true;
    }
    placed.has_data = kind != none;
    if (placed.has_data && !placed.is_active) {
      placed.is_active = true;
      active_.push_back(which);
    }
    const auto count = bytes.number<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) read_property(contents_.objects[which], bytes);
  }

  std::size_t find_object(const std::string& path, const MetadataBytes& bytes) {
    const auto [found, is_new] = by_path_.try_emplace(path, contents_.objects.size());
    if (!is_new) return found->second;
    TdmsObject object;
    if (!parse_object_path(path, object))
      throw bytes.damaged(fmt::format("{} is no path of an object", file_.quoted(path)));
    constexpr std::size_t bytes_each = 500;  // of the object, its index and its places in maps
    claim(bytes_each + 3 * path.size());
    contents_.objects.push_back(std::move(object));
    index_of_.emplace_back();
    return found->second;
  }

  static Index read_index(MetadataBytes& bytes) {
    Index index;
    index.type = bytes.number<std::uint32_t>();
    const auto found = tdms_types().find(index.type);
    if (found == tdms_types().end())
      throw bytes.damaged(fmt::format("values of type 0x{:x} are not known", index.type));
    if (bytes.number<std::uint32_t>() != 1) throw bytes.damaged("values in more than one dimension are not known");
    index.count = bytes.number<std::uint64_t>();
    if (index.type == text_values)
      index.bytes = bytes.number<std::uint64_t>();
    else if (__builtin_mul_overflow(index.count, found->second.bytes, &index.bytes))
      throw bytes.damaged("more values than any file can hold");
    return index;
  }

  void read_property(TdmsObject& object, MetadataBytes& bytes) {
    constexpr std::size_t longest = 1 << 12;
    const std::string name = bytes.text(longest);
    const auto type = bytes.number<std::uint32_t>();
    const auto found = tdms_types().find(type);
    if (type != 0 && found == tdms_types().end())
      throw bytes.damaged(fmt::format("a property of type 0x{:x} is not known", type));
    TdmsValue value;
    if (type == text_values)
      value = bytes.text(longest);
    else if (type == time_values)
      value = property_time(bytes);
    else if (type != 0 && found->second.format.bytes > 0)
      value = property_number(type, bytes);
    else
      return bytes.skip(type == 0 ? 0 : found->second.bytes);
    if (!is_used_property(name)) return;
    constexpr std::size_t bytes_each = 200;
    const auto [place, is_new] = object.properties.insert_or_assign(name, std::move(value));
    if (is_new) claim(bytes_each + name.size() + longest * (type == text_values ? 1 : 0));
  }

  // Of memory, before it is taken or right behind it where it is little.
  void claim(std::size_t bytes) {
    claimed_bytes_ += bytes;
    require_memory(file_.name(), static_cast<double>(claimed_bytes_), max_memory_bytes_);
  }

  void place_data(std::uint64_t at, const Lead& lead) {
    const std::uint64_t raw_bytes = lead.end - lead.raw_begin;
    std::uint64_t chunk_bytes = 0, row_bytes = 0;
    for (const std::size_t one : active_) {
      const Placed& placed = index_of_[one];
      if (!placed.has_data || placed.index.bytes == 0) continue;
      if (__builtin_add_overflow(chunk_bytes, placed.index.bytes, &chunk_bytes)) chunk_bytes = unknown_offset;
      row_bytes += tdms_type(placed.index.type).bytes;
    }
    if (chunk_bytes == 0) return;
    if (lead.has(is_interleaved)) return place_rows(at, lead, row_bytes);
    const std::uint64_t num_chunks = raw_bytes / chunk_bytes, rest = raw_bytes % chunk_bytes;
    if (num_chunks > 0) place_chunks(lead, num_chunks, chunk_bytes);
    if (rest == 0) return;
    place_rest(lead, lead.end - rest, rest);
    throw Cut{fmt::format("ends in the values of its segment at byte {}", at)};
  }

  void place_chunks(const Lead& lead, std::uint64_t num_chunks, std::uint64_t chunk_bytes) {
    std::uint64_t offset = lead.raw_begin;
    for (const std::size_t one : active_) {
      const Placed& placed = index_of_[one];
      if (!placed.has_data || placed.index.bytes == 0) continue;
      add_run(one, {.offset = offset,
                    .count = placed.index.count,
                    .row_bytes = tdms_type(placed.index.type).bytes,
                    .num_chunks = num_chunks,
                    .chunk_step = chunk_bytes,
                    .is_big = lead.has(is_big_endian)});
      offset += placed.index.bytes;
    }
  }

  // Of a chunk that is cut the first rows, as far as all have them.
  void place_rest(const Lead& lead, std::uint64_t begin, std::uint64_t rest) {
    std::uint64_t count = unknown_offset, before = 0;
    for (const std::size_t one : active_) {
      const Placed& placed = index_of_[one];
      if (!placed.has_data || placed.index.bytes == 0) continue;
      const std::uint64_t each = tdms_type(placed.index.type).bytes;
      if (each == 0) return;
      count = std::min({count, placed.index.count, (rest - std::min(rest, before)) / each});
      before += std::min(placed.index.bytes, unknown_offset - before);
    }
    for (const std::size_t one : active_) {
      const Placed& placed = index_of_[one];
      if (!placed.has_data || placed.index.bytes == 0 || count == 0) continue;
      add_run(one, {.offset = begin,
                    .count = count,
                    .row_bytes = tdms_type(placed.index.type).bytes,
                    .num_chunks = 1,
                    .is_big = lead.has(is_big_endian)});
      begin += placed.index.bytes;
    }
  }

  void place_rows(std::uint64_t at, const Lead& lead, std::uint64_t row_bytes) {
    const std::uint64_t raw_bytes = lead.end - lead.raw_begin,
                        count = raw_bytes / std::max<std::uint64_t>(1, row_bytes);
    std::optional<std::uint64_t> promised;
    std::uint64_t offset = 0;
    for (const std::size_t one : active_) {
      const Placed& placed = index_of_[one];
      if (!placed.has_data || placed.index.bytes == 0) continue;
      const std::uint64_t each = tdms_type(placed.index.type).bytes;
      if (each == 0 || placed.index.count != promised.value_or(placed.index.count))
        throw MetadataBytes(file_, at, at, false).damaged("values in rows are text or of several lengths");
      promised = placed.index.count;
      if (count > 0)
        add_run(one, {.offset = lead.raw_begin,
                      .count = count,
                      .row_bytes = row_bytes,
                      .offset_in_row = offset,
                      .num_chunks = 1,
                      .is_big = lead.has(is_big_endian)});
      offset += each;
    }
    if (raw_bytes % row_bytes != 0) throw Cut{fmt::format("ends in the values of its segment at byte {}", at)};
  }

  // One with the last run where that is as the one before, at the same distance.
  void add_run(std::size_t which, TdmsRun run) {
    TdmsObject& object = contents_.objects[which];
    const std::uint32_t type = index_of_[which].index.type;
    object.has_several_types = object.has_several_types || (object.num_values > 0 && object.type != type);
    object.type = type;
    run.first_value = object.num_values;
    object.num_values += run.num_values();
    if (tdms_type(type).bytes == 0 || object.has_several_types) return;
    if (!object.runs.empty()) {
      TdmsRun& last = object.runs.back();
      const bool is_same = last.count == run.count && last.row_bytes == run.row_bytes &&
                           last.offset_in_row == run.offset_in_row && last.num_chunks == run.num_chunks &&
                           last.chunk_step == run.chunk_step && last.is_big == run.is_big;
      if (is_same && last.num_segments == 1) last.segment_step = run.offset - last.offset;
      if (is_same && run.offset == last.offset + last.num_segments * last.segment_step) {
        ++last.num_segments;
        return;
      }
    }
    claim(2 * sizeof(TdmsRun));  // of a list that grows
    object.runs.push_back(run);
  }

  struct Placed {
    Index index{};
    bool has_index = false, has_data = false, is_active = false;
  };

  const InputFile& file_;
  std::size_t max_memory_bytes_, claimed_bytes_ = 0;
  TdmsContents contents_;
  std::vector<Placed> index_of_;  // of each object
  std::vector<std::size_t> active_;
  std::map<std::string, std::size_t> by_path_;
};

}  // namespace

const TdmsType& tdms_type(std::uint32_t number) {
  return tdms_types().at(number);
}

TdmsContents read_tdms_segments(const InputFile& file, const OpenOptions& options) {
  return TdmsSegments(file, options).take();
}

}  // namespace dsp
