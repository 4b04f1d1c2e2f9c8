#include <fmt/format.h>

#include "apps/reference/setting_reference.hpp"
#include "dsp/signals.hpp"

namespace apps {
namespace {

std::string roles() {
  std::string text;
  for (const dsp::SignalInfo& signal : dsp::signal_table())
    if (signal.role != dsp::Role::other) text += (text.empty() ? "" : ", ") + std::string(signal.name);
  return text;
}

std::vector<SettingHelp> document_help() {
  return {
      {"", "schema", "Version of this layout of the file.", "", "1"},
      {"", "title", "Title of the recording."},
      {"", "start", "When it began: 2023-05-04T10:12:30Z."},
      {"", "rate",
       "Samples per second, as a number or a ratio: \"51200/3\". It must agree with the file where that has one. A "
       "time "
       "column is read as seconds or in its unit, as 10:00:00.123 with or without a date "
       "(2026-11-20T10:00:00.123+01:00, "
       "20.11.2026 10:00:00,123) and as 00:12.3, minutes and seconds.",
       "Hz", "the file's own"},
      {"", "clock",
       "\"interpolate\": a time column with uneven steps is interpolated onto `rate`, which must be given. "
       "\"regular\": "
       "uneven steps are refused."},
      {"", "range", "A part of the recording with an equation of its own, as in a config, whose ranges replace these."},
      {"range", "name", "Its name in all outputs.", "", "range1, range2, ..."},
      {"range", "from", "Where it begins, from the start of the recording.", "s"},
      {"range", "to", "Where it ends.", "s", "the end of the recording"},
      {"range", "train_to", "Rows up to here are fitted, the later ones tested.", "s",
       "as the config's fit.train_share says"},
      {"range", "where", "Condition on rows: \"abs(v) > 0.004\".", "", "all rows"},
      {"", "bad", "An interval that is left out of every fit and figure, with the filters' reach on either side."},
      {"bad", "from", "Where it begins, from the start of the recording.", "s"},
      {"bad", "to", "Where it ends.", "s"},
      {"bad", "why", "The reason, for segments.json."},
  };
}

std::vector<SettingHelp> channel_help() {
  return {
      {"", "channel", "A channel. Without any, the file's own columns with the names and units of its header."},
      {"channel", "name", "Its name in terms and outputs. Names must differ."},
      {"channel", "file", "Another file on the same clock that holds this channel.", "", "the recording itself"},
      {"channel", "index", "Its column or track in the file, counted from 1.", "", "found by `column` or by its name"},
      {"channel", "column", "Its name in the file.", "", "as `name`"},
      {"channel", "role", fmt::format("What it measures: {}. `ardent help terms` explains them.", roles()), "",
       "\"other\": usable in terms by its name"},
      {"channel", "unit", "Unit after calibration, or of the numbers in the file where there is no sensitivity.", "",
       "SI of the sensitivity, else as the file says"},
      {"channel", "sensitivity", "What the sensor gives per measured unit: \"100.1 mV/g\", \"250 mV/mm\".", "",
       "the numbers are measured values already"},
      {"channel", "full_scale", "What 1.0 in a sound file stands for: \"10 V\".", "", "the numbers are volts or units"},
      {"channel", "offset", "Subtracted before or after calibration, according to its unit: \"0.2 mV\", \"1 mm\".", "",
       "0"},
      {"channel", "sensitivity_uncertainty",
       "Standard deviation of the sensitivity as a fraction, or as a text \"0.5 %\". It enters the standard deviations "
       "of coefficients.",
       "", "0.01"},
      {"channel", "range", "Largest reading of the sensor; its zero is known to 1 % of it: \"35 mm\".", "",
       "what the record spans"},
      {"channel", "drift", "Standard deviation of its zero in the course of a record: \"40 um\".", "",
       "from the slow motion of x"},
      {"channel", "sign", "-1 for a sensor that was mounted the other way round."},
      {"channel", "delay", "By how much the channel lags, in seconds or as a text \"0.23 ms\". The lag is corrected.",
       "s"},
      {"channel", "coupling", "Coupling of its amplifier.", "", "not known"},
      {"channel", "highpass", "Cut-off of its AC coupling, one number for each pole, or \"0.5 Hz\".", "Hz",
       "none known"},
      {"channel", "sensor", "Notes: { model = \"352C33\", serial = \"A1234\" }. Not used in computations."},
  };
}

}  // namespace

const std::vector<SettingHelp>& sidecar_help() {
  static const std::vector<SettingHelp> all = [] {
    std::vector<SettingHelp> joined = document_help();
    const std::vector<SettingHelp> channels = channel_help();
    joined.insert(joined.end(), channels.begin(), channels.end());
    return joined;
  }();
  return all;
}

}  // namespace apps
