#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "support/program.hpp"

using nlohmann::json;
using support::expect;
using support::Scratch;

namespace {

/// Two days' runs of one name, and another setting.
const Scratch& bench() {
  static const Scratch folder;
  static const bool made = [] {
    for (const char* day : {"mon", "tue"}) {
      const std::string place(day);
      REQUIRE(support::run(folder, "$ARDENT sim duffing --duration 12 --noise 0.01 --seed " + std::to_string(place[0]) +
                                       " -o " + place + "/d")
                  .code == 0);
      REQUIRE(support::run(folder, "$ARDENT run " + place + "/d/response.csv -o " + place +
                                       "/run --set segment.find=false --set 'fit.methods=[\"fast_rvm\"]'")
                  .code == 0);
    }
    return true;
  }();
  CHECK(made);
  return folder;
}

}  // namespace

TEST_CASE("a comparison says what changed, then verdicts, then coefficients in their deviations", "[apps][compare]") {
  const Scratch& folder = bench();
  REQUIRE(
      support::run(
          folder,
          "$ARDENT run mon/d/response.csv -o again --set segment.find=false --set 'fit.methods=[\"fast_rvm\"]' --set "
          "fit.train_share=0.4")
          .code == 0);
  const auto days = expect(folder, "$ARDENT compare mon/run tue/run", 0, {"mon/run", "tue/run", "input response.csv"});
  CHECK(days.out.find("input response.csv") < days.out.find("verdict"));
  CHECK(days.out.find("verdict") < days.out.find("x^3"));
  CHECK_THAT(days.out, !Catch::Contains("train_share"));
  const auto setting = expect(folder, "$ARDENT compare mon/run again", 0, {"fit.train_share", "0.6", "0.4"});
  CHECK_THAT(setting.out, !Catch::Contains("input "));
  expect(folder, "$ARDENT compare mon/run mon/run", 0, {"the same inputs, settings and program", "(=)"});
  // The number in brackets is the difference over the root of both variances.
  const json both = json::parse(expect(folder, "$ARDENT compare mon/run tue/run --json", 0, {}).out);
  const auto& runs = both["ranges"][0]["runs"];
  const auto term = [&](std::size_t run) {
    for (const json& one : runs[run]["fit"]["terms"])
      if (one["name"] == "x^3") return one;
    return json();
  };
  const double difference = term(1)["mean"].get<double>() - term(0)["mean"].get<double>();
  const double deviation = std::hypot(term(0)["std"].get<double>(), term(1)["std"].get<double>());
  CHECK_THAT(days.out, Catch::Contains(fmt::format("({:+.1f})", difference / deviation)));
  CHECK(both["changes"][0]["kind"] == "input");
  CHECK(runs[0]["verdict"].is_string());
}

TEST_CASE("many runs are rows, and nothing is wider than 120 columns", "[apps][compare]") {
  const Scratch& folder = bench();
  const auto many =
      expect(folder, "for i in 1 2 3 4 5 6; do cp -r tue/run many-$i; done; $ARDENT compare mon/run many-*", 0,
             {"\n  many-3", "NMSE test"});
  for (std::size_t from = 0; from < many.out.size(); from = many.out.find('\n', from) + 1)
    CHECK(many.out.find('\n', from) - from <= 120);
}

TEST_CASE("a comparison as a page holds its tables, and a figure of every common coefficient",
          "[apps][compare][page]") {
  const Scratch& folder = bench();
  const auto shown = expect(folder, "$ARDENT compare mon/run tue/run --truth mon/d/truth.json -o days --force", 0, {});
  CHECK(support::bytes_of(folder / "days/compare.txt") == shown.out);
  const std::string page = support::bytes_of(folder / "days/compare.html");
  for (const char* piece :
       {"Content-Security-Policy", "What differs", "Range all", "mon/run", "x^3", "inside, outside: "})
    CHECK_THAT(page, Catch::Contains(piece));
  for (const char* request : {"src=", "href=\"http", "@import"}) CHECK(page.find(request) == std::string::npos);
  const json document = json::parse(support::bytes_of(folder / "days/compare.json"));
  const auto& terms = document["ranges"][0]["runs"][0]["fit"]["terms"];
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const std::string name = terms[k]["name"];
    CHECK_THAT(page, Catch::Contains("Coefficient of " + name + " by run"));
  }
  // The figure's numbers are those of the document: the mean of each run in order.
  bool found = false;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "days/figures")) {
    if (entry.path().extension() != ".csv" || entry.path().filename().string().find("x_3") == std::string::npos)
      continue;
    found = true;
    CHECK_THAT(support::bytes_of(entry.path()), Catch::Contains("coefficient,1,") && Catch::Contains("true value,"));
  }
  CHECK(found);
  expect(folder, "$ARDENT compare mon/run tue/run -o mon/run/inside", 2, {"[output.overlap]"});
}
