#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "sim/noise.hpp"
#include "support/program.hpp"

using nlohmann::json;
using support::Scratch;

namespace {

json document(const Scratch& folder, const std::string& name) {
  return json::parse(support::bytes_of(folder / name));
}

/// Runs a command that ends with this code; what it says on standard error.
std::string ends(const Scratch& folder, const std::string& command, int code) {
  const auto ended = support::run(folder, command);
  CAPTURE(command, ended.err);
  CHECK(ended.code == code);
  return ended.err;
}

}  // namespace

TEST_CASE("a table with x1, x2 and f gives one equation a body, modes and a verdict, without settings",
          "[apps][bodies]") {
  const Scratch folder;
  (void)ends(folder, "$ARDENT -q sim chain -o chain --noise 0.01 --seed 960001", 0);
  CHECK_THAT(support::bytes_of(folder / "chain/response.csv"), Catch::StartsWith("time_s,x1,x2,f\n"));
  (void)ends(folder, "$ARDENT -q check chain/response.csv && $ARDENT -q run chain/response.csv -o run", 0);
  const json result = document(folder, "run/equation.json"), truth = document(folder, "chain/truth.json");
  CHECK(support::bytes_of(folder / "run/report.json") == support::bytes_of(folder / "run/equation.json"));
  CHECK(result["verdict"] == "describes");
  REQUIRE(result["bodies"].size() == 2);
  std::size_t found = 0, num_true = 0;
  for (const json& term : truth["terms"]) {
    const std::string target = term["target"];
    if (target.front() != 'a') continue;
    ++num_true;
    for (const json& own : result["bodies"][target == "a1" ? 0 : 1]["terms"]) {
      if (own["name"] != term["name"]) continue;
      ++found;
      CHECK(own["mean"].get<double>() == Approx(term["value"].get<double>()).epsilon(0.02));
    }
  }
  CHECK(found == num_true);
  REQUIRE(result["modes"].size() == 2);
  // Two equal masses of 1 kg on springs of 100 N/m: (3 -+ sqrt 5) / 2 of k / m.
  CHECK(result["modes"][0]["frequency_hz"].get<double>() == Approx(0.983632).epsilon(2e-3));
  CHECK(result["modes"][1]["frequency_hz"].get<double>() == Approx(2.575181).epsilon(2e-3));
  CHECK(result["modes"][0]["frequency_std"].get<double>() > 0.0);
  CHECK(result["couplings"][0]["action_is_reaction"] == true);
  for (const char* file : {"manifest.json", "report.html", "equation.tex", "predictions.csv", "prepared.csv"})
    CHECK(std::filesystem::exists(folder / "run" / file));
  CHECK_THAT(support::bytes_of(folder / "run/prepared.csv"), Catch::StartsWith("t,x1,x2,f,excluded\n"));

  SECTION("the same bytes again") {
    (void)ends(folder, "$ARDENT -q run run", 0);
  }
  SECTION("another record, and a force alone, are predicted") {
    (void)ends(folder, "$ARDENT -q sim chain -o other --duration 20 --seed 960002", 0);
    (void)ends(folder, "$ARDENT -q predict run other/response.csv -o predicted", 0);
    for (const json& body : document(folder, "predicted/predict.json")["bodies"])
      CHECK(body["nmse"].get<double>() < 1e-3);  // coefficients of a record of 1 % noise, without noise here
    (void)ends(folder, "cut -d, -f1,4 other/response.csv > force.csv && $ARDENT -q predict run force.csv -o forced", 0);
    CHECK_THAT(support::bytes_of(folder / "forced/predict.csv"), Catch::StartsWith("t,x1_predicted,x2_predicted\n"));
  }
  SECTION("commands for one body refuse it in a line") {
    CHECK_THAT(ends(folder, "$ARDENT -q merge run", 3), Catch::Contains("several bodies"));
    CHECK_THAT(ends(folder, "$ARDENT -q prep chain/response.csv -o prep", 3), Catch::Contains("several bodies"));
  }
  SECTION("the response to a sine is that of a chosen body to the input") {
    const std::string about = " --draws 4 --set amplitude=0.01 --set from_hz=0.9 --set to_hz=1.1 --set step_hz=0.02";
    (void)ends(folder, "$ARDENT -q frc run --body 2 --input f -o frc" + about, 0);
    const json response = document(folder, "frc/frc.json");
    CHECK(response["equation"]["of"] == "x2");
    CHECK(response["drive"] == "f");
    // So small a force leaves the chain linear: peaks stand at the first mode, one body over the other as its shape.
    const json peak = response["frequency_response"]["up"]["peak"];
    CHECK(peak["f_hz"].get<double>() == Approx(result["modes"][0]["frequency_hz"].get<double>()).margin(0.01));
    CHECK(peak["std_m"].get<double>() > 0.0);
    (void)ends(folder, "$ARDENT -q frc run -o first" + about, 0);
    const json first = document(folder, "first/frc.json")["frequency_response"]["up"]["peak"];
    CHECK(first["amplitude_m"].get<double>() / peak["amplitude_m"].get<double>() ==
          Approx(result["modes"][0]["shape"][0].get<double>()).epsilon(0.01));
    CHECK_THAT(ends(folder, "$ARDENT -q frc run --body 3 -o none" + about, 2), Catch::Contains("bodies 1 to 2"));
    CHECK_THAT(ends(folder, "$ARDENT -q frc run --input r -o none" + about, 2), Catch::Contains("there is f"));
    CHECK_THAT(ends(folder, "$ARDENT -q frc run -o none", 2), Catch::Contains("--set amplitude=..."));
    CHECK_THAT(ends(folder, "$ARDENT -q frc run -o none --range mixed" + about, 2), Catch::Contains("--range"));
  }
  SECTION("an edited equation.json is refused in a line, or run as it stands") {
    const std::string frc =
                          "$ARDENT -q --force frc run -o out --draws 1 --set amplitude=0.01 --set from_hz=1 "
                          "--set to_hz=1.1 --set step_hz=0.1",
                      predict = "$ARDENT -q --force predict run chain/response.csv -o out",
                      to_c = "$ARDENT -q --force export run --to c -o out";
    const auto say = [&](const json& edited, int code, const std::string& what) {
      (void)folder.file("run/equation.json", edited.dump());
      for (const std::string& command : {frc, predict, to_c}) {
        CAPTURE(command, edited["bodies"].dump().substr(0, 300));
        CHECK_THAT(ends(folder, command, code), Catch::Contains(what));
      }
    };
    const auto with = [&](const auto& edit) {
      json edited = result;
      edit(edited);
      return edited;
    };
    const auto first_term = [&](const char* name) {
      return with([&](json& all) { all["bodies"][0]["terms"][0]["name"] = name; });
    };
    say(with([](json& all) { all["covariance"].erase(0); }), 3, "run.damaged");
    say(with([](json& all) { std::swap(all["bodies"][0], all["bodies"][1]); }), 3, "run.damaged");
    say(with([](json& all) { all["bodies"][0]["largest"] = "far"; }), 3, "run.damaged");
    say(with([](json& all) { all["imposed"] = true, all["force_unit"] = "N"; }), 3, "run.damaged");
    say(with([](json& all) { all["bodies"] = json::array(); }), 2, "run.no_such_equation");
    say(first_term("foo(("), 2, "term.");
    say(first_term("x9"), 2, "term.unknown_name");
    say(first_term("log(x1)"), 4, "run");  // no number at rest: it runs away
    say(with([](json& all) { all["bodies"][0]["terms"][0]["mean"] = 1e300; }), 4, "run");
  }
  SECTION("two runs are compared equation by equation, and mode by mode") {
    (void)ends(folder,
               "$ARDENT -q sim chain -o stiff --duration 20 --noise 0.01 --seed 5 --set stiffness_2=110 && "
               "$ARDENT -q run stiff/response.csv -o stiff-run",
               0);
    const auto ended = support::run(folder, "$ARDENT -q compare run stiff-run -o both");
    CAPTURE(ended.err);
    REQUIRE(ended.code == 0);
    CHECK_THAT(ended.out,
               Catch::Contains("equation for a2") && Catch::Contains("modes") && Catch::Contains("describes"));
    const json compared = document(folder, "both/compare.json");
    const auto both = [&](std::size_t range, const std::string& name) {
      std::vector<double> z;
      for (const json& run : compared["ranges"][range]["runs"])
        for (const json& term : run["fit"]["terms"])
          if (term["name"] == name) z.push_back(term["mean"]), z.push_back(term["std"]);
      REQUIRE(z.size() == 4);
      return (z[2] - z[0]) / std::hypot(z[1], z[3]);
    };
    CHECK(std::abs(both(0, "x1")) < 4.5);  // the spring that was not changed
    CHECK(both(1, "(x2 - x1)") < -20.0);   // -110 for -100
    CHECK(both(2, "natural frequency 2") > 20.0);
    CHECK_THAT(support::bytes_of(folder / "both/compare.html"), Catch::Contains("Equation for a1") &&
                                                                    Catch::Contains("Modes") &&
                                                                    !Catch::Contains("Coefficient of natural"));
    const auto beside_truth = support::run(folder, "$ARDENT -q compare run --truth chain/truth.json");
    CHECK(beside_truth.code == 0);
    CHECK_THAT(beside_truth.out, Catch::Contains("-100") && Catch::Contains("side"));
  }
  SECTION("settings that are for one body are refused") {
    (void)folder.file("two.toml",
                      "schema = 1\n[[recording]]\nfile = \"chain/response.csv\"\n[[range]]\nname = \"a\"\n");
    CHECK_THAT(ends(folder, "$ARDENT -q run two.toml -o two", 2), Catch::Contains("[[range]]"));
  }
}

