#pragma once
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/batch/ranks.hpp"

namespace apps {

/// How one task ended.
struct TaskOutcome {
  std::size_t task = 0;
  int exit_code = 0;
  bool has_run = false;   ///< its folder holds the results; also with exit code 4
  bool was_kept = false;  ///< it was there already
  std::string error;      ///< "[name] text"; empty: none
};

/// As a message between ranks, and back. Throws std::invalid_argument for a text that is none.
[[nodiscard]] std::string to_message(const TaskOutcome& outcome);
[[nodiscard]] TaskOutcome outcome_from(const std::string& message);

/// Where a process does tasks, several at a time.
class Workplace {
 public:
  virtual ~Workplace() = default;
  [[nodiscard]] virtual int num_places() const = 0;
  /// In a place that is free.
  virtual void start(std::size_t task) = 0;
  /// Those that have ended since the last call; waits for the first, but no longer than this.
  [[nodiscard]] virtual std::vector<TaskOutcome> ended(std::chrono::milliseconds longest) = 0;
};

/// Rank 0: begins the tasks in this order, each where a place is free, here or, with `ranks` (null: there are none), at
/// a rank that is in take_tasks(). Every rank has as many places. `sink` has each outcome as it becomes known; `poll`
/// is called several times a second and may throw to stop.
void deal_tasks(const std::vector<std::size_t>& order, Workplace& here, Ranks* ranks,
                const std::function<void(TaskOutcome)>& sink, const std::function<void()>& poll);

/// Another rank: does what rank 0 deals it, until that sends it home.
void take_tasks(Workplace& here, Ranks& ranks, const std::function<void()>& poll);

/// Rank 0: ends take_tasks() of all others.
void send_home(Ranks& ranks);

}  // namespace apps
