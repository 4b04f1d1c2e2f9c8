#include "dsp/io/tdms_segments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <numeric>
#include <string_view>

#include "dsp/io/foreign_file.hpp"
#include "dsp/io/table_header.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/memory_limit.hpp"

namespace dsp {
namespace {

constexpr std::uint64_t lead_in_bytes = 28, unknown_offset = ~std::uint64_t{0};

enum SegmentContents : std::uint32_t {  // what a segment says it has
  has_metadata = 1U << 1,
  has_new_list = 1U << 2,
  has_raw_data = 1U << 3,
  is_interleaved = 1U << 5,
  is_big_endian = 1U << 6,
  has_daqmx = 1U << 7
};

bool is_used_property(const std::string& property) {
  return property.starts_with("wf_") || property.starts_with("NI_Scal") || property == "unit_string" ||
         rate_name(property);
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
    std::vector<std::uint32_t> widths{};          // of a row in each buffer of DAQmx; none: it is not of that
    std::uint32_t buffer = 0, offset_in_row = 0;  // where the value is in them
    bool is_one = true;                           // not several raw values for one
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
    lead.contents = TdmsBytes(file_, at + 4, at + 8, false).number<std::uint32_t>();
    TdmsBytes offsets(file_, at + 12, at + lead_in_bytes, lead.has(is_big_endian));
    const auto next = offsets.number<std::uint64_t>(), raw = offsets.number<std::uint64_t>();
    const std::uint64_t begin = at + lead_in_bytes, left = file_.size() - begin;
    if (next != unknown_offset && raw > next) throw offsets.damaged("raw data begin behind the end of their segment");
    lead.is_whole = next <= left;
    lead.end = lead.is_whole ? begin + next : file_.size();
    if (raw > left) throw Cut{fmt::format("ends in the metadata of the segment at byte {}", at)};
    lead.raw_begin = begin + raw;
    return lead;
  }

  [[nodiscard]] Fault daqmx() const {
    const std::string path = path_to_paste(file_);
    return Fault(
        FaultKind::input, "container.unsupported",
        fmt::format("{}: digital lines of DAQmx (the driver's own log) are not read. Make a table of it, with pip "
                    "install npTDMS pandas: python3 -c \"from nptdms import TdmsFile; "
                    "TdmsFile.read('{}').as_dataframe(time_index=True).to_csv('{}.csv', "
                    "index_label='time_s')\"",
                    file_.name(), path, path));
  }

  void read_metadata(std::uint64_t at, const Lead& lead) {
    if (lead.has(has_new_list)) {
      for (const std::size_t one : active_) index_of_[one].is_active = false;
      active_.clear();
    }
    TdmsBytes bytes(file_, at + lead_in_bytes, lead.raw_begin, lead.has(is_big_endian));
    const auto count = bytes.number<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) read_object(bytes);
  }