TEST_CASE("bodies are recognised by their numbers, stated by a key, or asked for", "[apps][bodies]") {
  const Scratch folder;
  (void)ends(folder, "$ARDENT -q sim chain -o chain --duration 5", 0);
  const auto info = [&](const std::string& header) {
    (void)ends(folder, "sed '1s/.*/" + header + "/' chain/response.csv > named.csv", 0);
    const auto ended = support::run(folder, "$ARDENT -q info named.csv --json");
    CAPTURE(header, ended.err);
    REQUIRE(ended.code == 0);
    return json::parse(ended.out)["recordings"][0]["channels"];
  };
  for (const char* header : {"time_s,mass_1,mass_2,f", "time_s,floor_2,floor_1,f",
                             "time_s,displacement 1,displacement 2,f", "t,x_1_mm,x_2_mm,force"}) {
    const json channels = info(header);
    CAPTURE(header);
    CHECK(channels[0]["role"] == "x");
    CHECK(channels[0]["body"].get<int>() + channels[1]["body"].get<int>() == 3);
    CHECK(channels[2]["role"] == "f");
  }
  CHECK(info("t,floor_0,floor_1,floor_2")[0]["role"] == "r");
  (void)ends(folder, "sed '1s/.*/time_s,x2,x4,f/' chain/response.csv > open.csv", 0);
  CHECK_THAT(ends(folder, "$ARDENT -q check open.csv", 3), Catch::Contains("Which body is each"));
  (void)folder.file("open.csv.toml",
                    "schema = 1\n[[channel]]\nname = \"x2\"\nrole = \"x\"\nunit = \"m\"\nbody = 1\n[[channel]]\n"
                    "name = \"x4\"\nrole = \"x\"\nunit = \"m\"\nbody = 2\n[[channel]]\nname = \"f\"\nrole = \"f\"\n");
  (void)ends(folder, "$ARDENT -q check open.csv", 0);
}

