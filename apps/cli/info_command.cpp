#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "apps/cli/command.hpp"
#include "apps/config/recording_runs.hpp"
#include "apps/output/results_json.hpp"
#include "apps/process/printable.hpp"
#include "dsp/io/read_recording.hpp"

namespace apps {
namespace {

struct InfoArguments {
  std::vector<std::filesystem::path> files;
  std::filesystem::path sidecar;
  bool salvage = false;
};

RecordingInfo info_of(const RecordingConfig& wanted, const InfoArguments& arguments) {
  const std::filesystem::path& file = wanted.file;
  dsp::ReadOptions options;
  options.salvage = arguments.salvage;
  options.sidecar = arguments.sidecar;
  options.run = wanted.run;
  options.uncalibrated = true;  // what is missing shows as such; only a run needs it
  const dsp::RecordingReader reader(file, options);
  const dsp::Recording& recording = reader.description();
  return {wanted.run > 0 ? fmt::format("{} run {}", file.string(), wanted.run) : file.string(),
          reader.container(),
          reader.sidecar().file.string(),
          recording.sample_rate_hz,
          reader.num_frames(),
          recording.channels,
          recording.bad,
          recording.checks,
          reader.sidecar().ranges};
}

std::string info_text(const RecordingInfo& info) {
  std::string text = fmt::format(
      "{}\n  container  {}\n  rate       {:.12g} Hz\n  samples    {}\n  duration   {:.9g} s\n  sidecar    {}\n",
      printable(info.file), info.container, info.sample_rate_hz, info.num_samples,
      static_cast<double>(info.num_samples) / info.sample_rate_hz,
      info.sidecar.empty() ? "none found" : printable(info.sidecar));
  for (const dsp::Channel& channel : info.channels)
    text += fmt::format("  channel    {:<16} role {:<6} {}unit {}{}\n", printable(channel.name),
                        to_string(channel.role), channel.body > 0 ? fmt::format("body {} ", channel.body) : "",
                        channel.unit.empty() ? "-" : printable(channel.unit),
                        channel.calibrated ? "" : " (not calibrated)");
  for (const dsp::RangeSpec& range : info.ranges)
    text += fmt::format("  range      {} from {:g} s to {:g} s\n", printable(range.name), range.from_s, range.to_s);
  for (const dsp::Interval& bad : info.bad)
    text += fmt::format("  bad        {:g} s to {:g} s: {}\n", bad.from_s, bad.to_s, printable(bad.why));
  for (const dsp::Check& check : info.checks)
    if (check.status != dsp::CheckStatus::ok)
      text += fmt::format("  {:<10} {}: {}{}\n", to_string(check.status), check.name, printable(channel_prefix(check)),
                          printable(check.message));
  return text;
}

void info(const InfoArguments& arguments, bool strict, Console& console) {
  std::vector<RecordingInfo> recordings;
  std::string text;
  std::vector<RecordingConfig> wanted;
  for (const std::filesystem::path& file : arguments.files) wanted.push_back({file, arguments.sidecar});
  take_runs_apart(wanted);
  for (const RecordingConfig& recording : wanted) {
    recordings.push_back(info_of(recording, arguments));
    text += info_text(recordings.back());
    for (const dsp::Check& check : recordings.back().checks)
      if (strict && (check.status == dsp::CheckStatus::warning || check.status == dsp::CheckStatus::failed))
        console.warning(check.name, channel_prefix(check) + check.message);
  }
  refuse_warnings(strict, console);
  console.result(console.json() ? info_json(recordings) : text);
}

}  // namespace

Command info_command() {
  const auto typed = std::make_shared<InfoArguments>();
  return {.name = "info",
          .help = "What a recording is: container, channels, rate, length, sidecar",
          .group = look_group,
          .unused = {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}, {"--force"}, {"--threads"}},
          .options = {{"FILE", &typed->files, "Recordings.", {.required = true, .is_recording = true}},
                      {"--sidecar",
                       &typed->sidecar,
                       "Sidecar of them all. Left out: NAME.ext.toml beside each.",
                       {.name = "FILE"}},
                      {"--salvage", &typed->salvage, "Read a recording that was cut short, as far as it goes."}},
          .run =
              [typed](const GlobalOptions& global, Console& console) {
                info(*typed, global.strict, console);
                return 0;
              },
          .examples = {"ardent info drive.wav", "ardent info *.csv --json"}};
}

}  // namespace apps
