#include "dsp/prepare/sensor_checks.hpp"

#include <catch2/catch.hpp>

#include "dsp/io/sidecar.hpp"
#include "dsp/prepare.hpp"
#include "support/rig.hpp"
#include "support/signals.hpp"

namespace {

using Lines = std::vector<std::pair<std::string, std::string>>;  // name and message of a check

/// Two minutes of the rig with sensors that have noise and nothing else.
support::RigRecord record(std::uint64_t seed) {
  return support::rig_record(
      sim::qzs_twin("T0"),
      sim::sine_steps(
          {.frequencies_hz = {1.7, 1.6, 1.5, 1.45}, .amplitude_m = 4.5e-3, .dwell_s = 30.0, .transition_s = 2.0}),
      {.level = sim::SensorLevel::noise, .seed = seed});
}

/// What a recipe raises of the sensors: everything of theirs that is not "ok".
Lines raised(const dsp::Recording& recording, dsp::Recipe recipe, const std::vector<dsp::ChannelSpec>& channels = {}) {
  const auto prepared =
      dsp::prepare(recording, {.recipe = recipe, .rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0});
  Lines lines;
  for (const dsp::Check& check : dsp::sensor_checks(prepared, channels, "side.toml"))
    if (check.status != dsp::CheckStatus::ok)
      lines.emplace_back((check.status == dsp::CheckStatus::warning ? "! " : "") + check.name, check.message);
  return lines;
}

std::vector<dsp::ChannelSpec> described() {
  std::vector<dsp::ChannelSpec> channels;
  for (const auto& sensor : sim::rig_sensors(sim::SensorLevel::ideal, sim::qzs_twin("T0"))) {
    dsp::ChannelSpec channel;
    channel.name = sensor.name;
    channel.sensitivity = dsp::parse_sensitivity(sensor.unit == "m" ? "114.286 mV/mm" : "100 mV/g");
    channels.push_back(channel);
  }
  return channels;
}

}  // namespace

TEST_CASE("a wrong sensor is one line with the line that mends it", "[dsp][sensor_checks]") {
  const dsp::Recording clean = record(81).recording;
  CHECK(raised(clean, dsp::Recipe::matched).empty());
  CHECK(raised(clean, dsp::Recipe::paper).empty());
  const auto with = [&](double base_laser, double payload_accelerometer) {
    dsp::Recording recording = clean;
    recording.samples.col(0) *= base_laser;
    recording.samples.col(3) *= payload_accelerometer;
    return recording;
  };
  const auto one = [&](const dsp::Recording& recording, const std::string& name, const std::string& line) {
    const Lines lines = raised(recording, dsp::Recipe::matched, described());
    INFO(name);
    REQUIRE(lines.size() == 1);
    CHECK(lines[0].first == name);
    CHECK_THAT(lines[0].second, Catch::Contains("In side.toml, [[channel]] name = \"") && Catch::Contains(line) &&
                                    !Catch::Contains("\n"));
  };
  one(with(1.0, 1.02), "sensor.gain", "payload_accelerometer\": sensitivity = \"10");
  one(with(1.0, -1.0), "! sensor.polarity", "payload_accelerometer\" or its partner");
  one(with(1000.0, 1.0), "! sensor.unit", "base_laser\": sensitivity = \"1.14");
  one(with(1.0, 1.0 / 9.80665), "! sensor.unit", "payload_accelerometer\": sensitivity = \"10.");
  auto in_newtons = described();
  in_newtons[3].sensitivity = dsp::parse_sensitivity("10 pC/(m/s^2)");
  CHECK_THAT(raised(with(1.0, 1.02), dsp::Recipe::matched, in_newtons).at(0).second,
             Catch::Contains("sensitivity = \"1.02e-11 C/(m/s^2)\""));
  for (const Lines& lines :
       {raised(with(1000.0, 1.0), dsp::Recipe::matched), raised(with(1.0, 1.0 / 9.80665), dsp::Recipe::matched),
        raised(with(1.0, 1.3), dsp::Recipe::matched), raised(with(1.0, -1.0), dsp::Recipe::matched)}) {
    REQUIRE(lines.size() == 1);  // beyond what sensors differ by nothing is touched
    CHECK_THAT(lines[0].second, Catch::Contains("not corrected"));
  }
  dsp::Recording late = clean;  // 1.7 samples at 256 Hz, as a mixture of the two neighbours' neighbours
  const Eigen::Index n = late.samples.rows();
  for (Eigen::Index i = 2; i < n; ++i)
    late.samples(i, 1) = 0.3 * clean.samples(i - 1, 1) + 0.7 * clean.samples(i - 2, 1);
  one(late, "sensor.lag", "payload_laser\": delay = \"6.6");
  // A recipe that takes the sensors as they are says that nothing was corrected.
  const Lines uncorrected = raised(with(1.0, 1.02), dsp::Recipe::paper);
  REQUIRE(uncorrected.size() == 1);
  CHECK(uncorrected[0].first == "! sensor.gain");
  CHECK_THAT(uncorrected[0].second, Catch::Contains("not corrected"));
}

