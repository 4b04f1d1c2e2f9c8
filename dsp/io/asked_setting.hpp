#pragma once
#include <limits>
#include <string>
#include <vector>

namespace dsp {

/// Numbers a setting may take: [from, to], or (from, to] where `above`.
struct NumberRange {
  double from = -std::numeric_limits<double>::infinity(), to = std::numeric_limits<double>::infinity();
  bool above = false;
};

/// What a reader asked of one key of a TOML document: the type, range and default that hold, because it is these that
/// were applied.
struct AskedSetting {
  std::string table;  ///< "prepare", "channel", "recording.use"; empty: the document itself. Elements share a name
  std::string key;
  bool number = false, whole_number = false, flag = false, text = false;  ///< any of these is taken
  bool several = false;                                                   ///< an array of them, too
  bool moment = false, notes = false, table_of_its_own = false, tables = false;
  bool required = false;
  NumberRange range;               ///< of numbers
  std::vector<std::string> words;  ///< not empty: a text must be one of these
  std::string fallback;            ///< as TOML; empty: absence is a state of its own
};

/// Adds to `all` what further reading of the same kind of document asked: a key that is there gets its further types.
void add_asked(std::vector<AskedSetting>& all, const std::vector<AskedSetting>& further);

}  // namespace dsp
