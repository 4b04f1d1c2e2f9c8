#include "ident/judgement/judge.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "ident/judgement/findings.hpp"

using ident::Verdict;

namespace {

/// A range with one fit of a = -50 x - 0.8 v that leaves `error` of the target over and runs free to `free_run`.
ident::RangeResult range(const std::string& name, double free_run, double error, double stiffness = -50.0) {
  ident::RangeResult result;
  result.spec.name = name;
  if (name != "all") result.regime = dsp::regime_set_from_string(name);
  result.target = Eigen::Vector4d(1.0, -1.0, 1.0, -1.0);
  result.rows.train.resize(2);
  result.rows.test.resize(2);
  ident::JudgedFit fit;
  fit.model = {
      "a", "m/s^2", {{.name = "x", .mean = stiffness, .scale = 0.02}, {.name = "v", .mean = -0.8, .scale = 0.2}}};
  fit.train = fit.train_centred = fit.test = fit.test_centred = {error, {}};
  fit.whiteness = {.p_value = 0.4, .peak_fraction = 0.2, .tested = true, .white = true};
  fit.free_run.nmse = fit.free_run.nmse_centred = free_run;
  fit.free_run.applies = true;
  result.fits = {fit};
  return result;
}

/// The judgement of the first range's fit beside the others.
ident::Judgement of(std::vector<ident::RangeResult> ranges) {
  ident::judge(ranges);
  return ranges[0].fits[0].judgement;
}
ident::Judgement of(const ident::RangeResult& range) {
  return of(std::vector{range});
}

}  // namespace

TEST_CASE("the free run decides whether an equation describes its record", "[ident][judge]") {
  auto good = range("low", 1e-4, 1e-5);
  CHECK(of(good).verdict == Verdict::describes);
  CHECK_THAT(of(good).sentence, Catch::StartsWith("This equation describes the record: the free run follows x"));
  CHECK(of(range("low", 0.05, 1e-5)).verdict == Verdict::in_part);
  // A one-step error of half a per cent hides a free run that fails.
  CHECK(of(range("low", 0.37, 5e-3)).verdict == Verdict::does_not);
  CHECK_THAT(of(range("low", 0.37, 5e-3)).sentence,
             Catch::StartsWith("This equation does not describe the record") && Catch::Contains("0.37"));
  auto away = good;
  away.fits[0].free_run.diverged_after_s = 3.0;
  away.fits[0].free_run.reason = "diverged after 3 s";
  CHECK(of(away).verdict == Verdict::does_not);
  auto none = good;
  none.fits[0].free_run.reason = "no test interval is long enough";
  CHECK(of(none).verdict == Verdict::undecided);
  CHECK_THAT(of(none).sentence, Catch::Contains("is undecided") && Catch::Contains("long enough"));
}

TEST_CASE("an equation that nothing drives must follow what it was fitted to as well", "[ident][judge]") {
  auto result = range("low", 1e-4, 1e-5);
  ident::FreeRun& run = result.fits[0].free_run;
  run.alone = true;
  run.nmse_training = 5e-3;
  CHECK(of(result).verdict == Verdict::describes);
  run.nmse_training = 0.3;
  CHECK(of(result).verdict == Verdict::does_not);
  CHECK_THAT(of(result).sentence, Catch::Contains("does not follow x through the training rows (NMSE 0.3"));
  result.fits[0].noise.x_std = 0.5, run.mean_square_training = 1.0;  // noise of a start alone makes 0.75
  CHECK(of(result).verdict == Verdict::describes);
  run.nmse_training = INFINITY;
  CHECK(of(result).verdict == Verdict::does_not);
  CHECK_THAT(of(result).sentence, Catch::Contains("through the training rows diverged"));
}

TEST_CASE("a free run whose errors grow tenfold and again decides nothing where noise alone is left over",
          "[ident][judge]") {
  auto result = range("low", 0.5, 5e-3);
  CHECK(of(result).verdict == Verdict::does_not);
  result.fits[0].free_run.num_restarts = 3;
  CHECK(of(result).verdict == Verdict::undecided);
  CHECK_THAT(of(result).sentence, Catch::Contains("so sensitive a motion does not decide"));
  // What is left over beyond noise speaks for itself.
  result.fits[0].noise.residual_power = 5e-3;
  result.fits[0].noise.residual_std = result.fits[0].noise.known_std = std::sqrt(1e-3);
  CHECK(of(result).verdict == Verdict::does_not);
}

