#include "ident/selection/effective_size.hpp"

#include <algorithm>

namespace ident {

double EffectiveSize::num_effective() const {
  if (!(num_uncorrelated > 0.0)) return num_rows;
  const double known = num_states > 0.0 ? std::min(num_uncorrelated, num_states) : num_uncorrelated;
  const double noise = num_noise > 0.0 ? num_noise : num_uncorrelated;
  return 1.0 / ((1.0 - structural_fraction) / noise + structural_fraction / known);
}

double EffectiveSize::fraction() const {
  return num_rows > 0.0 ? num_effective() / num_rows : 1.0;
}

EffectiveSize together(const std::vector<EffectiveSize>& records) {
  EffectiveSize sum;
  for (const EffectiveSize& record : records) {
    sum.num_rows += record.num_rows;
    sum.num_uncorrelated += record.num_uncorrelated;
    sum.num_states = std::max(sum.num_states, record.num_states);
    sum.structural_fraction += record.structural_fraction * record.num_rows;
  }
  if (sum.num_rows > 0.0) sum.structural_fraction /= sum.num_rows;
  return sum;
}

}  // namespace ident
