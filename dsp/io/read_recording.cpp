#include "dsp/io/read_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <unordered_map>
#include <unordered_set>

#include "dsp/filter/dispatch.hpp"
#include "dsp/filter/lanes.hpp"
#include "dsp/io/array_file.hpp"
#include "dsp/io/calibrate.hpp"
#include "dsp/io/channel_bodies.hpp"
#include "dsp/io/channel_roles.hpp"
#include "dsp/io/recording_files.hpp"
#include "dsp/samples/bridge_gaps.hpp"
#include "dsp/samples/isolated_values.hpp"
#include "dsp/values/faults.hpp"
#include "dsp/values/memory_limit.hpp"
#include "dsp/values/names.hpp"
#include "dsp/values/set_shape.hpp"

namespace dsp {
namespace {

namespace fs = std::filesystem;

// Where a channel comes from and what makes it SI.
struct Pick {
  std::size_t file = 0;
  int column = 0;
  double scale = 1.0, shift = 0.0;
};

Sidecar find_sidecar(const fs::path& recording, const ReadOptions& options) {
  if (!options.sidecar.empty()) return read_sidecar(options.sidecar);
  std::error_code error;
  const auto beside = sidecar_path(recording);
  return fs::exists(beside, error) ? read_sidecar(beside) : Sidecar{};
}

// `use` gives roles by name and takes them from whoever else claims them.
void assign_roles(std::vector<Channel>& channels, const ReadOptions& options, const std::string& recording) {
  for (const auto& [role_name, wanted] : options.use) {
    Role role = Role::other;
    try {
      role = role_from_string(role_name);
    } catch (const std::invalid_argument& error) {
      throw Fault(FaultKind::usage, "channel.role", fmt::format("use {}={}: {}", role_name, wanted, error.what()));
    }
    const auto found = std::find_if(channels.begin(), channels.end(),
                                    [&, &name = wanted](const Channel& channel) { return channel.name == name; });
    if (found == channels.end()) {
      std::vector<std::string> names;
      for (const auto& channel : channels) names.push_back(channel.name);
      throw Fault(FaultKind::usage, "channel.name",
                  fmt::format("use {}={}: {} has no such channel, only {}", role_name, clean_name(wanted), recording,
                              fmt::join(names, ", ")));
    }
    for (auto& channel : channels)
      if (channel.role == role) channel.role = Role::other;
    found->role = role;
  }
  std::unordered_set<std::string_view> names;
  std::map<std::pair<Role, int>, std::string> players;
  for (const auto& channel : channels) {
    const auto role = channel.role;
    if (!fits(role, channel.unit) && channel.calibrated)
      throw Fault(FaultKind::usage, "unit.role",
                  fmt::format("{}: channel '{}' is in {}, which fits role {}; role {} is measured in {}", recording,
                              channel.name, channel.unit, roles_in(channel.unit), to_string(role), si_unit(role)));
    if (!names.insert(channel.name).second)
      throw Fault(
          FaultKind::usage, "channel.name",
          fmt::format("{}: two channels are called '{}'. Name them apart in a sidecar", recording, channel.name));
    if (role == Role::other) continue;
    if (const auto [player, is_free] = players.emplace(std::pair(role, channel.body), channel.name); !is_free)
      throw Fault(
          FaultKind::usage, "channel.role",
          fmt::format("{}: channels '{}' and '{}' both have role {}. Choose one: use = {{ {} = \"{}\" }}", recording,
                      player->second, channel.name, to_string(role), to_string(role), player->second));
  }
}

Check note(std::string name, std::string channel, std::string message) {
  return {std::move(name), std::move(channel), CheckStatus::note, 0.0, 0.0, std::move(message)};
}

// Rounded twice, as everywhere else, also where the processor could do both at once (see CMakeLists.txt).
ARDENT_DISPATCH void scale_and_shift(double* values, Eigen::Index count, const double* scale, const double* shift) {
  Eigen::Index i = 0;
  for (; i + 4 <= count; i += 4)
    *reinterpret_cast<UnalignedLanes*>(values + i) =
        *reinterpret_cast<const UnalignedLanes*>(values + i) * *reinterpret_cast<const UnalignedLanes*>(scale + i) +
        *reinterpret_cast<const UnalignedLanes*>(shift + i);
  for (; i < count; ++i) values[i] = values[i] * scale[i] + shift[i];
}

// Before the roles of channels are settled: where this channel's stands, if in a file.
void require_role(const ChannelSpec& channel, const Calibration& calibration) {
  if (!calibration.calibrated || !calibration.missing.empty() || fits(channel.role, calibration.unit)) return;
  throw Fault(FaultKind::usage, "unit.role",
              fmt::format("{}: channel '{}' is in {}, which fits role {}; role {} is measured in {}", channel.place,
                          channel.name, calibration.unit, roles_in(calibration.unit), to_string(channel.role),
                          si_unit(channel.role)));
}

// What 1.0 in the file is worth is not known: the lines that would say so, under the channel they belong to.
std::string lines_to_add(const ChannelSpec& channel, const Calibration& calibration, bool in_sidecar) {
  if (in_sidecar) return fmt::format("# {}: channel {}\n{}", channel.place, channel.name, calibration.missing);
  const auto role = channel.role == Role::other ? fmt::format("# role = \"y\"  # {}\n", role_choices)
                                                : fmt::format("role = \"{}\"\n", to_string(channel.role));
  return fmt::format("[[channel]]\nname = {}\nindex = {}\n{}{}", toml_quoted(channel.name), channel.index, role,
                     calibration.missing);
}

}  // namespace

struct RecordingReader::State {
  Recording description;
  Sidecar sidecar;
  std::string container;
  std::vector<fs::path> paths;
  std::vector<OpenFile> files;
  std::vector<Pick> picks;
  std::int64_t num_frames = 0, num_read = 0;
  std::optional<IsolatedValues> isolated;  // these two are none where nothing can be missing
  std::optional<GapBridge> bridge;
  ClockStart start;  // of the first clock among the files
  bool ended = false, is_straight = false, source_calibrates = false;

