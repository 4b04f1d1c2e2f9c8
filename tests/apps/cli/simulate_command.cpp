#include "apps/cli/simulate_command.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "dsp/filter/decimate.hpp"
#include "dsp/io/input_file.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/io/sound_file.hpp"
#include "dsp/io/sound_writer.hpp"
#include "sim/rig/qzs_sensors.hpp"
#include "support/fault.hpp"
#include "support/program.hpp"
#include "support/scratch.hpp"

using support::check_fault;
namespace fs = std::filesystem;

namespace {

void simulate(const apps::SimulateArguments& arguments) {
  apps::Console console({.verbosity = -1});
  apps::run_simulate(arguments, console);
}

nlohmann::json truth_of(const fs::path& folder) {
  return nlohmann::json::parse(support::bytes_of(folder / "truth.json"));
}

struct Csv {
  std::string header;
  std::map<std::string, std::vector<double>> columns;
};

Csv read_csv(const fs::path& file) {
  std::istringstream text(support::bytes_of(file));
  Csv csv;
  std::getline(text, csv.header);
  std::vector<std::string> names;
  std::istringstream header(csv.header);
  for (std::string name; std::getline(header, name, ',');) names.push_back(name);
  for (std::string line; std::getline(text, line);) {
    std::istringstream row(line);
    std::string cell;
    for (const auto& name : names) {
      REQUIRE(std::getline(row, cell, ','));
      csv.columns[name].push_back(std::stod(cell));
    }
  }
  return csv;
}

double value_of(const nlohmann::json& truth, int row, const std::string& name, const std::string& where = "") {
  for (const auto& term : truth["terms"])
    if (term["row"] == row && term["name"] == name && term.value("where", "") == where) return term["value"];
  FAIL("no term " << name << " in row " << row);
  return 0.0;
}

}  // namespace

TEST_CASE("a simulated Duffing oscillator is a table that obeys the truth beside it", "[apps][simulate_command]") {
  const support::Scratch folder;
  simulate({.system = "duffing", .folder = folder / "new/duffing", .set = {"epsilon=50", "ratio=0.8"}});
  const auto truth = truth_of(folder / "new/duffing");
  CHECK(truth["system"] == "duffing");
  CHECK(truth["parameters"]["epsilon"] == 50.0);
  CHECK(truth["noise"] == 0.0);
  CHECK(truth["relative_error"]["x"] < 1e-6);  // 1e-10 a step, some hundred steps, ten times the tolerance
  CHECK(truth["relative_error"]["v"] > 0.0);
  CHECK(truth["error_growth"].get<double>() ==
        Approx(1e9 * std::max(truth["relative_error"]["x"].get<double>(), truth["relative_error"]["v"].get<double>())));
  const auto csv = read_csv(folder / "new/duffing/response.csv");
  CHECK(csv.header == "t,x,v,a,f");
  REQUIRE(csv.columns.at("t").size() == 2501);
  CHECK(csv.columns.at("t")[1234] == 12.34);
  double worst = 0.0;
  for (std::size_t n = 0; n < 2501; ++n) {
    const double x = csv.columns.at("x")[n], v = csv.columns.at("v")[n], f = csv.columns.at("f")[n];
    const double a = value_of(truth, 2, "f") * f + value_of(truth, 2, "v") * v + value_of(truth, 2, "x") * x +
                     value_of(truth, 2, "x^3") * x * x * x;
    worst = std::max(worst, std::abs(a - csv.columns.at("a")[n]));
  }
  CHECK(worst < 1e-11);  // 17 digits of numbers around 100
}

TEST_CASE("three-state systems name their third state z and its rate dz", "[apps][simulate_command]") {
  const support::Scratch folder;
  simulate({.system = "valanis-4", .folder = folder / "a"});
  CHECK(read_csv(folder / "a/response.csv").header == "t,x,v,z,a,dz,f");
  CHECK(value_of(truth_of(folder / "a"), 3, "x*v", "v < 0") == -15.0);
}

