#include "apps/page/remedies.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "support/program.hpp"

namespace {

/// A run of one recording and one range; without fits no equation was found.
struct Run {
  apps::Config config;
  std::vector<apps::Input> inputs = std::vector<apps::Input>(1);
  std::vector<ident::Columns> columns;
  std::vector<ident::RangeResult> ranges = std::vector<ident::RangeResult>(1);

  ident::JudgedFit& fit() { return ranges.front().fits.front(); }
  dsp::Prepared& prepared() { return inputs.front().prepared; }
  /// A signal that moves.
  void record(const std::string& name, const std::string& unit) {
    prepared().signals.signals.push_back({name, unit, Eigen::VectorXd::LinSpaced(3, 0.0, 1.0)});
  }
  /// All that is proposed, "|" before a line to paste.
  [[nodiscard]] std::string proposed() const {
    std::string text;
    for (const apps::Remedy& remedy : apps::remedies({config, inputs, columns, ranges})) {
      text += remedy.why + "\n";
      for (const std::string& line : remedy.lines) text += "| " + line + "\n";
    }
    return text;
  }
};

/// Of an equation a = -50 x that is judged so.
Run judged(ident::Verdict verdict, ident::Cause cause, std::optional<ident::Explanation> named = {}) {
  Run run;
  ident::JudgedFit fit;
  fit.model.target = "a";
  fit.model.terms = {{.name = "x", .mean = -50.0, .std_noise = 0.1}};
  fit.judgement = {.verdict = verdict, .cause = cause, .named = std::move(named)};
  run.ranges.front().fits.push_back(fit);
  run.ranges.front().terms = {"x", "v"};
  return run;
}
Run failed(ident::Cause cause, std::optional<ident::Explanation> named = {}) {
  return judged(ident::Verdict::does_not, cause, std::move(named));
}

/// What is proposed where this is the only equation.
std::string proposed(const ident::JudgedFit& fit) {
  Run run;
  run.ranges.front().fits.push_back(fit);
  return run.proposed();
}

}  // namespace

TEST_CASE("where only doubt speaks against an equation, more data are proposed", "[apps][page]") {
  ident::JudgedFit fit;
  fit.model.target = "a";
  fit.model.terms = {{.name = "x", .mean = -50.0, .std_noise = 0.1}, {.name = "v", .mean = -0.8, .std_noise = 1.0}};
  fit.judgement.verdict = ident::Verdict::in_part;
  const auto judged_again = [&] {
    std::vector<ident::RangeResult> ranges(1);
    ranges[0].fits.push_back(fit);
    ident::judge(ranges);
    return ranges[0].fits[0];
  };
  fit.free_run.applies = true;
  fit.free_run.nmse_centred = 1e-4;
  CHECK(proposed(judged_again()) ==
        "Whether that term belongs in the equation: a record with other amplitudes, a longer one, or one with less "
        "noise, would tell.\n");
  fit.model.terms[1].std_noise = 0.01;
  CHECK(proposed(judged_again()).empty());
  fit.explanations.may_lack_at_motion = true;
  CHECK(proposed(judged_again()) ==
        "Whether a term is missing: a longer record, or one with less noise, would tell.\n");
  fit.noise.residual_power = 1.0, fit.noise.residual_std = 0.1;  // more is left over than noise, and than matters
  fit.train_centred.value = 0.01;
  CHECK(proposed(judged_again()).empty());
  fit.noise = {};
  fit.judgement.verdict = ident::Verdict::in_part;
  fit.judgement.cause = ident::Cause::noise;
  CHECK(proposed(fit).empty());
  fit.judgement = {.verdict = ident::Verdict::describes};
  CHECK(proposed(fit).empty());
}

