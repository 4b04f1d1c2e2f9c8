#include "apps/batch/record_runs.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <string.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "apps/output/manifest.hpp"
#include "apps/process/child_process.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

/// Of what a command said: "[name] text".
std::string first_error(const std::string& said) {
  constexpr std::string_view mark = "error [";
  for (std::size_t begin = 0; begin < said.size();) {
    const std::size_t end = std::min(said.find('\n', begin), said.size());
    const std::string_view line(said.data() + begin, end - begin);
    if (line.starts_with(mark)) return std::string(line.substr(mark.size() - 1));
    begin = end + 1;
  }
  return {};
}

/// When the results in a run folder were written.
std::optional<fs::file_time_type> written_at(const fs::path& folder) {
  std::error_code none;
  const auto time = fs::last_write_time(folder / manifest_name, none);
  return none ? std::nullopt : std::optional(time);
}

}  // namespace

/// One under way.
class RecordRuns::Run {
 public:
  Run(std::size_t task, fs::path folder, const std::vector<std::string>& arguments)
      : task_(task), folder_(std::move(folder)), before_(written_at(folder_)), child_(arguments) {}
  ChildProcess& child() { return child_; }
  [[nodiscard]] TaskOutcome outcome() {
    const ChildEnd end = child_.take();
    TaskOutcome outcome{.task = task_, .exit_code = end.exit_code};
    if (end.signal == SIGKILL) {
      outcome.exit_code = code_numerics;
      outcome.error = "[task.killed] the system killed its process, most likely for want of memory";
    } else if (end.signal != 0) {
      outcome.exit_code = code_bug;
      outcome.error =
          fmt::format("[task.crashed] its process ended by signal {} ({})", end.signal, ::strsignal(end.signal));
    } else if (end.exit_code == 0 || (end.exit_code == code_numerics && !end.out.empty())) {
      // Code 4 with results ends with an equation on standard output, without them with nothing there.
      outcome.has_run = true;
      outcome.was_kept = before_ && before_ == written_at(folder_);
      const std::optional<Manifest> manifest = read_manifest(folder_);
      outcome.error = manifest && !manifest->errors.empty() ? manifest->errors.front() : first_error(end.err);
    } else {
      outcome.error = first_error(end.err);
      if (outcome.error.empty())
        outcome.error =
            fmt::format("[task.failed] its process ended with exit code {} and said nothing", end.exit_code);
    }
    return outcome;
  }

 private:
  static constexpr int code_bug = 1, code_numerics = 4;
  std::size_t task_;
  fs::path folder_;
  std::optional<fs::file_time_type> before_;  ///< of the results that were there
  ChildProcess child_;
};

RecordRuns::RecordRuns(Options options, const std::vector<RecordTask>& tasks)
    : options_(std::move(options)), tasks_(tasks) {}
RecordRuns::~RecordRuns() = default;

void RecordRuns::start(std::size_t index) {
  const RecordTask& task = tasks_.at(index);
  const fs::path folder = options_.runs / task.name;
  std::vector<std::string> arguments{"run", "-o", folder.string()};
  arguments.insert(arguments.end(), options_.options.begin(), options_.options.end());
  // Behind --: their names may look like options.
  arguments.emplace_back("--");
  if (!options_.config.empty()) arguments.push_back(options_.config.string());
  arguments.push_back(task.recording.string());
  try {
    running_.emplace_back(index, folder, arguments);
  } catch (const std::system_error& error) {
    refused_.push_back({index, 4, false, false, fmt::format("[system.refused] the system refuses: {}", error.what())});
  }
}

std::vector<TaskOutcome> RecordRuns::ended(std::chrono::milliseconds longest) {
  std::vector<ChildProcess*> children;
  for (Run& run : running_) children.push_back(&run.child());
  if (refused_.empty()) ChildProcess::wait_for_any(children, longest);
  std::vector<TaskOutcome> outcomes = std::exchange(refused_, {});
  std::erase_if(running_, [&](Run& run) {
    if (!run.child().ended()) return false;
    outcomes.push_back(run.outcome());
    return true;
  });
  return outcomes;
}

}  // namespace apps