  void calibrate_channels(const fs::path& recording, const ReadOptions& options) {
    const bool described = std::any_of(sidecar.channels.begin(), sidecar.channels.end(),
                                       [](const ChannelSpec& channel) { return channel.role != Role::t; });
    const auto channels = described ? sidecar.channels : channels_of(files[0]);
    std::vector<int> next_index(files.size(), 0);
    std::vector<std::unordered_map<int, std::string>> taken(files.size());  // column -> channel
    std::string missing, names;
    std::vector<bool> role_is_known;
    Faults faults;
    const auto add = [&](const ChannelSpec& channel) {
      const auto path = channel.file.empty() ? recording : recording.parent_path() / channel.file;
      Pick pick;
      while (files[pick.file].path != path) ++pick.file;
      pick.column = find_column(channel, files[pick.file], next_index[pick.file]++);
      if (const auto [other, is_free] = taken[pick.file].emplace(pick.column, channel.name); !is_free)
        throw Fault(
            FaultKind::usage, "channel.index",
            fmt::format("{}: channels '{}' and '{}' both are column {} of {}. Give one of them another index or "
                        "column",
                        channel.place, other->second, channel.name, pick.column + 1, files[pick.file].name));
      auto calibration = calibrate(channel, files[pick.file].source->info(), pick.column);
      require_role(channel, calibration);
      if (!calibration.missing.empty() && !options.uncalibrated) {
        missing += lines_to_add(channel, calibration, described);
        names += (names.empty() ? "" : ", ") + channel.name;
      }
      if (!calibration.missing.empty()) calibration = {.scale = channel.sign, .unit = "", .calibrated = false};
      if (!calibration.calibrated)
        description.checks.push_back({"calibration.missing", channel.name, CheckStatus::warning, 0.0, 0.0,
                                      "not calibrated: its numbers are raw, as they are in the file"});
      if (!calibration.remark.empty())
        description.checks.push_back(note("calibration", channel.name, calibration.remark));
      pick.scale = calibration.scale;
      pick.shift = calibration.shift;
      picks.push_back(pick);
      // A file that begins late holds samples that are ahead of the clock.
      const double late_s = late_start_s(files[pick.file], start, description.sample_rate_hz);
      role_is_known.push_back(channel.role_is_known);
      description.channels.push_back({channel.name, channel.role, calibration.unit, channel.delay_s - late_s,
                                      channel.highpass_hz, calibration.calibrated, channel.sensitivity_uncertainty,
                                      measured(channel.range, channel), measured(channel.drift, channel),
                                      calibration.unit_is_assumed, channel.body});
    };
    for (const auto& channel : channels)
      if (channel.role != Role::t) faults.attempt([&] { add(channel); });
    faults.raise();
    if (!missing.empty())
      throw Fault(FaultKind::input, "calibration.missing",
                  fmt::format("{}: no calibration for {}. Add to {} (or read raw numbers with --uncalibrated):",
                              description.name, names,
                              clean_name((sidecar.file.empty() ? sidecar_path(recording) : sidecar.file).string())),
                  missing);
    for (Check& check : assume_bodies(description.channels, role_is_known))
      description.checks.push_back(std::move(check));
    for (Check& check : assume_roles(description.channels, role_is_known, options.use))
      description.checks.push_back(std::move(check));
    if (!picks.empty()) return;
    std::vector<std::string> left_out;
    for (const auto& file : files)
      left_out.insert(left_out.end(), file.source->info().left_out.begin(), file.source->info().left_out.end());
    throw Fault(FaultKind::input, "recording.empty",
                fmt::format("{}: no channel but the clock{}", description.name,
                            left_out.empty() ? ". Want a column of numbers beside it"
                                             : fmt::format("; no column is {}. Want real vectors "
                                                           "(n x 1) as long as it, best called like signals (x, y, r, "
                                                           "ddy, f) or named in a sidecar",
                                                           fmt::join(left_out, ", "))));
  }

