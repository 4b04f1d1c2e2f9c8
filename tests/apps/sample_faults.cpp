// Samples that show something else than the motion, as the program meets them: refused, or repaired visibly.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>

#include "support/program.hpp"

using nlohmann::json;
using support::bytes_of;
using support::expect;
using support::Scratch;

namespace {

/// A minute of an oscillation at 100 Hz that no one needs to excuse; `spoil` changes the rows.
struct Row {
  double y, r, f;
};
void write_table(const Scratch& folder, const std::function<void(int, Row&)>& spoil, int num_rows = 6000,
                 const std::string& header = "t,y,r,f\n") {
  std::string text = header;
  for (int i = 0; i < num_rows; ++i) {
    const double t = 0.01 * i;
    Row row{0.01 * std::sin(7.0 * t + 0.3 * std::sin(0.4 * t)), 0.004 * std::sin(5.0 * t + 0.2 * std::sin(0.3 * t)),
            std::sin(4.3 * t)};
    spoil(i, row);
    char line[160];
    std::snprintf(line, sizeof line, "%.4f,%.12g,%.12g,%.12g\n", t, row.y, row.r, row.f);
    text += line;
  }
  (void)folder.file("m.csv", text);
}

json checks_of(const Scratch& folder, const std::string& run, const std::string& name, const std::string& channel) {
  const json quality = json::parse(bytes_of(folder / (run + "/quality.json")));
  for (const auto& check : quality["checks"])
    if (check["name"] == name && check["channel"] == channel) return check;
  FAIL("no check " << name << " of " << channel);
  return {};
}

/// The excluded interval with this reason.
std::pair<double, double> excluded(const Scratch& folder, const std::string& run, const std::string& reason) {
  const json segments = json::parse(bytes_of(folder / (run + "/segments.json")));
  for (const auto& segment : segments)
    if (segment["label"] == "excluded" && segment["reason"] == reason) return {segment["from_s"], segment["to_s"]};
  FAIL("nothing excluded because of " << reason);
  return {};
}

}  // namespace

TEST_CASE("missing values are bridged, marked and left out, however many", "[apps][faults]") {
  const Scratch folder;
  write_table(folder, [](int i, Row& row) {
    if (i >= 3000 && i < 3020) row.y = std::nan("");
    if (i == 4000) row.y = -INFINITY;
  });
  expect(folder, "$ARDENT run m.csv -o few", 0, {"warning", "[sample.missing]", "21 values missing in 2 gaps", "30 s"});
  const auto [from_s, to_s] = excluded(folder, "few", "no values in y");
  CHECK(from_s < 30.0);
  CHECK(to_s > 30.2);
  write_table(folder, [](int i, Row& row) {
    if (i >= 3000 && i < 3320) row.y = std::nan("");
  });
  expect(folder, "$ARDENT run m.csv -o many", 0, {"warning", "[sample.missing]", "320 values missing in 1 gaps"});
  const auto [begin_s, end_s] = excluded(folder, "many", "no values in y");
  CHECK(begin_s < 30.0);
  CHECK(end_s > 33.2);
  CHECK(begin_s > 25.0);  // the record around it is kept
  CHECK(end_s < 38.0);
}

TEST_CASE("what the rig's sensors lose is found where it was lost, with the margins of the filters", "[apps][faults]") {
  const Scratch folder;
  REQUIRE(
      support::run(folder,
                   "$ARDENT -q sim qzs --raw -o rig --duration 100 --set rail=payload_laser:40:40.3 "
                   "--set hold=3:50:50.4 --set hold=base_laser:60:60.25 --set clip=payload_accelerometer:70:72:0.004")
          .code == 0);
  const json faults = json::parse(bytes_of(folder / "rig/truth.json"))["sensors"]["faults"];
  REQUIRE(faults.size() == 4);
  CHECK(faults[3]["limit_v"] == 0.004);
  expect(folder, "$ARDENT -q prep rig/recording.wav -o found --set prepare.rate_hz=25.6 --set prepare.cutoff_hz=10.24",
         0, {});
  const double reach_s = 1.7, late_s = 0.4;  // two filters and the derivatives' taper; intervals are placed to a cell
  const auto check_found = [&](const std::string& reason, double from, double to) {
    CAPTURE(reason);
    const auto [from_s, to_s] = excluded(folder, "found", reason);
    CHECK(from_s <= from - reach_s);
    CHECK(from_s >= from - reach_s - late_s);
    CHECK(to_s >= to + reach_s);
    CHECK(to_s <= to + reach_s + late_s);
  };
  check_found("payload_laser: dropout", 40.0, 40.3);
  check_found("base_accelerometer: held", 50.0, 50.4);
  check_found("base_laser: held", 60.0, 60.25);
  const auto [from_s, to_s] = excluded(folder, "found", "payload_accelerometer: clipped");
  CHECK(from_s > 67.0);
  CHECK(to_s < 75.0);
  CHECK(checks_of(folder, "found", "sample.dropout", "payload_laser")["value"].get<double>() ==
        Approx(0.3).margin(3e-3));
  CHECK(checks_of(folder, "found", "sample.held", "base_accelerometer")["value"].get<double>() ==
        Approx(0.4).margin(3e-3));
  CHECK(checks_of(folder, "found", "sample.clipped", "payload_accelerometer")["value"].get<double>() > 1e-3);
  CHECK(checks_of(folder, "found", "sample.clipped", "payload_laser")["value"] == 0.0);
}

