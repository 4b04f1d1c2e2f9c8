#include "dsp/samples/hold_length.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace test_hold_length {

TEST_CASE("a channel that holds its values is told from one that rests", "[dsp][hold_length]") {
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  const auto held_by = [&](int samples, int shift, int count) {
    dsp::HoldLength hold;
    double value = noise(random);
    for (int i = 0; i < count; ++i) {
      if (i % samples == shift) value = noise(random);
      hold.push(value);
    }
    return hold.samples();
  };
  for (const int samples : {2, 4, 5, 16})
    for (const int shift : {0, 1}) CHECK(held_by(samples, shift, 80 * samples) == samples);
  CHECK(held_by(4, 3, 4 * 60) == 1);  // too few to tell
  CHECK(held_by(1, 0, 1000) == 1);

  // Coarse steps of a slow motion change anywhere; one late update among many spoils a hold.
  dsp::HoldLength coarse, spoilt, rests;
  for (int i = 0; i < 4000; ++i) {
    coarse.push(std::round(10.0 * std::sin(0.01 * i)));
    spoilt.push(std::sin(static_cast<double>((i + (i > 2000 ? 1 : 0)) / 4)));
    rests.push(i % 400 < 40 ? static_cast<double>(i / 2) : -1.0);  // moves by two, then stands
  }
  CHECK(coarse.samples() == 1);
  CHECK(spoilt.samples() == 1);
  CHECK(spoilt.holds_none());
  CHECK(rests.samples() == 1);

  // Pieces of a record, each by itself.
  dsp::HoldLength pieces;
  for (int piece = 0; piece < 5; ++piece) {
    for (int i = 0; i < 100; ++i) pieces.push(std::sin(static_cast<double>((i + piece) / 4)));
    pieces.restart();
  }
  CHECK(pieces.samples() == 4);
}

}  // namespace test_hold_length
