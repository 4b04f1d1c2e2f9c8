#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace kinds {

/// Random numbers that are the same with every standard library (splitmix64: Steele, Lea, Flood, OOPSLA 2014).
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t index, std::uint64_t draw) : state_(seed) {
    state_ = next() ^ index;
    state_ = next() ^ draw;
  }
  double uniform(double from = 0.0, double to = 1.0) {
    return from + (to - from) * static_cast<double>(next() >> 11) * 0x1p-53;
  }
  double log_uniform(double from, double to) { return std::exp(uniform(std::log(from), std::log(to))); }
  double sign() { return uniform() < 0.5 ? -1.0 : 1.0; }
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }
  template <class List>
  auto pick(const List& list) {
    return list[static_cast<std::size_t>(uniform() * static_cast<double>(list.size()))];
  }

 private:
  std::uint64_t next() {
    std::uint64_t mixed = state_ += 0x9e3779b97f4a7c15U;
    mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9U;
    mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111ebU;
    return mixed ^ (mixed >> 31);
  }
  std::uint64_t state_;
};

}  // namespace kinds
