#pragma once
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "apps/config/inputs.hpp"

// segments.json: what every interval of a record is taken for, one interval a line, for a person to read, edit and hand
// back ([segment] file = "segments.json").

namespace apps {

/// One line of the file.
struct LabelledInterval {
  dsp::Regime label = dsp::Regime::excluded;
  double from_s = 0.0, to_s = 0.0;
  std::string reason, recording;  ///< recording: its file's name, empty where there is one only
  double probability = std::numeric_limits<double>::quiet_NaN();  ///< as in dsp::Segment, as the standard deviations
  double from_std_s = std::numeric_limits<double>::quiet_NaN(), to_std_s = from_std_s;
};

/// [{"label": "low|high|stick|excluded", "from_s", "to_s", "reason", "probability", "from_std_s", "to_std_s"}], by
/// time; null: not estimated, as where something excluded ends. "recording" where there are several.
[[nodiscard]] std::string segments_json(const std::vector<Input>& inputs);

/// The same file back, edited or not. Throws dsp::Fault (usage): segments.syntax, segments.label, segments.time, each
/// with the file and the number of the interval.
[[nodiscard]] std::vector<LabelledInterval> read_segments(const std::filesystem::path& file);

/// Labels a prepared recording by the intervals meant for it. Where intervals overlap, excluded wins, then the later
/// one in the file; what none covers is excluded, and so stays what the record itself or its sidecar rules out. Throws
/// dsp::Fault (usage): segments.recording where no interval is meant for this recording.
[[nodiscard]] dsp::Segmentation apply_segments(const std::vector<LabelledInterval>& intervals,
                                               const std::filesystem::path& file, dsp::Prepared& prepared);

}  // namespace apps
