#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dsp/io/setting.hpp"
#include "dsp/prepare.hpp"
#include "dsp/segment_regimes.hpp"
#include "ident/bodies/candidates.hpp"
#include "ident/library/library.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/regression/methods.hpp"

namespace apps {

/// One [[recording]]: file and sidecar as paths from the current folder.
struct RecordingConfig {
  std::filesystem::path file, sidecar;  ///< sidecar empty: NAME.ext.toml beside the recording, if there
  std::string name{};                   ///< in all outputs (apps/config/recording_name.hpp)
  bool salvage = false, uncalibrated = false;
  int run = 0;                             ///< of several side by side in a table: which; 0: as the sidecar says
  bool test = false;                       ///< use = "test": never fitted, only predicted
  std::map<std::string, std::string> use;  ///< role -> channel
};

/// What is subtracted from x (a laser's zero means nothing).
struct ZeroChoice {
  enum class Kind {
    automatic,  ///< fit where x is the difference of two displacements, else as_it_is
    as_it_is,   ///< of the recordings: known as far as their sidecars say
    none,       ///< the sensor's own, which is known
    mean,       ///< of the first range, which is known then
    fit,        ///< the same, and what the equation finds beyond it
    value,
  };
  Kind kind = Kind::automatic;
  double value_m = 0.0;
};

struct FitConfig {
  std::string target = "a";
  std::vector<ident::Method> methods = ident::default_methods();
  ident::MethodSettings settings;  ///< of all methods, whether they are used or not
  ident::Stage stage = ident::Stage::likelihood;
  double train_fraction = 0.6;  ///< of a range's rows, where its train_to is left out
  std::string place;            ///< of `target` in the config
};

/// What a page says of its test, as it is; empty: nothing.
struct ReportHeader {
  std::string title, object, test, operator_name, date;
};

/// A setting and the values a study gives it, as `--set` would take them.
struct StudyAxis {
  std::string key;  ///< "library.order"
  std::vector<std::string> values;
};

struct Config {
  std::vector<RecordingConfig> recordings;       ///< to be fitted
  std::vector<RecordingConfig> test_recordings;  ///< use = "test"; ranges do not count them
  dsp::PrepareOptions prepare;
  ZeroChoice zero;
  double max_clipped = 0.01;  ///< of a training interval, for any channel; more is refused
  bool segment = true;        ///< look for amplitude regimes
  dsp::SegmentOptions segment_options;
  std::filesystem::path segment_file;  ///< segments.json of an earlier run, edited or not; empty: found in the record
  bool split_by_direction = false;     ///< every range becomes two, v > 0 and v < 0
  ident::LibraryOptions library;
  ident::Inner inner = ident::Inner::none;
  bool default_terms = false;  ///< beside those named, sgn(v) and the inputs that were measured; not with order = 0
  FitConfig fit;
  ReportHeader report;
  bool rows = true, figures = true;  ///< a run folder has its tables with a row a sample, and figures/
  std::vector<StudyAxis> study;      ///< [study]: what `ardent study` varies; a run takes no notice
  std::vector<ident::Range> ranges;  ///< empty: one for each recording, named after it
  std::string library_place;         ///< file:line of `terms`, for messages
};

/// Reads INPUT: a config where its name ends in .toml, else a recording with the defaults for the rest. Overrides read
/// `a.b=c`. Where a `recording` is given the config is about that one, as it is about its own first (completed), and
/// may have none. Throws dsp::Fault (usage, config.*): every message begins with file:line.
[[nodiscard]] Config read_config(const std::filesystem::path& input, const std::vector<std::string>& overrides = {},
                                 const std::filesystem::path& recording = {});

/// A recording with what was left out as for `first`: a sidecar, where none is beside it, the channels in use, raw
/// numbers.
[[nodiscard]] RecordingConfig completed(RecordingConfig recording, const RecordingConfig& first);

/// Every key that a config may have.
[[nodiscard]] const std::vector<dsp::Setting>& config_settings();

/// The keys of a config as --set names them, of elements those of the first: "prepare.rate_hz", "range.0.to".
[[nodiscard]] std::vector<std::string> override_keys();

/// The full key of a setting that a study may call by a short name: "order" is "library.order". Others stay.
[[nodiscard]] std::string study_key(const std::string& name);

/// All that [study] may name.
[[nodiscard]] std::vector<std::string> study_names();

/// The config as TOML with nothing left to a default but what differs between recordings. Files are written relative
/// to `folder`, where the text is to live.
[[nodiscard]] std::string to_toml(const Config& config, const std::filesystem::path& folder);

}  // namespace apps
