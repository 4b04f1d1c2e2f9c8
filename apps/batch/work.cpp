#include "apps/batch/work.hpp"

#include <charconv>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "apps/process/printable.hpp"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;

// Rank 0 is asked by `ask` and answers with a task's number or `no_more`; any other message is an outcome.
constexpr std::string_view ask = "next", no_more = "end";

// Nothing wakes a process for a message; for the end of a run its child does.
constexpr std::chrono::milliseconds among_ranks{2}, alone{100};

class OwnWork final : public SharedWork {
 public:
  OwnWork(std::vector<std::size_t> order, OutcomeSink sink, Ranks* ranks)
      : order_(std::move(order)), sink_(std::move(sink)), ranks_(ranks) {
    if (ranks_ != nullptr) waiting_ = ranks_->size() - 1;
  }
  Next next() override {
    if (given_ == order_.size()) return {Answer::none, 0};
    return {Answer::task, order_[given_++]};
  }
  void done(TaskOutcome outcome) override {
    ++known_;
    sink_(std::move(outcome));
  }
  void serve() override {
    while (ranks_ != nullptr && waiting_ > 0) {
      const auto message = ranks_->receive();
      if (!message) return;
      if (message->text != ask) {
        done(outcome_from(message->text));
        continue;
      }
      const Next answer = next();
      ranks_->send(message->from, answer.answer == Answer::task ? std::to_string(answer.task) : std::string(no_more));
      if (answer.answer == Answer::none) --waiting_;
    }
  }
  std::chrono::milliseconds patience() const override { return waiting_ > 0 ? among_ranks : alone; }
  bool is_over() const override { return known_ == order_.size() && waiting_ == 0; }

 private:
  std::vector<std::size_t> order_;
  OutcomeSink sink_;
  Ranks* ranks_;
  std::size_t given_ = 0, known_ = 0;
  int waiting_ = 0;  ///< ranks that have not been sent home
};

class GivenWork final : public SharedWork {
 public:
  explicit GivenWork(Ranks& ranks) : ranks_(ranks) {}
  Next next() override {
    if (over_) return {Answer::none, 0};
    if (!asked_) ranks_.send(0, ask);
    asked_ = true;
    const auto message = ranks_.receive();
    if (!message) return {Answer::later, 0};
    asked_ = false;
    std::size_t task = 0;
    const std::string& text = message->text;
    if (text == no_more) over_ = true;
    if (over_ || std::from_chars(text.data(), text.data() + text.size(), task).ec != std::errc())
      return {Answer::none, 0};
    return {Answer::task, task};
  }
  void done(TaskOutcome outcome) override { ranks_.send(0, to_message(outcome)); }
  std::chrono::milliseconds patience() const override { return asked_ ? among_ranks : alone; }
  bool is_over() const override { return over_; }

 private:
  Ranks& ranks_;
  bool asked_ = false, over_ = false;
};

}  // namespace

std::string to_message(const TaskOutcome& outcome) {
  constexpr std::size_t most = 2000;  // a message this short never waits for its reader
  return Json{{"task", outcome.task},
              {"exit_code", outcome.exit_code},
              {"has_run", outcome.has_run},
              {"was_kept", outcome.was_kept},
              {"error", printable(outcome.error, most)}}
      .dump();
}

TaskOutcome outcome_from(std::string_view message) {
  try {
    const Json json = Json::parse(message);
    return {json.at("task").get<std::size_t>(), json.at("exit_code").get<int>(), json.at("has_run").get<bool>(),
            json.at("was_kept").get<bool>(), json.at("error").get<std::string>()};
  } catch (const Json::exception&) {
    throw std::invalid_argument("outcome_from: no outcome of a task");
  }
}

std::unique_ptr<SharedWork> own_work(std::vector<std::size_t> order, OutcomeSink sink, Ranks* ranks) {
  return std::make_unique<OwnWork>(std::move(order), std::move(sink), ranks);
}

std::unique_ptr<SharedWork> given_work(Ranks& ranks) {
  return std::make_unique<GivenWork>(ranks);
}

}  // namespace apps
