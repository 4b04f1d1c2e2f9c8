#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "apps/batch/record_tasks.hpp"
#include "apps/batch/work.hpp"

namespace apps {

/// How the recordings of a batch are run: `ardent run CONFIG RECORDING` each, in a process of its own, so that one that
/// crashes or finds no memory costs its own recording and no other.
struct RecordRuns {
  std::filesystem::path config, runs;  ///< `runs`: folder of the run folders
  std::vector<std::string> options;    ///< of `ardent run`, beside -o, for every recording
  int num_jobs = 1;                    ///< at a time in this process
};

/// Runs what `work` gives until nobody waits for anything. `poll` is called several times a second and may throw to
/// stop: the runs under way are then ended.
void run_records(const RecordRuns& runs, const std::vector<RecordTask>& tasks, SharedWork& work,
                 const std::function<void()>& poll);

}  // namespace apps
