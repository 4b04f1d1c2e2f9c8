#include "dsp/io/recording_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "dsp/io/array_file.hpp"
#include "dsp/io/channel_roles.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

namespace fs = std::filesystem;

/// Whether messages may show what is in a file that a sidecar names: a sidecar may come from anybody, name any file of
/// this machine, also by a link, and messages get passed on. What lies in the recording's folder came with it.
bool may_be_quoted(const fs::path& file, const fs::path& recording) {
  std::error_code unknown;
  const fs::path folder =
                     fs::weakly_canonical(recording.parent_path().empty() ? "." : recording.parent_path(), unknown),
                 own = fs::weakly_canonical(file, unknown);
  return file == recording || std::mismatch(folder.begin(), folder.end(), own.begin(), own.end()).first == folder.end();
}

/// What a sidecar says of the clock of a file; `as_written` is how the sidecar's channels name it.
OpenOptions how_to_open(const fs::path& as_written, const Sidecar& sidecar, const ReadOptions& options) {
  OpenOptions how{.salvage = options.salvage, .max_memory_bytes = options.max_memory_bytes};
  for (const auto& channel : sidecar.channels)
    if (channel.role == Role::t && channel.file == as_written) {
      how.time_column = channel.index > 0        ? std::to_string(channel.index)
                        : channel.column.empty() ? channel.name
                                                 : channel.column;
      how.time_unit = channel.unit;
    } else if (channel.file == as_written) {
      how.signal_columns.push_back(channel.index > 0        ? std::to_string(channel.index)
                                   : channel.column.empty() ? channel.name
                                                            : channel.column);
    }
  how.rate_hz = sidecar.rate_hz;
  how.clock = sidecar.clock;
  how.header_row = sidecar.header_row;
  how.skip_rows = sidecar.skip_rows;
  how.run = options.run > 0 ? options.run : std::max(sidecar.run, 0);
  return how;
}

OpenFile opened(const fs::path& path, std::unique_ptr<SampleSource> source, bool may_be_quoted) {
  OpenFile file{path, clean_name(path.filename().string()), std::move(source), {}, may_be_quoted, {}, {}};
  const auto& info = file.source->info();
  for (int i = 0; i < static_cast<int>(info.columns.size()); ++i) {
    if (!info.named) file.called.push_back(fmt::format("channel{}", i + 1));
    if (i == info.time_column) continue;
    const auto& column = info.columns[static_cast<std::size_t>(i)];
    file.columns.emplace(column, i);
    file.columns.emplace(split_unit(column).base, i);
  }
  return file;
}

/// `with_clock` false: rows as they are, whatever their times.
OpenFile open_file(const fs::path& path, const fs::path& as_written, const fs::path& recording, const Sidecar& sidecar,
                   const ReadOptions& options, bool with_clock, int num_threads) {
  OpenOptions how = how_to_open(as_written, sidecar, options);
  how.with_clock = with_clock;
  how.may_be_quoted = may_be_quoted(path, recording);
  how.num_threads = num_threads;
  return opened(path, open_source(path, how), how.may_be_quoted);
}

}  // namespace

OpenFile open_in_memory(ArrayContents arrays, const Sidecar& sidecar, const ReadOptions& options) {
  for (const ChannelSpec& channel : sidecar.channels)
    if (!channel.file.empty())
      throw Fault(FaultKind::usage, "channel.file",
                  fmt::format("{}: channel '{}' is in a file, and the others in memory. Want arrays for all",
                              channel.place, channel.name));
  const fs::path name = arrays.name;
  return opened(name, open_arrays(nullptr, std::move(arrays), how_to_open({}, sidecar, options)), true);
}

std::vector<OpenFile> open_files(const fs::path& recording, const Sidecar& sidecar, const ReadOptions& options,
                                 Faults& faults) {
  const auto open = [&](bool with_clock) {
    std::vector<OpenFile> files;
    // One file has a further thread: they are read by turns, and their threads would be at work at the same time.
    const auto add = [&](const fs::path& path, const fs::path& as_written) {
      files.push_back(open_file(path, as_written, recording, sidecar, options, with_clock,
                                files.empty() ? options.num_threads : 1));
    };
    const bool used =
        sidecar.channels.empty() || std::any_of(sidecar.channels.begin(), sidecar.channels.end(),
                                                [](const ChannelSpec& channel) { return channel.file.empty(); });
    if (used) add(recording, "");
    for (const auto& channel : sidecar.channels) {
      const auto path = channel.file.empty() ? recording : recording.parent_path() / channel.file;
      const bool known = std::any_of(files.begin(), files.end(), [&](const OpenFile& one) { return one.path == path; });
      if (!known) add(path, channel.file);
    }
    return files;
  };
  try {
    return open(true);
  } catch (const Fault& fault) {
    if (!fault.name().starts_with("clock.")) throw;
    faults.add(fault);
  }
  return open(false);
}

std::vector<ChannelSpec> channels_of(const OpenFile& file) {
  const auto& info = file.source->info();
  std::vector<ChannelSpec> channels;
  for (int i = 0; i < static_cast<int>(info.columns.size()); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (i == info.time_column || (at < info.partial.size() && info.partial[at])) continue;
    ChannelSpec channel;
    channel.index = i + 1;
    channel.name = info.named ? split_unit(info.columns[at]).base : file.called[at];
    channel.place = file.name;
    try {
      channel.role = role_from_string(channel.name);
      channel.role_is_known = channel.role != Role::other;
    } catch (const std::invalid_argument&) {
    }
    if (channel.role == Role::t) {
      channel.role = Role::other;
      channel.role_is_known = false;
    }
    channels.push_back(std::move(channel));
  }
  leave_axes_open(channels, info);
  return channels;
}

