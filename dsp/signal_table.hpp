#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "dsp/sensors/motion.hpp"

namespace dsp {

/// The columns of a file as signals in the file's own units, whatever they are; its rows are its clock, at 1 Hz.
struct SignalTable {
  Motion signals;
  std::vector<std::pair<std::string, std::string>> renamed;  ///< columns whose names no expression can hold
};

/// Column names that are no names become some ("force [kN]" -> force_kN). Throws Fault (input): channel.name where two
/// become one, and what open_source throws.
[[nodiscard]] SignalTable read_signal_table(const std::filesystem::path& file);

}  // namespace dsp
