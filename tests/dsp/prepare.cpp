#include "dsp/prepare.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "dsp/io/read_recording.hpp"
#include "dsp/prepare/power_check.hpp"
#include "support/signals.hpp"

namespace {
dsp::Recording recording(double rate_hz, Eigen::Index n) {
  dsp::Recording result{.name = "made up", .sample_rate_hz = rate_hz};
  result.channels = {{.name = "top", .role = dsp::Role::y, .unit = "m"},
                     {.name = "base", .role = dsp::Role::r, .unit = "m"}};
  result.samples.resize(n, 2);
  const support::SweptHarmonics payload, base{.start_hz = 1.2, .sweep_hz_per_s = 1e-3, .amplitudes = {4e-3, 1e-4}};
  for (Eigen::Index i = 0; i < n; ++i) {
    result.samples(i, 0) = payload.at(static_cast<double>(i) / rate_hz).x;
    result.samples(i, 1) = base.at(static_cast<double>(i) / rate_hz).x;
  }
  return result;
}
}  // namespace

TEST_CASE("left-out options are filled in from the rates", "[dsp][prepare]") {
  const auto own = dsp::resolved({}, 250.0);
  CHECK(own.rate_hz == 250.0);
  CHECK(own.cutoff_hz == 100.0);
  CHECK(own.rolloff_hz == Approx(78.125));
  CHECK(own.state_cutoff_hz == Approx(122.5));  // as far as the rate allows
  const auto narrow = dsp::resolved({.cutoff_hz = 30.0}, 250.0);
  CHECK(narrow.state_cutoff_hz == Approx(122.5));
  CHECK(narrow.state_rolloff_hz == Approx(0.75 * narrow.state_cutoff_hz));
}

TEST_CASE("the intermediate rate is a multiple of the regression rate that divides the recording's", "[dsp][prepare]") {
  const auto intermediate = [](double rate_hz, double sample_rate_hz) {
    return dsp::resolved({.rate_hz = rate_hz}, sample_rate_hz).intermediate_rate_hz;
  };
  CHECK(intermediate(25.6, 25600.0) == Approx(256.0));
  CHECK(intermediate(100.0, 10000.0) == Approx(1000.0));
  CHECK(intermediate(200.0, 3200.0) == Approx(1600.0));
  CHECK(intermediate(25.6, 256.0) == 256.0);
  CHECK(intermediate(25.6, 250.0) == 250.0);
  CHECK(intermediate(25.6, 44100.0) == Approx(256.0));
  CHECK(dsp::resolved({.rate_hz = 25.6}, 25600.0).state_cutoff_hz == Approx(20.0));
  // The multiple that is the record's own rate is that to the last bit: 15 (250 / 15) is rounded up, 19 (250 / 19)
  // down.
  for (const double own_hz : {50.0, 100.0, 125.0, 200.0, 250.0, 256.0, 1000.0})
    for (const double ratio : {11.0, 13.0, 15.0, 17.0, 19.0}) CHECK(intermediate(own_hz / ratio, own_hz) == own_hz);
}

TEST_CASE("frequencies that do not fit each other are refused by name", "[dsp][prepare]") {
  const auto name_of = [](const dsp::PrepareOptions& options) {
    try {
      (void)dsp::resolved(options, 250.0);
    } catch (const dsp::Fault& fault) {
      CHECK(fault.kind() == dsp::FaultKind::usage);
      return fault.name();
    }
    return std::string();
  };
  CHECK(name_of({.rate_hz = 300.0}) == "prepare.rate");
  CHECK(name_of({.rate_hz = -1.0}) == "prepare.rate");
  CHECK(name_of({.rate_hz = 50.0, .intermediate_rate_hz = 260.0}) == "prepare.bus_rate");
  CHECK(name_of({.cutoff_hz = 125.0}) == "prepare.cutoff");
  CHECK(name_of({.cutoff_hz = 20.0, .rolloff_hz = 20.0}) == "prepare.rolloff");
  CHECK(name_of({.cutoff_hz = 20.0, .state_cutoff_hz = 19.0}) == "prepare.state_cutoff");
  CHECK(name_of({.cutoff_hz = 20.0, .state_cutoff_hz = 30.0, .state_rolloff_hz = 30.0}) == "prepare.state_rolloff");
}