TEST_CASE("terms that only imitate another take the yes away", "[ident][judge]") {
  auto result = range("low", 1e-4, 5e-3);
  result.fits[0].explanations.better = ident::Explanation{.what = "sgn(v)",
                                                          .cause = ident::Cause::missing_term,
                                                          .fraction = 0.8,
                                                          .is_recorded = false,
                                                          .instead_of = {"abs(v)*v", "v^3"}};
  CHECK(of(result).verdict == Verdict::does_not);
  result.fits[0].train = result.fits[0].train_centred = {1e-5, {}};  // they do it so well that next to nothing is left
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK(of(result).cause == ident::Cause::missing_term);
  REQUIRE(of(result).named.has_value());
  CHECK(of(result).named->what == "sgn(v)");
  CHECK_THAT(of(result).sentence,
             Catch::Contains("sgn(v) is no candidate; in place of abs(v)*v and v^3 it explains 80 %"));
}

TEST_CASE("sensors out of step and rows it was fitted to take the yes away", "[ident][judge]") {
  auto result = range("low", 1e-4, 1e-5);
  result.power_balance = 3e-4;
  CHECK(of(result).verdict == Verdict::describes);
  CHECK_THAT(of(result).sentence, Catch::Contains("in step"));
  result.power_balance = 0.3;
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK_THAT(of(result).sentence, Catch::Contains("reads as damping"));
  result = range("low", 1e-4, 1e-3);
  result.fits[0].test = result.fits[0].test_centred = {0.05, {}};
  CHECK(of(result).verdict == Verdict::in_part);
}

TEST_CASE("structure in a residual that matters, and a fit that did not converge, take describes down",
          "[ident][judge]") {
  auto result = range("low", 1e-4, 5e-3);
  CHECK(of(result).verdict == Verdict::describes);
  result.fits[0].whiteness.white = false;
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK_THAT(of(result).sentence, Catch::Contains("structure"));
  // A tenth of a per mille of the power spoils error bars, not the equation.
  auto small = range("low", 1e-4, 1e-4);
  small.fits[0].whiteness.white = false;
  CHECK(of(small).verdict == Verdict::describes);
  auto unfinished = range("low", 1e-4, 1e-5);
  unfinished.fits[0].fit.status = ident::FitStatus::iteration_limit;
  CHECK(of(unfinished).verdict == Verdict::in_part);
  CHECK_THAT(of(unfinished).sentence, Catch::Contains("iteration_limit"));
}

TEST_CASE("noise of the channels excuses what is left over, and nothing else does", "[ident][judge]") {
  auto result = range("low", 0.015, 5e-3);
  CHECK(of(result).verdict == Verdict::in_part);
  // Of a run about as much as x is known to is its noise; that of x at its start and that of v go with it.
  result.fits[0].noise.x_std = 0.1;
  result.fits[0].free_run.mean_square = 1.0;
  CHECK(of(result).verdict == Verdict::describes);
  result.fits[0].noise.residual_power = 5e-3;
  result.fits[0].noise.residual_std = result.fits[0].noise.known_std = std::sqrt(4e-3);
  CHECK_THAT(of(result).sentence, Catch::Contains("no more than noise"));
  result.fits[0].noise.residual_std = std::sqrt(1e-3);
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK_THAT(of(result).sentence, Catch::Contains("more than the noise of the signals"));
  result.fits[0].noise.x_std = 0.0;
  result.fits[0].free_run.nmse_centred = 0.05;
  CHECK(of(result).verdict == Verdict::does_not);
  // Sensors are not linear to better than this.
  result.fits[0].free_run.nmse_centred = 1e-4;
  result.fits[0].train_centred = {5e-6, {}};
  CHECK(of(result).verdict == Verdict::describes);
}

