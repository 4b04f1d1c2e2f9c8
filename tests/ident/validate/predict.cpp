#include "ident/validate/predict.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/random.hpp"

using Eigen::Index;
using Eigen::VectorXd;

TEST_CASE("the noise of a displacement is told from its motion", "[ident][predict]") {
  VectorXd motion(4000);
  for (Index i = 0; i < motion.size(); ++i) motion(i) = std::cos(0.1 * static_cast<double>(i));
  for (const double noise_std : {1e-2, 1e-4}) {
    const VectorXd noise = noise_std * support::gaussian(motion.size(), 1, 3);
    // Differences of order 8 know it to 1.5 times the deviation of 4000 white values, 1.7 %.
    CHECK(ident::white_noise_std(motion + noise) == Approx(noise_std).epsilon(0.07));
  }
}
