#include "dsp/values/recording.hpp"

#include <catch2/catch.hpp>

TEST_CASE("every role has a name that leads back to it", "[dsp][recording]") {
  for (int i = 0; i <= static_cast<int>(dsp::Role::z); ++i) {
    const auto role = static_cast<dsp::Role>(i);
    CHECK(dsp::role_from_string(dsp::to_string(role)) == role);
  }
  CHECK_THROWS_AS(dsp::role_from_string("payload"), std::invalid_argument);
}
