#include "ident/equation/equation_oscillator.hpp"

#include <catch2/catch.hpp>

#include "sim/ode/steady_response.hpp"

TEST_CASE("an equation for the payload's absolute acceleration answers as that for the relative one",
          "[ident][equation_oscillator]") {
  ident::IdentifiedEquation relative{.target = "a", .terms = {"x", "v", "sgn(v)", "ddr"}, .base_measured = true};
  ident::IdentifiedEquation absolute{.target = "ddy", .terms = {"x", "v", "sgn(v)"}, .base_measured = true};
  ident::IdentifiedEquation grounded{.target = "ddy", .terms = {"y", "r", "dy", "sgn(dy)"}, .base_measured = true};
  ident::IdentifiedEquation same{.target = "a", .terms = {"y", "r", "dy", "sgn(dy)", "ddr"}, .base_measured = true};
  const auto answer = [](const ident::IdentifiedEquation& equation, const Eigen::VectorXd& coefficients) {
    return sim::steady_response(ident::equation_oscillator(equation, coefficients).oscillator,
                                {.from_hz = 0.9, .to_hz = 1.5, .step_hz = 0.2})
        .response;
  };
  const auto a = answer(relative, Eigen::Vector4d(-50.0, -0.8, -0.08, -1.0));
  const auto b = answer(absolute, Eigen::Vector3d(-50.0, -0.8, -0.08));
  const auto c = answer(grounded, Eigen::Vector4d(-50.0, 50.0, -0.8, -0.08));
  const auto d = answer(same, (Eigen::VectorXd(5) << -50.0, 50.0, -0.8, -0.08, -1.0).finished());
  for (std::size_t k = 0; k < a.up.size(); ++k) {
    CHECK(b.up[k].x_m == Approx(a.up[k].x_m).epsilon(1e-12));
    CHECK(d.up[k].x_m == Approx(c.up[k].x_m).epsilon(1e-12));
    CHECK(c.up[k].x_m != Approx(a.up[k].x_m).epsilon(0.01));
  }
}