TEST_CASE("a recorded force drives a chain as it drove what was recorded", "[apps][bodies]") {
  const Scratch folder;
  (void)ends(folder, "$ARDENT -q sim chain -o one --duration 10 --seed 960003", 0);
  (void)ends(folder, "$ARDENT -q sim chain -o two --drive one/response.csv", 0);
  // f between samples is a cubic here and a sum of sines there: (omega h)^4 / 100 of it, omega h = 0.13.
  (void)ends(
      folder,
      "paste -d, one/response.csv two/response.csv | awk -F, 'NR > 1 {d = $2 - $6; if (d < 0) d = -d; if (d > m) "
      "m = d} END {exit !(NR > 2000 && m < 1e-4)}'",
      0);
  CHECK_THAT(ends(folder, "$ARDENT -q sim qzs -o no --drive one/response.csv", 2), Catch::Contains("--drive"));
}

TEST_CASE("an actuator's lag is said to be missing, and found where it is asked for", "[apps][bodies][memory]") {
  const Scratch folder;
  (void)ends(folder,
             "$ARDENT -q sim chain -o drive --set from_hz=0.3 --set to_hz=2 --set rms=5 --seed 960020 && "
             "$ARDENT -q sim duffing --drive drive/response.csv --lag 0.1 --noise 0.01 -o late && "
             "cut -d, -f1,2,5 late/response.csv > late.csv",
             0);
  CHECK(document(folder, "late/truth.json")["lag_s"] == 0.1);
  (void)ends(folder, "$ARDENT -q run late.csv -o plain", 0);
  CHECK_THAT(support::bytes_of(folder / "plain/equation.txt"),
             Catch::Contains("does not describe") && Catch::Contains("s late") && Catch::Contains("inner = \"lag\""));
  (void)ends(folder, "$ARDENT -q run late.csv -o run --set library.inner=lag", 0);
  const json result = document(folder, "run/equation.json"), inner = result["inner"];
  CHECK(result["verdict"] == "describes");
  CHECK(inner["kind"] == "lag");
  CHECK(inner["input"] == "f");
  REQUIRE(inner["kept"] == true);
  const double lag_s = inner["lag_s"], std = inner["lag_std_s"];
  CHECK(std::abs(lag_s - 0.1) < 4.0 * std);
  CHECK(std < 0.005);
  REQUIRE(inner["terms"].size() == 1);
  CHECK(inner["terms"][0]["unit"] == "1/s");
  CHECK_THAT(support::bytes_of(folder / "run/equation.txt"),
             Catch::Contains("f arrives 0.") && Catch::Contains("late"));
  (void)ends(folder, "$ARDENT -q run run", 0);
  (void)ends(folder, "$ARDENT -q predict run late.csv -o predicted", 0);
  CHECK(document(folder, "predicted/predict.json")["bodies"][0]["nmse"].get<double>() < 1e-3);
  (void)ends(folder, "cut -d, -f1,2 late.csv > free.csv", 0);
  CHECK_THAT(ends(folder, "$ARDENT -q run free.csv -o free --set library.inner=lag", 3),
             Catch::Contains("of a recorded force"));
  CHECK_THAT(ends(folder, "$ARDENT -q sim duffing -o no --lag 0.1", 2), Catch::Contains("--drive"));
}