TEST_CASE("lines for a channel given by its unit", "[dsp][sensor_checks]") {
  dsp::ChannelSpec channel;
  channel.role = dsp::Role::ddy;
  channel.unit = "g";
  const dsp::SensorProblem gain{.kind = dsp::SensorProblemKind::gain, .unit = "m/s^2", .sensitivity_factor = 1.02};
  CHECK(dsp::remedy(gain, &channel) == "full_scale = \"9.61436 m/s^2\"");  // 9.80665 / 1.02
  CHECK(dsp::remedy(gain, nullptr) == "full_scale = \"0.980392 m/s^2\"");
  const dsp::SensorProblem unit{.kind = dsp::SensorProblemKind::unit, .unit = "mm"};
  CHECK(dsp::remedy(unit, &channel) == "unit = \"mm\"");
  channel.delay_s = 1e-3;
  CHECK(dsp::remedy({.kind = dsp::SensorProblemKind::lag, .delay_s = 5e-4}, &channel) == "delay = \"1.5 ms\"");
  CHECK(dsp::remedy({.kind = dsp::SensorProblemKind::cutoff, .highpass_hz = {0.4, 0.3}}, &channel) ==
        "highpass = [0.4, 0.3]");
}

TEST_CASE("a table's displacement, velocity and acceleration are compared for sign and scale", "[dsp][sensor_checks]") {
  // A slow swing and a fast one, a hundred seconds at 50 Hz; velocity and acceleration by hand.
  const auto table = [](double x_scale, double v_scale, double a_scale) {
    dsp::Recording recording{.name = "table", .sample_rate_hz = 50.0};
    recording.channels = {{.name = "x", .role = dsp::Role::x, .unit = "m"},
                          {.name = "v", .role = dsp::Role::v, .unit = "m/s"},
                          {.name = "a", .role = dsp::Role::a, .unit = "m/s^2"}};
    recording.samples.resize(5000, 3);
    for (Eigen::Index i = 0; i < 5000; ++i) {
      const double t = static_cast<double>(i) / 50.0;
      double x = 0.0, v = 0.0, a = 0.0;
      for (const auto& [amplitude, speed] : {std::pair{0.02, 0.9}, std::pair{0.003, 11.0}}) {
        x += amplitude * std::sin(speed * t), v += amplitude * speed * std::cos(speed * t);
        a -= amplitude * speed * speed * std::sin(speed * t);
      }
      recording.samples.row(i) << x_scale * x, v_scale * v, a_scale * a;
    }
    return recording;
  };
  const auto raised_of = [&](const dsp::Recording& recording, dsp::Recipe recipe) {
    Lines lines;
    for (const dsp::Check& check : dsp::sensor_checks(
             dsp::prepare(recording, {.recipe = recipe, .rate_hz = 50.0, .cutoff_hz = 10.0}), {}, "side.toml"))
      if (check.status != dsp::CheckStatus::ok) lines.emplace_back(check.name, check.message);
    return lines;
  };
  for (const auto recipe : {dsp::Recipe::matched, dsp::Recipe::paper}) {
    CHECK(raised_of(table(1, 1, 1), recipe).empty());
    CHECK(raised_of(table(1, 1, 0.95), recipe).empty());  // a column that was filtered, say
    const auto one = [&](const dsp::Recording& recording, const std::string& name, const std::string& piece) {
      const Lines lines = raised_of(recording, recipe);
      REQUIRE(lines.size() == 1);
      CHECK(lines[0].first == name);
      CHECK_THAT(lines[0].second, Catch::Contains("not corrected. In side.toml") && Catch::Contains(piece));
    };
    one(table(1, 1, 1 / 9.80665), "sensor.unit", "name = \"a\": unit = \"g\"");
    one(table(1, 1000, 1), "sensor.unit", "name = \"v\": unit = \"mm/s\"");
    one(table(1, 1, -1), "sensor.polarity", "a\" or its partner, whichever is wired the wrong way round: sign = -1");
    one(table(1, 1, 1.2), "sensor.gain",
        "name = \"a\" or its partner, whichever is calibrated wrongly: full_scale = \"0.833333 m/s^2\"");
    one(table(1, 0.7, 1), "sensor.gain", "v reads 0.7");
    const auto calibrated_to = [](dsp::Recording recording, double fraction) {
      for (dsp::Channel& channel : recording.channels) channel.sensitivity_uncertainty = fraction;
      return recording;
    };
    one(calibrated_to(table(1, 1, 0.95), 0.002), "sensor.gain", "a\" or its partner");  // 18 standard deviations
    CHECK(raised_of(calibrated_to(table(1, 1, 1.2), 0.1), recipe).empty());             // 1.3
    dsp::Recording noisy = table(1, 1, 1);  // noise in x that takes a tenth off the ratio
    noisy.samples.col(0) += support::gaussian(5000, 5, 0.3 * 0.0143);
    CHECK(raised_of(noisy, recipe).empty());
    const Lines both = raised_of(table(1000, 1, 1), recipe);  // seen from v and from a
    REQUIRE(both.size() == 2);
    for (const auto& [name, line] : both) CHECK_THAT(line, Catch::Contains("name = \"x\": unit = \"mm\""));
    dsp::Recording bare = table(1, 1, -1 / 9.80665);
    bare.channels[0].role = dsp::Role::other;
    bare.channels.push_back({.name = "y", .role = dsp::Role::y, .unit = "m"});
    bare.samples.conservativeResize(Eigen::NoChange, 4);
    bare.samples.col(3) = bare.samples.col(0);
    CHECK(raised_of(bare, recipe).size() == 2);  // v and a alone: sign and unit
  }
}

TEST_CASE("sensors of twenty clean records raise nothing", "[.][study][sensor_checks]") {
  for (std::uint64_t seed = 201; seed <= 220; ++seed) {
    INFO("seed " << seed);
    const dsp::Recording clean = record(seed).recording;
    CHECK(raised(clean, dsp::Recipe::matched).empty());
    CHECK(raised(clean, dsp::Recipe::paper).empty());
  }
}
