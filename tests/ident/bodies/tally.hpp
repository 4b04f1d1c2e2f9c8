#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "ident/bodies/bodies.hpp"
#include "sim/noise.hpp"

namespace support {

/// With white noise of a fraction of its standard deviation.
inline Eigen::VectorXd noisy(Eigen::VectorXd x, double fraction, std::uint64_t seed, std::uint64_t number) {
  const double own = std::sqrt((x.array() - x.mean()).square().mean());
  const sim::Noise source(seed, number);
  for (Eigen::Index k = 0; k < x.size(); ++k) x(k) += fraction * own * source.normal(static_cast<std::uint64_t>(k));
  return x;
}

inline std::string key(int body, const std::string& term) {
  return fmt::format("{} {}", body, term);
}

/// How equations stand to the truth, which is by key; the force of z is none of it.
struct BodiesTally {
  int exact = 0, covered = 0, of = 0;
  std::vector<double> worst;
  void add(const ident::BodiesResult& result, const std::map<std::string, double>& truth) {
    const std::size_t known = result.model.layout.inner == ident::Inner::hysteresis ? 1 : 0;
    bool is_exact = result.silent_because.empty() && result.model.terms.size() == truth.size() + known;
    double largest = 0.0;
    int inside = 0;
    for (std::size_t i = 0; i < result.model.terms.size(); ++i) {
      if (known > 0 && result.model.terms[i] == ident::inner_force()) continue;
      const auto found = truth.find(key(result.model.terms[i].body, result.model.terms[i].name));
      is_exact = is_exact && found != truth.end();
      if (!is_exact) return;
      const auto at = static_cast<Eigen::Index>(i);
      const double error = std::abs(result.model.mean(at) - found->second);
      largest = std::max(largest, error / std::abs(found->second));
      inside += error < 1.96 * result.model.std(at) ? 1 : 0;
    }
    if (!is_exact) return;
    ++exact, covered += inside, of += static_cast<int>(truth.size());
    worst.push_back(largest);
  }
  [[nodiscard]] double median_worst() const {
    std::vector<double> sorted = worst;
    std::sort(sorted.begin(), sorted.end());
    return sorted.at(sorted.size() / 2);
  }
};

}  // namespace support
