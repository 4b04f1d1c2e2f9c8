#pragma once
#include <cmath>
#include <cstdint>

namespace sim {

/// Steele, Lea & Flood's generator as a function of its counter: any draw by its number, the same on every machine.
[[nodiscard]] constexpr std::uint64_t splitmix64(std::uint64_t z) {
  z += 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

/// White noise of mean 0 and standard deviation 1, one independent sequence for each seed and id.
class Noise {
 public:
  constexpr Noise(std::uint64_t seed, std::uint64_t id) : key_(splitmix64(seed * 1000003u + id)) {}

  /// Nearly normal, by integer arithmetic: the sum of four 16-bit numbers, within 3.46 standard deviations.
  [[nodiscard]] constexpr double at(std::uint64_t i) const {
    const std::uint64_t z = splitmix64(i ^ key_);
    const auto sum = (z & 0xFFFFu) + ((z >> 16) & 0xFFFFu) + ((z >> 32) & 0xFFFFu) + (z >> 48);
    return (static_cast<double>(sum) - 131070.0) / 37837.22667;
  }

  /// Normal, by Box and Muller.
  [[nodiscard]] double normal(std::uint64_t i) const {
    constexpr double unit = 1.0 / 9007199254740992.0;  // 2^-53
    const double u = static_cast<double>((splitmix64((2 * i) ^ key_) >> 11) + 1) * unit;
    const double turn = static_cast<double>(splitmix64((2 * i + 1) ^ key_) >> 11) * unit;
    return std::sqrt(-2.0 * std::log(u)) * std::cos(6.283185307179586 * turn);
  }

 private:
  std::uint64_t key_;
};

}  // namespace sim