TEST_CASE("a gap in a sensor costs the rows around it and no more", "[apps][faults]") {
  const Scratch folder;
  const auto coefficients = [&](const std::string& settings, const std::string& run) {
    REQUIRE(
        support::run(folder, "$ARDENT -q sim qzs --raw -o " + run + "-rig --sensors noise --duration 120 " + settings)
            .code == 0);
    expect(folder,
           "$ARDENT -q run " + run + "-rig/recording.wav -o " + run +
               " --set prepare.rate_hz=25.6 --set prepare.cutoff_hz=10.24 --set library.order=0 --set "
               "'library.terms=[\"x\",\"v\",\"x^3\",\"sgn(v)\",\"ddr\"]'"
               " --set 'fit.methods=[\"ols\"]'",
           0, {});
    const json metrics = json::parse(bytes_of(folder / (run + "/metrics.json")));
    std::vector<double> means;
    for (const auto& term : metrics["ranges"][0]["methods"][0]["terms"]) means.push_back(term["mean"]);
    return means;
  };
  const auto whole = coefficients("", "whole");
  const auto gapped = coefficients("--set rail=payload_laser:40:40.3 --set hold=base_laser:60:60.4", "gapped");
  REQUIRE(whole.size() == 5);
  REQUIRE(gapped.size() == 5);
  // Nine seconds of rows less, of seventy; half a per cent of what is left in the gap's neighbourhood. A rail left in
  // changes every coefficient by its own size.
  for (std::size_t i = 0; i < whole.size(); ++i) CHECK(gapped[i] == Approx(whole[i]).epsilon(0.02));
}

TEST_CASE("too much clipping where it is trained is refused, elsewhere it is left out", "[apps][faults]") {
  const Scratch folder;
  write_table(folder, [](int i, Row& row) { row.y = i < 3000 ? std::clamp(row.y, -0.007, 0.007) : 0.6 * row.y; });
  const std::string elsewhere = " --set 'range=[{name=\"late\", from=32.0, to=60.0}]'";
  expect(folder, "$ARDENT run m.csv -o early", 3,
         {"[sample.clipped]", "m.csv", "range 'all'", "y is clipped", "at most 1 %", "prepare.max_clipped"});
  CHECK_FALSE(std::filesystem::exists(folder / "early"));
  expect(folder, "$ARDENT check m.csv", 3, {"[sample.clipped]"});
  expect(folder, "$ARDENT run m.csv -o late" + elsewhere, 0, {"warning", "[sample.clipped]"});
  CHECK(excluded(folder, "late", "y: clipped").second < 34.0);
  CHECK(checks_of(folder, "late", "sample.clipped", "y")["status"] == "warning");
  expect(folder, "$ARDENT check m.csv --set prepare.max_clipped=0.9", 0, {"sample.clipped"});
}

TEST_CASE("spikes of a force, offsets and drifts are left as they are; isolated displacements are missing values",
          "[apps][faults]") {
  const Scratch folder;
  write_table(folder, [](int i, Row& row) {
    if (i == 2000 || i == 4000) row.f += 5.0;
    if (i == 3000) row.y += 0.05;
    row.r += 0.02 + 1e-6 * i;
  });
  expect(folder, "$ARDENT run m.csv -o left", 0, {});
  const json spikes = checks_of(folder, "left", "sample.spike", "f");
  CHECK(spikes["value"] == 2.0);
  CHECK_THAT(spikes["message"].get<std::string>(), Catch::Contains("20 s") && Catch::Contains("left in"));
  CHECK(checks_of(folder, "left", "sample.spike", "r")["value"] == 0.0);
  CHECK(checks_of(folder, "left", "sample.isolated", "y")["value"] == 1.0);
  CHECK(checks_of(folder, "left", "sample.missing", "y")["value"] == 1.0);
  CHECK(checks_of(folder, "left", "sample.offset", "r")["value"].get<double>() == Approx(0.023).margin(2e-4));
  CHECK(checks_of(folder, "left", "sample.offset", "r")["status"] == "note");
  CHECK(checks_of(folder, "left", "sample.drift", "r")["value"].get<double>() == Approx(0.006).margin(4e-4));
}