TEST_CASE("noise is the same fraction of every signal's standard deviation, but for time and input",
          "[apps][simulate_command]") {
  const support::Scratch folder;
  simulate({.system = "bouc-wen", .folder = folder / "clean"});
  simulate({.system = "bouc-wen", .folder = folder / "noisy", .seed = 3, .noise = 0.1});
  simulate({.system = "bouc-wen", .folder = folder / "again", .seed = 3, .noise = 0.1});
  CHECK(support::bytes_of(folder / "noisy/response.csv") == support::bytes_of(folder / "again/response.csv"));
  const auto clean = read_csv(folder / "clean/response.csv"), noisy = read_csv(folder / "noisy/response.csv");
  CHECK(clean.columns.at("t") == noisy.columns.at("t"));
  CHECK(clean.columns.at("f") == noisy.columns.at("f"));
  for (const auto* name : {"x", "v", "z", "a", "dz"}) {
    const auto &before = clean.columns.at(name), &after = noisy.columns.at(name);
    const Eigen::Map<const Eigen::ArrayXd> signal(before.data(), 2501), noisy_signal(after.data(), 2501);
    const double signal_std = std::sqrt((signal - signal.mean()).square().mean());
    const double noise = std::sqrt((noisy_signal - signal).square().mean());
    CHECK(noise == Approx(0.1 * signal_std).epsilon(4.0 / std::sqrt(2.0 * 2501)));  // four standard errors
  }
  const auto truth = truth_of(folder / "noisy");
  CHECK(truth["seed"] == 3);
  CHECK(truth["noise"] == 0.1);
}

TEST_CASE("the rig's recording holds what the sensors gave, and its sidecar what a person knows",
          "[apps][simulate_command]") {
  const support::Scratch folder;
  for (const std::string container : {"rf64", "flac"}) {
    simulate({.system = "qzs",
              .folder = folder / "rig",
              .force = true,
              .seed = 5,
              .duration_s = 3.0,
              .raw = true,
              .container = container});
    const auto file = folder / ("rig/recording." + dsp::extension(dsp::sound_container(container)));
    const auto sidecar = dsp::read_sidecar(dsp::sidecar_path(file));
    REQUIRE(sidecar.channels.size() == 4);
    CHECK(sidecar.channels[1].role == dsp::Role::y);
    CHECK(sidecar.channels[1].sensitivity->value == Approx(4.0 / 0.035));
    CHECK(sidecar.channels[3].sensitivity->value == Approx(0.1 / 9.80665));
    CHECK(sidecar.channels[3].full_scale->value == 5.0);
    CHECK(sidecar.bad.empty());

    const auto source = dsp::open_sound_file(std::make_unique<dsp::InputFile>(file), {});
    CHECK(source->info().sample_rate_hz == 25600.0);
    const auto rig = std::make_shared<const sim::QzsRig>(sim::qzs_twin("T0"), sim::stepped_sine_down());
    sim::RawRecorder recorder(rig, 3.0, {.seed = 5});
    dsp::FrameBlock frames;
    REQUIRE(source->read(frames, 1 << 20) == 76800);
    CHECK(dsp::FrameBlock(frames) == dsp::FrameBlock(recorder.next(76800)));
  }
  const auto truth = truth_of(folder / "rig");
  CHECK(truth["parameters"]["k3"] == 9.5e4);
  CHECK(truth["sensors"]["channels"][0]["gain"] == 1.003);
  CHECK(value_of(truth, 2, "sgn(v)") == -0.08);
  CHECK(truth["regimes"][0]["label"] == "stick");
  const auto exact = read_csv(folder / "rig/truth.csv");
  CHECK(exact.header == "t,x,v,r,ddr,mode");
  CHECK(exact.columns.at("t").size() == 769);
  CHECK(exact.columns.at("r")[256] == Approx(4.874812887e-04).margin(1e-12));
  CHECK(exact.columns.at("mode")[256] == 0.0);
  CHECK(read_csv(folder / "rig/response.csv").columns.at("t")[1] == 0.0390625);
}