  // Whether one file's columns are the channels as they are.
  bool straight() const {
    if (files.size() > 1 || files[0].source->info().columns.size() != picks.size()) return false;
    for (std::size_t c = 0; c < picks.size(); ++c)
      if (picks[c].column != static_cast<int>(c)) return false;
    return true;
  }

  // Whether the file's source does it on its way.
  bool calibrated_by_source() const {
    Eigen::VectorXd scales(std::ssize(picks)), shifts(std::ssize(picks));
    for (Eigen::Index c = 0; c < scales.size(); ++c) {
      scales(c) = picks[static_cast<std::size_t>(c)].scale;
      shifts(c) = picks[static_cast<std::size_t>(c)].shift;
    }
    return files[0].source->calibrate(scales, shifts);
  }

  // In place, many frames at a time: this pass is a quarter of reading a long record.
  void calibrate_straight(FrameBlock& block) const {
    constexpr Eigen::Index batch = 64;
    const auto width = static_cast<Eigen::Index>(picks.size());
    Eigen::ArrayXd scale(batch * width), shift(batch * width);
    for (Eigen::Index i = 0; i < scale.size(); ++i) {
      scale(i) = picks[static_cast<std::size_t>(i % width)].scale;
      shift(i) = picks[static_cast<std::size_t>(i % width)].shift;
    }
    for (Eigen::Index first = 0; first < block.size(); first += scale.size()) {
      const auto count = std::min(scale.size(), block.size() - first);
      scale_and_shift(block.data() + first, count, scale.data(), shift.data());
    }
  }

