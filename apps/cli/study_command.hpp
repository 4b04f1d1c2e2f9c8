#pragma once
#include <string>
#include <vector>

#include "apps/cli/run_command.hpp"
#include "apps/process/console.hpp"

namespace apps {

/// `ardent study INPUT -o DIR ...` as it was typed.
struct StudyArguments {
  RunArguments run;               ///< input, folder and what a run takes
  std::vector<std::string> over;  ///< "KEY=V1,V2,..."; none: the config's [study], else default_axes
  bool grid = false;              ///< every combination instead of one setting at a time
};

/// Writes study.txt, study.csv, study.json and study-RANGE.svg into the folder. Returns 4 where no cell kept a term,
/// else 0. Throws dsp::Fault.
int run_study(const StudyArguments& arguments, Console& console);

}  // namespace apps