TEST_CASE("a cause is named where a test found it", "[ident][judge]") {
  auto result = range("low", 0.5, 5e-3);
  ident::JudgedFit& fit = result.fits[0];
  CHECK(of(range("low", 1e-4, 1e-5)).cause == std::nullopt);
  CHECK(of(result).cause == ident::Cause::not_found);
  fit.noise.residual_power = 5e-3, fit.noise.residual_std = 1e-3;
  CHECK(of(result).cause == ident::Cause::not_found);  // nothing is known of what comes back
  fit.size.state_dependent_fraction = 0.0;
  CHECK(of(result).cause == ident::Cause::not_found);  // something drives it
  fit.free_run.alone = true;
  CHECK(of(result).cause == ident::Cause::missing_input);
  fit.size.state_dependent_fraction = 0.9;
  CHECK(of(result).cause == ident::Cause::missing_term);
  CHECK_THAT(of(result).sentence, Catch::Contains("90 % of what is left over comes back with the state"));
  fit.explanations.form = ident::Explanation{"x^2*v", ident::Cause::missing_term, 0.7, false};
  CHECK_THAT(of(result).sentence, Catch::Contains("x^2*v is no candidate and explains 70 % of what is left over"));
  REQUIRE(of(result).named.has_value());
  CHECK(of(result).named->what == "x^2*v");
  fit.size.state_dependent_fraction = 0.5;
  CHECK(of(result).cause == ident::Cause::missing_term);
  fit.explanations.form->fraction = 0.4;  // something else is larger
  CHECK(of(result).cause == ident::Cause::not_found);
  fit.model.terms[1].std = 0.02;
  fit.noise.bias = Eigen::Vector2d(0.0, 0.05);
  fit.noise.band_hz = 10.0, fit.noise.needed_hz = 8.0;
  CHECK(of(result).cause == ident::Cause::noise);
  CHECK_THAT(of(result).sentence, Catch::Contains("noise of the signals biases the coefficient of v"));
  fit.noise.needed_hz = 3.0;
  CHECK(of(result).cause == ident::Cause::wide_band);
  fit.explanations.recorded = ident::Explanation{"f", ident::Cause::missing_input, 0.05};
  CHECK(of(result).cause == ident::Cause::wide_band);  // too little to matter
  fit.explanations.recorded->fraction = 0.8;
  CHECK(of(result).cause == ident::Cause::missing_input);
  CHECK_THAT(of(result).sentence, Catch::Contains("f was recorded and is not in the equation: it explains 80 %"));
  fit.explanations.recorded->what = "z", fit.explanations.recorded->cause = ident::Cause::missing_term;
  CHECK_THAT(of(result).sentence, Catch::Contains("z was recorded and is not in the equation: it explains 80 %"));
}

TEST_CASE("noise of the speed at the start is in the run of an equation alone, and soon forgotten by a driven one",
          "[ident][judge]") {
  auto result = range("low", 0.115, 1e-5);
  ident::JudgedFit& fit = result.fits[0];
  fit.free_run.mean_square = 1.0;
  fit.noise.x_std = 0.1, fit.noise.v_as_x_std = 0.3;  // with that of x and of the start's x 0.11
  CHECK(of(result).verdict == Verdict::in_part);      // of a driven one 0.03
  fit.free_run.alone = true;
  CHECK(of(result).verdict == Verdict::describes);
  fit.noise.v_as_x_std = 0.05;  // no less than that of x
  CHECK(of(result).verdict == Verdict::in_part);
}

TEST_CASE("what an equation alone leaves beyond noise is of the state, or something outside drives the motion",
          "[ident][judge]") {
  auto result = range("low", 0.5, 5e-3);
  ident::JudgedFit& fit = result.fits[0];
  fit.free_run.alone = true;
  fit.noise.residual_power = 5e-3, fit.noise.residual_std = std::sqrt(1e-3);  // a fifth of what is left over
  fit.size.has_inputs = false;
  fit.size.state_dependent_fraction = 0.5;
  CHECK(of(result).cause == ident::Cause::missing_input);
  fit.size.has_inputs = true;  // the input may be among them
  CHECK(of(result).cause == ident::Cause::not_found);
  fit.size.has_inputs = false;
  fit.size.revisit_error = 0.15;  // all of it may come back
  CHECK(of(result).cause == ident::Cause::not_found);
  fit.size.revisit_error = 0.0;
  fit.size.autoregression = 0.5;  // of whitened rows that is not known
  CHECK(of(result).cause == ident::Cause::not_found);
  fit.size.autoregression = 0.0;
  fit.size.state_dependent_fraction = 0.75;
  CHECK(of(result).cause == ident::Cause::missing_term);
  CHECK_THAT(of(result).sentence, Catch::Contains("75 % of what is left over comes back with the state"));
  fit.size.state_dependent_fraction = 0.5;
  fit.free_run.alone = false;  // an input that is in the equation may be wrong
  CHECK(of(result).cause == ident::Cause::not_found);
  fit.free_run.alone = true;
  fit.test_centred = {9e-4, {}};  // too little to drive anything
  CHECK(of(result).cause == ident::Cause::not_found);
}

TEST_CASE("what nothing drives or damps describes a record in part at best", "[ident][judge]") {
  auto result = range("low", 1e-4, 5e-3);
  ident::JudgedFit& fit = result.fits[0];
  fit.free_run.alone = true;
  fit.free_run.nmse_training = 1e-4;
  CHECK(of(result).verdict == Verdict::describes);
  fit.model.terms.pop_back();  // v
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK_THAT(of(result).sentence, Catch::Contains("nothing in it drives the motion or damps it"));
  fit.model.terms.push_back({.name = "x*v", .mean = -0.8, .scale = 0.2});
  CHECK(of(result).verdict == Verdict::describes);
  fit.model.terms.back().name = "x^3";
  CHECK(of(result).verdict == Verdict::in_part);
  fit.free_run.alone = false;  // an input, which may as well be its only excitation
  CHECK(of(result).verdict == Verdict::describes);
}

