#include "dsp/io/survives.hpp"

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <stdexcept>

TEST_CASE("what brings a process down is seen from beside it", "[dsp][survives]") {
  int here = 0;
  CHECK(dsp::survives([&] { here = 1; }));
  CHECK(here == 0);  // it happened elsewhere
  CHECK(dsp::survives([] { throw std::runtime_error("said by the parent"); }));
  CHECK_FALSE(dsp::survives([] { std::raise(SIGSEGV); }));
  CHECK_FALSE(dsp::survives([] { std::abort(); }));
}