TEST_CASE("the truth of random sensors names what was drawn and the equation in their units",
          "[apps][simulate_command]") {
  const support::Scratch folder;
  simulate({.system = "qzs", .folder = folder / "rig", .seed = 5, .duration_s = 1.0, .raw = true, .sensors = "random"});
  const auto truth = truth_of(folder / "rig");
  const auto drawn = sim::rig_sensors(sim::SensorLevel::random, sim::qzs_twin("T0"), 5);
  CHECK(truth["sensors"]["level"] == "random");
  for (std::size_t c = 0; c < drawn.size(); ++c) {
    CHECK(truth["sensors"]["channels"][c]["gain"] == drawn[c].gain);
    CHECK(truth["sensors"]["channels"][c]["offset"] == drawn[c].offset);
    CHECK(truth["sensors"]["channels"][c]["highpass_hz"] == drawn[c].highpass_hz);
  }
  CHECK(truth["sensors"]["channels"][1]["drift"]["sine_m"] == drawn[1].drift.sine_m);
  for (const auto& term : truth["terms_as_recorded"])
    if (term["name"] == "x^3") CHECK(term["value"].get<double>() == Approx(-9.5e4 / std::pow(drawn[1].gain, 2)));
  CHECK(truth["terms_as_recorded"].size() == 5);
}

TEST_CASE("an excerpt of the rig's test is that part of the whole", "[apps][simulate_command]") {
  const support::Scratch folder;
  simulate({.system = "qzs", .folder = folder / "whole", .duration_s = 5.0, .raw = true});
  simulate({.system = "qzs", .folder = folder / "part", .duration_s = 2.0, .raw = true, .from_s = 3.0});
  dsp::FrameBlock whole, part;
  const auto read = [&](const char* name, dsp::FrameBlock& frames) {
    return dsp::open_sound_file(std::make_unique<dsp::InputFile>(folder / name), {})->read(frames, 1 << 20);
  };
  REQUIRE(read("whole/recording.wav", whole) == 128000);
  REQUIRE(read("part/recording.wav", part) == 51200);
  CHECK(dsp::FrameBlock(whole.bottomRows(51200)) == part);
  const auto truth = read_csv(folder / "part/truth.csv"), all = read_csv(folder / "whole/truth.csv");
  CHECK(truth.columns.at("t").front() == 0.0);
  CHECK(truth.columns.at("x").front() == all.columns.at("x")[768]);
}

TEST_CASE("regimes are the truth of any programme, and of its part what they are of the whole",
          "[apps][simulate_command]") {
  const support::Scratch folder;
  apps::SimulateArguments up{
      .system = "qzs",
      .folder = folder / "whole",
      .set = {"amplitude_mm=3", "mu_static=0.15", "from_hz=1.1", "to_hz=1.25", "step_hz=0.05", "dwell_s=20"},
      .programme = "up"};
  simulate(up);
  // Loose at the second step, where (2 pi f)^2 A exceeds mu_static, it sets out against the base; three cycles later it
  // goes with it, which is where it settles: 9 mm, but the upper branch, from the start.
  const auto whole = truth_of(folder / "whole")["regimes"];
  REQUIRE(whole.size() == 2);
  CHECK(whole[0]["label"] == "stick");
  CHECK(whole[1]["label"] == "high");
  CHECK(whole[1]["to_s"] == 80.0);
  up.folder = folder / "part";
  up.duration_s = 35.0;  // no step of it is seen to its end
  simulate(up);
  const auto part = truth_of(folder / "part")["regimes"];
  REQUIRE(part.size() == 2);
  CHECK(part[1]["label"] == "high");
  CHECK(part[1]["from_s"] == whole[1]["from_s"]);
}

