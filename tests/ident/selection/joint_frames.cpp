// Two records of one frame on a shaken base whose friction on the ground differs, fitted together.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "ident/identify.hpp"
#include "ident/records/record.hpp"
#include "support/oscillator.hpp"
#include "support/random.hpp"

namespace test_selection_joint_frames {

using Eigen::Index;

namespace {

/// Displacements of plate and base as two lasers of this noise record them.
dsp::Recording recorded(const sim::Coulomb& frame, const std::string& name, double noise_m, unsigned seed) {
  const dsp::Motion motion = support::friction_on_the_ground(frame, 10.0, 250.0);
  dsp::Recording recording{.name = name, .sample_rate_hz = motion.sample_rate_hz};
  recording.channels = {{.name = "plate", .role = dsp::Role::y, .unit = "m"},
                        {.name = "base", .role = dsp::Role::r, .unit = "m"}};
  recording.samples = noise_m * support::gaussian(motion.num_samples(), 2, seed);
  recording.samples.col(0) += motion.at("y");
  recording.samples.col(1) += motion.at("r");
  return recording;
}

struct Tally {
  int pairs = 0, false_terms = 0, with_false = 0, stiffness = 0, friction = 0, separate = 0;
};

/// Frames like that of the measured records: stiffness 386.7 and damping 0.217 per mass; load, drive and noise drawn.
Tally tally(unsigned first_seed, int pairs) {
  Tally result;
  for (int pair = 0; pair < pairs; ++pair) {
    std::mt19937 engine(first_seed + static_cast<unsigned>(pair));
    const auto uniform = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(engine);
    };
    const double stiffness = 386.7, light = uniform(0.15, 0.25), heavy = uniform(1.6, 2.0) * light;
    const double drive_hz = uniform(0.9, 1.1), base_m = uniform(1.6e-3, 2.0e-3);
    const double noise_m = uniform(1e-6, 3e-6);
    std::vector<ident::Record> records;
    for (const double friction : {light, heavy}) {
      const sim::Coulomb frame{.m = 1.0,
                               .c = 0.217,
                               .k = stiffness,
                               .c_f = friction,
                               .force_n = stiffness * base_m,
                               .ratio = 2.0 * M_PI * drive_hz / std::sqrt(stiffness)};
      dsp::Recording recording =
          recorded(frame, friction == light ? "light" : "heavy", noise_m, static_cast<unsigned>(engine()));
      records.push_back(ident::find_regimes(dsp::prepare(recording, {.cutoff_hz = 30.0, .rolloff_hz = 24.0})));
      dsp::Prepared& prepared = records.back().prepared;
      dsp::set_displacement_zero(prepared, dsp::mean_displacement(prepared, 0.0, INFINITY));
    }
    const ident::CandidateLibrary library =
        ident::record_library({.order = 3, .terms = {"sgn(dy)", "ddr"}}, "ddy", records.front().prepared);
    std::vector<ident::Columns> columns;
    for (const ident::Record& record : records) columns.push_back(ident::record_columns(library, "ddy", record));
    ident::Range slip;
    slip.spec.name = "slip";
    slip.spec.where = "abs(dy) > 0.004";
    slip.train_fraction = 1.0;
    const auto found = ident::identify(
        slip, columns, library,
        {.target = "ddy", .target_unit = "m/s^2", .methods = {ident::FastRvmOptions{}}, .free_run = false});
    const ident::Model& model = found.fits.front().model;
    std::string text;
    bool stiffness_covered = false, own = true;
    int friction_covered = 0;
    const int false_before = result.false_terms;
    for (const ident::ModelTerm& term : model.terms) {
      text += label(term) + " " + std::to_string(term.mean) + "+-" + std::to_string(term.std) + "  ";
      const auto covers = [&](double truth) { return std::abs(term.mean - truth) <= 1.96 * term.std; };
      if (term.name == "x") {
        own = own && term.recording == 0;
        stiffness_covered = term.recording == 0 && covers(-stiffness);
      } else if (term.name == "sgn(dy)") {
        own = own && term.recording > 0;
        friction_covered += covers(term.recording == 2 ? -heavy : -light);
      } else if (term.name != "v" && term.name != "1" && term.recording < 2) {
        ++result.false_terms;
      }
    }
    ++result.pairs;
    result.with_false += result.false_terms > false_before;
    result.stiffness += stiffness_covered;
    result.friction += friction_covered == 2;
    result.separate += own;
    std::printf("%2d n_eff %.0f of %.0f f %.2f: %s\n", pair, found.fits.front().size.num_effective(),
                found.fits.front().size.num_rows, found.fits.front().size.structural_fraction, text.c_str());
  }
  std::printf(
      "%d pairs of frames: %d false terms in %d, x common and sgn(dy) by record in %d, K covered in %d, F in %d\n",
      result.pairs, result.false_terms, result.with_false, result.separate, result.stiffness, result.friction);
  return result;
}

}  // namespace

TEST_CASE("two loads on one frame: its stiffness is common, its friction is not", "[ident][records]") {
  const Tally found = tally(91000, 10);
  CHECK(found.false_terms <= 1);
  CHECK(found.separate >= 9);
  CHECK(found.stiffness >= 9);
  CHECK(found.friction >= 9);
}

TEST_CASE("thirty pairs of frames", "[.study][records]") {
  const Tally found = tally(92000, 30);
  CHECK(found.with_false <= 3);
  CHECK(found.stiffness >= 27);
  CHECK(found.friction >= 27);
}

TEST_CASE("what the low-pass carries from a standstill into the slip biases neither stiffness nor friction",
          "[ident][records]") {
  constexpr double stiffness = 386.7, base_m = 1.8e-3;
  for (const double friction : {0.25, 0.35, 0.42}) {
    INFO(friction);
    const sim::Coulomb frame{.m = 1.0,
                             .c = 0.8,
                             .k = stiffness,
                             .c_f = friction,
                             .force_n = stiffness * base_m,
                             .ratio = 2.0 * M_PI / std::sqrt(stiffness)};
    ident::Record record =
        ident::find_regimes(dsp::prepare(recorded(frame, "frame", 1e-6, 93000), {.rate_hz = 62.5, .cutoff_hz = 23.0}));
    dsp::set_displacement_zero(record.prepared, dsp::mean_displacement(record.prepared, 0.0, INFINITY));
    const ident::CandidateLibrary library =
        ident::record_library({.order = 0, .terms = {"x", "v", "sgn(dy)"}}, "ddy", record.prepared);
    std::vector<ident::Columns> columns{ident::record_columns(library, "ddy", record)};
    ident::Range slip;
    slip.spec.name = "slip";
    slip.spec.where = "abs(dy) > 0.004";
    slip.train_fraction = 1.0;
    const auto found =
        ident::identify(slip, columns, library,
                        {.target = "ddy", .target_unit = "m/s^2", .methods = {ident::OlsOptions{}}, .free_run = false});
    // Up to 3 % low; where the terms act through the standstill, 6 to 10 and 7 to 13 %.
    for (const ident::ModelTerm& term : found.fits.front().model.terms) {
      if (term.name == "x") CHECK(-term.mean == Catch::Detail::Approx(stiffness).epsilon(0.04));
      if (term.name == "sgn(dy)") CHECK(-term.mean == Catch::Detail::Approx(friction).epsilon(0.04));
    }
  }
}

}  // namespace test_selection_joint_frames
