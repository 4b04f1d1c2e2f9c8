#include "apps/batch/record_runs.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <string.h>

#include <algorithm>
#include <chrono>
#include <list>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "apps/output/manifest.hpp"
#include "apps/process/child_process.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

/// The run of one recording under way.
class RecordRun {
 public:
  RecordRun(std::size_t task, fs::path folder, const std::vector<std::string>& arguments)
      : task_(task), folder_(std::move(folder)), before_(written_at()), child_(arguments) {}
  ChildProcess& child() { return child_; }
  [[nodiscard]] TaskOutcome outcome() {
    const ChildEnd end = child_.take();
    TaskOutcome outcome{.task = task_, .exit_code = end.exit_code};
    if (end.signal != 0) {
      outcome.exit_code = end.signal == SIGKILL ? code_numerics : code_bug;
      outcome.error =
          end.signal == SIGKILL
              ? "[task.killed] the system killed its process, most likely for want of memory"
              : fmt::format("[task.crashed] its process ended by signal {} ({})", end.signal, ::strsignal(end.signal));
      return outcome;
    }
    // Code 4 with results ends with an equation on standard output, without them with nothing there.
    outcome.has_run = end.exit_code == 0 || (end.exit_code == code_numerics && !end.out.empty());
    outcome.error = first_error(end.err);
    if (outcome.has_run) {
      outcome.was_kept = before_ && before_ == written_at();
      const std::optional<Manifest> manifest = read_manifest(folder_);
      if (manifest && !manifest->errors.empty()) outcome.error = manifest->errors.front();
    } else if (outcome.error.empty()) {
      outcome.error = fmt::format("[task.failed] its process ended with exit code {} and said nothing", end.exit_code);
    }
    return outcome;
  }

 private:
  static constexpr int code_bug = 1, code_numerics = 4;
  [[nodiscard]] std::optional<fs::file_time_type> written_at() const {
    std::error_code none;
    const auto time = fs::last_write_time(folder_ / manifest_name, none);
    return none ? std::nullopt : std::optional(time);
  }
  /// Of what a command said: "[name] text".
  [[nodiscard]] static std::string first_error(const std::string& said) {
    constexpr std::string_view mark = "error [";
    for (std::size_t begin = 0; begin < said.size();) {
      const std::size_t end = std::min(said.find('\n', begin), said.size());
      const std::string_view line(said.data() + begin, end - begin);
      if (line.starts_with(mark)) return std::string(line.substr(mark.size() - 1));
      begin = end + 1;
    }
    return {};
  }
  std::size_t task_;
  fs::path folder_;
  std::optional<fs::file_time_type> before_;  ///< when the results that were there were written
  ChildProcess child_;
};

/// Those under way, and what they are started with.
class Pool {
 public:
  Pool(const RecordRuns& runs, const std::vector<RecordTask>& tasks) : runs_(runs), tasks_(tasks) {}
  [[nodiscard]] bool has_room() const { return std::ssize(running_) < runs_.num_jobs; }
  [[nodiscard]] bool is_empty() const { return running_.empty(); }
  /// Where the system gives no process the outcome is at hand at once.
  [[nodiscard]] std::optional<TaskOutcome> start(std::size_t index) {
    const RecordTask& task = tasks_.at(index);
    std::vector<std::string> arguments{"run", "-o", (runs_.runs / task.name).string()};
    arguments.insert(arguments.end(), runs_.options.begin(), runs_.options.end());
    for (const std::string& last : {std::string("--"), runs_.config.string(), task.recording.string()})
      arguments.push_back(last);  // behind --: their names may look like options
    try {
      running_.emplace_back(index, runs_.runs / task.name, arguments);
      return std::nullopt;
    } catch (const std::system_error& error) {
      return TaskOutcome{index, 4, false, false, fmt::format("[system.refused] the system refuses: {}", error.what())};
    }
  }
  void collect(SharedWork& work) {
    for (auto run = running_.begin(); run != running_.end();) {
      if (!run->child().ended()) {
        ++run;
        continue;
      }
      work.done(run->outcome());
      run = running_.erase(run);
    }
  }
  void wait(std::chrono::milliseconds longest) {
    std::vector<ChildProcess*> children;
    for (RecordRun& run : running_) children.push_back(&run.child());
    ChildProcess::wait_for_any(children, longest);
  }

 private:
  const RecordRuns& runs_;
  const std::vector<RecordTask>& tasks_;
  std::list<RecordRun> running_;
};

}  // namespace

void run_records(const RecordRuns& runs, const std::vector<RecordTask>& tasks, SharedWork& work,
                 const std::function<void()>& poll) {
  Pool pool(runs, tasks);
  bool more = true;
  while (more || !pool.is_empty() || !work.is_over()) {
    poll();
    work.serve();
    while (more && pool.has_room()) {
      const SharedWork::Next next = work.next();
      if (next.answer == SharedWork::Answer::later) break;
      if (next.answer == SharedWork::Answer::none)
        more = false;
      else if (auto failed = pool.start(next.task))
        work.done(std::move(*failed));
    }
    if (!more && pool.is_empty() && work.is_over()) return;
    pool.wait(work.patience());
    pool.collect(work);
  }
}

}  // namespace apps