TEST_CASE("a recording at a lower rate is the raw one decimated", "[apps][simulate_command]") {
  const support::Scratch folder;
  simulate({.system = "qzs", .folder = folder / "256", .duration_s = 30.0, .raw = true, .rate_hz = 256.0});
  const auto file = folder / "256/recording.wav";
  CHECK(dsp::read_sidecar(dsp::sidecar_path(file)).rate_hz == 256.0);
  dsp::FrameBlock intermediate;
  REQUIRE(dsp::open_sound_file(std::make_unique<dsp::InputFile>(file), {})->read(intermediate, 1 << 20) == 7680);
  const auto rig = std::make_shared<const sim::QzsRig>(sim::qzs_twin("T0"), sim::stepped_sine_down());
  const Eigen::MatrixXd raw = sim::RawRecorder(rig, 30.0).next(768000);
  const auto expected =
      dsp::decimate(raw, 25600.0, {.output_rate_hz = 256.0, .passband_end_hz = 30.0, .stopband_start_hz = 226.0});
  CHECK((intermediate - expected).cwiseAbs().maxCoeff() <= 0.5 / 8388608.0 * (1 + 1e-9));
}

TEST_CASE("the whole record that comes with the sources shows the base's motion through its laser",
          "[apps][simulate_command]") {
  const fs::path file = ARDENT_DATA "/qzs_256.flac";
  dsp::FrameBlock intermediate;
  REQUIRE(dsp::open_sound_file(std::make_unique<dsp::InputFile>(file), {})->read(intermediate, 1 << 20) == 460800);
  const sim::BaseMotion base(sim::stepped_sine_down());
  const auto laser = sim::rig_sensors(sim::SensorLevel::full, {})[0];
  double square = 0.0;
  std::size_t near = 0;
  for (Eigen::Index n = 0; n < intermediate.rows(); ++n) {
    const double t = static_cast<double>(n) / 256.0, taken_s = t - laser.lag_s;
    const double drift = 30e-6 * std::sin(2 * M_PI * taken_s / 1400 + 0.3) + 20e-6 * taken_s / 1800;
    const double shown = laser.gain * base.at(taken_s, near).r_m + laser.offset + drift;
    square += std::pow(5.0 * intermediate(n, 0) / laser.volts_per_unit - shown, 2);
  }
  // 12 um a value at 800 Hz, and 10 um steps, leave 12.3 um sqrt(128 / 400) = 7 um below 128 Hz; mains 3 um.
  // The filter's slope beyond 30 Hz takes a little of both.
  CHECK(std::sqrt(square / static_cast<double>(intermediate.rows())) == Approx(7.2e-6).epsilon(0.05));
}

TEST_CASE("the whole record that comes with the sources is the raw one decimated, channel by channel",
          "[apps][simulate_command]") {
  const auto shipped = [](const char* name, Eigen::Index count) {
    dsp::FrameBlock frames;
    REQUIRE(dsp::open_sound_file(std::make_unique<dsp::InputFile>(fs::path(ARDENT_DATA) / name), {})
                ->read(frames, 1 << 20) == count);
    return frames;
  };
  const dsp::FrameBlock intermediate = shipped("qzs_256.flac", 460800);
  const dsp::DecimateOptions to_intermediate{
      .output_rate_hz = 256.0, .passband_end_hz = 30.0, .stopband_start_hz = 226.0};
  const auto check_same = [&](const dsp::FrameBlock& raw, double from_s, Eigen::Index left_out_at_start) {
    const Eigen::MatrixXd fresh = dsp::decimate(raw, sim::raw_rate_hz, to_intermediate);
    const Eigen::Index count = fresh.rows() - left_out_at_start - 8;  // the filter reaches 5 samples to either side
    const Eigen::ArrayXXd difference =
        (fresh.middleRows(left_out_at_start, count) -
         intermediate.middleRows(static_cast<Eigen::Index>(from_s * 256.0) + left_out_at_start, count))
            .array()
            .abs();
    // Half a step of the converter, but where another processor's sines moved a raw value by a step.
    CHECK(difference.maxCoeff() <= 1.01 / 8388608.0);
    CHECK((difference > 0.501 / 8388608.0).count() <= difference.size() / 1000);
  };
  check_same(shipped("qzs_jump_25k6.flac", 512000), 1396.0, 8);
  const auto rig = std::make_shared<const sim::QzsRig>(sim::qzs_twin("T0"), sim::stepped_sine_down());
  check_same(sim::RawRecorder(rig, 1800.0, {}).next(768000), 0.0, 0);  // the record's own beginning too
}

