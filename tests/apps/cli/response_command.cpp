#include "apps/cli/response_command.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/output/equation_file.hpp"
#include "apps/output/steps_table.hpp"
#include "sim/ode/frequency_response.hpp"
#include "support/fault.hpp"
#include "support/program.hpp"

namespace test_cli_response_command {

using nlohmann::json;
using support::check_fault;
using support::Scratch;

namespace {

struct Coefficient {
  std::string name;
  double mean = 0.0, std = 0.0;
};

/// A range of a run's equation.json with one equation.
json range_of(const std::string& range, const std::string& target, const std::vector<Coefficient>& terms) {
  json row{{"method", "fast_rvm"},
           {"target", target},
           {"text", target + " = ..."},
           {"verdict", "describes"},
           {"terms", json::array()}};
  for (const auto& term : terms) {
    row["terms"].push_back({{"name", term.name}, {"mean", term.mean}, {"std", term.std}, {"scale", 0.03}});
    row["covariance"].push_back(std::vector<double>(terms.size(), 0.0));
    row["covariance"].back().back() = 0.0;
    row["covariance"].back()[row["covariance"].size() - 1] = term.std * term.std;
  }
  return {{"name", range}, {"verdict", "describes"}, {"methods", json::array({row})}};
}

/// A run folder with these equations, as far as the frequency response looks at one.
void make_run(const Scratch& folder, const std::vector<json>& ranges, const std::string& header) {
  const json document{{"chosen", {{"range", ranges.back()["name"]}, {"method", "fast_rvm"}}}, {"ranges", ranges}};
  (void)folder.file("manifest.json", "{}");
  (void)folder.file("equation.json", document.dump());
  (void)folder.file("prepared.csv", header + "\n");
}

const std::vector<Coefficient> t0{
    {"x", -50.0, 0.02}, {"v", -0.8, 1e-3}, {"x^3", -9.5e4, 40.0}, {"sgn(v)", -0.08, 1e-4}, {"ddr", -1.0, 3e-4}};

apps::ResponseArguments arguments_for(const Scratch& folder) {
  apps::ResponseArguments arguments;
  arguments.run = folder / "";
  arguments.folder = folder / "frc";
  arguments.force = true;
  return arguments;
}

json respond(const apps::ResponseArguments& arguments) {
  apps::Console console({.verbosity = -1});
  apps::run_response(arguments, console);
  return json::parse(support::bytes_of(arguments.folder / "frc.json"));
}

}  // namespace

TEST_CASE("the true equation with its static friction answers as the rig does", "[apps][response_command]") {
  const Scratch folder;
  make_run(folder, {range_of("all", "a", t0)}, "t,r,y,x,v,a,ddr");
  auto arguments = arguments_for(folder);
  arguments.static_friction = 0.385;
  arguments.set = {"from_hz=0.79", "to_hz=1.56"};
  arguments.num_draws = 0;
  const json found = respond(arguments);
  CHECK(found["frequency_response"]["up"]["unlock_hz"].get<double>() == Approx(1.48));
  CHECK(found["frequency_response"]["down"]["jump_hz"].get<double>() == Approx(1.49));
  CHECK(found["frequency_response"]["down"]["lock_hz"].get<double>() == Approx(0.82));
  CHECK(found["located"]["up"]["unlock_hz"]["value"].get<double>() == Approx(1.47212).margin(1.1e-4));
  CHECK(found["located"]["up"]["unlock_hz"]["draws_std"].is_null());

  // Without it, friction at rest is the sliding one: it breaks loose where (2 pi f)^2 A passes 0.08 m/s^2.
  arguments.static_friction.reset();
  arguments.set = {"from_hz=0.6", "to_hz=0.8"};
  const json sliding = respond(arguments);
  CHECK(sliding["located"]["up"]["unlock_hz"]["value"].get<double>() ==
        Approx(std::sqrt(0.08 / 4.5e-3) / (2.0 * M_PI)).margin(1.1e-4));
  CHECK(sliding["located"]["down"]["lock_hz"]["value"].get<double>() ==
        Approx(std::sqrt(0.08 / 4.5e-3) / (2.0 * M_PI)).margin(0.005));  // with what is left of x on the spring
  CHECK(sliding["remarks"][0].get<std::string>().find("static friction cannot be identified") != std::string::npos);
}

TEST_CASE("uncertain coefficients spread amplitudes and jumps, the same for any number of threads",
          "[apps][response_command]") {
  const Scratch folder;
  // Only damping is uncertain and the oscillator is linear: the amplitude's standard deviation follows from its slope.
  const std::vector<Coefficient> linear{{"x", -50.0, 0.0}, {"v", -0.8, 0.02}, {"ddr", -1.0, 0.0}};
  make_run(folder, {range_of("all", "a", linear)}, "t,r,y,x,v,a,ddr");
  auto arguments = arguments_for(folder);
  arguments.set = {"from_hz=1.0", "to_hz=1.2", "step_hz=0.1"};
  arguments.num_draws = 400;
  (void)respond(arguments);
  const std::string one = support::bytes_of(folder / "frc/frc.csv"),
                    document = support::bytes_of(folder / "frc/frc.json");
  arguments.num_threads = 3;
  (void)respond(arguments);
  CHECK(support::bytes_of(folder / "frc/frc.csv") == one);
  CHECK(support::bytes_of(folder / "frc/frc.json") == document);
  std::istringstream table(one);
  std::string line;
  std::getline(table, line);
  CHECK(line.find(",amplitude_std_m,amplitude_low_m,amplitude_high_m") != std::string::npos);
  while (std::getline(table, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    const double w = 2.0 * M_PI * std::stod(cells[1]), x = std::stod(cells[2]), std = std::stod(cells[7]);
    const double stiffness = 50.0 - w * w, damping = 0.8 * w;
    const double slope = x * damping * w / (stiffness * stiffness + damping * damping);
    CHECK(std == Approx(0.02 * slope).epsilon(4.0 / std::sqrt(2.0 * 400)));  // four standard errors
    CHECK(std::stod(cells[9]) - std::stod(cells[8]) == Approx(2 * 1.96 * std).epsilon(0.25));
  }
}

TEST_CASE("equations that have no answer to a sine are refused with the reason", "[apps][response_command]") {
  const auto usage = dsp::FaultKind::usage;
  const auto refused = [&](const std::string& target, const std::vector<Coefficient>& terms, const std::string& header,
                           const std::string& piece) {
    const Scratch folder;
    make_run(folder, {range_of("all", target, terms)}, header);
    check_fault([&] { (void)respond(arguments_for(folder)); }, usage, "frc.equation", {piece});
  };
  refused("r", {{"x", 1.0, 0.0}}, "t,r,x,v", "not an equation of motion");
  refused("a", {{"x", -1.0, 0.0}}, "t,r,x,v", "nothing in it moves with the base");
  refused("a", {{"x", -1.0, 0.0}}, "t,x,v", "no base and no force");
  refused("a", {{"z", -1.0, 0.0}, {"ddr", -1.0, 0.0}}, "t,r,x,v", "the term z");
  refused("a", {{"sgn(x)", -1.0, 0.0}, {"ddr", -1.0, 0.0}}, "t,r,x,v", "sgn(x)");
  refused("a", {{"sgn(v)", -1.0, 0.0}, {"sgn(dy)", -1.0, 0.0}, {"ddr", -1.0, 0.0}}, "t,r,x,v", "at once");
  refused("a", {}, "t,r,x,v", "no term");

  const Scratch folder;
  check_fault([&] { (void)respond(arguments_for(folder)); }, dsp::FaultKind::input, "run.incomplete",
              {"manifest.json"});
  make_run(folder, {range_of("low", "a", t0), range_of("mixed", "a", t0)}, "t,r,y,x,v,a,ddr");
  CHECK(apps::read_equation(folder / "", "", "").range == "mixed");
  CHECK(apps::read_equation(folder / "", "low", "").range == "low");
  json low = range_of("low", "a", t0);  // two methods, and the second speaks for it
  low["methods"].push_back(low["methods"][0]);
  low["methods"][1]["method"] = low["method"] = "ols";
  make_run(folder, {low, range_of("mixed", "a", t0)}, "t,r,y,x,v,a,ddr");
  CHECK(apps::read_equation(folder / "", "low", "").method == "ols");
  CHECK(apps::read_equation(folder / "", "", "").method == "fast_rvm");
  make_run(folder, {range_of("low", "a", t0), range_of("mixed", "a", t0)}, "t,r,y,x,v,a,ddr");
  auto arguments = arguments_for(folder);
  arguments.range = "high";
  check_fault([&] { (void)respond(arguments); }, usage, "run.no_such_equation", {"low by fast_rvm", "mixed"});
  arguments = arguments_for(folder);
  arguments.set = {"dwell_s=3"};
  check_fault([&] { (void)respond(arguments); }, usage, "frc.option", {"dwell_s", "amplitude_mm"});
  arguments.set = {"from_hz=3"};
  check_fault([&] { (void)respond(arguments); }, usage, "frc.option", {"from_hz"});
  (void)folder.file("equation.json", "{\"equations\": [{}]}");
  check_fault([&] { (void)respond(arguments_for(folder)); }, dsp::FaultKind::input, "run.damaged", {"equation.json"});
}

TEST_CASE("a record's steady amplitudes come back from their table", "[apps][steps_table]") {
  const Scratch folder;
  CHECK(apps::read_final_steps(folder / "").empty());
  const dsp::SteadyStep slipping{.from_s = 1.0,
                                 .to_s = 2.0,
                                 .frequency_hz = 1.25,
                                 .drive = 4.5e-3,
                                 .x_m = 7e-3,
                                 .y_m = 3e-3,
                                 .phase_rad = -1.0,
                                 .direction = 1};
  dsp::SteadyStep locked = slipping, iteration = slipping;
  locked.locked = true;
  locked.phase_rad = std::nan("");
  locked.direction = -1;
  iteration.tag = dsp::StepTag::iteration;
  (void)folder.file("steps.csv", apps::steps_csv({{"a,\"b\"", {iteration, slipping, locked}}}));
  const auto points = apps::read_final_steps(folder / "");
  REQUIRE(points.size() == 2);
  CHECK(points[0].frequency_hz == 1.25);
  CHECK(points[0].x_m == 7e-3);
  CHECK(points[0].up);
  CHECK(!points[0].locked);
  CHECK(points[1].locked);
  CHECK(!points[1].up);
  (void)folder.file("steps.csv", "f,x\n1,2\n");
  check_fault([&] { (void)apps::read_final_steps(folder / ""); }, dsp::FaultKind::input, "run.damaged", {"steps.csv"});
}

TEST_CASE("a sweep without frequencies is about those of the equation", "[apps][response_command]") {
  const Scratch folder;
  auto arguments = arguments_for(folder);
  arguments.num_draws = 0;
  arguments.set = {"amplitude=0.01"};
  // The largest |x| of training is 0.03: 40 Hz, hardening to sqrt(1 + 3/4 0.1) of it.
  const double k = std::pow(2.0 * M_PI * 40.0, 2);
  json row = range_of("all", "a", {{"x", -k, 0.0}, {"x^3", -0.1 * k / 9e-4, 0.0}, {"v", -20.0, 0.0}, {"f", 1.0, 0.0}});
  row["methods"][0]["target_unit"] = "rad/s^2";
  make_run(folder, {row}, "t,x,v,a,f");
  const json found = respond(arguments);
  CHECK(found["sweep"]["from_hz"].get<double>() == Approx(0.45 * 40.0).epsilon(0.05));
  CHECK(found["sweep"]["to_hz"].get<double>() == Approx(1.7 * 40.0 * std::sqrt(1.075)).epsilon(0.05));
  CHECK(found["sweep"]["step_hz"].get<double>() == Approx(0.2));
  CHECK(found["frequency_response"]["up"]["peak"]["f_hz"].get<double>() == Approx(40.0).margin(0.4));
  CHECK(found["remarks"].empty());
  const std::string svg = support::bytes_of(folder / "frc/frc.svg");
  CHECK_THAT(svg, Catch::Contains("amplitude of x (rad)") && !Catch::Contains("amplitude of y"));
  for (const char* zero : {"from_hz=0", "to_hz=0", "step_hz=0"}) {  // is no setting left out
    auto typed = arguments;
    typed.set.push_back(zero);
    check_fault([&] { (void)respond(typed); }, dsp::FaultKind::usage, "frc.option", {"from_hz"});
  }
  arguments.set.push_back("to_hz=35");
  CHECK_THAT(respond(arguments)["remarks"].dump(), Catch::Contains("--set to_hz=52 shows more"));
  make_run(folder, {range_of("all", "a", {{"v", -0.8, 0.0}, {"f", 2.0, 0.0}})}, "t,x,v,a,f");
  arguments.set = {"amplitude=1"};
  check_fault([&] { (void)respond(arguments); }, dsp::FaultKind::usage, "frc.option", {"--set from_hz="});
}

TEST_CASE("a force drives an equation without a base", "[apps][response_command]") {
  const Scratch folder;
  make_run(folder, {range_of("all", "a", {{"x", -50.0, 0.0}, {"v", -0.8, 0.0}, {"f", 2.0, 0.0}})}, "t,x,v,a,f");
  auto arguments = arguments_for(folder);
  arguments.num_draws = 0;
  check_fault([&] { (void)respond(arguments); }, dsp::FaultKind::usage, "frc.option", {"--set amplitude="});
  arguments.set = {"from_hz=1", "to_hz=1.2", "step_hz=0.1", "amplitude=0.3"};
  const json found = respond(arguments);
  const double w = 2.0 * M_PI * 1.1;
  CHECK(found["frequency_response"]["up"]["peak"]["amplitude_m"].get<double>() ==
        Approx(0.6 / std::hypot(50.0 - w * w, 0.8 * w)).epsilon(1e-5));
}

TEST_CASE("the equation identified from the record that comes with the sources has the rig's frequency response",
          "[apps][response_command][rig]") {
  const Scratch folder;
  (void)folder.file("qzs.toml",
                    "schema = 1\n[[recording]]\nfile = \"" ARDENT_DATA
                    "/qzs_256.flac\"\n[prepare]\nrate_hz = 25.6\ncutoff_hz = 10.24\nrolloff_hz = 8\n"
                    "[library]\norder = 0\nterms = [\"x\", \"v\", \"x^3\", \"sgn(v)\", \"ddr\"]\n[fit]\nmethods = "
                    "[\"fast_rvm\"]\n[[range]]\nname = \"mixed\"\nfrom = 0\nto = 1720\ntrain_to = 1000\n");
  REQUIRE(support::run(folder, "$ARDENT -q run qzs.toml -o run").code == 0);
  // 45 frequencies, each set in four iterations: the last of each is the result, but where hands were at the payload.
  const auto steps = apps::read_final_steps(folder / "run");
  CHECK(steps.size() >= 43);
  CHECK(steps.back().locked);
  auto arguments = arguments_for(folder);
  arguments.run = folder / "run";
  arguments.set = {"amplitude_mm=4.5", "from_hz=0.5", "to_hz=1.9"};  // of Fig. 11
  arguments.num_draws = 4;
  arguments.static_friction = 0.385;
  const json found = respond(arguments);
  const auto& response = found["frequency_response"];
  CHECK(response["up"]["unlock_hz"].get<double>() == Approx(1.48).margin(0.0101));
  CHECK(response["down"]["jump_hz"].get<double>() == Approx(1.49).margin(0.0101));
  CHECK(response["down"]["lock_hz"].get<double>() == Approx(0.82).epsilon(0.02));
  CHECK(response["up"]["peak"]["amplitude_m"].get<double>() == Approx(38.86e-3).epsilon(0.01));
  CHECK(response["down"]["peak"]["amplitude_m"].get<double>() == Approx(26.22e-3).epsilon(0.01));
  CHECK_THAT(found["coordinates"].get<std::string>(), Catch::Contains("x = 0 is where y - r is"));
  const json equation = json::parse(support::bytes_of(folder / "run/equation.json"))["ranges"][0]["methods"][0];
  CHECK(equation["sensors"].size() > 6);
  for (const json& term : equation["terms"]) {
    CHECK(term["std"].get<double>() > term["std_noise"].get<double>());
    CHECK(term["budget"]["noise"].get<double>() > 0.0);
    CHECK(term["budget"].contains("relative gain of the base's displacement"));
  }
  CHECK(found["record"]["num_steps"].get<int>() >= 42);
  CHECK(found["record"]["rms"].get<double>() < 0.01);
  // The drive's amplitude is known to its sensors' calibration of 1 %, which moves the jump by about 2 mHz.
  CHECK(found["located"]["down"]["jump_hz"]["draws_std"].get<double>() < 4e-3);
}

}  // namespace test_cli_response_command
