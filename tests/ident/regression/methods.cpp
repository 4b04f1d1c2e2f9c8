#include "ident/regression/methods.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "support/random.hpp"

using Eigen::MatrixXd;
using support::gaussian;

TEST_CASE("every method is named, put in words and made by its row of the table", "[ident][methods]") {
  const MatrixXd phi = gaussian(100, 4, 1);
  const auto data = ident::r_factor(phi, phi.col(1) + 0.1 * gaussian(100, 1, 2));
  REQUIRE(ident::methods().size() == std::variant_size_v<ident::MethodOptions>);
  for (const ident::MethodDescription& row : ident::methods()) {
    CAPTURE(row.name);
    CHECK_FALSE(row.help.empty());
    CHECK(ident::to_string(row.method) == row.name);
    CHECK(ident::method_named(row.name).method == row.method);
    CHECK(&ident::description(row.defaults) == &ident::description(row.method));
    const ident::Fit fit = ident::fit(data, row.defaults);
    CHECK(fit.method == row.method);
    CHECK(fit.selection.has_value() == row.has("selection"));
    CHECK(std::isfinite(fit.log_evidence) == row.has("tau"));
  }
}

TEST_CASE("a method that is not known is refused with the list of those that are", "[ident][methods]") {
  CHECK_THROWS_WITH(ident::method_named("svm"), Catch::Contains("'svm'") && Catch::Contains("fast_rvm, slow_rvm"));
}

TEST_CASE("a setting reaches the methods that have it, and no other", "[ident][methods]") {
  ident::MethodSettings settings;
  settings.set("tau", 3.0);
  settings.set("threshold_on", ident::find_method_setting("threshold_on")->index_of("raw"));
  settings.set("selection", static_cast<double>(ident::Selection::type2));
  using enum ident::Method;
  const auto options = settings.options_of({multi_rvm, stlsq, slow_rvm});
  CHECK(std::get<ident::MultiRvmOptions>(options[0]).tau == 3.0);
  CHECK(std::get<ident::MultiRvmOptions>(options[0]).selection == ident::Selection::type2);
  CHECK_FALSE(std::get<ident::StlsqOptions>(options[1]).unit_norm);
  CHECK(std::get<ident::StlsqOptions>(options[1]).threshold == ident::StlsqOptions{}.threshold);
  CHECK(std::get<ident::SlowRvmOptions>(options[2]).tau == 3.0);
  CHECK(settings.value("tau") == 3.0);
  CHECK_THROWS_AS(settings.set("taw", 3.0), std::invalid_argument);
  CHECK_THROWS_AS((void)settings.value("taw"), std::invalid_argument);
}

TEST_CASE("every fit can be stopped at each of its steps", "[ident][methods]") {
  struct Stop {};
  const MatrixXd phi = gaussian(100, 4, 1);
  const auto data = ident::r_factor(phi, phi.col(1) + 0.1 * gaussian(100, 1, 2));
  for (const ident::MethodDescription& row : ident::methods()) {
    CAPTURE(row.name);
    int calls = 0, last = std::numeric_limits<int>::max();
    ident::MethodOptions options = row.defaults;
    std::visit(
        [&](auto& own) {
          own.poll = [&] {
            if (++calls > last) throw Stop();
          };
        },
        options);
    (void)ident::fit(data, options);
    REQUIRE(calls > 0);
    const int all = calls;
    for (last = 0; last < all; ++last) {
      calls = 0;
      CHECK_THROWS_AS((void)ident::fit(data, options), Stop);
    }
    calls = 0;
    CHECK_NOTHROW((void)ident::fit(data, options));
  }
}

TEST_CASE("a method for one target refuses several instead of taking the first", "[ident][methods]") {
  const auto data = ident::r_factor(gaussian(50, 3, 3), gaussian(50, 2, 4));
  for (const ident::MethodDescription& row : ident::methods()) {
    CAPTURE(row.name);
    CHECK_THROWS_WITH(ident::fit(data, row.defaults), Catch::Contains("one target"));
    CHECK_NOTHROW((void)ident::fit(ident::select(data, {0, 1, 2}, 1), row.defaults));
  }
}