TEST_CASE("signals are those at the intermediate rate through the column filter, or filtered before they are formed",
          "[dsp][prepare]") {
  const auto record = recording(64.0, 3000);
  const auto matched = dsp::prepare(record, {.cutoff_hz = 12.0});
  for (const auto& signal : matched.signals.signals)
    if (signal.name != "t") CHECK(signal.values == matched.filter.apply(matched.intermediate.at(signal.name)));
  CHECK(matched.signals.at("t") == matched.intermediate.at("t"));

  // All content lies below the roll-off: both recipes see the same motion.
  const auto paper = dsp::prepare(record, {.recipe = dsp::Recipe::paper, .cutoff_hz = 12.0});
  for (const char* name : {"x", "v", "a", "ddr"})
    CHECK((paper.signals.at(name) - matched.signals.at(name)).cwiseAbs().maxCoeff() <=
          1e-3 * matched.signals.at(name).cwiseAbs().maxCoeff());
}

TEST_CASE("bad intervals are excluded with the reach of the filters, edges are counted", "[dsp][prepare]") {
  auto record = recording(64.0, 3000);
  record.bad = {{20.0, 21.0, "held by hand"}};
  const auto prepared = dsp::prepare(record, {.cutoff_hz = 12.0, .rolloff_hz = 10.0});
  REQUIRE(prepared.excluded.size() == 1);
  const double margin_s = 1.0 / 2.0 + 1.0 / (0.25 * prepared.options.state_cutoff_hz);
  CHECK(prepared.excluded[0].from_s == Approx(20.0 - margin_s));
  CHECK(prepared.excluded[0].to_s == Approx(21.0 + margin_s));
  CHECK(prepared.excluded[0].why == "held by hand");
  CHECK(prepared.signals.excluded[static_cast<std::size_t>(64 * 20)] == 1);
  CHECK(prepared.signals.excluded[static_cast<std::size_t>(64 * 19)] == 0);
  CHECK(prepared.intermediate.excluded == prepared.signals.excluded);
  CHECK(prepared.signals.edge_samples == static_cast<Eigen::Index>(std::ceil(64.0 * margin_s)));
  REQUIRE(prepared.checks.back().name == "prepare.edges");
  CHECK(prepared.checks.back().value == Approx(margin_s).margin(1.0 / 64.0));
}

TEST_CASE("the zero of the displacement moves at the intermediate rate and after the filter alike", "[dsp][prepare]") {
  for (const auto recipe : {dsp::Recipe::matched, dsp::Recipe::paper}) {
    auto prepared = dsp::prepare(recording(64.0, 2000), {.recipe = recipe, .cutoff_hz = 12.0});
    const auto before = prepared;
    dsp::set_displacement_zero(prepared, 1e-3);
    CHECK((prepared.intermediate.at("x") - before.intermediate.at("x")).array().mean() == Approx(-1e-3));
    CHECK((prepared.signals.at("x") - before.signals.at("x")).minCoeff() == Approx(-1e-3));
    CHECK(prepared.signals.at("y") == before.signals.at("y"));
  }
}

TEST_CASE("decimated motion is the motion at the lower rate, with a data sheet of the whole way", "[dsp][prepare]") {
  const auto record = recording(2560.0, 2560 * 60);
  const support::SweptHarmonics payload, base{.start_hz = 1.2, .sweep_hz_per_s = 1e-3, .amplitudes = {4e-3, 1e-4}};
  for (const auto recipe : {dsp::Recipe::matched, dsp::Recipe::paper}) {
    const auto prepared = dsp::prepare(record, {.recipe = recipe, .rate_hz = 25.6});
    REQUIRE(prepared.signals.num_samples() == 1536);
    CHECK(prepared.intermediate.sample_rate_hz == Approx(256.0));
    CHECK(prepared.intermediate.num_samples() == 15360);
    for (Eigen::Index i = 0; i < 1536; ++i) {
      const auto p = payload.at(static_cast<double>(i) / 25.6), b = base.at(static_cast<double>(i) / 25.6);
      CHECK(prepared.signals.at("x")(i) == Approx(p.x - b.x).margin(5e-6));
      CHECK(prepared.signals.at("v")(i) == Approx(p.v - b.v).margin(5e-5));
    }
    REQUIRE(prepared.decimation);
    CHECK(prepared.decimation->passband_ripple_db <= 1e-3);
    CHECK(prepared.decimation->alias_rejection_db >= 120.0);
    CHECK(prepared.decimation->stages.front().input_rate_hz == 2560.0);
    CHECK(prepared.signals.edge_samples >= 43);  // 851 taps at 256 Hz reach 1.66 s
  }
}