TEST_CASE("a force with a memory is found where it is asked for, and said to be missing where it is not",
          "[apps][bodies][memory]") {
  const Scratch folder;
  const auto loop = [&](const std::string& name, const std::string& options) {
    (void)ends(folder,
               "$ARDENT -q sim chain -o drive-" + name + " --set from_hz=0.3 --set to_hz=2 " + options +
                   " && $ARDENT -q sim bouc-wen --set a=0.2 --drive drive-" + name + "/response.csv -o " + name +
                   " --noise 0.01 && cut -d, -f1,2,7 " + name + "/response.csv > " + name + ".csv",
               0);
  };
  loop("own", "--set rms=40 --seed 7");
  loop("other", "--set rms=30 --seed 960012 --duration 30");
  (void)ends(folder, "$ARDENT -q check own.csv --set library.inner=hysteresis", 0);
  (void)ends(folder, "$ARDENT -q run own.csv -o run --set library.inner=hysteresis", 0);
  const json result = document(folder, "run/equation.json"), inner = result["inner"];
  CHECK(result["verdict"] == "describes");
  CHECK(inner["kept"] == true);
  CHECK(inner["target"] == "dz");
  // Of z in units of its own force, which is four fifths of the restoring one: k (1 - a), delta, gamma.
  const std::map<std::string, double> truth{{"v", 40.0}, {"z*abs(v)", -0.5}, {"abs(z)*v", -0.5}};
  REQUIRE(inner["terms"].size() == truth.size());
  for (const json& term : inner["terms"])
    CHECK(std::abs(term["mean"].get<double>() - truth.at(term["name"])) < 4.0 * term["std"].get<double>());
  const json& own = result["bodies"][0]["terms"];
  REQUIRE(own.size() == 3);
  CHECK(own[2]["name"] == "z");
  CHECK(own[2]["mean"] == -1.0);
  CHECK(result["covariance"].size() == 6);
  CHECK_THAT(support::bytes_of(folder / "run/equation.txt"), Catch::Contains(" f - z\n") && Catch::Contains("dz = "));
  CHECK(std::filesystem::exists(folder / "run/figures/memory-loop.svg"));
  (void)ends(folder, "$ARDENT -q run run", 0);  // the same bytes again
  (void)ends(folder, "$ARDENT -q predict run other.csv -o predicted", 0);
  // From coefficients of a record of 1 % noise.
  CHECK(document(folder, "predicted/predict.json")["bodies"][0]["nmse"].get<double>() < 1e-3);

  // Without the setting the residual shows in this record what is missing, and the setting that finds it is said.
  const auto plain = support::run(folder, "$ARDENT -q run own.csv -o plain");
  CAPTURE(plain.out, plain.err);
  CHECK_THAT(plain.out, Catch::Contains("inner = \"hysteresis\""));
  // Where it is read it counts, and where it does not count it is refused.
  (void)folder.file("two.toml",
                    "schema = 1\n[[recording]]\nfile = \"own.csv\"\n[[recording]]\nfile = \"other.csv\"\n[library]\n"
                    "inner = \"hysteresis\"\n");
  (void)ends(folder, "$ARDENT -q run two.toml -o two", 0);
  const json both = document(folder, "two/equation.json");
  CHECK(both["inner"]["terms"].size() == truth.size());
  REQUIRE(both["recordings"].size() == 2);
  for (const json& one : both["recordings"]) CHECK(one["free_run_nmse"][0].get<double>() < 1e-3);
  CHECK(both["recordings"][1]["train_s"][0] == 0.0);
  const std::string rows = support::bytes_of(folder / "two/predictions.csv");
  CHECK_THAT(rows, Catch::StartsWith("recording,t,x,x_free_run\nown.csv,") && Catch::Contains("\nother.csv,"));
  CHECK(std::filesystem::exists(folder / "two/figures/body-1-free-run-2.svg"));
  (void)ends(folder, "cut -d, -f1,2 own.csv > no-force.csv", 0);
  (void)folder.file("mixed.toml",
                    "schema = 1\n[[recording]]\nfile = \"own.csv\"\n[[recording]]\nfile = \"no-force.csv\"\n[library]\n"
                    "inner = \"hysteresis\"\n");
  CHECK_THAT(ends(folder, "$ARDENT -q run mixed.toml -o mixed", 3),
             Catch::Contains("no-force") && Catch::Contains("which are others"));
  CHECK_THAT(ends(folder, "$ARDENT -q study own.csv -o s --set library.inner=hysteresis", 2),
             Catch::Contains("[library] inner"));
}