TEST_CASE("a channel that never moves is refused where the motion rests on it, else reported", "[apps][faults]") {
  const Scratch folder;
  write_table(folder, [](int, Row& row) { row.y = 0.0; });
  expect(folder, "$ARDENT run m.csv -o dead", 3, {"[sample.constant]", "m.csv", "'y'", "all values are zero", "use"});
  CHECK_FALSE(std::filesystem::exists(folder / "dead"));
  write_table(folder, [](int, Row& row) { row.f = 2.5; });
  expect(folder, "$ARDENT run m.csv -o alive", 0, {"warning", "[sample.constant]", "all values are 2.5"});
}

TEST_CASE("too few samples for the filters are refused with the least", "[apps][faults]") {
  const Scratch folder;
  const auto unspoilt = [](int, Row&) {};
  write_table(folder, unspoilt, 1);
  expect(folder, "$ARDENT run m.csv -o one", 3, {"[rate.missing]", "m.csv"});
  write_table(folder, unspoilt, 6);
  expect(folder, "$ARDENT run m.csv -o six", 3, {"[sample.too_few]", "6 samples are too few", "some hundred"});
  write_table(folder, unspoilt, 300);
  expect(folder, "$ARDENT run m.csv -o few --set prepare.rate_hz=2.5", 3,
         {"[sample.too_few]", "300 samples", "at least", "rate_hz"});
  for (const char* name : {"one", "six", "few"}) CHECK_FALSE(std::filesystem::exists(folder / name));
}

TEST_CASE("a channel of few levels is warned of with its effective bits", "[apps][faults]") {
  const Scratch folder;
  write_table(folder, [](int, Row& row) { row.y = 0.0005 * std::round(row.y / 0.0005); });
  expect(folder, "$ARDENT run m.csv -o coarse", 0, {"warning", "[sample.quantised]", "effective bits"});
  CHECK(checks_of(folder, "coarse", "sample.quantised", "y")["value"].get<double>() ==
        Approx(std::log2(41.0)).margin(0.1));
}

TEST_CASE("what would fold is estimated, and power close to half the rate warned of", "[apps][faults]") {
  const Scratch folder;
  write_table(folder, [](int i, Row& row) {
    row.y += 0.001 * std::sin(2 * 3.14159265358979 * 30.0 * 0.01 * i);        // hum: removed by the decimator
    row.r += 0.002 * std::sin(2 * 3.14159265358979 * 48.0 * 0.01 * i + 0.1);  // something above half the rate, folded
  });
  expect(folder, "$ARDENT run m.csv -o folded --set prepare.rate_hz=20 --set prepare.cutoff_hz=8", 0,
         {"warning", "[sample.near_nyquist]"});
  const json alias = checks_of(folder, "folded", "sample.alias", "y");
  CHECK_THAT(alias["message"].get<std::string>(), Catch::Contains("30 Hz") && Catch::Contains("fold to 10 Hz"));
  CHECK(alias["value"].get<double>() < 1e-6);  // a tenth of the rms, 120 dB down
  CHECK(alias["value"].get<double>() > 0.0);
  CHECK(checks_of(folder, "folded", "sample.near_nyquist", "y")["status"] == "ok");
  const json near = checks_of(folder, "folded", "sample.near_nyquist", "r");
  CHECK(near["status"] == "warning");
  CHECK(near["value"].get<double>() == Approx(0.2).margin(0.02));  // 2^2 of 2^2 + 4^2
}

TEST_CASE("values beyond all measure are refused, tiny ones scaled", "[apps][faults]") {
  const Scratch folder;
  write_table(folder, [](int i, Row& row) {
    if (i == 3000) row.y = 1e300;
  });
  expect(folder, "$ARDENT run m.csv -o alone", 0, {"[sample.isolated]", "1e+300", "30 s"});
  write_table(folder, [](int i, Row& row) {
    if (i >= 3000) row.y = 1e300;
  });
  expect(folder, "$ARDENT run m.csv -o huge", 3, {"[sample.huge]", "'y'", "1e+300", "30 s"});
  CHECK_FALSE(std::filesystem::exists(folder / "huge"));
  const auto identified = [&](double unit) {
    write_table(folder, [&](int, Row& row) { row.y *= unit, row.r *= unit; });
    const auto ended = expect(
        folder, "$ARDENT run m.csv --force -o scaled --set library.order=1 --set 'library.terms=[\"ddr\"]'", 0, {});
    CHECK(ended.out.find("nan") == std::string::npos);
    return json::parse(bytes_of(folder / "scaled/metrics.json"))["ranges"][0]["methods"][0];
  };
  const json usual = identified(1.0);
  for (const double unit : {1e-150, 1e-310, 1e90}) {
    CAPTURE(unit);
    const json fit = identified(unit);
    REQUIRE(fit["terms"].size() == usual["terms"].size());
    for (std::size_t i = 0; i < fit["terms"].size(); ++i)  // accelerations of 1e-310 hold five digits
      CHECK(fit["terms"][i]["mean"].get<double>() == Approx(usual["terms"][i]["mean"].get<double>()).epsilon(1e-4));
    CHECK(fit["nmse"]["train"].get<double>() == Approx(usual["nmse"]["train"].get<double>()).epsilon(1e-3));
  }
}

