#include "apps/batch/work.hpp"

#include <catch2/catch.hpp>
#include <deque>
#include <map>
#include <numeric>
#include <stdexcept>

#include "apps/batch/record_tasks.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"

namespace {

/// Ranks of one process: what one sends the other finds.
struct Network {
  std::map<int, std::deque<apps::Ranks::Message>> boxes;
};

class FakeRanks final : public apps::Ranks {
 public:
  FakeRanks(Network& network, int rank, int size) : network_(network), rank_(rank), size_(size) {}
  int rank() const override { return rank_; }
  int size() const override { return size_; }
  void send(int to, std::string_view text) override { network_.boxes[to].push_back({rank_, std::string(text)}); }
  std::optional<Message> receive() override {
    auto& box = network_.boxes[rank_];
    if (box.empty()) return std::nullopt;
    Message message = box.front();
    box.pop_front();
    return message;
  }
  void finish() override {}

 private:
  Network& network_;
  int rank_, size_;
};

}  // namespace

TEST_CASE("every task is given out once, whoever asks, and every outcome arrives", "[apps][batch]") {
  for (const int size : {1, 2, 5}) {
    Network network;
    std::vector<std::unique_ptr<FakeRanks>> ranks;
    for (int rank = 0; rank < size; ++rank) ranks.push_back(std::make_unique<FakeRanks>(network, rank, size));
    std::vector<std::size_t> order(23);
    std::iota(order.rbegin(), order.rend(), std::size_t{0});
    std::map<std::size_t, int> arrived;
    std::vector<std::unique_ptr<apps::SharedWork>> work;
    work.push_back(apps::own_work(
        order, [&](const apps::TaskOutcome& outcome) { arrived[outcome.task] += outcome.exit_code; },
        size > 1 ? ranks[0].get() : nullptr));
    for (int rank = 1; rank < size; ++rank) work.push_back(apps::given_work(*ranks[static_cast<std::size_t>(rank)]));
    std::vector<std::size_t> begun;
    for (int turn = 0; turn < 500 && !work.front()->is_over(); ++turn)
      for (std::size_t rank = 0; rank < work.size(); ++rank) {
        work[rank]->serve();
        if ((static_cast<std::size_t>(turn) + rank) % (rank + 1) != 0) continue;  // not all are equally fast
        const apps::SharedWork::Next next = work[rank]->next();
        if (next.answer != apps::SharedWork::Answer::task) continue;
        begun.push_back(next.task);
        work[rank]->done({.task = next.task, .exit_code = 1, .error = "[x] y"});
      }
    CAPTURE(size);
    for (const auto& one : work) {
      CHECK(one->next().answer == apps::SharedWork::Answer::none);
      CHECK(one->is_over());
    }
    CHECK(begun.front() == order.front());
    CHECK(begun.size() == order.size());
    CHECK(arrived.size() == order.size());
    for (const auto& [task, count] : arrived) CHECK(count == 1);
  }
}

TEST_CASE("an outcome survives being a message", "[apps][batch]") {
  const apps::TaskOutcome outcome{7, 4, true, true, "[name] text with \"quotes\" and \xff"};
  const apps::TaskOutcome again = apps::outcome_from(apps::to_message(outcome));
  CHECK(again.task == 7);
  CHECK(again.exit_code == 4);
  CHECK((again.has_run && again.was_kept));
  CHECK_THAT(again.error, Catch::Contains("\"quotes\""));
  CHECK(apps::to_message({.error = std::string(100'000, 'x')}).size() < 4000);
  CHECK_THROWS_AS(apps::outcome_from("next"), std::invalid_argument);
}

TEST_CASE("recordings of one name get names of their own, and a file named twice is refused", "[apps][batch]") {
  const support::Scratch folder;
  std::filesystem::create_directories(folder / "mon");
  std::filesystem::create_directories(folder / "tue");
  const std::vector<std::filesystem::path> files{
      folder.file("mon/Rec 1.csv", "1"),
      folder.file("tue/Rec 1.csv", "22"),
      folder.file("mon/Rec 1.wav", "4444"),
      folder.file("tue/other.csv", "333"),
      folder / "gone.csv",
  };
  const auto tasks = apps::record_tasks(files);
  REQUIRE(tasks.size() == 5);
  CHECK(tasks[0].name == "mon-rec_1_csv");
  CHECK(tasks[1].name == "tue-rec_1_csv");
  CHECK(tasks[2].name == "rec_1_wav");
  CHECK(tasks[3].name == "other");
  CHECK(tasks[4].bytes == 0);
  CHECK(apps::longest_first(tasks) == std::vector<std::size_t>{2, 3, 1, 0, 4});
  support::check_fault(
      [&] {
        (void)apps::record_tasks({files[0], folder / "tue/../mon/Rec 1.csv"});
      },
      dsp::FaultKind::usage, "batch.twice", {"is given twice, also as"});
}