TEST_CASE("the excerpt that comes with the sources is what the command in its manifest makes",
          "[apps][simulate_command][slow]") {
  const fs::path file = ARDENT_DATA "/qzs_jump_25k6.flac";
  dsp::FrameBlock shipped;
  REQUIRE(dsp::open_sound_file(std::make_unique<dsp::InputFile>(file), {})->read(shipped, 1 << 20) == 512000);
  CHECK(dsp::read_sidecar(dsp::sidecar_path(file)).channels.size() == 4);
  const auto rig = std::make_shared<const sim::QzsRig>(sim::qzs_twin("T0"), sim::stepped_sine_down());
  sim::RawRecorder recorder(rig, 1416.0, {});
  for (int second = 0; second < 1396; ++second) REQUIRE(recorder.next(25600).rows() == 25600);
  const dsp::FrameBlock made = recorder.next(512000);
  // Another processor's sines may end a value on the other side of a step of the converter (2^-23), or of a laser
  // (10 um, 2e-4 of full scale): rarely.
  const Eigen::ArrayXXd difference = (made - shipped).array().abs();
  CHECK(difference.maxCoeff() < 2.4e-4);
  CHECK((difference > 0.0).count() < difference.size() / 1000);
}

TEST_CASE("the rig's other tests come with the same truth, and a hand that lets go is named",
          "[apps][simulate_command]") {
  const support::Scratch folder;
  simulate({.system = "qzs",
            .folder = folder / "up",
            .duration_s = 40.0,
            .set = {"amplitude_mm=6", "dwell_s=8", "mu_static=0.2"},
            .programme = "up"});
  CHECK(truth_of(folder / "up")["programme"] == "up");
  CHECK(truth_of(folder / "up")["parameters"]["mu_static"] == 0.2);
  const auto up = read_csv(folder / "up/response.csv");
  const auto& r = up.columns.at("r");
  CHECK(*std::max_element(r.begin(), r.end()) == Approx(6e-3).epsilon(0.06));

  simulate({.system = "qzs",
            .folder = folder / "decay",
            .set = {"amplitude_mm=24", "dwell_s=9", "releases=2"},
            .programme = "decay",
            .raw = true});
  const auto truth = truth_of(folder / "decay");
  CHECK(truth["duration_s"] == 18.0);
  REQUIRE(truth["manual"].size() == 2);
  CHECK(truth["manual"][1]["to_s"] == 13.5);
  CHECK(truth["manual"][0]["released_at_m"].get<double>() == Approx(0.024).epsilon(0.1));
  CHECK(truth["manual"][1]["released_at_m"].get<double>() == Approx(-0.012).epsilon(0.1));
  CHECK(truth["regimes"].size() > 2);
  const auto sidecar = dsp::read_sidecar(dsp::sidecar_path(folder / "decay/recording.wav"));
  REQUIRE(sidecar.bad.size() == 2);
  CHECK(sidecar.bad[0].to_s == 4.5);
}