TEST_CASE("any rate below the recording's is reached, none above it", "[apps][faults]") {
  const Scratch folder;
  write_table(folder, [](int, Row&) {});
  expect(folder, "$ARDENT prep m.csv -o broken --set prepare.rate_hz=17.5", 0, {});
  const json motion = json::parse(bytes_of(folder / "broken/quality.json"))["motion"][0];
  CHECK(motion["rate_hz"] == 17.5);
  CHECK(motion["num_samples"] == 1050);
  CHECK(motion["decimation"]["alias_rejection_db"].get<double>() >= 120.0);
  // 100 / 17.501 is no fraction that a filter could be made for; what is named instead serves.
  for (const char* odd : {"17.501", "3.14159265", "99.9999"}) {
    const auto refused = expect(folder, std::string("$ARDENT prep m.csv -o odd --set prepare.rate_hz=") + odd, 2,
                                {"[prepare.rate]", odd, "100 Hz", "nearest"});
    const std::string nearest = refused.err.substr(refused.err.find("possible rate_hz is ") + 20);
    CHECK(std::stod(nearest) == Approx(std::stod(odd)).epsilon(5e-3));
    expect(folder, "$ARDENT prep m.csv --force -o even --set prepare.rate_hz=" + nearest, 0, {});
  }
  CHECK_FALSE(std::filesystem::exists(folder / "odd"));
  expect(folder, "$ARDENT prep m.csv -o above --set prepare.rate_hz=250", 2, {"[prepare.rate]", "250", "100"});
  expect(folder, "$ARDENT prep m.csv -o above --set prepare.cutoff_hz=55", 2, {"[prepare.cutoff]", "55", "50"});
}

TEST_CASE("ends that lean on predicted samples are trimmed and counted", "[apps][faults]") {
  const Scratch folder;
  write_table(folder, [](int, Row&) {});
  expect(folder, "$ARDENT run m.csv -o ends --set prepare.rate_hz=20", 0, {});
  const json quality = json::parse(bytes_of(folder / "ends/quality.json"));
  const int edge = quality["motion"][0]["edge_samples"];
  CHECK(edge > 0);
  bool reported = false;
  for (const auto& check : quality["checks"]) {
    if (check["name"] != "prepare.edges") continue;
    reported = true;
    CHECK(check["status"] == "note");
    CHECK(check["value"].get<double>() == Approx(edge / 20.0));
    CHECK_THAT(check["message"].get<std::string>(),
               Catch::Contains(std::to_string(edge) + " samples") && Catch::Contains("either end"));
  }
  CHECK(reported);
  const json range = json::parse(bytes_of(folder / "ends/metrics.json"))["ranges"][0];
  CHECK(range["num_train"].get<int>() + range["num_test"].get<int>() ==
        quality["motion"][0]["num_samples"].get<int>() - 2 * edge);
}

TEST_CASE("a laser's lag and an accelerometer's gain are estimated, reported, and left where asked", "[apps][faults]") {
  const Scratch folder;
  REQUIRE(support::run(folder, "$ARDENT -q sim qzs --raw -o rig --duration 300 --rate 256").code == 0);
  const std::string run = "$ARDENT -v prep rig/recording.wav --set prepare.rate_hz=25.6 --set prepare.cutoff_hz=10.24";
  expect(folder, run + " -o agreed", 0,
         {"velocity and acceleration", "payload_laser comes 1.2", "ms later", "corrected"});
  const json quality = json::parse(bytes_of(folder / "agreed/quality.json"));
  REQUIRE(quality["pairs"].size() == 2);
  for (const auto& pair : quality["pairs"]) {
    CAPTURE(pair);
    CHECK(pair["lag_s"].get<double>() == Approx(1.2305e-3).margin(0.3e-3));  // a sixth of the 1800 s it is meant for
  }
  expect(folder, run + " -o left --set prepare.equalise=false", 0,
         {"[sensor.lag]", "[sensor.gain]", "[sensor.corner]", "not corrected", "sensitivity = "});
  const std::string agreed = bytes_of(folder / "agreed/prepared.csv"), left = bytes_of(folder / "left/prepared.csv");
  CHECK(agreed != left);
}
