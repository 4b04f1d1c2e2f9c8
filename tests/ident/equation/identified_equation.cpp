#include "ident/equation/identified_equation.hpp"

#include <catch2/catch.hpp>
#include <cmath>

TEST_CASE("draws of the coefficients have the covariance they are drawn from", "[ident][identified_equation]") {
  ident::IdentifiedEquation equation;
  equation.mean = Eigen::Vector3d(1e5, -2.0, 3e-4);
  const Eigen::Vector3d deviation(100.0, 0.1, 1e-6);
  Eigen::Matrix3d correlation;
  correlation << 1.0, 0.8, -0.3, 0.8, 1.0, 0.1, -0.3, 0.1, 1.0;
  equation.covariance = deviation.asDiagonal() * correlation * deviation.asDiagonal();
  constexpr int count = 4000;
  Eigen::Matrix3d found = Eigen::Matrix3d::Zero();
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d z =
        (ident::drawn_coefficients(equation.mean, equation.covariance, 7, static_cast<std::uint64_t>(k)) -
         equation.mean)
            .cwiseQuotient(deviation);
    found += z * z.transpose() / count;
  }
  CHECK((found - correlation).cwiseAbs().maxCoeff() < 4.0 * std::sqrt(2.0 / count));  // four standard errors
}
