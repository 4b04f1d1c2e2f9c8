#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "apps/config/config.hpp"
#include "apps/process/console.hpp"
#include "ident/identify.hpp"

// The settings a study varies, and the identifications with them.

namespace apps {

/// "KEY=V1,V2,..." as typed; KEY in full or by its short name. Commas in brackets or quotes do not part. Throws
/// dsp::Fault (usage, "study.over").
[[nodiscard]] StudyAxis parse_axis(const std::string& text);

/// What is worth varying where nothing was asked for: order (unless the terms are all given by name), tau, the
/// threshold of sindy, the training fraction and the cut-off, each from well below to above what `config` has; the
/// cut-off over two decades, as far as the rates and the length allow. rate_hz, num_samples: of the first recording.
[[nodiscard]] std::vector<StudyAxis> default_axes(const Config& config, double rate_hz, std::int64_t num_samples);

/// One combination of settings, on top of the config.
struct StudyCell {
  int axis = -1;                                             ///< varied alone; -1: the config as it is, or a grid
  std::vector<std::pair<std::string, std::string>> setting;  ///< key and value; none: as it is
  [[nodiscard]] std::string label() const;                   ///< "library.order=2 fit.tau=10"; "as it is"
};
/// The config as it is and each value of each axis alone; or, as a grid, every combination.
[[nodiscard]] std::vector<StudyCell> study_cells(const std::vector<StudyAxis>& axes, bool grid);

/// What a cell says of one range; models and figures only.
struct StudyRange {
  std::string name;
  std::vector<std::string> terms;  ///< of the library
  std::size_t num_train = 0, num_test = 0;
  std::vector<ident::JudgedFit> fits;
};

struct StudyResult {
  StudyCell cell;
  std::vector<StudyRange> ranges = {};
  std::string trouble = {};  ///< not empty: why there is nothing
  bool keeps_motion = true;  ///< in its band: prepare.band warns of no recording
};

/// Of the cells that vary the cut-off: the one whose equation of the first method has the best verdict on its worst
/// range, and then the free run closest to x there, among those that keep the motion; -1 where none of them
/// does.
[[nodiscard]] int best_cutoff(const std::vector<StudyResult>& results);

struct StudyRequest {
  std::function<Config(const std::vector<std::string>&)> config_with;  ///< these overrides, "a.b=c"
  std::vector<StudyCell> cells;
  double sample_rate_hz = 0.0;  ///< of the first recording
  std::size_t max_memory_bytes = 0;
  int num_threads = 1;
  bool strict = false;
};

/// Each cell's ranges are those of a run with its settings, but that a cell with fit.train_share takes no notice of
/// train_to, and that a cut-off takes a given roll-off with it in proportion. Recordings are prepared once for all
/// cells that differ in library and fit only. In a study of single axes, those of a method's setting are fitted by the
/// methods that have it only. Throws dsp::Fault for what is wrong with a setting before anything is read; a value that
/// only does not go with the rest is its cell's trouble, unless none is left.
[[nodiscard]] std::vector<StudyResult> run_cells(const StudyRequest& request, Console& console);

}  // namespace apps
