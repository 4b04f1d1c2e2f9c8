#include "dsp/io/sidecar.hpp"

#include <catch2/catch.hpp>
#include <ctime>
#include <string>

#include "support/fault.hpp"

using dsp::FaultKind;
using support::check_fault;

namespace {
dsp::Sidecar parse(const std::string& text) {
  return dsp::parse_sidecar(text, "rig.wav.toml");
}
dsp::Sidecar channel(const std::string& lines) {
  return parse("[[channel]]\nname = \"c\"\n" + lines);
}
}  // namespace

TEST_CASE("a full sidecar is understood", "[dsp][sidecar]") {
  const auto sidecar = parse(R"(schema = 1
title  = "QZS rig, stepped sine, down-sweep 45"
rate   = "51200/3"
start  = 2023-05-04T10:12:30Z
[[channel]]
name        = "base_disp"
index       = 1
role        = "r"
unit        = "mm"
sensitivity = "250 mV/mm"
full_scale  = "10 V"
coupling    = "DC"
sensor      = { model = "ZX2-LD100", serial = "A1234", calibrated = 2022-11-02 }
[[channel]]
name        = "payload_acc"
column      = "ai0"
file        = "acc.w64"
role        = "ddy"
sensitivity = "100.1 mV/g"
full_scale  = "5 V"
coupling    = "IEPE"
highpass    = [0.4, 0.3]
sign        = -1
delay       = "0.23 ms"
offset      = "2.5 V"
[[range]]
name = "low"
to   = 830
train_to = 500
[[bad]]
from = 412.1
to   = 412.6
why  = "cable knocked"
)");
  CHECK(sidecar.title == "QZS rig, stepped sine, down-sweep 45");
  CHECK(*sidecar.rate_hz == 51200.0 / 3);
  CHECK(sidecar.start == "2023-05-04T10:12:30Z");
  REQUIRE(sidecar.channels.size() == 2);
  const auto& base = sidecar.channels[0];
  CHECK(base.index == 1);
  CHECK(base.role == dsp::Role::r);
  CHECK(base.full_scale->value == 10.0);
  CHECK(base.sensor.at("serial") == "A1234");
  const auto& payload = sidecar.channels[1];
  CHECK(payload.file == "acc.w64");
  CHECK(payload.column == "ai0");
  CHECK(payload.sign == -1.0);
  CHECK(payload.delay_s == Approx(0.23e-3).epsilon(1e-15));
  CHECK(payload.highpass_hz == std::vector<double>{0.4, 0.3});
  CHECK(payload.offset->si == "V");
  REQUIRE(sidecar.ranges.size() == 1);
  CHECK(sidecar.ranges[0].from_s == 0.0);
  CHECK(*sidecar.ranges[0].train_to_s == 500.0);
  REQUIRE(sidecar.bad.size() == 1);
  CHECK(sidecar.bad[0].why == "cable knocked");
}

TEST_CASE("six lines are enough", "[dsp][sidecar]") {
  const auto sidecar = parse(
      "[[channel]]\nname = \"acc\"\nindex = 1\nrole = \"ddy\"\nsensitivity = \"100 mV/g\"\nfull_scale = \"5 V\"\n");
  CHECK(sidecar.channels.at(0).sign == 1.0);
  CHECK(sidecar.channels[0].highpass_hz.empty());
}

