#include "apps/batch/work.hpp"

#include <catch2/catch.hpp>
#include <deque>
#include <map>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "apps/batch/record_tasks.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"

namespace {

/// Ranks of one process: what one sends the other finds.
struct Network {
  std::mutex lock;
  std::map<int, std::deque<apps::Ranks::Message>> boxes;
};

class FakeRanks final : public apps::Ranks {
 public:
  FakeRanks(Network& network, int rank, int size) : network_(network), rank_(rank), size_(size) {}
  int rank() const override { return rank_; }
  int size() const override { return size_; }
  void send(int to, std::string_view text) override {
    const std::lock_guard hold(network_.lock);
    network_.boxes[to].push_back({rank_, std::string(text)});
  }
  std::optional<Message> receive() override {
    const std::lock_guard hold(network_.lock);
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

/// Tasks end one at a time, each at the call that its rank is slow by.
class FakeWorkplace final : public apps::Workplace {
 public:
  FakeWorkplace(int num_places, int slowness) : num_places_(num_places), slowness_(slowness) {}
  int num_places() const override { return num_places_; }
  void start(std::size_t task) override {
    begun.push_back(task);
    running_.push_back(task);
    most_running = std::max(most_running, static_cast<int>(running_.size()));
  }
  std::vector<apps::TaskOutcome> ended(std::chrono::milliseconds) override {
    std::this_thread::yield();
    if (running_.empty() || ++calls_ % slowness_ != 0) return {};
    const std::size_t task = running_.front();
    running_.pop_front();
    return {{.task = task, .exit_code = 1, .error = "[x] y"}};
  }
  std::vector<std::size_t> begun;
  int most_running = 0;

 private:
  int num_places_, slowness_, calls_ = 0;
  std::deque<std::size_t> running_;
};

}  // namespace

TEST_CASE("every task is given out once, and every outcome arrives", "[apps][batch]") {
  for (const auto& [size, num_places] : {std::pair{1, 1}, {1, 3}, {2, 1}, {5, 2}}) {
    CAPTURE(size, num_places);
    Network network;
    std::vector<std::unique_ptr<FakeRanks>> ranks;
    std::vector<std::unique_ptr<FakeWorkplace>> places;
    for (int rank = 0; rank < size; ++rank) {
      ranks.push_back(std::make_unique<FakeRanks>(network, rank, size));
      places.push_back(std::make_unique<FakeWorkplace>(num_places, rank + 1));  // not all are equally fast
    }
    std::vector<std::size_t> order(23);
    std::iota(order.rbegin(), order.rend(), std::size_t{0});
    std::map<std::size_t, int> arrived;
    std::vector<std::thread> others;
    for (std::size_t rank = 1; rank < ranks.size(); ++rank)
      others.emplace_back([&, rank] { apps::take_tasks(*places[rank], *ranks[rank], [] {}); });
    apps::deal_tasks(
        order, *places[0], size > 1 ? ranks[0].get() : nullptr,
        [&](const apps::TaskOutcome& outcome) { arrived[outcome.task] += outcome.exit_code; }, [] {});
    apps::send_home(*ranks[0]);
    for (std::thread& other : others) other.join();
    std::vector<std::size_t> begun;
    for (const auto& place : places) {
      begun.insert(begun.end(), place->begun.begin(), place->begun.end());
      CHECK(place->most_running <= num_places);
    }
    CHECK(begun.front() == order.front());
    CHECK(begun.size() == order.size());
    CHECK(arrived.size() == order.size());
    for (const auto& [task, count] : arrived) CHECK(count == 1);
  }
}

TEST_CASE("ranks that are sent home before there is a task go, and one that is stopped stops", "[apps][batch]") {
  Network network;
  FakeRanks lead(network, 0, 2), other(network, 1, 2);
  FakeWorkplace place(1, 1);
  apps::send_home(lead);
  apps::take_tasks(place, other, [] {});
  CHECK(place.begun.empty());
  CHECK_THROWS_AS(
      apps::deal_tasks(
          {0}, place, nullptr, [](const apps::TaskOutcome&) {}, [] { throw std::runtime_error("stopped"); }),
      std::runtime_error);
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