TEST_CASE("the rig's frequency response is written as a table, its jumps and a picture", "[apps][simulate_command]") {
  const support::Scratch folder;
  simulate({.system = "qzs",
            .folder = folder / "frc",
            .set = {"from_hz=1.4", "to_hz=1.6", "step_hz=0.02", "dwell_s=30", "mu_static=0.36"},
            .frc = true});
  const auto truth = truth_of(folder / "frc");
  const auto& found = truth["frequency_response"];
  // Static friction is overcome where (2 pi f)^2 A exceeds it: 1.4235 Hz.
  CHECK(found["up"]["unlock_hz"].get<double>() == Approx(1.44));
  CHECK(found["down"]["jump_hz"].get<double>() == Approx(1.48));
  CHECK(found["down"]["lock_hz"].is_null());
  CHECK(found["up"]["peak"]["f_hz"].get<double>() == Approx(1.6));
  CHECK(nlohmann::json::parse(support::bytes_of(folder / "frc/frc.json"))["frequency_response"] == found);
  std::istringstream table(support::bytes_of(folder / "frc/frc.csv"));
  std::string line;
  std::getline(table, line);
  CHECK(line == "direction,f_hz,amplitude_m,mode,payload_amplitude_m,phase_deg,stuck_share");
  std::getline(table, line);
  CHECK(line == "up,1.4,0,locked,0.0045,,1");
  int rows = 1;
  while (std::getline(table, line)) ++rows;
  CHECK(rows == 22);
  CHECK(support::bytes_of(folder / "frc/frc.svg").find("</svg>") != std::string::npos);
}

TEST_CASE("an earlier simulation is replaced only by force, and then whole", "[apps][simulate_command]") {
  const support::Scratch folder;
  simulate({.system = "qzs", .folder = folder / "out", .duration_s = 1.0, .raw = true, .rate_hz = 256.0});
  const auto names = [&] {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder / "out")) found.insert(entry.path().filename().string());
    return found;
  };
  const auto first = names();
  const std::string truth = support::bytes_of(folder / "out/truth.json");
  check_fault([&] { simulate({.system = "duffing", .folder = folder / "out"}); }, dsp::FaultKind::output,
              "output.exists", {"holds earlier results", "--force", "-o"});
  // What is refused for another reason leaves the old one, too.
  CHECK_THROWS_AS(simulate({.system = "pendulum", .folder = folder / "out", .force = true}), dsp::Fault);
  CHECK_THROWS_AS(simulate({.system = "duffing", .folder = folder / "out", .force = true, .set = {"epsilon=-100"}}),
                  dsp::Fault);
  CHECK(names() == first);
  CHECK(support::bytes_of(folder / "out/truth.json") == truth);

  std::ofstream(folder / "out/notes.txt") << "mine";
  check_fault([&] { simulate({.system = "duffing", .folder = folder / "out", .force = true}); }, dsp::FaultKind::output,
              "output.foreign", {"out/notes.txt"});
  CHECK(support::bytes_of(folder / "out/truth.json") == truth);
  fs::remove(folder / "out/notes.txt");
  simulate({.system = "duffing", .folder = folder / "out", .force = true});
  CHECK(names() == std::set<std::string>{"manifest.json", "response.csv", "truth.json"});
  CHECK(truth_of(folder / "out")["system"] == "duffing");
  CHECK(support::run(folder, "$ARDENT -q sim coulomb -o out").code == 5);
  CHECK(support::run(folder, "$ARDENT -q sim coulomb -o out --force").code == 0);
  CHECK(truth_of(folder / "out")["system"] == "coulomb");
}

