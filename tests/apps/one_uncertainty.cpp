#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/output/equation_file.hpp"
#include "apps/text/rounded.hpp"
#include "support/program.hpp"

using nlohmann::json;
using support::bytes_of;
using support::run;

namespace {

/// The terms of the chosen equation of a run folder.
json chosen_method(const std::filesystem::path& run) {
  const json document = json::parse(bytes_of(run / "equation.json"));
  for (const json& range : document.at("ranges"))
    if (range.at("name") == document.at("chosen").at("range"))
      for (const json& method : range.at("methods"))
        if (method.at("method") == document.at("chosen").at("method")) return method;
  throw std::runtime_error("no equation");
}

}  // namespace

TEST_CASE("a coefficient has one standard deviation, in all documents and commands", "[apps][one_uncertainty]") {
  const support::Scratch folder;
  for (const char* seed : {"5", "6"})
    REQUIRE(run(folder, std::string("$ARDENT -q sim duffing --noise 0.02 --seed ") + seed + " -o sim" + seed).code ==
            0);
  const auto first = run(folder, "$ARDENT -q run sim5/response.csv -o one");
  REQUIRE(first.code == 0);
  REQUIRE(run(folder, "$ARDENT -q run sim6/response.csv -o other").code == 0);
  REQUIRE(run(folder, "$ARDENT -q predict one sim6/response.csv -o predicted").code == 0);
  const auto compared = run(folder, "$ARDENT -q compare one other -o compared");
  REQUIRE(compared.code == 0);
  (void)folder.file("all.toml", "schema = 1\n");
  REQUIRE(run(folder, "$ARDENT -q batch all.toml sim5/response.csv sim6/response.csv -o all").code == 0);
  const json method = chosen_method(folder / "one");
  const json prediction = json::parse(bytes_of(folder / "predicted/predict.json"));
  const json batch = json::parse(bytes_of(folder / "all/table.json"));
  const auto read = apps::read_equation(folder / "one", "", "");
  const std::string page = bytes_of(folder / "one/report.html"), latex = bytes_of(folder / "one/equation.tex"),
                    details = bytes_of(folder / "one/details.txt");
  REQUIRE(method.at("terms").size() >= 3);
  for (std::size_t i = 0; i < method.at("terms").size(); ++i) {
    const json& term = method.at("terms")[i];
    const std::string name = term.at("name");
    const double mean = term.at("mean"), std = term.at("std");
    CAPTURE(name, mean, std);
    CHECK(method.at("covariance")[i][i].get<double>() == Approx(std * std).epsilon(1e-12));
    CHECK(read.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) == Approx(std * std));
    const std::string shown = apps::with_uncertainty(std::abs(mean), std);
    CHECK_THAT(first.out, Catch::Contains(shown));
    CHECK_THAT(bytes_of(folder / "one/equation.txt"), Catch::Contains(shown));
    CHECK_THAT(page, Catch::Contains(">" + apps::with_uncertainty(mean, std) + "<"));
    CHECK_THAT(latex, Catch::Contains(fmt::format("({:.2g})", std / std::abs(mean))));
    CHECK_THAT(details, Catch::Contains(fmt::format("+- {:<10.3g}", std)));
    CHECK_THAT(compared.out, Catch::Contains(fmt::format("{:.6g} +- {:.2g}", mean, std)));
    CHECK(prediction.at("coefficients")[i].at("identified_std").get<double>() == std);
    CHECK(batch.at("records")[0].at("ranges")[0].at("terms")[i].at("std").get<double>() == std);
  }
  // What all coefficients share is one line of its own.
  CHECK_THAT(first.out, Catch::Contains("Calibration, apart from these: "));
}
