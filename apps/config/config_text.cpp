#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "apps/config/config.hpp"
#include "apps/config/config_keys.hpp"
#include "apps/process/path.hpp"
#include "dsp/io/settings.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

/// A number that TOML reads back as the same double and as a float.
std::string real(double value) {
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".einf") == std::string::npos ? text + ".0" : text;
}

std::string_view word(dsp::AccelerationSource source) {
  if (source == dsp::AccelerationSource::accelerometer) return "accelerometer";
  return source == dsp::AccelerationSource::displacement ? "displacement" : "automatic";
}

std::string relative_to(const fs::path& file, const fs::path& folder) {
  return located_path(file).lexically_relative(fs::weakly_canonical(fs::absolute(folder))).generic_string();
}

std::string text_array(const std::vector<std::string>& texts) {
  std::vector<std::string> quoted;
  for (const std::string& text : texts) quoted.push_back(dsp::toml_quoted(text));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

std::string segment_text(const Config& config, const fs::path& folder) {
  std::string text = fmt::format("[segment]\nfind = {}\n", config.segment);
  if (!config.segment_file.empty())
    text += fmt::format("file = {}\n", dsp::toml_quoted(relative_to(config.segment_file, folder)));
  if (config.split_by_direction) text += "split = \"sgn(v)\"\n";
  for (const auto& [key, option] : segment_keys)
    if (config.segment_options.*option > 0.0)
      text += fmt::format("{} = {}\n", key, real(config.segment_options.*option));
  return text + "\n";
}

std::string recording_text(const RecordingConfig& recording, const fs::path& folder) {
  std::string text = fmt::format("[[recording]]\nfile = {}\n", dsp::toml_quoted(relative_to(recording.file, folder)));
  if (!recording.sidecar.empty())
    text += fmt::format("sidecar = {}\n", dsp::toml_quoted(relative_to(recording.sidecar, folder)));
  text += fmt::format("salvage = {}\nuncalibrated = {}\n", recording.salvage, recording.uncalibrated);
  std::vector<std::string> pairs;
  for (const auto& [role, channel] : recording.use)
    pairs.push_back(fmt::format("{} = {}", role, dsp::toml_quoted(channel)));
  if (recording.test) text += "use = \"test\"\n";
  if (!pairs.empty()) text += fmt::format("use = {{ {} }}\n", fmt::join(pairs, ", "));
  return text + "\n";
}

std::string prepare_text(const Config& config) {
  const dsp::PrepareOptions& prepare = config.prepare;
  const ZeroChoice& zero = config.zero;
  std::string text =
      fmt::format("[prepare]\nrecipe = \"{}\"\n", prepare.recipe == dsp::Recipe::paper ? "paper" : "matched");
  const auto known = [&](std::string_view key, double value) {
    if (value > 0.0) text += fmt::format("{} = {}\n", key, real(value));
  };
  known("rate_hz", prepare.rate_hz);
  known("cutoff_hz", prepare.cutoff_hz);
  known("rolloff_hz", prepare.rolloff_hz);
  known("state_cutoff_hz", prepare.state_cutoff_hz);
  known("state_rolloff_hz", prepare.state_rolloff_hz);
  known("bus_rate_hz", prepare.intermediate_rate_hz);
  known("integrate_from_hz", prepare.integrate_from_hz);
  text += fmt::format("acceleration = \"{}\"\nequalise = {}\nscale = \"{}\"\n", word(prepare.acceleration),
                      prepare.equalise,
                      prepare.scale == dsp::ScaleReference::accelerometer ? "accelerometer" : "displacement");
  if (zero.kind == ZeroChoice::Kind::value) text += fmt::format("zero = {}\n", real(zero.value_m));
  if (zero.kind == ZeroChoice::Kind::none) text += "zero = \"none\"\n";
  if (zero.kind == ZeroChoice::Kind::regime_mean) text += "zero = \"regime-mean\"\n";
  return text + fmt::format("max_clipped = {}\n\n", real(config.max_clipped));
}

std::string fit_text(const FitConfig& fit) {
  std::vector<std::string> methods;
  for (const ident::Method method : fit.methods) methods.emplace_back(to_string(method));
  std::string text = fmt::format("[fit]\ntarget = {}\nmethods = {}\ntrain_share = {}\n", dsp::toml_quoted(fit.target),
                                 text_array(methods), real(fit.train_fraction));
  for (const ident::MethodSetting& setting : ident::method_settings()) {
    const double value = fit.settings.value(setting.name);
    if (!setting.words.empty())
      text += fmt::format("{} = \"{}\"\n", setting.name, setting.words[static_cast<std::size_t>(value)]);
    else if (value >= 0.0)
      text += fmt::format("{} = {}\n", setting.name, real(value));
  }
  return text + "\n";
}

std::string range_text(const ident::Range& range) {
  std::string text = fmt::format("[[range]]\nname = {}\n", dsp::toml_quoted(range.spec.name));
  if (range.recording > 0) text += fmt::format("recording = {}\n", range.recording);
  if (!range.regime.any()) text += fmt::format("regime = \"{}\"\n", range.regime.name());
  text += fmt::format("from = {}\n", real(range.spec.from_s));
  if (std::isfinite(range.spec.to_s)) text += fmt::format("to = {}\n", real(range.spec.to_s));
  if (range.spec.train_to_s) text += fmt::format("train_to = {}\n", real(*range.spec.train_to_s));
  if (!range.spec.where.empty()) text += fmt::format("where = {}\n", dsp::toml_quoted(range.spec.where));
  return text + "\n";
}

}  // namespace

std::string to_toml(const Config& config, const fs::path& folder) {
  std::string text = fmt::format("schema = {}\n\n", config_schema);
  for (const auto* recordings : {&config.recordings, &config.test_recordings})
    for (const RecordingConfig& recording : *recordings) text += recording_text(recording, folder);
  text += prepare_text(config);
  text += segment_text(config, folder);
  text += fmt::format("[library]\norder = {}\nvariables = {}\nconstant = {}\nterms = {}\nmax_terms = {}\n\n",
                      config.library.order, text_array(config.library.variables), config.library.constant,
                      text_array(config.library.terms), config.library.max_terms);
  text += fit_text(config.fit);
  text += fmt::format("[output]\nrows = {}\nfigures = {}\n\n", config.rows, config.figures);
  for (const ident::Range& range : config.ranges) text += range_text(range);
  text.pop_back();
  return text;
}

}  // namespace apps
