#include "ident/equation/model.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/motion.hpp"
#include "support/random.hpp"

using Eigen::VectorXd;

namespace {

ident::Model two_term_model(double stiffness, double friction, double std) {
  return {"a",
          "m/s^2",
          {{"x", "1/s^2", 0, stiffness, std, std, 1.0, 50.0, 1.0},
           {"sgn(v)", "m/s^2", 1, friction, std, std, 1.0, 50.0, 1.0}},
          0.1};
}

}  // namespace

TEST_CASE("a model reads like an equation", "[ident][model]") {
  CHECK(ident::to_text(two_term_model(-50.25, 0.08, 0.1)) == "a = -50.25 x + 0.08 sgn(v)");
  CHECK(ident::to_text({"a", "m/s^2", {}, 0.0}) == "a = 0");
  CHECK(ident::to_latex(two_term_model(-50.25, 0.08, 0.1)) ==
        "\\ddot{x} = -\\underset{(0.002)}{50.25}\\,x +\\underset{(1.2)}{0.08}\\,\\operatorname{sgn}(\\dot{x})");
}

TEST_CASE("terms that are sums or have signs are in brackets behind their coefficients", "[ident][model]") {
  const auto texts = [](const std::string& term) {
    const ident::Model model{"a", "m/s^2", {{term, "", 0, -2500.0}}};
    return ident::to_text(model) + " | " + ident::to_latex(model);
  };
  CHECK(texts("x+x^3") == "a = -2500 (x+x^3) | \\ddot{x} = -\\underset{(0)}{2500}\\,(x+x^{3})");
  CHECK_THAT(texts("-2^2*x^3"), Catch::Contains("a = -2500 (-2^2*x^3)") && Catch::Contains("\\,(-2^{2} x^{3})"));
  CHECK_THAT(texts("2*x"), Catch::Contains("-2500 (2*x)"));
  CHECK_THAT(texts("v>0"), Catch::Contains("-2500 (v>0)"));
  CHECK_THAT(texts("(x+1)*v"), Catch::Contains("-2500 (x+1)*v"));
  CHECK_THAT(texts("v*2^-x"), Catch::Contains("-2500 v*2^-x"));
}

TEST_CASE("a model carries units, scales and probabilities of its fit", "[ident][model]") {
  const VectorXd x = support::gaussian(200, 1, 1), v = support::gaussian(200, 1, 2);
  const auto motion = support::motion_of(10.0, {{"x", x}, {"v", v}});
  const auto library = ident::make_library({.order = 2}, "a", motion);
  Eigen::MatrixXd phi(200, 6);
  for (Eigen::Index j = 0; j < 6; ++j)
    phi.col(j) = library.terms[static_cast<std::size_t>(j)].expression.evaluate(motion);
  const auto fit = ident::fit_fast_rvm(ident::r_factor(phi, -4.0 * x + 0.1 * support::gaussian(200, 1, 3)));
  const VectorXd scale = phi.cwiseAbs().colwise().maxCoeff();
  const auto model = ident::make_model(library, fit, "a", "m/s^2", scale, {});
  REQUIRE(model.terms.size() == 1);
  CHECK(model.terms[0].name == "x");
  CHECK(model.terms[0].unit == "1/s^2");
  CHECK(model.terms[0].scale == scale(1));
  CHECK(model.terms[0].inclusion_probability > 0.999);
  const auto wider = ident::make_model(library, fit, "a", "m/s^2", scale, 9.0 * fit.covariance);
  CHECK(wider.terms[0].std == Approx(3.0 * std::sqrt(fit.covariance(0, 0))));
  CHECK(wider.covariance(0, 0) == Approx(wider.terms[0].std * wider.terms[0].std));
  CHECK(model.terms[0].coefficient_of_variation() == Approx(-1.0 / model.terms[0].t()));
  CHECK(model.noise_std == Approx(0.1).epsilon(0.2));  // 200 rows: 5 % standard error
}

TEST_CASE("two equations say what they do not agree on", "[ident][model]") {
  const auto a = two_term_model(-50.0, 0.08, 0.01);
  CHECK(ident::disagreements(a, "low", two_term_model(-50.01, 0.08, 0.01), "high").empty());
  const auto sign = ident::disagreements(a, "low", two_term_model(-50.0, -0.08, 0.01), "high");
  REQUIRE(sign.size() == 1);
  CHECK(sign[0].sentence == "sgn(v): 0.08 in low, -0.08 in high: opposite signs");
  const auto apart = ident::disagreements(a, "low", two_term_model(-51.0, 0.08, 0.01), "high");
  REQUIRE(apart.size() == 1);
  CHECK(apart[0].sentence == "x: -50 in low, -51 in high: 71 standard deviations apart");
  auto b = a;
  b.terms.pop_back();
  const auto missing = ident::disagreements(b, "low", a, "high");
  REQUIRE(missing.size() == 1);
  CHECK(missing[0].sentence == "sgn(v) is in high (0.08) and not in low");
  const auto other_way = ident::disagreements(a, "low", b, "high");
  REQUIRE(other_way.size() == 1);
  CHECK(other_way[0].sentence == "sgn(v) is in low (0.08) and not in high");
}