TEST_CASE("a form that is most of what exceeds noise is a missing term, however well x is followed", "[ident][judge]") {
  auto result = range("low", 1e-4, 5e-3);
  ident::JudgedFit& fit = result.fits[0];
  fit.noise.residual_power = 5e-3, fit.noise.residual_std = 1e-3;
  CHECK(of(result).verdict == Verdict::in_part);
  fit.explanations.form = ident::Explanation{"sgn(v)", ident::Cause::missing_term, 0.4, false};
  CHECK(of(result).verdict == Verdict::in_part);  // something else is larger
  fit.explanations.form->fraction = 0.7;
  CHECK(of(result).verdict == Verdict::does_not);
  CHECK(of(result).cause == ident::Cause::missing_term);
  CHECK_THAT(of(result).sentence, Catch::Contains("sgn(v) is no candidate and explains 70 % of what is left over"));
  // What comes back with the state without a form to it may be any small part of a real machine.
  fit.explanations.form.reset();
  fit.size.state_dependent_fraction = 0.9;
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK(of(result).cause == ident::Cause::missing_term);
  // Where it is no more than noise, or less than sensors add that are not linear, nothing is missing.
  fit.explanations.form = ident::Explanation{"sgn(v)", ident::Cause::missing_term, 0.7, false};
  fit.noise.residual_std = fit.noise.known_std = std::sqrt(4e-3);
  CHECK(of(result).verdict == Verdict::describes);
  fit.noise.residual_std = fit.noise.known_std = 1e-3;
  fit.train_centred = {5e-6, {}};
  CHECK(of(result).verdict == Verdict::describes);
}

TEST_CASE("noise beside the motion does not excuse what is left over where the motion is", "[ident][judge]") {
  auto result = range("low", 1e-4, 5e-3);
  ident::RegressorNoise& noise = result.fits[0].noise;
  noise.residual_power = 5e-3, noise.residual_std = noise.known_std = std::sqrt(4e-3);
  noise.motion_power = 1.5e-4, noise.motion_std = std::sqrt(1e-4);
  CHECK(of(result).verdict == Verdict::describes);
  noise.motion_power = 3e-4;
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK_THAT(of(result).sentence, Catch::Contains("more than noise at the frequencies of the motion"));
  noise.motion_power = 5e-6, noise.motion_std = 0.0;  // sensors are not linear to better than this
  CHECK(of(result).verdict == Verdict::describes);
}

TEST_CASE("an equation with a term that may be zero by noise alone describes in part", "[ident][judge]") {
  auto result = range("low", 1e-4, 5e-3);
  std::vector<ident::ModelTerm>& terms = result.fits[0].model.terms;
  terms[0].std_noise = std::abs(terms[0].mean) / 2.0;
  CHECK(of(result).verdict == Verdict::describes);
  terms[0].std = 3.0 * std::abs(terms[0].mean);  // by sensors, which make no term
  CHECK(of(result).verdict == Verdict::describes);
  terms[0].std_noise = std::abs(terms[0].mean) / 1.9;
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK_FALSE(of(result).cause.has_value());
  CHECK_THAT(of(result).sentence, Catch::Contains(terms[0].name + " may not belong in the equation"));
  // A method that counts every row has the same terms, and does not know better.
  std::vector<ident::RangeResult> both{result};
  both[0].fits.push_back(result.fits[0]);
  both[0].fits[1].model.terms[0].std_noise = std::abs(terms[0].mean) / 100.0;
  ident::judge(both);
  CHECK(both[0].fits[1].judgement.verdict == Verdict::in_part);
  both[0].fits[1].model.terms[0].name = "abs(x)*x";  // of another term it says nothing
  ident::judge(both);
  CHECK(both[0].fits[1].judgement.verdict == Verdict::describes);
  // Not known is no doubt; a constant is a zero of a sensor; what does not describe says nothing of it.
  terms[0].std_noise = std::nan("");
  CHECK(of(result).verdict == Verdict::describes);
  terms[0].std_noise = std::abs(terms[0].mean);
  result.fits[0].free_run.nmse_centred = 0.5;
  CHECK(of(result).verdict == Verdict::does_not);
  CHECK_THAT(of(result).sentence, !Catch::Contains("may not belong"));
  result.fits[0].free_run.nmse_centred = 1e-4;
  terms[0].name = "1";
  CHECK(of(result).verdict == Verdict::describes);
}

