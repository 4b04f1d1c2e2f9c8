#include "sim/ode/driven.hpp"

#include <algorithm>
#include <cmath>

namespace sim {

void Range::extend(double z0, double dz0, double z1, double dz1, double h) {
  low = std::min({low, z0, z1}), high = std::max({high, z0, z1});
  if (!(dz0 * dz1 < 0.0)) return;
  // z'(u) / h = a u^2 + b u + dz0 h, u from 0 to 1.
  const double d0 = h * dz0, d1 = h * dz1, rise = z1 - z0;
  const double a = 3.0 * (d0 + d1 - 2.0 * rise), b = 2.0 * (3.0 * rise - 2.0 * d0 - d1);
  const double root = std::sqrt(std::max(b * b - 4.0 * a * d0, 0.0));
  const double u = 2.0 * d0 / (d0 > 0.0 ? -b + root : -b - root);
  if (!(u > 0.0 && u < 1.0)) return;
  const double z = z0 + u * (d0 + u * (0.5 * b + u * a / 3.0));
  low = std::min(low, z), high = std::max(high, z);
}

}  // namespace sim