namespace {

/// A machine runs a damper at 1 Hz (a quarter of the amplitude in the first cycles, all of it, less again): spring,
/// dashpot and a part that yields, z' = k (v - (z^2 v + |v| z |z|) / (2 F^2)), by twenty steps a sample of second
/// order.
std::string damper_csv(double stroke_m, double hz) {
  constexpr double rate_hz = 200.0, duration_s = 16.0, take_up = 80e3, yield = 300.0, two_pi = 6.283185307179586;
  constexpr int parts = 20;
  const auto amplitude = [&](double t) { return stroke_m * (0.25 + 0.75 * std::pow(std::sin(0.19 * t), 2)); };
  const auto position = [&](double t) { return amplitude(t) * std::sin(two_pi * hz * t); };
  const auto speed = [&](double t) { return (position(t + 1e-5) - position(t - 1e-5)) / 2e-5; };
  const auto rate = [&](double z, double v) {
    return take_up * (v - 0.5 * (z * z * v + std::abs(v) * z * std::abs(z)) / (yield * yield));
  };
  const sim::Noise noise(981500, 0);
  std::string text = "t (s),x (m),f (N)\n";
  double z = 0.0;
  for (int k = 0; k < static_cast<int>(rate_hz * duration_s); ++k) {
    const double t = k / rate_hz;
    const double force = 2000.0 * position(t) + 50.0 * speed(t) + z + 2.0 * noise.normal(static_cast<std::uint64_t>(k));
    text += fmt::format("{:.3f},{:.9g},{:.9g}\n", t, position(t), force);
    for (int part = 0; part < parts; ++part) {
      const double at = t + part / (rate_hz * parts), h = 1.0 / (rate_hz * parts);
      const double half = z + 0.5 * h * rate(z, speed(at));
      z += h * rate(half, speed(at + 0.5 * h));
    }
  }
  return text;
}

}  // namespace

