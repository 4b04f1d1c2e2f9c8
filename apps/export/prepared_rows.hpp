#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "apps/export/exported_equation.hpp"
#include "dsp/sensors/motion.hpp"

// What a free run of a finished run was driven by, from its prepared.csv.

namespace apps {

/// The signals of one recording of prepared.csv, and its name there; of the only one none.
struct PreparedRows {
  std::string recording;
  dsp::Motion motion;
};
/// `recording`: from 1. Throws dsp::Fault (input, "run.damaged") where it has no columns t and `position`, or fewer
/// than 2 rows.
[[nodiscard]] PreparedRows read_prepared_rows(const std::filesystem::path& file, std::size_t recording,
                                              const std::string& position);

/// Samples of a motion that a free run goes through. Throws dsp::Fault (input, "run.damaged") for times outside of it.
[[nodiscard]] dsp::IndexRange samples_between(const dsp::Motion& motion, double from_s, double to_s);

/// A run over these samples, its inputs between them; its state and x are left to the caller.
[[nodiscard]] ExportedRun run_over(const dsp::Motion& motion, dsp::IndexRange samples,
                                   const std::vector<std::string>& inputs);

}  // namespace apps