TEST_CASE("an input that is missing is looked for among what was recorded", "[apps][page]") {
  Run run = failed(ident::Cause::missing_input);
  const std::string none =
      "An input that drives the motion is not in the equation: record it, or keep to times without it. If nothing "
      "drives "
      "it from outside, it excites itself, and a term is missing.\n";
  CHECK(run.proposed() == none);
  run.record("f", "N");
  CHECK(run.proposed() ==
        "An input that drives the motion is not in the equation; f was recorded and is no candidate. In the config:\n"
        "| [library]\n| terms = [\"f\"]\n");
  run.record("a_channel_with_a_name_of_more_letters_than_fit_into_a_short_text", "V");
  run.config.library.terms = {"sgn(v)"};
  CHECK(run.proposed() ==
        "An input that drives the motion is not in the equation; f and "
        "a_channel_with_a_name_of_more_letters_than_fit_into_a_short_text were recorded and are no candidate. In the "
        "config:\n| [library]\n| terms = [\"sgn(v)\", \"f\", "
        "\"a_channel_with_a_name_of_more_letters_than_fit_into_a_short_text\"]\n");
  run.ranges.front().terms = {"x", "sin(f)", "abs(a_channel_with_a_name_of_more_letters_than_fit_into_a_short_text)"};
  CHECK(run.proposed() == none);
  for (const ident::Cause cause : {ident::Cause::missing_input, ident::Cause::switch_variable}) {
    const Run named =
        failed(cause, ident::Explanation{.what = "sgn(dy)", .fraction = 0.42, .instead_of = {"v^3", "x"}});
    CHECK(
        named.proposed() ==
        "sgn(dy) explains 42 % of the power of the residual without v^3 and x. In the config:\n| [library]\n| terms = "
        "[\"sgn(dy)\"]\n");
  }
}

TEST_CASE("a term that is missing is proposed by its name, and more candidates where it has none", "[apps][page]") {
  const auto cause = ident::Cause::missing_term;
  Run run = failed(cause);
  run.config.library.order = 1;
  const std::string more =
      "The residual repeats whenever the motion returns to the same state, so a term is missing. Try more candidates; "
      "in the config:\n| [library]\n| order = ";
  CHECK(run.proposed() == more + "3\n");
  run.config.library.order = 4;
  CHECK(run.proposed() == more + "5\n");
  run.config.library.terms = {"x^5", "sgn(v)*x^9"};  // a switch has no degree
  CHECK(run.proposed() == more + "6\n");
  run.config.library.terms = {"x^9"};
  CHECK(run.proposed() == more + "8\n");

  CHECK(failed(cause, ident::Explanation{.what = "x^3", .fraction = 0.5}).proposed() ==
        "x^3 explains 50 % of the power of the residual. In the config:\n| [library]\n| terms = [\"x^3\"]\n");
  CHECK_THAT(failed(cause, ident::Explanation{.what = "A spring behind a slider", .fraction = 0.5, .is_term = false})
                 .proposed(),
             Catch::StartsWith("A spring behind a slider explains 50 %") && Catch::Contains("role = \"z\""));
  Run drowned = failed(cause, ident::Explanation{.what = "x^2", .candidate = true, .at_motion = true});
  CHECK(drowned.proposed() ==
        "x^2 is a candidate that was not taken and shows at the frequencies of the motion, under noise: a longer "
        "record, or one with less noise, would tell.\n");
  drowned.fit().noise.band_hz = 50.0, drowned.fit().noise.needed_hz = 12.5;
  CHECK(drowned.proposed() ==
        "x^2 is a candidate that was not taken and shows at the frequencies of the motion, under noise, most of it "
        "above 12.5 Hz. In the config:\n| [prepare]\n| cutoff_hz = 12.5\n");
  Run wide = failed(ident::Cause::wide_band);
  wide.fit().noise.needed_hz = 8.0;
  CHECK(wide.proposed() == "Above 8 Hz the target is noise. In the config:\n| [prepare]\n| cutoff_hz = 8\n");
  CHECK(failed(ident::Cause::noise).proposed().empty());
}