TEST_CASE("what a sidecar gets wrong is named with its line", "[dsp][sidecar]") {
  const auto refused = [](const std::string& lines, const std::string& name, const std::vector<std::string>& pieces) {
    check_fault([&] { (void)channel(lines); }, FaultKind::usage, name, pieces);
  };
  refused("sensitvity = \"1 mV/g\"", "config.unknown_key", {"rig.wav.toml:3:", "Did you mean 'sensitivity'?"});
  refused("sensitivity = \"0 mV/g\"", "calibration.value", {"rig.wav.toml:3: [[channel]] 1: sensitivity", "positive"});
  refused("sensitivity = \"-3 mV/g\"", "calibration.value", {"sign = -1"});
  refused("sensitivity = \"nan mV/g\"", "calibration.value", {"positive"});
  refused("sensitivity = \"100 mV/gram\"", "unit.unknown", {"gravity"});
  refused("sensitivity = 100", "config.type", {"want a text", "such as \"100 mV/g\""});
  refused("full_scale = 10", "config.type", {"want a text", "such as \"10 V\""});
  refused("unit = \"mm\"\nsensitivity = \"100 mV/g\"", "unit.kind", {"rig.wav.toml:3", "m/s^2"});
  refused("unit = \"mm\"\nrole = \"ddy\"", "unit.role", {"role ddy is measured in m/s^2"});
  refused("full_scale = \"5 N\"\nunit = \"mm\"", "unit.kind", {"want m", "sensitivity"});
  refused("full_scale = \"-5 V\"\nsensitivity = \"1 mV/g\"", "calibration.value", {"positive"});
  refused("sign = 2", "config.range", {"want 1 or -1"});
  refused("role = \"payload\"", "config.range", {"role must be one of"});
  refused("index = 0", "config.range", {"1 to 100000"});
  refused("index = 1\ncolumn = \"a\"", "config.range", {"cannot be given beside 'index'"});
  refused("delay = \"3 mm\"", "unit.kind", {"want s"});
  refused("highpass = -1", "config.range", {"above 0"});
  refused("[[channel]]\nname = \"c\"", "channel.name", {"rig.wav.toml:3", "rig.wav.toml:1", "'c'"});
  refused("[[bad]]\nfrom = 3\nto = 2", "config.range", {"from below to"});
}

TEST_CASE("cut-offs and uncertainties are numbers or texts with their unit", "[dsp][sidecar]") {
  const auto of = [](const std::string& line) { return channel(line).channels.at(0); };
  CHECK(of("highpass = \"0.4 Hz\"").highpass_hz == of("highpass = 0.4").highpass_hz);
  CHECK(of("sensitivity_uncertainty = \"0.5 %\"").sensitivity_uncertainty == 0.01 * 0.5);
  CHECK(of("sensitivity_uncertainty = 0.005").sensitivity_uncertainty == 0.005);
  const auto refused = [&](const std::string& line, const std::string& piece) {
    check_fault([&] { (void)of(line); }, FaultKind::usage, "config.range", {"rig.wav.toml:3", piece});
  };
  refused("highpass = \"0 Hz\"", "above 0 Hz");
  for (const char* text : {"half a percent", "5", "0 %", "101 %"})
    refused("sensitivity_uncertainty = \"" + std::string(text) + "\"", "\"0.5 %\"");
  check_fault([] { (void)parse("start = 2023\n[[channel]]\nname = \"c\""); }, FaultKind::usage, "config.type",
              {"rig.wav.toml:1", "2023-05-04T10:12:30Z"});
}

TEST_CASE("ranges must make sense", "[dsp][sidecar]") {
  const auto refused = [](const std::string& lines, const std::vector<std::string>& pieces) {
    check_fault([&] { (void)parse(lines); }, FaultKind::usage, "config.range", pieces);
  };
  refused("[[range]]\nfrom = 5\nto = 5", {"rig.wav.toml:3", "from below to"});
  refused("[[range]]\nto = 5\ntrain_to = 6", {"rig.wav.toml:3", "above 0 and at most 5"});
  refused("[[range]]\nname = \"a\"\n[[range]]\nname = \"a\"", {"rig.wav.toml:4", "exists already"});
  refused("rate = \"51200/0\"", {"rig.wav.toml:1", "51200/3"});
  refused("rate = -1", {"above 0"});
  check_fault([] { (void)parse("clock = \"interpolate\""); }, FaultKind::usage, "config.missing", {"rate = 100"});
}

TEST_CASE("a sidecar lies beside its recording", "[dsp][sidecar]") {
  CHECK(dsp::sidecar_path("runs/rig.wav") == "runs/rig.wav.toml");
}

TEST_CASE("many ranges and channels are read in a time that grows with their number", "[dsp][sidecar]") {
  const auto seconds = [](int count) {
    std::string text;
    for (int i = 0; i < count; ++i)
      text += "[[range]]\nname = \"r" + std::to_string(i) + "\"\n[[channel]]\nname = \"c" + std::to_string(i) + "\"\n";
    const std::clock_t begin = std::clock();
    CHECK(parse(text).ranges.size() == static_cast<std::size_t>(count));
    return static_cast<double>(std::clock() - begin);
  };
  // Four times as many: 4 times the time if linear, 16 if quadratic.
  CHECK(seconds(4'000) < 9.0 * seconds(1'000));
}