  // The next calibrated frames, what is missing still NaN.
  Eigen::Index read_calibrated(FrameBlock& block, Eigen::Index max_frames) {
    const auto count = static_cast<Eigen::Index>(std::min<std::int64_t>(max_frames, num_frames - num_read));
    for (auto& file : files) (void)file.source->read(file.block, std::max<Eigen::Index>(count, 1));
    num_read += count;
    if (is_straight) {
      block.swap(files[0].block);
      block.conservativeResize(count, Eigen::NoChange);
      if (!source_calibrates) calibrate_straight(block);
      return count;
    }
    const auto width = static_cast<Eigen::Index>(picks.size());
    set_shape(block, count, width);
    if (count == 0) return 0;  // the blocks of the files are empty: there is nothing to point into
    for (Eigen::Index c = 0; c < width; ++c) {
      const auto& pick = picks[static_cast<std::size_t>(c)];
      const auto& raw = files[pick.file].block;
      const double* from = raw.data() + pick.column;
      double* to = block.data() + c;
      for (Eigen::Index i = 0; i < count; ++i, from += raw.cols(), to += width) *to = *from * pick.scale + pick.shift;
    }
    return count;
  }

  // Everything between open files and the first frame.
  void begin(const fs::path& file, const ReadOptions& options, Faults& faults) {
    const bool has_rate =
        faults.empty() && faults.attempt([&] { description.sample_rate_hz = agree_on_rate(files, sidecar); });
    faults.attempt([&] {
      num_frames = agree_on_length(files, options.salvage, description.checks);
      start = agree_on_start(files, description.sample_rate_hz, description.checks);
      description.clock_start_s = start.s;
    });
    description.bad = sidecar.bad;
    bool all_scaled = true;
    for (const auto& opened : files) {
      const auto& info = opened.source->info();
      description.bad.insert(description.bad.end(), info.gaps.begin(), info.gaps.end());
      description.checks.insert(description.checks.end(), info.checks.begin(), info.checks.end());
      container += (container.empty() ? "" : " + ") + info.container;
      paths.push_back(opened.path);
      all_scaled = all_scaled && info.scaled;
    }
    faults.attempt([&] {
      calibrate_channels(file, options);
      assign_roles(description.channels, options, description.name);
      if (!any_motion(description.channels))
        if (const std::optional<Fault> question = bodies_question(description.name, description.channels))
          throw *question;
      if (!has_rate && !any_motion(description.channels)) throw no_motion(description.name, description.channels);
    });
    faults.raise();
    is_straight = straight();
    source_calibrates = is_straight && calibrated_by_source();
    if (all_scaled) return;
    BridgeOptions gaps{description.name, {}, description.sample_rate_hz, options.max_memory_bytes};
    for (const auto& channel : description.channels) gaps.channels.push_back(channel.name);
    isolated.emplace(description.channels, description.sample_rate_hz);
    bridge.emplace(std::move(gaps));
  }