TEST_CASE("a term with a coefficient for each recording is in doubt where all of them are", "[ident][judge]") {
  auto result = range("low", 1e-4, 5e-3);
  std::vector<ident::ModelTerm>& terms = result.fits[0].model.terms;
  terms = std::vector<ident::ModelTerm>(2, ident::ModelTerm(terms[0]));
  for (int recording = 1; recording <= 2; ++recording) {
    ident::ModelTerm& term = terms[static_cast<std::size_t>(recording) - 1];
    term.recording = recording;
    term.std_noise = std::abs(term.mean);
  }
  CHECK(of(result).verdict == Verdict::in_part);
  terms[0].std_noise = 0.1 * std::abs(terms[0].mean);
  CHECK(of(result).verdict == Verdict::describes);
}

TEST_CASE("a term that may show at the frequencies of the motion is doubt enough, and no cause", "[ident][judge]") {
  auto result = range("low", 1e-4, 5e-3);
  ident::JudgedFit& fit = result.fits[0];
  fit.noise.residual_power = 5e-3, fit.noise.residual_std = fit.noise.known_std = std::sqrt(4e-3);
  fit.explanations.may_lack_at_motion = true;
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK(of(result).cause == ident::Cause::not_found);
  CHECK_THAT(of(result).sentence, Catch::Contains("a term may be missing"));
}

TEST_CASE("a term that shows at the frequencies of the motion is missing, however little it is", "[ident][judge]") {
  auto result = range("low", 1e-4, 5e-3);
  ident::JudgedFit& fit = result.fits[0];
  fit.noise.residual_power = 5e-3, fit.noise.residual_std = fit.noise.known_std = std::sqrt(4e-3);
  CHECK(of(result).verdict == Verdict::describes);
  fit.explanations.may_lack_at_motion = true;
  fit.explanations.at_motion = ident::Explanation{"x^3", ident::Cause::missing_term, 0.02, false, true, true};
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK(of(result).cause == ident::Cause::missing_term);
  REQUIRE(of(result).named.has_value());
  CHECK(of(result).named->what == "x^3");
  CHECK_THAT(of(result).sentence,
             Catch::Contains("x^3 is not in the equation and explains 2 % of what is left over at the frequencies"));
  // One that fails lacks more than a term that shows beside noise.
  fit.free_run.nmse_centred = 0.5;
  CHECK(of(result).verdict == Verdict::does_not);
  CHECK(of(result).cause == ident::Cause::noise);
}

TEST_CASE("what follows x beyond noise follows it roughly, and what has no free run does not", "[ident][findings]") {
  auto result = range("low", 0.15, 5e-3);
  ident::JudgedFit& fit = result.fits[0];
  const auto follows = [&] { return ident::findings_of(result, fit).follows_roughly(); };
  CHECK_FALSE(follows());
  fit.noise.x_std = 0.2, fit.free_run.mean_square = 1.0;  // noise of x and of the start makes 0.12
  CHECK(follows());
  fit.free_run.reason = "no test interval is long enough";
  CHECK_FALSE(follows());
}

TEST_CASE("where no equation was found, what comes back with the state is a missing term", "[ident][findings]") {
  auto result = range("low", 1e-4, 1.0);
  ident::JudgedFit& fit = result.fits[0];
  fit.model.terms.clear();
  const auto cause = [&] { return ident::cause_of_none(result, fit).cause; };
  CHECK(cause() == ident::Cause::not_found);
  fit.size.state_dependent_fraction = 0.9;
  CHECK(cause() == ident::Cause::missing_term);
  CHECK(of(result).cause == ident::Cause::missing_term);
  CHECK_FALSE(of(result).named.has_value());
  // Something that was recorded and was no candidate is the likelier reason.
  fit.explanations.recorded = ident::Explanation{"f", ident::Cause::missing_input, 0.8};
  CHECK(cause() == ident::Cause::missing_input);
}

