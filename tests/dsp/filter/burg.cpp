#include "dsp/filter/burg.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/signals.hpp"

TEST_CASE("the predictor of an autoregressive process is the process", "[dsp][burg]") {
  const Eigen::Vector2d truth(1.6, -0.81);
  const Eigen::Index n = 40000;
  Eigen::VectorXd x = support::gaussian(n, 11);
  for (Eigen::Index i = 2; i < n; ++i) x(i) += truth(0) * x(i - 1) + truth(1) * x(i - 2);
  const Eigen::VectorXd k = dsp::burg(x, 2);
  // Levinson's recursion backwards: k2 = a2, k1 = a1 / (1 - a2). Asymptotic standard error sqrt((1 - a2^2) / n), times
  // four.
  const double tolerance = 4 * std::sqrt((1 - 0.81 * 0.81) / static_cast<double>(n));
  CHECK(k(1) == Approx(truth(1)).margin(tolerance));
  CHECK(k(0) * (1 - k(1)) == Approx(truth(0)).margin(tolerance));
}

TEST_CASE("each reflection coefficient minimises the forward and backward error power", "[dsp][burg]") {
  const Eigen::Index n = 50, order = 3;
  const Eigen::VectorXd x = support::gaussian(n, 12) + Eigen::VectorXd::LinSpaced(n, 0.0, 9.0).array().sin().matrix();
  // The order-m predictor extends the order-(m-1) one by Levinson's recursion with some k; written out directly.
  const auto error_power = [&](const Eigen::VectorXd& a) {
    double sum = 0.0;
    for (Eigen::Index i = a.size(); i < n; ++i) {
      double forward = x(i), backward = x(i - a.size());
      for (Eigen::Index j = 0; j < a.size(); ++j) {
        forward -= a(j) * x(i - 1 - j);
        backward -= a(j) * x(i - a.size() + 1 + j);
      }
      sum += forward * forward + backward * backward;
    }
    return sum;
  };
  const auto levinson = [](const Eigen::VectorXd& shorter, double k) {
    Eigen::VectorXd a(shorter.size() + 1);
    a.head(shorter.size()) = shorter - k * shorter.reverse();
    a(shorter.size()) = k;
    return a;
  };
  const Eigen::VectorXd k = dsp::burg(x, order);
  Eigen::VectorXd shorter(0);
  for (Eigen::Index m = 0; m < order; ++m) {
    const double best = error_power(levinson(shorter, k(m)));
    CHECK(best <= error_power(levinson(shorter, k(m) + 1e-4)));
    CHECK(best <= error_power(levinson(shorter, k(m) - 1e-4)));
    shorter = levinson(shorter, k(m));
  }
  // The lattice predicts what the direct form sum a_j x_(n-1-j) predicts.
  const Eigen::VectorXd after = dsp::predict_forward(x, k, 2);
  CHECK(after(0) == Approx(shorter.dot(x.tail(order).reverse())));
  CHECK(after(1) == Approx(shorter(0) * after(0) + shorter.tail(2).dot(x.tail(2).reverse())));
}

TEST_CASE("noise-free tones are continued, before and after", "[dsp][burg]") {
  const auto tone = [](double i) { return std::sin(0.21 * i + 0.3) + 0.2 * std::cos(0.63 * i); };
  const Eigen::VectorXd x =
      Eigen::VectorXd::NullaryExpr(600, [&](Eigen::Index i) { return tone(static_cast<double>(i)); });
  const dsp::ExtensionOptions options{.num_samples = 100, .order = 64, .fit_samples = 512};
  const Eigen::VectorXd after = dsp::extend_after(x, options), before = dsp::extend_before(x, options);
  for (Eigen::Index i = 0; i < 100; ++i) {
    // Burg's windowless estimate still shifts a tone by a little; over two periods it stays within a part in a
    // thousand.
    CHECK(after(i) == Approx(tone(600.0 + static_cast<double>(i))).margin(2e-3));
    CHECK(before(i) == Approx(tone(static_cast<double>(i) - 100.0)).margin(2e-3));
  }
}

TEST_CASE("nothing is predicted to blow up", "[dsp][burg]") {
  for (const Eigen::VectorXd& x :
       {Eigen::VectorXd(Eigen::VectorXd::Zero(300)), Eigen::VectorXd(Eigen::VectorXd::Ones(300)),
        Eigen::VectorXd(Eigen::VectorXd::LinSpaced(300, -1.0, 5.0)), Eigen::VectorXd(Eigen::VectorXd::Unit(300, 299)),
        support::gaussian(300, 13)}) {
    const dsp::ExtensionOptions options{.num_samples = 20000, .order = 100, .fit_samples = 300};
    const Eigen::VectorXd after = dsp::extend_after(x, options);
    REQUIRE(after.allFinite());
    CHECK(after.cwiseAbs().maxCoeff() <= 3 * x.cwiseAbs().maxCoeff());
  }
  CHECK_THROWS_AS(dsp::burg(Eigen::VectorXd::Ones(5), 5), std::invalid_argument);
}
