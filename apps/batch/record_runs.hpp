#pragma once
#include <filesystem>
#include <list>
#include <string>
#include <vector>

#include "apps/batch/record_tasks.hpp"
#include "apps/batch/work.hpp"

namespace apps {

/// How the recordings of a batch are run: `ardent run [CONFIG] RECORDING` each, in a process of its own, so that one
/// that crashes or finds no memory costs its own recording and no other. The end of this ends what is under way.
class RecordRuns final : public Workplace {
 public:
  struct Options {
    std::filesystem::path config, runs;  ///< config: empty: none; runs: folder of the run folders
    std::vector<std::string> options;    ///< of `ardent run`, beside -o, for every recording
    int num_jobs = 1;                    ///< at a time in this process
  };
  RecordRuns(Options options, const std::vector<RecordTask>& tasks);
  RecordRuns(Options options, const std::vector<RecordTask>&& tasks) = delete;
  ~RecordRuns() override;
  [[nodiscard]] int num_places() const override { return options_.num_jobs; }
  void start(std::size_t task) override;
  [[nodiscard]] std::vector<TaskOutcome> ended(std::chrono::milliseconds longest) override;

 private:
  class Run;
  Options options_;
  const std::vector<RecordTask>& tasks_;
  std::list<Run> running_;
  std::vector<TaskOutcome> refused_;  ///< what the system gave no process for
};

}  // namespace apps