TEST_CASE("what lies in the record itself is said before any term", "[apps][page]") {
  for (const ident::Cause cause : {ident::Cause::missing_term, ident::Cause::not_found}) {
    Run run = failed(cause);
    run.record("x", "rad");
    CHECK_THAT(run.proposed(), Catch::StartsWith("x is an angle, and sin(x) and cos(x) are no candidate") &&
                                   Catch::Contains("| terms = [\"sin(x)\", \"cos(x)\"]\n"));
    run.ranges.front().terms = {"sin(x)"};
    CHECK_THAT(run.proposed(), Catch::StartsWith("x is an angle, and cos(x) is no candidate"));
    run.ranges.front().terms = {"cos(x)", "sin(x)"};
    CHECK_THAT(run.proposed(), !Catch::Contains("angle"));
  }
  for (const ident::Cause cause : {ident::Cause::missing_term, ident::Cause::missing_input, ident::Cause::not_found}) {
    Run run = failed(cause);
    run.prepared().options.integrate_from_hz = 0.5;  // and no channel is a displacement
    CHECK_THAT(run.proposed(), Catch::StartsWith("No displacement was recorded: what of x is slower than 0.5 Hz"));
  }
  Run noisy = failed(ident::Cause::noise);
  noisy.prepared().options.integrate_from_hz = 0.5;
  CHECK(noisy.proposed().empty());
}

TEST_CASE("without an equation more candidates are proposed, unless the record rests on the ground", "[apps][page]") {
  Run run;
  CHECK(run.proposed() ==
        "No candidate explains more than noise does. Try more candidates; in the config:\n| [library]\n| order = 4\n");
  run.prepared().name = "drive.csv";
  run.prepared().checks = {{"regime.ground", "", dsp::CheckStatus::warning, 0.0, 0.0, "the payload sits"}};
  CHECK(run.proposed() == "drive.csv: the payload sits [regime.ground]\n");
  run.ranges.push_back({.spec = {.name = "slip", .where = "abs(dy) > 0.1"}});
  run.ranges.push_back({.spec = {.name = "all"}});
  CHECK(run.proposed().empty());
  run.ranges[1].spec.where = "abs(v) > 0.1";
  CHECK_FALSE(run.proposed().empty());
}

TEST_CASE("a warning of a check is repeated unless it is said or put right already", "[apps][page]") {
  Run run = judged(ident::Verdict::describes, ident::Cause::noise);
  run.prepared().name = "drive.csv";
  const auto said_of = [&](dsp::Check check) {
    run.prepared().checks = {std::move(check)};
    return run.proposed();
  };
  const auto warning = dsp::CheckStatus::warning;
  CHECK(said_of({"sample.gap", "laser", warning, 0.0, 0.0, "3 gaps"}) == "drive.csv: laser: 3 gaps [sample.gap]\n");
  CHECK(said_of({"sample.clipped", "laser", dsp::CheckStatus::failed, 0.0, 0.0, "laser: 7 samples"}) ==
        "drive.csv: clipped: laser: 7 samples [sample.clipped]\n");
  CHECK(said_of({"sample.gap", "laser", dsp::CheckStatus::note, 0.0, 0.0, "3 gaps"}).empty());
  CHECK(said_of({"sensor.gain", "laser", warning, 0.0, 0.0, "reads too much"}).empty());
  CHECK_FALSE(said_of({"sensor.relation", "laser", warning, 0.0, 0.0, "not found"}).empty());
  const dsp::Check balance{"power.balance", "", warning, 0.2, 0.05, "v and a are out of step"};
  CHECK_FALSE(said_of(balance).empty());
  run.inputs.front().power = dsp::PowerCheck{{dsp::Regime::low, 0.2, 0.01}};
  CHECK(said_of(balance).empty());  // they are in step once corrected
  run.inputs.front().power->front().corrected = 0.1;
  CHECK_FALSE(said_of(balance).empty());
}

