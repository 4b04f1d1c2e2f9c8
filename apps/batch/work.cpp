#include "apps/batch/work.hpp"

#include <fmt/format.h>

#include <charconv>
#include <deque>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "apps/process/printable.hpp"

namespace apps {
namespace {

// Rank 0 sends numbers of tasks and at last this; every answer is an outcome.
constexpr std::string_view go_home = "end";

// Nothing wakes a process for a message; for the end of a run its child does.
constexpr std::chrono::milliseconds among_ranks{2}, on_one_rank{100};

}  // namespace

std::string to_message(const TaskOutcome& outcome) {
  constexpr std::size_t most = 2000;  // a message this short never waits for its reader
  return fmt::format("{} {} {:d} {:d} {}", outcome.task, outcome.exit_code, outcome.has_run, outcome.was_kept,
                     printable(outcome.error, most));
}

TaskOutcome outcome_from(const std::string& message) {
  std::istringstream text(message);
  TaskOutcome outcome;
  if (!(text >> outcome.task >> outcome.exit_code >> outcome.has_run >> outcome.was_kept) || text.get() != ' ')
    throw std::invalid_argument("outcome_from: no outcome of a task");
  std::getline(text, outcome.error);
  return outcome;
}

void deal_tasks(const std::vector<std::size_t>& order, Workplace& here, Ranks* ranks,
                const std::function<void(TaskOutcome)>& sink, const std::function<void()>& poll) {
  std::deque<int> free;  // places, by their rank
  for (int place = 0; place < here.num_places(); ++place)
    for (int rank = 0; rank < (ranks == nullptr ? 1 : ranks->size()); ++rank) free.push_back(rank);
  auto next = order.begin();
  std::size_t num_known = 0;
  const auto done = [&](int rank, TaskOutcome outcome) {
    free.push_back(rank);
    ++num_known;
    sink(std::move(outcome));
  };
  while (num_known < order.size()) {
    poll();
    for (; !free.empty() && next != order.end(); free.pop_front(), ++next)
      if (free.front() == 0)
        here.start(*next);
      else
        ranks->send(free.front(), std::to_string(*next));
    for (TaskOutcome& outcome : here.ended(ranks == nullptr ? on_one_rank : among_ranks)) done(0, std::move(outcome));
    while (ranks != nullptr) {
      const auto message = ranks->receive();
      if (!message) break;
      done(message->from, outcome_from(message->text));
    }
  }
}

void take_tasks(Workplace& here, Ranks& ranks, const std::function<void()>& poll) {
  bool at_home = false;
  for (int num_running = 0; !at_home || num_running > 0;) {
    poll();
    while (const auto message = ranks.receive()) {
      std::size_t task = 0;
      const std::string& text = message->text;
      at_home = at_home || text == go_home;
      if (at_home || std::from_chars(text.data(), text.data() + text.size(), task).ec != std::errc()) continue;
      here.start(task);
      ++num_running;
    }
    if (at_home && num_running == 0) return;
    for (const TaskOutcome& outcome : here.ended(num_running < here.num_places() ? among_ranks : on_one_rank)) {
      ranks.send(0, to_message(outcome));
      --num_running;
    }
  }
}

void send_home(Ranks& ranks) {
  for (int rank = 1; rank < ranks.size(); ++rank) ranks.send(rank, go_home);
}

}  // namespace apps
