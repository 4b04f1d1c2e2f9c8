// `ardent fit` on tables that leave little to find, by every method: exit code and what is said.
#include <catch2/catch.hpp>

#include "support/program.hpp"

using support::Scratch;

namespace {

constexpr const char* all_methods = "fast_rvm,slow_rvm,multi_rvm,sindy,lasso,ridge,ols";

struct Table {
  std::string text = "y,u,w\n";
  void row(double y, double u, double w) {
    text += std::to_string(y) + "," + std::to_string(u) + "," + std::to_string(w) + "\n";
  }
};

/// A table of 60 rows with y = of(u, w), u and w without pattern.
template <class Of>
Table table(Of&& of, int rows = 60) {
  Table made;
  for (int i = 0; i < rows; ++i) {
    const double u = 3.0 * std::sin(1.7 * i * i + 0.3), w = 2.0 * std::cos(2.9 * i * i);
    made.row(of(u, w, i), u, w);
  }
  return made;
}

support::Ended fit(const Table& made, const std::string& terms, const std::string& methods,
                   const std::string& more = "") {
  const Scratch folder;
  (void)folder.file("t.csv", made.text);
  return support::run(folder, "$ARDENT fit t.csv --target y --terms '" + terms + "' --methods " + methods + " " + more);
}

double hash_noise(int i) {
  return std::sin(12.9898 * i * i * i + 78.233 * i);
}

}  // namespace

TEST_CASE("a zero target is code 4 for each method", "[apps][fit_faults]") {
  const Table zero = table([](double, double, int) { return 0.0; });
  for (const std::string method : {"fast_rvm", "slow_rvm", "multi_rvm", "sindy", "lasso", "ridge", "ols"}) {
    CAPTURE(method);
    const auto ended = fit(zero, "1,u,w", method);
    CHECK(ended.code == 4);
    CHECK_THAT(ended.err, Catch::Contains("[fit.nothing_selected]"));
    CHECK_THAT(ended.out, Catch::Contains("zero_target"));
  }
}

TEST_CASE("a column of zeros and a second constant are dropped by name", "[apps][fit_faults]") {
  const auto ended = fit(table([](double u, double, int i) { return 2.0 * u + 0.1 * hash_noise(i); }),
                         "1,u,0*w,cos(0*w)", all_methods);
  CHECK(ended.code == 0);
  CHECK_THAT(ended.out, Catch::Contains("left out: 0*w (zero on all training rows)") &&
                            Catch::Contains("left out: cos(0*w) (constant on the training rows, as 1 is)"));
}

TEST_CASE("fewer rows than terms is code 4 where no method copes, and ridge copes without error bars",
          "[apps][fit_faults]") {
  const Table few = table([](double u, double w, int i) { return u - w + hash_noise(i); }, 4);
  const auto refused = fit(few, "1,u,w,u^2,w^2,u*w,u^3", "sindy,ols");
  CHECK(refused.code == 4);
  CHECK_THAT(refused.err, Catch::Contains("[fit.not_determined]") && Catch::Contains("sindy ended as too_few_rows"));
  for (const std::string method : {"lasso", "fast_rvm", "slow_rvm", "multi_rvm"}) {
    CAPTURE(method);
    const auto one = fit(few, "1,u,w,u^2,w^2,u*w,u^3", method);
    CHECK((one.code == 0 || one.code == 4));
    CHECK(one.out.find("+- 0 ") == std::string::npos);
    CHECK(one.out.find("nan") == std::string::npos);
  }
  const auto ridge = fit(few, "1,u,w,u^2,w^2,u*w,u^3", "ridge", "--json");
  CHECK(ridge.code == 0);
  CHECK_THAT(ridge.out, Catch::Contains("\"std\": null") && Catch::Contains("no row is left to estimate the noise"));
  CHECK_THAT(fit(few, "1,u,w,u^2,w^2,u*w,u^3", "ridge").out,
             Catch::Contains("4 rows for 7 terms") && !Catch::Contains("nan"));
}

TEST_CASE("a standard deviation whose square is beyond a double is left out with that reason", "[apps][fit_faults]") {
  Table tiny;
  for (int i = 0; i < 60; ++i) {
    const double u = std::sin(1.7 * i * i), w = std::cos(2.9 * i * i);
    tiny.text += std::to_string(3.0 * u - w + 0.1 * hash_noise(i)) + "e-160," + std::to_string(u) + "," +
                 std::to_string(w) + "\n";
  }
  for (const std::string method : {"fast_rvm", "ols"}) {
    const auto ended = fit(tiny, "u,w", method, "--json");
    CHECK(ended.code == 0);
    CHECK_THAT(ended.out,
               Catch::Contains("\"std_reason\": \"a variance in these units is beyond what a double holds") &&
                   Catch::Contains("\"noise_std_reason\": \"a variance in these units") &&
                   !Catch::Contains("no row is left") && !Catch::Contains("too few rows\""));
    CHECK_THAT(fit(tiny, "u,w", method).out, Catch::Contains("no standard deviations: a variance in these units"));
  }
}