TEST_CASE("what two sensors show of one another is written as lines of a sidecar", "[apps][page]") {
  Run run = judged(ident::Verdict::describes, ident::Cause::noise);
  run.inputs.front().sidecar = "drive.csv.toml";
  run.inputs.front().files = {"drive.csv", "drive.csv.toml"};
  run.inputs.front().channels = {{.name = "acc", .unit = "m/s^2"}};
  dsp::SensorRelation pair{.name = "y and ddy", .displacement = "laser", .acceleration = "acc"};
  pair.gain = 1.05, pair.gain_std = 1e-4, pair.lag_s = 2e-3, pair.lag_std_s = 1e-6, pair.num_windows = 10;
  run.prepared().relations = {pair};
  const std::string corrected = run.proposed();
  CHECK_THAT(corrected, Catch::StartsWith("Optional, as it is corrected in this run") &&
                            Catch::Contains("drive.csv.toml") &&
                            Catch::Contains("| [[channel]]  # \"acc\": add or replace\n"));
  CHECK(corrected.find("[[channel]]  # \"acc\"") == corrected.rfind("[[channel]]  # \"acc\""));  // each channel once
  run.prepared().options.equalise = false;
  CHECK_THAT(run.proposed(), Catch::Contains("; not corrected. In drive.csv.toml:") && !Catch::Contains("Optional"));
  run.prepared().relations.front().sign = -1.0;
  CHECK_THAT(run.proposed(), Catch::Contains("or of its partner: the record does not show which of the two is wrong"));
}

TEST_CASE("a second force that nobody recorded is missed, not the end of the program", "[apps][page]") {
  const support::Scratch folder;
  // 30 s at 100 Hz of x'' = -50 x - 0.8 v + f + 3 g, of which x and f are recorded; f and g are twelve sines each.
  const auto sines = [](double t, double step) {
    double sum = 0.0;
    for (int k = 1; k <= 12; ++k) sum += std::sin((3.0 + 11.0 * std::fmod(k * step, 1.0)) * t + 2.4 * k);
    return sum;
  };
  const auto force = [&](double t) { return sines(t, 0.4142); };
  const auto rate = [&](double t, double x, double v) {
    return -50.0 * x - 0.8 * v + force(t) + 3.0 * sines(t, 0.236);
  };
  std::string table = "time [s],x [m],f [N]\n";
  constexpr double h = 0.002;
  double x = 0.01, v = 0.0;
  for (int i = 0; i < 15'000; ++i) {
    const double t = h * i;
    if (i % 5 == 0) table += fmt::format("{:.2f},{:.9g},{:.9g}\n", t, x, force(t));
    const double a1 = rate(t, x, v), v2 = v + 0.5 * h * a1, a2 = rate(t + 0.5 * h, x + 0.5 * h * v, v2);
    const double v3 = v + 0.5 * h * a2, a3 = rate(t + 0.5 * h, x + 0.5 * h * v2, v3), v4 = v + h * a3;
    const double a4 = rate(t + h, x + h * v3, v4);
    x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  (void)folder.file("two.csv", table);
  const std::string real = ARDENT_REAL_DATA "/reports/crash_second_force.csv";
  for (const std::string& file : {std::string("two.csv"), real}) {
    if (!std::filesystem::exists(file == real ? std::filesystem::path(real) : folder / file)) continue;
    const auto ended = support::expect(folder, "$ARDENT -q run " + file + " -o out --force", 0, {"mend"});
    CHECK_THAT(ended.out, Catch::Contains("This equation does not describe the record"));
    // Of the measured file noise of x, derived twice, is as large as what drives it.
    if (file != real) CHECK_THAT(ended.out, Catch::Contains("drives the motion"));
  }
}

TEST_CASE("where the force arrives late its lag is proposed, if there is a displacement and the config allows one",
          "[apps][page]") {
  Run run = failed(ident::Cause::late_input);
  CHECK_THAT(run.proposed(), Catch::Contains("record what arrives, or a displacement"));
  run.prepared().channels = {{.name = "x", .role = dsp::Role::x, .unit = "m"}};
  CHECK_THAT(run.proposed(), Catch::Contains("| [library]\n| inner = \"lag\"\n"));
  run.config.test_recordings.emplace_back();
  CHECK_THAT(run.proposed(), Catch::Contains("record what arrives") && !Catch::Contains("inner"));
  run.config.test_recordings.clear();
  run.config.fit.target = "ddy";
  CHECK_THAT(run.proposed(), !Catch::Contains("inner"));
}