TEST_CASE("a motion that a machine imposes is not taken for one of its own, and its force is found",
          "[apps][bodies][memory]") {
  const Scratch folder;
  (void)folder.file("damper.csv", damper_csv(0.02, 1.0));
  (void)folder.file("other.csv", damper_csv(0.012, 1.7));
  (void)support::run(folder, "$ARDENT -q run damper.csv -o bare");
  const std::string screen = support::bytes_of(folder / "bare/equation.txt");
  CAPTURE(screen);
  CHECK_THAT(screen, !Catch::Contains("natural frequency") && !Catch::Contains("describes the record in part"));
  CHECK_THAT(screen, Catch::Contains("target = \"f\""));
  // x and v alone do not make the force, and the line that is said for it works.
  const auto plain = support::run(folder, "$ARDENT -q run damper.csv -o plain --set fit.target=f");
  CAPTURE(plain.out);
  CHECK_THAT(plain.out, Catch::Contains("inner = \"hysteresis\""));
  (void)ends(folder, "$ARDENT -q run damper.csv -o run --set fit.target=f --set library.inner=hysteresis", 0);
  const json result = document(folder, "run/equation.json");
  CHECK(result["verdict"] == "describes");
  CHECK(result["imposed"] == true);
  CHECK(result["bodies"][0]["target"] == "f");
  REQUIRE(result["inner"]["kept"] == true);
  const std::map<std::string, double> truth{{"x", 2000.0}, {"v", 50.0}, {"z", 1.0}};
  const json& terms = result["bodies"][0]["terms"];
  REQUIRE(terms.size() == truth.size());
  for (const json& term : terms)
    CHECK(std::abs(term["mean"].get<double>() - truth.at(term["name"])) <= 4.0 * term["std"].get<double>());
  CHECK(terms[0]["unit"] == "N/m");
  CHECK(result["inner"]["terms"][0]["unit"] == "N/m");
  CHECK(std::filesystem::exists(folder / "run/figures/memory-loop.svg"));
  CHECK_THAT(support::bytes_of(folder / "run/predictions.csv"), Catch::StartsWith("t,f,f_free_run\n"));
  (void)ends(folder, "$ARDENT -q run run", 0);  // the same bytes again
  (void)ends(folder, "$ARDENT -q predict run other.csv -o predicted", 0);
  CHECK(document(folder, "predicted/predict.json")["bodies"][0]["nmse"].get<double>() < 1e-3);
  (void)ends(folder, "cut -d, -f1,2 other.csv > no-force.csv", 0);
  (void)ends(folder, "$ARDENT -q predict run no-force.csv -o blind", 0);
  CHECK_THAT(support::bytes_of(folder / "blind/predict.csv"), Catch::StartsWith("t,f_predicted\n"));
  CHECK_THAT(ends(folder, "$ARDENT -q run no-force.csv -o no --set fit.target=f --set library.inner=hysteresis", 3),
             Catch::Contains("no force was recorded"));
}