TEST_CASE("an equation that misses where only noise is left lacks what noise hides", "[ident][judge]") {
  auto result = range("low", 0.5, 5e-3);
  ident::JudgedFit& fit = result.fits[0];
  fit.noise.residual_power = 5e-3, fit.noise.residual_std = fit.noise.known_std = std::sqrt(4e-3);
  fit.noise.band_hz = 10.0, fit.noise.needed_hz = 8.0;
  CHECK(of(result).cause == ident::Cause::noise);
  CHECK_THAT(of(result).sentence, Catch::Contains("what the equation lacks is hidden by that noise"));
  fit.noise.needed_hz = 3.0;
  CHECK(of(result).cause == ident::Cause::noise);  // a lower cut-off would take away half a hundredth
  fit.train = fit.train_centred = fit.test = fit.test_centred = {0.2, {}};
  fit.noise.residual_power = 0.2, fit.noise.residual_std = fit.noise.known_std = std::sqrt(0.19);
  CHECK(of(result).cause == ident::Cause::wide_band);
  // The amplitude that the equation cannot renew is seen in x itself.
  fit.free_run.alone = true;
  result.crests = {{1.0, 0.1, 1.0, 0.1, 1.0}};
  fit.noise.x_std = 0.01;
  CHECK(of(result).cause == ident::Cause::missing_input);
  fit.noise.x_std = 0.2;
  CHECK(of(result).cause == ident::Cause::wide_band);
  // On rows of its own noise is left, on others more.
  fit.test = fit.test_centred = {2.5, {}};
  CHECK(of(result).cause == ident::Cause::not_found);
  // Nothing is lacking where the free run follows.
  fit.test = fit.test_centred = {0.2, {}};
  fit.free_run.nmse_centred = 1e-4;
  CHECK(of(result).verdict == Verdict::describes);
  CHECK(of(result).cause == std::nullopt);
}

TEST_CASE("every verdict is read back from its word", "[ident][judge]") {
  for (const Verdict verdict : {Verdict::describes, Verdict::in_part, Verdict::does_not, Verdict::undecided})
    CHECK(ident::verdict_from_string(to_string(verdict)) == verdict);
  CHECK_FALSE(ident::verdict_from_string("trusted").has_value());
}

TEST_CASE("ranges that have another equation are named with the terms", "[ident][judge]") {
  const auto low = range("low", 1e-4, 1e-5), high = range("high", 1e-4, 1e-5, -51.0);
  CHECK(of({low, high}).verdict == Verdict::describes);
  CHECK_THAT(of({low, high}).sentence, Catch::Contains("high agrees within 10 %"));
  const auto other = range("high", 1e-4, 1e-5, -70.0);
  CHECK(of({low, other}).verdict == Verdict::in_part);
  CHECK_THAT(of({low, other}).sentence, Catch::Contains("high has another x"));
  CHECK(of({low, range("mixed", 1e-4, 1e-5, -70.0)}).verdict == Verdict::describes);
}

TEST_CASE("a force law is judged by what it leaves over", "[ident][judge]") {
  auto law = range("all", 0.0, 0.01);
  law.fits[0].free_run.applies = false;
  law.fits[0].free_run.reason = "an equation for f is no equation of motion";
  CHECK(of(law).verdict == Verdict::describes);
  law.fits[0].whiteness.white = false;
  CHECK(of(law).verdict == Verdict::in_part);
  law.fits[0].test_centred = {0.22, {}};
  CHECK(of(law).verdict == Verdict::does_not);
  CHECK_THAT(of(law).sentence, Catch::Contains("22 %") && Catch::Contains("cause not found"));
  law.fits[0].size.state_dependent_fraction = 0.9;
  CHECK(of(law).cause == ident::Cause::missing_term);
  CHECK_THAT(of(law).sentence, Catch::Contains("90 % of what is left over comes back with the state"));
  law.fits[0].model.terms.clear();
  CHECK_THAT(of(law).sentence, Catch::Contains("No equation was found"));
}

TEST_CASE("the chosen fit has the best verdict", "[ident][judge]") {
  CHECK_FALSE(ident::chosen_fit({}).has_value());
  std::vector<ident::RangeResult> ranges{range("mixed", 0.5, 1e-3), range("low", 0.05, 1e-3),
                                         range("high", 1e-4, 1e-5)};
  const auto chosen = [&] {
    ident::judge(ranges);
    return ident::chosen_fit(ranges)->range;
  };
  CHECK(chosen() == 2);
  ranges[0].rows.train.resize(100);
  ranges[2].fits[0].free_run.nmse_centred = ranges[1].fits[0].free_run.nmse_centred = 0.5;
  CHECK(chosen() == 0);  // no range's equation describes it: the one with the most rows
  ranges[0].fits[0].free_run.applies = false;
  ranges[0].fits[0].test_centred = ranges[0].fits[0].train_centred = {0.0, "the target is constant"};
  CHECK(to_string(of(ranges).verdict) == "undecided");
  CHECK(chosen() == 0);  // which may describe it, where the others do not
}

