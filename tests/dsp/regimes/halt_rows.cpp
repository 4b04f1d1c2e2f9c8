#include "dsp/regimes/halt_rows.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double against = -3.0, weak = 1.0, clear = 8.0, certain = 40.0;

VectorXd plain() {
  return VectorXd::Constant(500, against);
}

}  // namespace

TEST_CASE("reversals that speak against a halt have none", "[dsp][halt_rows]") {
  CHECK(dsp::halt_probabilities(plain()).maxCoeff() < 0.01);
  CHECK(dsp::halt_probabilities(VectorXd()).size() == 0);
}

TEST_CASE("a halt alone must be as clear as switches are rare", "[dsp][halt_rows]") {
  for (const auto& [log_ratio, halts] : {std::pair{weak, false}, {clear, false}, {certain, true}}) {
    VectorXd log_ratios = plain();
    log_ratios(200) = log_ratio;
    CHECK((dsp::halt_probabilities(log_ratios)(200) > 0.5) == halts);
  }
}

TEST_CASE("a weak halt is carried by clear ones beside it, and a reversal between them without one is not",
          "[dsp][halt_rows]") {
  VectorXd log_ratios = plain();
  for (Index k = 200; k < 240; ++k) log_ratios(k) = k == 220 ? weak : k == 230 ? against : clear;
  const VectorXd halts = dsp::halt_probabilities(log_ratios);
  CHECK(halts(210) > 0.99);
  CHECK(halts(220) > 0.9);
  CHECK(halts(230) < 0.75);
  CHECK(halts(100) < 0.01);
}

TEST_CASE("what is likelier without a halt speaks against one by no more than its range allows", "[dsp][halt_rows]") {
  const double least = std::log(std::sqrt(2.0 * std::numbers::pi) / 100.0);
  CHECK(dsp::log_ratio_of_halt(-5.0, 1.0, 100.0) == Approx(least));
  CHECK(dsp::log_ratio_of_halt(3.0, 1.0, 100.0) == Approx(4.5 + least));
  CHECK(dsp::log_ratio_of_halt(0.0, 1.0, 0.5) == 0.0);  // a range within the noise says nothing
  // Without noise a sign is certain, either way, and a number.
  const VectorXd exact = (VectorXd(3) << dsp::log_ratio_of_halt(1e-3, 0.0, 1.0), dsp::log_ratio_of_halt(0.0, 0.0, 1.0),
                          dsp::log_ratio_of_halt(-1.0, 0.0, 1.0))
                             .finished();
  const VectorXd halts = dsp::halt_probabilities(exact);
  CHECK(halts(0) > 0.99);
  CHECK(halts(1) < 0.01);
  CHECK(halts(2) < 0.01);
}
