#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/program.hpp"

using nlohmann::json;
using support::Scratch;

namespace {

/// Two forced Duffing oscillators, alike but for the frequency of the force, and a run of the first.
void two_records(const Scratch& folder, const std::string& more_config = "") {
  (void)folder.file("run.toml", "schema = 1\n[[recording]]\nfile = \"one/response.csv\"\n" + more_config +
                                    "[fit]\nmethods = [\"fast_rvm\"]\n");
  const auto ended = support::run(folder,
                                  "$ARDENT -q sim duffing --duration 40 -o one && $ARDENT -q sim duffing --duration 30 "
                                  "--set ratio=1.3 -o other && $ARDENT -q run run.toml -o run");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
}

}  // namespace

TEST_CASE("an equation is run free on another recording, against baselines", "[apps][predict]") {
  const Scratch folder;
  two_records(folder);
  const auto ended = support::run(folder, "$ARDENT -q predict run other/response.csv -o predicted");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  const json result = json::parse(support::bytes_of(folder / "predicted/predict.json"));
  CHECK(result["recording"] == "other/response.csv");  // the run is of one/response.csv
  CHECK(result["stretches"].size() == 1);
  CHECK(result["unit"] == "m");
  CHECK(result["nmse"].get<double>() < 1e-3);  // no noise: what is left is of the derivatives' ends
  CHECK(result["baselines"]["linear"].get<double>() > 10.0 * result["nmse"].get<double>());
  CHECK(result["baselines"]["still"].get<double>() == Approx(1.0).epsilon(0.01));
  CHECK(result["rms"].get<double>() > 0.0);
  CHECK_THAT(support::bytes_of(folder / "predicted/predict.csv"), Catch::StartsWith("t,x,x_predicted,x_linear\n"));
}

TEST_CASE("a prediction is about the zero that is stated, else about the one it finds, and shows both curves",
          "[apps][predict]") {
  const Scratch folder;
  two_records(folder);
  // The same motion by a sensor whose zero is 0.1 m away.
  REQUIRE(support::run(folder,
                       "mkdir moved && awk -F, 'NR == 1 {for (i = 1; i <= NF; ++i) if ($i == \"x\") c = i} NR > 1 "
                       "{$c = sprintf(\"%.12g\", $c + 0.1)} 1' OFS=, other/response.csv > moved/response.csv")
              .code == 0);
  const auto prediction = [&](const std::string& options) {
    const auto ended =
        support::run(folder, "$ARDENT -q --force predict run moved/response.csv -o predicted " + options);
    CAPTURE(ended.err);
    REQUIRE(ended.code == 0);
    return json::parse(support::bytes_of(folder / "predicted/predict.json"));
  };
  const json found = prediction("");
  CHECK(found["nmse"].get<double>() < 1e-3);
  CHECK(found["coordinates"][0]["zero"].get<double>() == Approx(0.1).epsilon(1e-3));
  CHECK_THAT(found["remark"].get<std::string>(), Catch::Contains("the zero of x is not stated"));
  const std::string page = support::bytes_of(folder / "predicted/predict.html");
  CHECK_THAT(page, Catch::Contains("measured") && Catch::Contains("free run") && Catch::Contains("x = 0 is where"));
  const json stated = prediction("--set prepare.zero=0.1");
  CHECK(stated["coordinates"][0]["zero"].get<double>() == 0.1);
  CHECK(stated["nmse"].get<double>() < 1e-3);
  const json mistaken = prediction("--set prepare.zero=none");
  CHECK(mistaken["coordinates"][0]["zero"].get<double>() == 0.0);
  CHECK(mistaken["nmse"].get<double>() > 10.0 * stated["nmse"].get<double>());
  const auto of_fit = support::run(folder, "$ARDENT predict run moved/response.csv --set library.order=2");
  CHECK(of_fit.code == 2);
  CHECK_THAT(of_fit.err, Catch::Contains("a prediction fits nothing"));
}

TEST_CASE("a coefficient that the other recording contradicts does not carry over, and the others do",
          "[apps][predict]") {
  const Scratch folder;
  const auto ended = support::run(
      folder,
      "$ARDENT -q sim duffing --duration 60 --noise 0.01 --seed 3 -o one && $ARDENT -q sim duffing "
      "--duration 60 --noise 0.01 --seed 4 --set zeta=0.4 -o other && $ARDENT -q run one/response.csv -o run "
      "&& $ARDENT -q predict run other/response.csv -o predicted");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  const json result = json::parse(support::bytes_of(folder / "predicted/predict.json"));
  REQUIRE(result["coefficients"].size() == 4);
  for (const json& one : result["coefficients"]) {
    CAPTURE(one.dump());
    CHECK(one["carries_over"].get<bool>() == (one["name"] != "v"));
  }
}

TEST_CASE("a recording for testing is never fitted, only predicted", "[apps][predict]") {
  const Scratch folder;
  two_records(folder, "[[recording]]\nfile = \"other/response.csv\"\nuse = \"test\"\n");
  const json result = json::parse(support::bytes_of(folder / "run/predict-1-response.json"));
  CHECK(result["nmse"].get<double>() < 1e-3);
  CHECK_THAT(support::bytes_of(folder / "run/config.toml"), Catch::Contains("use = \"test\""));
  const json metrics = json::parse(support::bytes_of(folder / "run/metrics.json"));
  CHECK(metrics["ranges"].size() == 1);
}

TEST_CASE("a recording at a lower rate is predicted in the band that it holds", "[apps][predict]") {
  const Scratch folder;
  REQUIRE(
      support::run(folder, "$ARDENT -q sim duffing -o s --noise 0.01 && $ARDENT -q run s/response.csv -o run").code ==
      0);
  std::istringstream rows(support::bytes_of(folder / "s/response.csv"));
  std::string slow, row;
  for (int i = 0; std::getline(rows, row); ++i)  // the head, then every third of 100 Hz
    if (i == 0 || i % 3 == 1) slow += row + "\n";
  (void)folder.file("slow.csv", slow);
  const auto ended = support::run(folder, "$ARDENT predict run slow.csv -o slow");
  REQUIRE(ended.code == 0);
  CHECK_THAT(ended.err, Catch::Contains("predict.band") && Catch::Contains("33.3333 Hz"));
  CHECK(json::parse(support::bytes_of(folder / "slow/predict.json"))["nmse"].get<double>() < 0.01);
}

TEST_CASE("predict says what it cannot do in a line", "[apps][predict]") {
  const Scratch folder;
  two_records(folder);
  const auto no_run = support::run(folder, "$ARDENT predict nothing other/response.csv");
  CHECK(no_run.code == 3);
  const auto no_range = support::run(folder, "$ARDENT predict run other/response.csv --range low");
  CHECK(no_range.code == 2);
  CHECK_THAT(no_range.err, Catch::Contains("run.no_such_equation"));
  const auto no_sidecar = support::run(folder, "$ARDENT predict run other/response.csv --sidecar nothing.toml");
  CHECK(no_sidecar.code == 2);
  CHECK_THAT(no_sidecar.err, Catch::Contains("nothing.toml"));
  const auto no_input =
      support::run(folder, "cut -d, -f1,2 other/response.csv > alone.csv && $ARDENT predict run alone.csv");
  CHECK(no_input.code == 3);
  CHECK_THAT(no_input.err, Catch::Contains("error [predict.input] alone.csv: no f, which the equation has"));
}