TEST_CASE("fast_rvm speaks for a range, and among equal verdicts the range with the most rows", "[ident][judge]") {
  auto first = range("low", 1e-4, 1e-5), second = range("high", 1e-4, 1e-5);
  first.fits[0].fit.method = ident::Method::slow_rvm;
  first.fits.push_back(first.fits[0]);
  first.fits[1].fit.method = ident::Method::fast_rvm;
  CHECK(ident::chosen_method(first) == 1);
  CHECK(ident::chosen_fit({first})->method == 1);
  CHECK(ident::chosen_fit({first, second})->range == 0);  // as many rows in both
  second.rows.test.resize(3);
  CHECK(ident::chosen_fit({first, second})->range == 1);
  // A better verdict of another method may be one that is less tested, but for want of an equation.
  first.fits[0].judgement.verdict = Verdict::describes;
  first.fits[1].judgement.verdict = Verdict::does_not;
  CHECK(ident::chosen_method(first) == 1);
  first.fits[1].model.terms.clear();
  CHECK(ident::chosen_method(first) == 0);
}

TEST_CASE("a sensor that the fit has further off than anyone can believe takes the yes away", "[ident][judge][rules]") {
  auto result = range("low", 1e-4, 5e-3);
  result.fits[0].sensors = {{"drift of x", "m", 1e-3, 2e-3, 1e-5}, {"relative gain of base", "1", 0.01, -0.039, 1e-3}};
  CHECK(of(result).verdict == Verdict::describes);
  result.fits[0].sensors[1].mean = -0.54;
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK_THAT(of(result).sentence,
             Catch::StartsWith("This equation describes the record in part: the fit has the relative gain of base "
                               "-0.54 off, 54 standard deviations of what is known of it"));
  CHECK_FALSE(of(result).cause.has_value());
}

TEST_CASE("friction that feeds a motion takes the yes away, damping only where nothing excites itself",
          "[ident][judge][rules]") {
  auto result = range("low", 1e-4, 5e-3);
  ident::JudgedFit& fit = result.fits[0];
  fit.model.terms.push_back({.name = "x^2*v", .mean = 0.3, .std = 0.01, .scale = 0.1});
  CHECK(of(result).verdict == Verdict::in_part);  // of a driven one
  CHECK_THAT(of(result).sentence, Catch::Contains("x^2*v feeds energy to the motion, and v takes it"));
  fit.free_run.alone = true, fit.free_run.nmse_training = 1e-4;
  result.crests = {{1.0, 1.01, 0.99, 1.0, 1.01, 0.99, 1.0, 1.01, 0.99, 1.0}};
  CHECK(of(result).verdict == Verdict::describes);  // a limit cycle
  result.crests = {{1.2, 1.1, 1.05, 1.02, 1.01, 1.005, 1.003, 1.001, 1.0}};
  CHECK(of(result).verdict == Verdict::describes);  // and the way to it from above
  result.crests = {{1.0, 0.8, 0.63, 0.51, 0.41, 0.33, 0.265, 0.212}};
  CHECK(of(result).verdict == Verdict::in_part);
  result.crests.clear();
  fit.model.terms.back().name = "sgn(v)";
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK_THAT(of(result).sentence, Catch::Contains("sgn(v) feeds energy"));
  fit.model.terms.back().mean = -0.3;
  CHECK(of(result).verdict == Verdict::describes);
}

TEST_CASE("an amplitude that falls where no term takes energy is said with its loss per cycle",
          "[ident][judge][rules]") {
  auto result = range("low", 1e-4, 5e-3);
  ident::JudgedFit& fit = result.fits[0];
  fit.free_run.alone = true, fit.free_run.nmse_training = 1e-4;
  result.crests = {{}};
  for (int i = 0; i < 20; ++i) result.crests[0].push_back(std::pow(0.95, i) * (1.0 + 1e-3 * std::cos(2.0 * i)));
  CHECK(of(result).verdict == Verdict::describes);
  fit.model.terms[1].name = "x*v";
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK_THAT(of(result).sentence, Catch::Contains("the amplitude falls by 5 +- 0.00") &&
                                      Catch::Contains("% a cycle, and no term of the equation takes energy"));
  fit.model.terms[1].name = "z";  // an inner state may
  CHECK(of(result).verdict == Verdict::describes);
}

TEST_CASE("a range that flatters is said to be smaller than one that no equation describes", "[ident][judge][rules]") {
  const auto low = range("low", 1e-4, 1e-5);
  auto mixed = range("mixed", 0.5, 0.05);
  CHECK(of({low, mixed}).verdict == Verdict::describes);  // as many rows
  mixed.rows.train.resize(30);
  CHECK(of({low, mixed}).verdict == Verdict::in_part);
  CHECK_THAT(of({low, mixed}).sentence,
             Catch::StartsWith("This equation describes the record in part: range mixed, with 8 times as many rows, is "
                               "not described by its equation"));
  mixed.fits[0].free_run.nmse_centred = 1e-4;
  CHECK(of({low, mixed}).verdict == Verdict::describes);
}

