#include <fmt/format.h>

#include <sstream>
#include <utility>

#include "dsp/io/calibrate.hpp"
#include "dsp/io/channel_roles.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/io/recording_files.hpp"
#include "dsp/values/faults.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

std::string commented(const std::string& lines) {
  std::istringstream text(lines);
  std::string result;
  for (std::string line; std::getline(text, line);) result += "# " + line + "\n";
  return result;
}

std::string role_line(Role role, const std::string& why) {
  if (role == Role::other) return fmt::format("# role = \"y\"  # {}\n", role_choices);
  return fmt::format("role = \"{}\"{}\n", to_string(role), why.empty() ? "" : fmt::format("  # by {}", why));
}

// What a file states is a setting; what follows from a column of times or is not known is a question.
std::string rate_text(const SourceInfo& info) {
  if (!(info.sample_rate_hz > 0)) return fmt::format("# {}  needed: the file does not say it\n", rate_line);
  if (info.time_column < 0) return fmt::format("rate = {}  # Hz\n", info.sample_rate_hz);
  const auto column = static_cast<std::size_t>(info.time_column);
  if (!info.units[column].empty())
    return fmt::format("# rate = {:.9g}  # Hz, by its time column; not needed here\n", info.sample_rate_hz);
  return fmt::format(
      "# rate = {:.9g}  # Hz, if column {} is time in s: it names no unit. If it is in ms:\n"
      "# [[channel]]\n# name = \"t\"\n# index = {}\n# role = \"t\"\n# unit = \"ms\"\n",
      info.sample_rate_hz, column + 1, column + 1);
}

std::string channel_text(const ChannelSpec& channel, const RoleGuess& role, const SourceInfo& info) {
  const auto calibration = calibrate(channel, info, channel.index - 1);
  const auto& in_file = info.units[static_cast<std::size_t>(channel.index - 1)];
  const auto unit = in_file.empty() ? calibration.unit : find_unit(in_file).name;
  std::string text = fmt::format("\n[[channel]]\nname = {}\nindex = {}\n{}", toml_quoted(channel.name), channel.index,
                                 role_line(role.role, role.why));
  text += commented(calibration.missing);
  if (calibration.missing.empty())
    text += unit.empty() ? fmt::format("# unit = \"{}\"\n", role.role == Role::other ? "m" : si_unit(role.role))
            : calibration.unit_is_assumed ? fmt::format("# unit = \"{}\"  # if so: the file names no unit\n", unit)
                                          : fmt::format("unit = \"{}\"\n", unit);
  return text + "# sign = -1  # mounted the other way round\n# delay = \"0 ms\"\n# coupling = \"DC\"\n";
}

}  // namespace

std::string draft_sidecar(const std::filesystem::path& file, const ReadOptions& options) {
  Faults faults;  // of the clock: they are why a person wants a sidecar
  const auto opened = std::move(open_files(file, {}, options, faults).front());
  const auto& info = opened.source->info();
  std::string text = fmt::format("schema = 1\n# {}: {} frames, {}\n# title = \"\"\n# start = 2023-05-04T10:12:30Z\n",
                                 opened.name, info.num_frames, info.container);
  if (faults.empty()) text += rate_text(info);
  for (const Fault& fault : faults.all()) text += commented(std::string(fault.what()) + "\n" + fault.lines());
  const std::vector<ChannelSpec> channels = channels_of(opened);
  const std::vector<RoleGuess> roles = guess_roles(channels, info);
  for (std::size_t i = 0; i < channels.size(); ++i) text += channel_text(channels[i], roles[i], info);
  text += "\n# [[range]]\n# name = \"low\"\n# from = 0\n# to = 830\n# train_to = 500\n";
  return text + "\n# [[bad]]\n# from = 412.1\n# to = 412.6\n# why = \"cable knocked\"\n";
}

}  // namespace dsp