TEST_CASE("sensors of one body are equalised and columns share their high-pass", "[dsp][prepare][sensors]") {
  constexpr double rate_hz = 256.0, lag_s = 1.2e-3, gain = 1.02;
  const std::vector<double> cutoffs_hz{0.45};
  const Eigen::Index n = 256 * 200;
  const support::SweptHarmonics motion;
  Eigen::VectorXd late(n), x(n), v(n), a(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto p = motion.at(static_cast<double>(i) / rate_hz);
    x(i) = p.x, v(i) = p.v, a(i) = p.a;
    late(i) = motion.at(static_cast<double>(i) / rate_hz - lag_s).x + 2e-3;
  }
  dsp::Recording record{.name = "pair", .sample_rate_hz = rate_hz};
  record.channels = {{.name = "laser", .role = dsp::Role::y, .unit = "m"},
                     {.name = "acc", .role = dsp::Role::ddy, .unit = "m/s^2"}};
  record.samples.resize(n, 2);
  record.samples.col(0) = late;
  record.samples.col(1) = gain * dsp::ExtendedSpectrum(a, rate_hz).filtered([&](double f) {
    return dsp::highpass_response(cutoffs_hz, f);
  });
  record.samples.col(1).array() += 0.02;

  const auto prepared = dsp::prepare(record, {.rate_hz = 25.6});
  REQUIRE(prepared.relations.size() == 1);
  CHECK(prepared.relations[0].gain == Approx(gain).epsilon(5e-4));
  CHECK(prepared.relations[0].lag_s == Approx(lag_s).margin(1.5e-4));
  REQUIRE(prepared.highpass_hz.size() == 1);
  CHECK(prepared.highpass_hz[0] == Approx(0.45).margin(5e-3));
  REQUIRE(prepared.excluded.size() == 1);
  CHECK(prepared.excluded[0].to_s == Approx(2.0 / prepared.highpass_hz[0]));

  // The intermediate rate shows the motion itself; what is regressed has passed the accelerometer's AC coupling, all of
  // it alike.
  const Eigen::VectorXd column = prepared.filter.apply(prepared.intermediate.at("v"));
  const Eigen::VectorXd target = dsp::regression_signal(prepared, "a");
  std::vector<unsigned char> use(static_cast<std::size_t>(target.size()), 0);
  for (Eigen::Index i = 256; i < target.size() - 256; ++i) {
    use[static_cast<std::size_t>(i)] = 1;
    CHECK(prepared.signals.at("a")(i) == Approx(a(i * 10)).margin(5e-3));  // of 0.9 m/s^2
    CHECK(prepared.signals.at("v")(i) == Approx(v(i * 10)).margin(1e-4));
  }
  CHECK(std::abs(dsp::power_balance(prepared.raw_v, prepared.raw_a, use)) > 0.2);
  CHECK(std::abs(dsp::power_balance(column, target, use)) <= 2e-3);
  CHECK(std::abs(dsp::power_balance(prepared.signals.at("v"), prepared.signals.at("a"), use)) <= 2e-3);

  // Asked not to, or by the paper's recipe, nothing is touched.
  for (const auto& options : {dsp::PrepareOptions{.rate_hz = 25.6, .equalise = false},
                              dsp::PrepareOptions{.recipe = dsp::Recipe::paper, .rate_hz = 25.6}}) {
    const auto as_measured = dsp::prepare(record, options);
    CHECK(as_measured.highpass_hz.empty());
    CHECK(dsp::regression_signal(as_measured, "a") == as_measured.signals.at("a"));
    CHECK(std::abs(dsp::power_balance(as_measured.signals.at("v"), as_measured.signals.at("a"), use)) > 0.2);
  }
}