TEST_CASE("coefficients of each recording are one equation where only friction differs", "[ident][judge][rules]") {
  auto result = range("all", 1e-4, 5e-3);
  std::vector<ident::ModelTerm>& terms = result.fits[0].model.terms;
  terms = {{.name = "x", .mean = -940.0, .std = 1.0, .scale = 0.02, .recording = 1, .recording_name = "a"},
           {.name = "x", .mean = -1930.0, .std = 1.0, .scale = 0.02, .recording = 2, .recording_name = "b"},
           {.name = "v", .mean = -0.8, .std = 0.01, .scale = 0.2}};
  CHECK(of(result).verdict == Verdict::in_part);
  CHECK_THAT(of(result).sentence, Catch::Contains("x is -1930 in b and -940 in a"));
  terms[1].mean = -1000.0;
  CHECK(of(result).verdict == Verdict::describes);
  terms[1].mean = -1930.0;
  terms[0].name = terms[1].name = "sgn(v)";
  CHECK(of(result).verdict == Verdict::describes);
}

TEST_CASE("one closed orbit leaves every verdict undecided but that which fails", "[ident][judge][rules]") {
  auto result = range("all", 1e-4, 1e-5);
  result.orbit = ident::ClosedOrbit{.hz = 2.1, .num_lines = 1, .num_candidates = 12};
  CHECK(of(result).verdict == Verdict::undecided);
  CHECK_THAT(of(result).sentence, Catch::Contains("one closed orbit at 2.1 Hz: its 1 spectral line above noise makes 2 "
                                                  "independent equations for 12 candidates"));
  result.fits[0].free_run.nmse_centred = 0.5;
  CHECK(of(result).verdict == Verdict::does_not);
}

TEST_CASE("every rule of the verdict says what it is about, once", "[ident][rules]") {
  std::vector<std::string_view> names;
  for (const ident::VerdictRule& rule : ident::verdict_rules()) {
    CAPTURE(rule.name);
    CHECK(rule.holds != nullptr);
    CHECK(rule.at_most != Verdict::describes);
    CHECK_FALSE((rule.condition.empty() || rule.reason.empty()));
    CHECK((!rule.is_cause || (rule.clause != nullptr && !rule.remedy.empty())));
    CHECK(std::count(names.begin(), names.end(), rule.name) == 0);
    names.push_back(rule.name);
  }
}

TEST_CASE("a motion that answers later than its sensors are out of step has a force that arrives late",
          "[ident][findings]") {
  auto result = range("low", 0.5, 0.05);
  ident::JudgedFit& fit = result.fits[0];
  fit.by_likelihood = true;
  result.likelihood.gain_of_process_noise = 1e3;  // so it does not explain the samples
  result.likelihood.unexplained_std = 0.3;
  fit.sensors = {{.name = "lag of x", .unit = "s", .prior_std = 3e-3, .mean = 0.04, .std = 1e-3}};
  fit.model.coordinates = {{.recording = "one", .lead_s = -0.04, .lead_std_s = 1e-3}};
  CHECK(ident::lateness_s(fit) == 0.04);
  CHECK(of(result).cause == ident::Cause::late_input);
  CHECK_THAT(of(result).sentence, Catch::Contains("0.04 s late"));
  fit.free_run.alone = true;  // nothing in it is late
  CHECK_FALSE(ident::lateness_s(fit).has_value());
  fit.free_run.alone = false;
  fit.model.coordinates[0].lead_s = 0.04;  // early: no actuator
  CHECK_FALSE(ident::lateness_s(fit).has_value());
  CHECK(of(result).cause != ident::Cause::late_input);
  fit.model.coordinates[0].lead_s = -0.011;  // sensors may be
  CHECK_FALSE(ident::lateness_s(fit).has_value());
  fit.model.coordinates[0] = {.recording = "one", .lead_s = -0.04, .lead_std_s = 0.02};
  CHECK_FALSE(ident::lateness_s(fit).has_value());
}

TEST_CASE("where most of x is noise a free run decides nothing", "[ident][findings]") {
  auto result = range("low", 0.9, 1e-3);
  ident::JudgedFit& fit = result.fits[0];
  fit.free_run.mean_square = 1.0;
  fit.noise.x_std = 0.6;
  CHECK_FALSE(ident::findings_of(result, fit).is_buried);
  fit.noise.x_std = 0.8;
  CHECK(ident::findings_of(result, fit).is_buried);
  CHECK(of(result).verdict == Verdict::undecided);
  CHECK_THAT(of(result).sentence, Catch::Contains("most of x is its noise"));
  fit.free_run.mean_square_training = 10.0;  // of a decay, in whose end there is hardly anything left
  CHECK_FALSE(ident::findings_of(result, fit).is_buried);
}