TEST_CASE("what cannot be simulated is refused in one line", "[apps][simulate_command]") {
  const support::Scratch folder;
  const auto usage = dsp::FaultKind::usage;
  const auto fails = [&](apps::SimulateArguments arguments, const std::string& name, const std::string& piece) {
    arguments.folder = folder / "out";
    check_fault([&] { simulate(arguments); }, usage, name, {piece});
  };
  fails({.system = "pendulum", .folder = {}}, "sim.option", "there are linear, duffing");
  fails({.system = "duffing", .folder = {}, .set = {"mass=2"}}, "sim.option", "no parameter \"mass\"");
  fails({.system = "duffing", .folder = {}, .set = {"epsilon=two"}}, "sim.option", "got \"epsilon=two\"");
  fails({.system = "bouc-wen", .folder = {}, .set = {"z0=1e308"}}, "sim.option", "initial value");
  fails({.system = "duffing", .folder = {}, .noise = -0.1}, "sim.noise", "-0.1");
  fails({.system = "duffing", .folder = {}, .duration_s = 0.0}, "sim.duration", "--duration 0, want 0.01");
  fails({.system = "duffing", .folder = {}, .raw = true}, "sim.option", "belong to qzs");
  fails({.system = "duffing", .folder = {}, .frc = true}, "sim.option", "belong to qzs");
  fails({.system = "qzs", .folder = {}, .noise = 3.0}, "sim.option", "add --raw");
  fails({.system = "qzs", .folder = {}, .programme = "sideways"}, "sim.option", "down, up, decay");
  fails({.system = "qzs", .folder = {}, .set = {"dwell=3"}}, "sim.option", "of the programme: amplitude_mm, dwell_s");
  fails({.system = "qzs", .folder = {}, .set = {"releases=2.5"}, .programme = "decay"}, "sim.option", "2.5");
  fails({.system = "qzs", .folder = {}, .set = {"from_hz=1", "to_hz=2"}}, "sim.option", "cannot go from 1 to 2");
  fails({.system = "qzs", .folder = {}, .set = {"step_hz=0"}, .frc = true}, "sim.option", "step_hz");
  fails({.system = "qzs", .folder = {}, .set = {"step=1"}, .frc = true}, "sim.option", "of the sweep: from_hz");
  fails({.system = "qzs", .folder = {}, .frc = true, .raw = true}, "sim.option", "--frc");
  fails({.system = "qzs", .folder = {}, .sensors = "ideal"}, "sim.option", "add --raw");
  fails({.system = "qzs", .folder = {}, .raw = true, .rate_hz = 25.6}, "sim.option", "must be whole");
  fails({.system = "qzs", .folder = {}, .raw = true, .from_s = -1.0}, "sim.option", "want 0 to 1e+09");
  fails({.system = "qzs", .folder = {}, .duration_s = 0.01, .raw = true, .rate_hz = 256.0}, "sim.option",
        "599 are the least");
  fails({.system = "qzs", .folder = {}, .twin = "T9"}, "sim.option", "T0, T1");
  fails({.system = "qzs", .folder = {}, .raw = true, .container = "mp3"}, "sim.option", "mp3");
  // 13 981 s of 4 channels of 24 bits at 25.6 kHz are 4 GiB.
  fails({.system = "qzs", .folder = {}, .duration_s = 14000.0, .raw = true, .container = "wav"}, "container.limit",
        "rf64");
  for (const std::string setting : {"bounce_hz=-5", "stribeck_m_per_s=-1", "position_modulation=3",
                                    "position_period_m=0", "amplitude_mm=-4", "k1=nan"})
    fails({.system = "qzs", .folder = {}, .set = {setting}}, "sim.option", setting.substr(0, setting.find('=')));
  fails({.system = "qzs", .folder = {}, .duration_s = 20.0, .set = {"clip=payload_laser:30:40:1"}, .raw = true},
        "sim.option", "fail at 30 s");
  CHECK_FALSE(fs::exists(folder / "out"));  // nothing was there before
  check_fault([&] { simulate({.system = "qzs", .folder = folder / "out", .duration_s = 1e9, .raw = true}); },
              dsp::FaultKind::output, "output.space", {"MB free", "--duration"});
  for (const std::string setting : {"k3=-1e9", "c=-5"})
    check_fault([&] { simulate({.system = "qzs", .folder = folder / "out", .duration_s = 20.0, .set = {setting}}); },
                dsp::FaultKind::numerics, "sim.diverged", {"Try"});
  // A softening spring pulled past its crest runs away.
  check_fault([&] { simulate({.system = "duffing", .folder = folder / "out", .set = {"epsilon=-100"}}); },
              dsp::FaultKind::numerics, "sim.diverged", {"passed 1e+06", "Try"});
}