  void finish() {
    ended = true;
    if (!bridge) return;
    bridge->push(isolated->finish());
    bridge->finish();
    for (Check& check : isolated->checks()) description.checks.push_back(std::move(check));
    description.bad.insert(description.bad.end(), bridge->bridged().begin(), bridge->bridged().end());
    const auto checks = bridge->checks();
    description.checks.insert(description.checks.end(), checks.begin(), checks.end());
  }
};

RecordingReader::RecordingReader(const fs::path& file, const ReadOptions& options) : state_(std::make_unique<State>()) {
  state_->description.name = clean_name(file.filename().string());
  state_->sidecar = find_sidecar(file, options);
  Faults faults;
  state_->files = open_files(file, state_->sidecar, options, faults);
  state_->begin(file, options, faults);
}

RecordingReader::RecordingReader(ArrayContents arrays, const Sidecar& sidecar, const ReadOptions& options)
    : state_(std::make_unique<State>()) {
  if (!options.sidecar.empty() || options.salvage || options.run != 0)
    throw std::invalid_argument("RecordingReader: sidecar, salvage and run are of files, and these are arrays");
  const std::string name = arrays.name;
  state_->description.name = clean_name(name);
  state_->sidecar = sidecar;
  state_->files.push_back(open_in_memory(std::move(arrays), sidecar, options));
  Faults faults;
  state_->begin(name, options, faults);
}

RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;

const Recording& RecordingReader::description() const& {
  return state_->description;
}
const Sidecar& RecordingReader::sidecar() const& {
  return state_->sidecar;
}
const std::string& RecordingReader::container() const& {
  return state_->container;
}
const std::vector<fs::path>& RecordingReader::files() const& {
  return state_->paths;
}
std::int64_t RecordingReader::num_frames() const {
  return state_->num_frames;
}

Eigen::Index RecordingReader::read(FrameBlock& block, Eigen::Index max_frames) {
  if (max_frames < 1) throw std::invalid_argument("RecordingReader::read: max_frames must be at least 1");
  auto& state = *state_;
  constexpr Eigen::Index most_values = Eigen::Index{1} << 20;  // 8 MB, however many channels there are
  const auto width = static_cast<Eigen::Index>(state.picks.size());
  max_frames = std::min(max_frames, std::max<Eigen::Index>(most_values / width, 1));
  if (!state.bridge) {
    const auto count = state.read_calibrated(block, max_frames);
    if (count == 0 && !state.ended) state.finish();
    return count;
  }
  while (!state.ended && state.bridge->num_ready() < max_frames) {
    FrameBlock frames;
    if (state.read_calibrated(frames, max_frames) == 0)
      state.finish();
    else
      state.bridge->push(state.isolated->push(frames));
  }
  return state.bridge->take(block, max_frames);
}

void RecordingReader::set_bytes_beside(double bytes) {
  if (state_->bridge) state_->bridge->set_bytes_beside(bytes);
}

Eigen::Index RecordingReader::skip(Eigen::Index num_frames) {
  auto& state = *state_;
  Eigen::Index skipped = 0;
  if (state.bridge) {  // what is missing there decides how the next gap is filled
    constexpr Eigen::Index block_frames = 16384;
    FrameBlock block;
    while (skipped < num_frames) {
      const Eigen::Index count = read(block, std::min(block_frames, num_frames - skipped));
      if (count == 0) break;
      skipped += count;
    }
    return skipped;
  }
  skipped = static_cast<Eigen::Index>(std::min<std::int64_t>(num_frames, state.num_frames - state.num_read));
  for (auto& file : state.files) (void)file.source->skip(skipped);
  state.num_read += skipped;
  return skipped;
}

int count_runs(const std::filesystem::path& file, const Sidecar& sidecar) {
  OpenOptions how{.with_clock = false};
  how.header_row = sidecar.header_row;
  how.skip_rows = sidecar.skip_rows;
  return open_source(file, how)->info().num_runs;
}

Recording read_recording(const fs::path& file, const ReadOptions& options) {
  RecordingReader reader(file, options);
  return read_recording(reader, options.max_memory_bytes);
}

Recording read_recording(RecordingReader& reader, std::size_t max_memory_bytes) {
  const auto frames = static_cast<Eigen::Index>(reader.num_frames());
  const auto width = static_cast<Eigen::Index>(reader.description().channels.size());
  constexpr Eigen::Index block_frames = 16384;
  const double bytes = sizeof(double) * static_cast<double>(frames) * static_cast<double>(width);
  require_memory(reader.description().name, bytes, max_memory_bytes);
  reader.set_bytes_beside(bytes);
  Eigen::MatrixXd samples(frames, width);
  FrameBlock block;
  Eigen::Index done = 0;
  while (const auto got = reader.read(block, block_frames)) {
    samples.middleRows(done, got) = block;
    done += got;
  }
  Recording recording = reader.description();
  recording.samples = std::move(samples);
  return recording;
}

}  // namespace dsp
