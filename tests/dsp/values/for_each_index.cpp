#include "dsp/values/for_each_index.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <vector>

TEST_CASE("every index is visited once, whatever the number of threads", "[dsp][threads]") {
  for (const int num_threads : {-1, 0, 1, 3, 100}) {
    std::vector<std::atomic<int>> visits(1000);
    dsp::for_each_index(visits.size(), num_threads, [&](std::size_t i) { ++visits[i]; });
    for (const auto& count : visits) CHECK(count == 1);
  }
  dsp::for_each_index(0, 4, [](std::size_t) { FAIL("nothing to visit"); });
}

TEST_CASE("what an action throws in a thread reaches the caller, and no further work is begun", "[dsp][threads]") {
  for (const int num_threads : {1, 4}) {
    std::atomic<int> begun = 0;
    CHECK_THROWS_WITH(dsp::for_each_index(1'000'000, num_threads,
                                          [&](std::size_t i) {
                                            ++begun;
                                            throw std::runtime_error(std::to_string(i));
                                          }),
                      "0");
    CHECK(begun <= num_threads);
  }
}
