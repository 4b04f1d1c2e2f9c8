#include "fuzz/harness.hpp"
#include "support/uff.hpp"

std::vector<std::string> fuzz::seeds() {
  const std::vector<double> values{0.0, 1.5, -2.0, 3.0, 0.5, -1.0, 2.0, 4.0};
  support::Uff plain{values};
  std::vector<std::string> all;
  for (const bool is_binary : {false, true})
    for (const bool is_even : {true, false})
      for (const bool is_double : {false, true}) {
        support::Uff set = plain;
        set.is_binary = is_binary;
        set.is_even = is_even;
        set.is_double = is_double;
        set.is_big = is_double;
        all.push_back(support::uff_units(1000.0) + set.text() + set.text());
      }
  return all;
}