TEST_CASE("a file in blocks gives what the recording in memory gives", "[dsp][prepare]") {
  const auto folder = std::filesystem::temp_directory_path() / "ardent_prepare_test";
  std::filesystem::create_directories(folder);
  const auto file = folder / "swept.csv";
  const auto record = recording(1000.0, 9000);
  {
    std::ofstream out(file);
    out.precision(17);
    out << "t,y,r\n";
    for (Eigen::Index i = 0; i < record.samples.rows(); ++i)
      out << static_cast<double>(i) / 1000.0 << ',' << record.samples(i, 0) << ',' << record.samples(i, 1) << '\n';
  }
  const auto whole = dsp::prepare(dsp::read_recording(file), {.rate_hz = 50.0});
  for (const Eigen::Index block : {1000, 77}) {
    dsp::RecordingReader reader(file);
    double fraction = 0.0;
    const auto streamed = dsp::prepare(reader, {.rate_hz = 50.0},
                                       {.block_frames = block, .progress = [&](double done) { fraction = done; }});
    CHECK(fraction == 1.0);
    for (const auto& signal : whole.signals.signals) CHECK(streamed.signals.at(signal.name) == signal.values);
  }
  dsp::RecordingReader reader(file);
  CHECK_THROWS_WITH(dsp::prepare(reader, {.rate_hz = 50.0}, {.max_memory_bytes = 1000}), Catch::Contains("MB"));
  std::filesystem::remove_all(folder);
}

TEST_CASE("one pass over a file serves several ways of preparing it", "[dsp][prepare]") {
  const auto file = std::filesystem::temp_directory_path() / "ardent-several-ways.csv";
  {
    std::ofstream out(file);
    out.precision(17);
    out << "y,r\n";
    const auto samples = recording(800.0, 12000).samples;
    for (Eigen::Index i = 0; i < samples.rows(); ++i) out << samples(i, 0) << ',' << samples(i, 1) << '\n';
  }
  std::ofstream(file.string() + ".toml") << "schema = 1\nrate = 800\n";
  const dsp::PrepareOptions matched{.rate_hz = 25.0, .cutoff_hz = 10.0},
      paper{.recipe = dsp::Recipe::paper, .rate_hz = 25.0, .cutoff_hz = 10.0},
      narrow{.rate_hz = 25.0, .cutoff_hz = 6.0};
  dsp::RecordingReader reader(file);
  const std::vector<dsp::PrepareOptions> ways{matched, paper, narrow};
  const auto intermediates = dsp::read_intermediate(reader, ways);
  REQUIRE(intermediates.size() == 3);
  CHECK(intermediates[0] == intermediates[1]);
  CHECK(intermediates[0] != intermediates[2]);
  std::size_t i = 0;
  for (const auto& options : ways) {
    dsp::RecordingReader alone(file);
    const auto expected = dsp::prepare(alone, options), found = dsp::prepare(*intermediates[i++], options);
    for (const char* name : {"x", "v", "a"}) CHECK((found.signals.at(name) == expected.signals.at(name)));
    CHECK(found.signals.excluded == expected.signals.excluded);
    CHECK(found.checks.size() == expected.checks.size());
  }
  CHECK_THROWS_AS(dsp::prepare(*intermediates[0], narrow), std::invalid_argument);
  std::filesystem::remove(file);
  std::filesystem::remove(file.string() + ".toml");
}

TEST_CASE("the zero of a laser is the mean at the intermediate rate where it may be used", "[dsp][prepare]") {
  auto record = recording(64.0, 3000);
  record.samples.col(0).array() += 5e-3;
  record.samples.col(0).segment(64 * 20, 64).array() += 1.0;
  record.bad = {{20.0, 21.0, "held by hand"}};
  const auto prepared = dsp::prepare(record, {.cutoff_hz = 12.0});
  CHECK(dsp::mean_displacement(prepared, 0.0, 40.0) == Approx(5e-3).margin(2e-4));
  CHECK(dsp::mean_displacement(prepared, 100.0, 200.0) == 0.0);
}

TEST_CASE("a handful of samples is refused", "[dsp][prepare]") {
  CHECK_THROWS_WITH(dsp::prepare(recording(64.0, 5), {}), Catch::Contains("5 samples"));
}

TEST_CASE("numbers that are no vibration in their unit are a question", "[dsp][prepare]") {
  const auto asked = [](double scale, bool assumed) {
    auto record = recording(250.0, 5000);
    record.samples *= scale;
    for (auto& channel : record.channels) channel.unit_is_assumed = assumed;
    const auto prepared = dsp::prepare(record, {});
    return std::any_of(prepared.checks.begin(), prepared.checks.end(),
                       [](const dsp::Check& check) { return check.name == "sample.size"; });
  };
  CHECK(asked(1e5, true));   // hundredths of a millimetre
  CHECK(asked(1e5, false));  // a kilometre is no vibration whoever says the unit
  CHECK_FALSE(asked(20.0, false));
  CHECK_FALSE(asked(1.0, true));
}
