#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/clock_kind.hpp"
#include "dsp/io/range_spec.hpp"
#include "dsp/io/settings.hpp"
#include "dsp/io/units.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// One [[channel]] of a sidecar.
struct ChannelSpec {
  std::string name;
  std::filesystem::path file;  ///< beside the sidecar, same clock; empty: the recording itself
  int index = 0;               ///< 1-based index in the file; 0: found by column
  std::string column;          ///< empty: by index, else the column called like the channel
  Role role = Role::other;
  bool role_is_known = false;  ///< somebody gave it, if only as the name
  int body = 0;                ///< of several, from 1; 0: not given
  std::string unit;            ///< as written; empty: SI of the sensitivity's measured unit
  std::optional<Sensitivity> sensitivity;
  std::optional<Quantity> full_scale;  ///< what 1.0 in the file means, electrical or measured
  std::optional<Quantity> offset;      ///< subtracted, electrical or measured
  double sensitivity_uncertainty = Channel{}.sensitivity_uncertainty;  ///< standard deviation, as a fraction
  std::optional<Quantity> range;                                       ///< largest reading, electrical or measured
  std::optional<Quantity> drift;  ///< standard deviation of the zero in the course of a record, likewise
  double sign = 1.0;
  double delay_s = 0.0;
  std::string coupling;             ///< AC, DC, IEPE or empty
  std::vector<double> highpass_hz;  ///< cut-offs of the AC coupling, one pole each
  std::map<std::string, std::string> sensor;
  std::string place;  ///< file:line, for messages
};

/// What a person knows about a recording, in NAME.ext.toml beside it. Its keys are those of sidecar_settings().
struct Sidecar {
  std::filesystem::path file;  ///< empty if there is none
  std::string title, start;
  std::optional<double> rate_hz;
  ClockKind clock = ClockKind::regular;
  std::vector<ChannelSpec> channels;  ///< empty: the columns as the file names them
  std::vector<RangeSpec> ranges;
  std::vector<Interval> bad;
  int header_row = 0, skip_rows = 0, run = 0;  ///< of a table; 0: not given; run: or all_runs
};

/// NAME.ext.toml; of a stream, as /dev/stdin, that is in the current folder.
[[nodiscard]] std::filesystem::path sidecar_path(const std::filesystem::path& recording);
/// Throws Fault (usage): config.*, unit.*, calibration.value, channel.role, channel.name.
[[nodiscard]] Sidecar read_sidecar(const std::filesystem::path& file);
[[nodiscard]] Sidecar parse_sidecar(std::string_view text, const std::string& name);

/// Every key that a sidecar may have.
[[nodiscard]] const std::vector<Setting>& sidecar_settings();

/// The [[range]] tables of a document; a fault (config.range) where `from` is not below `to`, train_to lies outside, or
/// two ranges share a name.
[[nodiscard]] std::vector<RangeSpec> read_ranges(const Settings& document);

}  // namespace dsp