  void read_object(TdmsBytes& bytes) {
    constexpr std::size_t longest_path = 1 << 16;
    const std::size_t which = find_object(bytes.text(longest_path), bytes);
    Placed& placed = index_of_[which];
    constexpr std::uint32_t none = 0xffffffff, same = 0, daqmx_samples = 0x1269, daqmx_digital = 0x1369;
    const auto kind = bytes.number<std::uint32_t>();
    if (kind == daqmx_digital) throw daqmx();
    if (kind == same && !placed.has_index) throw bytes.damaged("an object has no earlier index to be like");
    if (kind != none && kind != same) {
      placed.index = kind == daqmx_samples ? read_daqmx_index(bytes) : read_index(bytes);
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

  std::size_t find_object(const std::string& path, const TdmsBytes& bytes) {
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

  static Index read_index(TdmsBytes& bytes) {
    Index index;
    index.type = bytes.number<std::uint32_t>();
    const TdmsType* const type = find_tdms_type(index.type);
    if (type == nullptr) throw bytes.damaged(fmt::format("values of type 0x{:x} are not known", index.type));
    if (bytes.number<std::uint32_t>() != 1) throw bytes.damaged("values in more than one dimension are not known");
    index.count = bytes.number<std::uint64_t>();
    if (index.type == tdms_text_type)
      index.bytes = bytes.number<std::uint64_t>();
    else if (__builtin_mul_overflow(index.count, type->bytes, &index.bytes))
      throw bytes.damaged("more values than any file can hold");
    return index;
  }

  // As the driver of the hardware writes it: rows of several channels, in one buffer or more.
  Index read_daqmx_index(TdmsBytes& bytes) {
    static constexpr std::array<std::uint32_t, 6> types{0x05, 0x01, 0x06, 0x02, 0x07, 0x03};  // its own numbers of them
    (void)bytes.number<std::uint32_t>();                                                      // no type of TDMS
    if (bytes.number<std::uint32_t>() != 1) throw bytes.damaged("values in more than one dimension are not known");
    Index index;
    index.count = bytes.number<std::uint64_t>();
    const auto num_scalers = bytes.number<std::uint32_t>();
    index.is_one = num_scalers == 1;
    for (std::uint32_t i = 0; i < num_scalers; ++i) {
      const auto type = bytes.number<std::uint32_t>();
      if (type >= types.size()) throw bytes.damaged(fmt::format("raw data of DAQmx of type {} are not known", type));
      index.type = types[type];
      index.buffer = bytes.number<std::uint32_t>();
      index.offset_in_row = bytes.number<std::uint32_t>();
      bytes.skip(2 * sizeof(std::uint32_t));  // format of samples, number of the scale
    }
    const auto num_widths = bytes.number<std::uint32_t>();
    for (std::uint32_t i = 0; i < num_widths; ++i) {
      claim(2 * sizeof(std::uint32_t));
      index.widths.push_back(bytes.number<std::uint32_t>());
    }
    const bool is_inside = num_scalers > 0 && index.buffer < num_widths &&
                           index.offset_in_row + bytes_of(index) <= index.widths[index.buffer];
    if (!is_inside || __builtin_mul_overflow(index.count, row_bytes_of(index), &index.bytes))
      throw bytes.damaged("raw data of DAQmx are not where their index says");
    return index;
  }

  static std::uint64_t bytes_of(const Index& index) { return find_tdms_type(index.type)->bytes; }
  static std::uint64_t row_bytes_of(const Index& index) {
    return std::accumulate(index.widths.begin(), index.widths.end(), std::uint64_t{0});
  }

  void read_property(TdmsObject& object, TdmsBytes& bytes) {
    constexpr std::size_t longest = 1 << 12;
    const std::string name = bytes.text(longest);
    const auto number = bytes.number<std::uint32_t>();
    const TdmsType* const type = find_tdms_type(number);
    if (number == 0) return;  // nothing
    if (type == nullptr) throw bytes.damaged(fmt::format("a property of type 0x{:x} is not known", number));
    TdmsValue value = bytes.value(*type, longest);
    if (!is_used_property(name)) return;
    constexpr std::size_t bytes_each = 200;
    const auto [place, is_new] = object.properties.insert_or_assign(name, std::move(value));
    if (is_new) claim(bytes_each + name.size() + longest * (number == tdms_text_type ? 1 : 0));
  }

  // Of memory, before it is taken or right behind it where it is little.
  void claim(std::size_t bytes) {
    claimed_bytes_ += bytes;
    require_memory(file_.name(), static_cast<double>(claimed_bytes_), max_memory_bytes_);
  }

  void place_data(std::uint64_t at, const Lead& lead) {
    placed_.clear();
    std::copy_if(active_.begin(), active_.end(), std::back_inserter(placed_),
                 [this](std::size_t one) { return index_of_[one].has_data && index_of_[one].index.bytes > 0; });
    if (placed_.empty()) return;
    if (lead.has(has_daqmx)) return place_daqmx(at, lead);
    const std::uint64_t raw_bytes = lead.end - lead.raw_begin;
    std::uint64_t chunk_bytes = 0, row_bytes = 0;
    for (const std::size_t one : placed_) {
      const Index& index = index_of_[one].index;
      if (!index.widths.empty())
        throw TdmsBytes(file_, at, at, false).damaged("raw data of DAQmx in a segment that has none");
      if (__builtin_add_overflow(chunk_bytes, index.bytes, &chunk_bytes)) chunk_bytes = unknown_offset;
      row_bytes += bytes_of(index);
    }
    if (lead.has(is_interleaved)) return place_rows(at, lead, row_bytes);
    const std::uint64_t num_chunks = raw_bytes / chunk_bytes, rest = raw_bytes % chunk_bytes;
    if (num_chunks > 0) place_chunks(lead, num_chunks, chunk_bytes);
    if (rest == 0) return;
    place_rest(lead, lead.end - rest, rest);
    throw Cut{fmt::format("ends in the values of its segment at byte {}", at)};
  }

  void place_chunks(const Lead& lead, std::uint64_t num_chunks, std::uint64_t chunk_bytes) {
    std::uint64_t offset = lead.raw_begin;
    for (const std::size_t one : placed_) {
      const Index& index = index_of_[one].index;
      add_run(one, {.offset = offset,
                    .count = index.count,
                    .row_bytes = bytes_of(index),
                    .num_chunks = num_chunks,
                    .chunk_step = chunk_bytes,
                    .is_big = lead.has(is_big_endian)});
      offset += index.bytes;
    }
  }

  // Of a chunk that is cut the first rows, as far as all have them.
  void place_rest(const Lead& lead, std::uint64_t begin, std::uint64_t rest) {
    std::uint64_t count = unknown_offset, before = 0;
    for (const std::size_t one : placed_) {
      const Index& index = index_of_[one].index;
      const std::uint64_t each = bytes_of(index);
      if (each == 0) return;
      count = std::min({count, index.count, (rest - std::min(rest, before)) / each});
      before += std::min(index.bytes, unknown_offset - before);
    }
    for (const std::size_t one : placed_) {
      if (count == 0) return;
      const Index& index = index_of_[one].index;
      add_run(one, {.offset = begin,
                    .count = count,
                    .row_bytes = bytes_of(index),
                    .num_chunks = 1,
                    .is_big = lead.has(is_big_endian)});
      begin += index.bytes;
    }
  }

  void place_rows(std::uint64_t at, const Lead& lead, std::uint64_t row_bytes) {
    const std::uint64_t raw_bytes = lead.end - lead.raw_begin,
                        count = raw_bytes / std::max<std::uint64_t>(1, row_bytes);
    std::uint64_t offset = 0;
    for (const std::size_t one : placed_) {
      const Index& index = index_of_[one].index;
      const std::uint64_t each = bytes_of(index);
      if (each == 0 || index.count != index_of_[placed_.front()].index.count)
        throw TdmsBytes(file_, at, at, false).damaged("values in rows are text or of several lengths");
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

  // All channels have the same buffers; rows of a single one go on from chunk to chunk.
  void place_daqmx(std::uint64_t at, const Lead& lead) {
    const Index* const first = &index_of_[placed_.front()].index;
    const std::uint64_t raw_bytes = lead.end - lead.raw_begin;
    const bool is_single = first->widths.size() == 1;
    const std::uint64_t step = is_single ? row_bytes_of(*first) : first->bytes;
    const TdmsRun run{.count = is_single ? raw_bytes / step : first->count,
                      .num_chunks = is_single ? 1 : raw_bytes / step,
                      .chunk_step = is_single ? 0 : step,
                      .is_big = lead.has(is_big_endian)};
    for (const std::size_t one : placed_) {
      const Index& index = index_of_[one].index;
      if (index.widths.empty() || index.widths != first->widths || index.count != first->count)
        throw TdmsBytes(file_, at, at, false).damaged("channels differ in their buffers of DAQmx");
      if (run.num_values() > 0) add_run(one, in_buffer(index, lead.raw_begin, run));
    }
    if (raw_bytes % step != 0) throw Cut{fmt::format("ends in the values of its segment at byte {}", at)};
  }

  static TdmsRun in_buffer(const Index& index, std::uint64_t begin, TdmsRun run) {
    run.offset = begin;
    for (std::uint32_t i = 0; i < index.buffer; ++i) run.offset += run.count * index.widths[i];
    run.row_bytes = index.widths[index.buffer];
    run.offset_in_row = index.offset_in_row;
    return run;
  }

  // One with the last run where that is as the one before, at the same distance.
  void add_run(std::size_t which, TdmsRun run) {
    TdmsObject& object = contents_.objects[which];
    const std::uint32_t type = index_of_[which].index.type;
    object.has_several_types =
        object.has_several_types || !index_of_[which].index.is_one || (object.num_values > 0 && object.type != type);
    object.type = type;
    run.first_value = object.num_values;
    object.num_values += run.num_values();
    if (type == tdms_text_type || object.has_several_types) return;
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
  std::vector<Placed> index_of_;              // of each object
  std::vector<std::size_t> active_, placed_;  // in order; those with values in the segment at hand
  std::map<std::string, std::size_t> by_path_;
};

}  // namespace

TdmsContents read_tdms_segments(const InputFile& file, const OpenOptions& options) {
  return TdmsSegments(file, options).take();
}

}  // namespace dsp