int find_column(const ChannelSpec& channel, const OpenFile& file, int index_in_file) {
  const auto& info = file.source->info();
  const int count = static_cast<int>(info.columns.size());
  const auto& wanted = channel.column.empty() ? channel.name : channel.column;
  int found = -1;
  if (channel.index > 0) {
    found = channel.index - 1;
  } else if (channel.column.empty() && !info.named) {
    const auto own = std::find(file.called.begin(), file.called.end(), wanted);
    found = own == file.called.end() ? index_in_file : static_cast<int>(own - file.called.begin());
  } else {
    const auto known = file.columns.find(wanted);
    if (known == file.columns.end())
      throw Fault(
          FaultKind::input, "channel.column",
          fmt::format("{}: channel '{}': no column '{}' in {}; there are {}{}", channel.place, channel.name, wanted,
                      file.name,
                      !info.named           ? "no names, use index"
                      : !file.may_be_quoted ? fmt::format("{} others", count)
                                            : fmt::format("{}", fmt::join(info.columns, ", ")),
                      info.left_out.empty() ? "" : fmt::format("; no column is {}", fmt::join(info.left_out, ", "))));
    found = known->second;
  }
  if (found >= count || found == info.time_column)
    throw Fault(FaultKind::usage, "channel.index",
                fmt::format("{}: channel '{}': {} has {} columns, got index {}{}", channel.place, channel.name,
                            file.name, count, found + 1, found == info.time_column ? ", which is its clock" : ""));
  return found;
}

double agree_on_rate(const std::vector<OpenFile>& files, const Sidecar& sidecar) {
  std::optional<double> agreed = sidecar.rate_hz;
  std::string from = agreed ? "the sidecar" : "";
  for (const auto& file : files) {
    const double rate_hz = file.source->info().sample_rate_hz;
    if (rate_hz == 0) continue;
    if (!agreed) {
      agreed = rate_hz;
      from = file.name;
      continue;
    }
    const double difference_hz = std::abs(*agreed - rate_hz);
    const bool rounded = rate_hz == std::floor(rate_hz) && difference_hz < 1 && difference_hz < 1e-3 * rate_hz;
    if (difference_hz > 1e-6 * rate_hz && !(rounded && sidecar.rate_hz))
      throw Fault(FaultKind::input, "rate.mismatch",
                  fmt::format("{}: {} Hz, but {} says {} Hz. Correct the one that is wrong", file.name, rate_hz, from,
                              *agreed));
  }
  if (!agreed)
    throw Fault(FaultKind::input, "rate.missing",
                fmt::format("{}: holds no time and no rate. Its rate is to stand at the top of {}:", files[0].name,
                            sidecar_path(files[0].name).string()),
                fmt::format("{}\n", rate_line));
  return *agreed;
}

std::int64_t agree_on_length(const std::vector<OpenFile>& files, bool salvage, std::vector<Check>& checks) {
  std::int64_t shortest = files[0].source->info().num_frames;
  for (const auto& file : files) {
    const auto frames = file.source->info().num_frames;
    if (frames == shortest) continue;
    const auto message = fmt::format("{} has {} frames, {} has {}", files[0].name, files[0].source->info().num_frames,
                                     file.name, frames);
    if (!salvage)
      throw Fault(FaultKind::input, "channel.length",
                  message + ". Try --salvage to use what they share from the start");
    shortest = std::min(shortest, frames);
    checks.push_back({"channel.length", "", CheckStatus::warning, static_cast<double>(shortest), 0.0,
                      fmt::format("{}; the first {} were used", message, shortest)});
  }
  if (shortest == 0) throw Fault(FaultKind::input, "recording.empty", fmt::format("{}: no samples", files[0].name));
  return shortest;
}

double late_start_s(const OpenFile& file, const ClockStart& start, double rate_hz) {
  constexpr double least_steps = 0.01;  // what a clock may tremble by
  const double late_s = start.until(file.source->info().clock_start);
  return file.source->info().time_column >= 0 && std::abs(late_s) * rate_hz > least_steps ? late_s : 0.0;
}

ClockStart agree_on_start(const std::vector<OpenFile>& files, double rate_hz, std::vector<Check>& checks) {
  const OpenFile* first = nullptr;
  for (const auto& file : files) {
    const auto& info = file.source->info();
    if (info.time_column < 0) continue;
    if (first == nullptr) first = &file;
    const ClockStart& start = first->source->info().clock_start;
    const double late_s = late_start_s(file, start, rate_hz);
    if (late_s == 0) continue;
    const auto message = fmt::format("{}: starts at {}, {} at {}", file.name, to_string(info.clock_start), first->name,
                                     to_string(start));
    if (std::abs(late_s) * rate_hz > 0.5)
      throw Fault(FaultKind::input, "clock.start",
                  message + ", which is more than half a sample. Cut the files to one beginning");
    checks.push_back({"clock.start", "", CheckStatus::warning, late_s, 0.5 / rate_hz,
                      fmt::format("{}; its channels are shifted by {:.3g} of a sample", message, late_s * rate_hz)});
  }
  return first == nullptr ? ClockStart() : first->source->info().clock_start;
}

}  // namespace dsp