TEST_CASE("columns that add up are distinguished from those that do not", "[apps][fit_faults]") {
  const Table sums = table([](double u, double w, int i) { return 3.0 * u - w + 0.1 * hash_noise(i); });
  const auto ols = fit(sums, "u,w,u+w", "ols");
  CHECK(ols.code == 4);
  CHECK_THAT(ols.out, Catch::Contains("u+w was left out: on the training rows it is a combination of u, w") &&
                          !Catch::Contains("e+11 u") && Catch::Contains("y = 2.99963 u - 0.999425 w"));
  CHECK_THAT(ols.err, Catch::Contains("ols ended as rank_deficient"));
  CHECK(fit(sums, "u,w,u+w", "fast_rvm,ols").code == 0);
}

TEST_CASE("terms that are not finite are dropped with row and value, all of them code 4", "[apps][fit_faults]") {
  const Table plain = table([](double u, double, int i) { return 2.0 * u + 0.1 * hash_noise(i); });
  const auto some = fit(plain, "u,log(w),exp(1000*u)", all_methods);
  CHECK(some.code == 0);
  CHECK_THAT(some.out, Catch::Contains("left out: log(w) (not finite") && Catch::Contains("left out: exp(1000*u)"));
  const auto none = fit(plain, "log(-1-w^2)", all_methods);
  CHECK(none.code == 4);
  CHECK_THAT(none.err, Catch::Contains("[library.nothing_left]"));
}

TEST_CASE("an exact and a constant target give finite figures by every method", "[apps][fit_faults]") {
  for (const bool constant : {false, true}) {
    const Table exact = table([&](double u, double w, int) { return constant ? 5.0 : 2.0 * u - w; });
    const auto ended = fit(exact, "1,u,w,u^2", all_methods, "--json");
    CHECK(ended.code == 0);
    CHECK(ended.out.find("nan") == std::string::npos);
    CHECK(ended.out.find("inf") == std::string::npos);
    if (constant) CHECK_THAT(ended.out, Catch::Contains("the target is constant on the training rows"));
  }
}

TEST_CASE("nothing selected is code 4, everything selected a remark", "[apps][fit_faults]") {
  const Table noise = table([](double, double, int i) { return hash_noise(i); });
  CHECK(fit(noise, "u,w", "fast_rvm,slow_rvm,multi_rvm").code == 4);
  const Table all = table([](double u, double w, int i) { return 1.0 + u - w + 0.01 * hash_noise(i); });
  CHECK_THAT(fit(all, "1,u,w", "fast_rvm").out, Catch::Contains("every candidate term was kept"));
}

TEST_CASE("the same table gives the same answer on each run, and penalties are options", "[apps][fit_faults]") {
  const Table plain = table([](double u, double w, int i) { return u * w - 0.5 * u + 0.2 * hash_noise(i); });
  const auto first = fit(plain, "1,u,w,u*w,u^2", all_methods), again = fit(plain, "1,u,w,u*w,u^2", all_methods);
  CHECK(first.out == again.out);
  const auto strong = fit(plain, "1,u,w,u*w,u^2", "lasso", "--lasso-lambda 0.9"),
             weak = fit(plain, "1,u,w,u*w,u^2", "lasso", "--lasso-lambda 1e-6");
  CHECK_THAT(strong.out, Catch::Contains("1 terms"));
  CHECK_THAT(weak.out, Catch::Contains("5 terms"));
  CHECK(fit(plain, "u,w", "ridge", "--ridge-lambda 100").out != fit(plain, "u,w", "ridge").out);
  CHECK(fit(plain, "u", "ridge", "--ridge-lambda 0").code == 2);
}

TEST_CASE("an equation that depends on the sign of the velocity is split by a condition", "[apps][fit_faults]") {
  const Scratch folder;
  REQUIRE(support::run(folder, "$ARDENT sim valanis-4 --set ratio=1 -o run").code == 0);
  const auto split = [&](const std::string& where) {
    const auto ended = support::run(folder,
                                    "$ARDENT fit run/response.csv --target dz --methods fast_rvm --terms "
                                    "'1,x,v,z,x^2,x*v,x*z,v^2,v*z,z^2,v*sin(x),f' --where '" +
                                        where + "'");
    CHECK(ended.code == 0);
    return ended.out;
  };
  CHECK_THAT(split("v >= 0"), Catch::Contains("dz = 10 v - 20 v*z + 40 v*sin(x)\n"));
  CHECK_THAT(split("v < 0"), Catch::Contains("dz = 10 v - 15 x*v + 20 v*z\n"));
}

TEST_CASE("help names every method and every setting of one, and each setting is taken", "[apps][fit_faults]") {
  const auto help = support::run(Scratch(), "$ARDENT fit --help").out;
  for (const std::string piece : {"fast_rvm,slow_rvm,multi_rvm,sindy,lasso,ridge,ols", "sparse Bayesian", "--selection",
                                  "--tau", "--threshold ", "--threshold-on", "--lasso-lambda", "--ridge-lambda"})
    CHECK_THAT(help, Catch::Contains(piece));
  const Table plain = table([](double u, double w, int i) { return 2.0 * u - 0.2 * w + 0.1 * hash_noise(i); });
  const auto raw = fit(plain, "u,w,u^2", "sindy", "--threshold 0.3 --threshold-on raw").out;
  CHECK(raw == fit(plain, "u,w,u^2", "sindy", "--threshold 0.3 --raw-threshold").out);
  CHECK(fit(plain, "u", "sindy", "--threshold-on cooked").code == 2);
}
