#pragma once
#include <filesystem>

#include "apps/cli/command.hpp"

namespace apps {

struct PredictArguments {
  std::filesystem::path run, recording, sidecar;
  std::string range, method;
};

/// The equations of a run with several bodies, run free over the inputs of another recording: from the state in which
/// its first two seconds are most likely, where displacements were recorded, else from rest. Writes predict.json and
/// predict.csv; returns the exit code, 4 where the equations run away.
int predict_bodies(const PredictArguments& arguments, const GlobalOptions& global, Console& console);

}  // namespace apps
