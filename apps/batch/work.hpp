#pragma once
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/batch/ranks.hpp"

namespace apps {

/// How the run of one recording ended.
struct TaskOutcome {
  std::size_t task = 0;
  int exit_code = 0;
  bool has_run = false;   ///< its folder holds the results; also with exit code 4
  bool was_kept = false;  ///< it was there already
  std::string error;      ///< "[name] text"; empty: none
};

/// As a message between ranks, and back. Throws std::invalid_argument for a text that is none.
[[nodiscard]] std::string to_message(const TaskOutcome& outcome);
[[nodiscard]] TaskOutcome outcome_from(std::string_view message);

/// Gives out tasks to whoever has nothing to do, each once.
class SharedWork {
 public:
  enum class Answer { task, later, none };  ///< later: not known yet, ask again; none: never again
  struct Next {
    Answer answer = Answer::none;
    std::size_t task = 0;
  };
  virtual ~SharedWork() = default;
  [[nodiscard]] virtual Next next() = 0;
  virtual void done(TaskOutcome outcome) = 0;
  /// Takes messages of others; called often.
  virtual void serve() {}
  /// How long to sleep between calls of serve() and next().
  [[nodiscard]] virtual std::chrono::milliseconds patience() const = 0;
  /// Whether nobody waits for anything of this process any more.
  [[nodiscard]] virtual bool is_over() const = 0;
};

/// Called with every outcome as it becomes known.
using OutcomeSink = std::function<void(TaskOutcome)>;

/// All tasks, in this order, to this process and to what ranks there are besides 0, which this must be. `ranks`: null
/// without any; else it must outlive this.
[[nodiscard]] std::unique_ptr<SharedWork> own_work(std::vector<std::size_t> order, OutcomeSink sink, Ranks* ranks);

/// What rank 0 gives to another rank.
[[nodiscard]] std::unique_ptr<SharedWork> given_work(Ranks& ranks);

}  // namespace apps
