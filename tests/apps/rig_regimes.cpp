// Regimes found in the rig's records against what its payload truly did: sim::true_regimes of the exact motion.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "dsp/prepare.hpp"
#include "dsp/segment_regimes.hpp"
#include "ident/identify.hpp"
#include "sim/rig/qzs_regimes.hpp"
#include "support/rig.hpp"

namespace test_rig_regimes {

using Eigen::Index;

namespace {

struct Case {
  std::string name;
  sim::QzsParameters rig;
  sim::Programme programme;
  sim::RawOptions raw;
};

std::vector<double> steps(double from_hz, double to_hz, double by_hz, const std::vector<double>& then = {}) {
  std::vector<double> frequencies;
  const long count = std::lround((to_hz - from_hz) / by_hz);
  for (long i = 0; i <= count; ++i) frequencies.push_back(from_hz + by_hz * static_cast<double>(i));
  frequencies.insert(frequencies.end(), then.begin(), then.end());
  return frequencies;
}

sim::Programme sweep(std::vector<double> frequencies_hz, double amplitude_m, double dwell_s,
                     double transition_s = 2.0) {
  return sim::sine_steps({.frequencies_hz = std::move(frequencies_hz),
                          .amplitude_m = amplitude_m,
                          .dwell_s = dwell_s,
                          .transition_s = transition_s});
}

// The base stops and starts, again and again: free decays.
sim::Programme with_decays(sim::Programme programme, int count, double dwell_s) {
  for (int i = 0; i < count; ++i) {
    sim::ProgrammeNode node = programme.nodes.back();
    const auto driven = programme.nodes.front().harmonics_m;
    node.t_s = programme.duration_s;
    node.transition_s = 0.5;
    node.harmonics_m = i % 2 == 0 ? decltype(driven){} : driven;
    programme.nodes.push_back(node);
    programme.duration_s += dwell_s;
  }
  return programme;
}

sim::Programme by_hand(sim::Programme programme, double push_s, double hold_s) {
  programme.manual = {{.from_s = push_s, .to_s = push_s + 4.0, .by_base = -0.8, .why = "pushed"},
                      {.from_s = hold_s, .to_s = hold_s + 4.0, .by_velocity_per_s = -4.8, .why = "held"}};
  return programme;
}

const sim::QzsParameters t0 = sim::qzs_twin("T0"), t1 = sim::qzs_twin("T1");

std::vector<Case> programmes() {
  sim::QzsParameters soft = t0, damped = t0, firm = t0;
  soft.k1 = 40.0, soft.k3 = 6e4;
  damped.c = 1.0, damped.mu_kinetic = 0.06;
  firm.k1 = 80.0, firm.mu_kinetic = 0.10, firm.mu_static = 0.45;
  return {
      {"down, 4 mm", t0, sweep(steps(1.75, 1.25, -0.05, {0.6}), 4e-3, 20), {.seed = 51}},
      {"down, 5.5 mm", t0, sweep(steps(1.90, 1.34, -0.04), 5.5e-3, 35, 3), {.seed = 52}},
      {"60 s dwells", t0, sweep({1.60, 1.52, 1.47, 1.40, 1.30, 0.7}, 4.5e-3, 60, 3), {.seed = 53}},
      {"12 s dwells", t0, sweep(steps(1.6, 1.4, -0.02, {0.7, 0.7}), 4.5e-3, 12, 1.5), {.seed = 54}},
      {"up, 5 mm", t0, sweep(steps(1.20, 1.60, 0.05), 5e-3, 20), {.seed = 55}},
      {"T1 up, 4 mm", t1, sweep(steps(1.40, 1.70, 0.05), 4e-3, 25), {.seed = 56}},
      {"T1 down, 4 mm", t1, sweep(steps(1.70, 1.22, -0.04), 4e-3, 25), {.seed = 57}},
      {"T1, noise x10", t1, sweep(steps(1.80, 1.30, -0.05), 5.5e-3, 25), {.noise = 10, .seed = 58}},
      {"noise x30", t0, sweep(steps(1.75, 1.30, -0.05, {0.6, 0.6}), 5e-3, 25), {.noise = 30, .seed = 59}},
      {"decays", t0, with_decays(sweep({1.60, 1.53, 1.50, 1.45, 1.45}, 4.2e-3, 25), 3, 30), {.seed = 60}},
      {"soft spring", soft, sweep(steps(1.60, 1.10, -0.05), 4.5e-3, 30), {.seed = 61}},
      {"pushed and held",
       damped,
       by_hand(sweep({1.75, 1.70, 1.65, 1.60, 1.55, 1.50, 1.45, 1.40, 1.35, 0.6}, 5e-3, 25), 60, 90),
       {.seed = 62}},
      {"firm spring", firm, sweep(steps(2.00, 1.40, -0.05, {0.7}), 4.8e-3, 28), {.seed = 63}},
      {"T1 decays", t1, with_decays(sweep({1.62, 1.55, 1.48, 1.42, 1.42}, 5e-3, 30), 3, 35), {.seed = 64}},
      {"5 mm, noise x3", t0, sweep(steps(1.72, 1.36, -0.06, {0.65, 0.5}), 5e-3, 45, 4), {.noise = 3, .seed = 65}},
      {"T1 up, 6 mm", t1, sweep(steps(1.05, 1.55, 0.05), 6e-3, 22), {.seed = 66}},
  };
}

// Most of them linger where the payload halts for a few milliseconds a half cycle.
std::vector<Case> later_programmes() {
  sim::QzsParameters firm = t0, slick = t0, weak = t0, less_friction = t1;
  firm.k1 = 66.0, firm.k3 = 1.1e5;
  slick.mu_kinetic = 0.06, slick.mu_static = 0.36;
  weak.k3 = 7e4, weak.c = 0.9;
  less_friction.mu_static = 0.35, less_friction.k1 = 53.0;
  return {
      {"down, 3.8 mm", t0, sweep(steps(1.76, 0.96, -0.05), 3.8e-3, 27, 2.5), {.seed = 301}},
      {"firm, noise x3", firm, sweep(steps(1.86, 1.06, -0.05), 4.4e-3, 32, 3), {.noise = 3, .seed = 302}},
      {"slick, 3.9 mm", slick, sweep(steps(1.70, 0.90, -0.04), 3.9e-3, 21), {.seed = 303}},
      {"weak, noise x10", weak, sweep(steps(1.72, 1.0, -0.06), 4.2e-3, 36, 3), {.noise = 10, .seed = 304}},
      {"5.2 mm, noise x30", t0, sweep(steps(1.85, 1.25, -0.05, {0.7}), 5.2e-3, 26), {.noise = 30, .seed = 305}},
      {"up, 4.3 mm", t0, sweep(steps(1.30, 1.70, 0.04), 4.3e-3, 18, 1.5), {.seed = 306}},
      {"65 s dwells", t0, sweep({1.72, 1.55, 1.42, 1.28, 1.14, 1.03}, 4e-3, 65, 3), {.seed = 307}},
      {"decays, 4.6 mm",
       t0,
       with_decays(sweep({1.65, 1.54, 1.46, 1.38, 1.38}, 4.6e-3, 24), 3, 28),
       {.noise = 3, .seed = 308}},
      {"T1 down, 5.4 mm", t1, sweep(steps(1.75, 1.2, -0.05, {0.7}), 5.4e-3, 24), {.noise = 3, .seed = 309}},
      {"T1, less friction", less_friction, sweep(steps(1.72, 1.0, -0.06), 4.4e-3, 29), {.seed = 310}},
  };
}

// Rig, amplitude, frequencies and noise drawn around both twins, from the seed 9000 + index.
Case random_programme(int index) {
  std::mt19937_64 engine(9000 + static_cast<std::uint64_t>(index));
  const auto draw = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(engine() >> 11) / 9007199254740992.0;  // 2^53
  };
  const bool has_mount = draw(0, 1) < 0.35;
  sim::QzsParameters rig = has_mount ? t1 : t0;
  rig.k1 *= draw(0.85, 1.4);
  rig.k3 *= draw(0.75, 1.25);
  rig.c *= draw(0.85, 1.15);
  rig.mu_kinetic *= draw(0.75, 1.3);
  rig.mu_static *= draw(0.85, 1.2);
  if (has_mount) {
    rig.bounce_hz *= draw(0.9, 1.25);
    rig.bounce_damping *= draw(0.7, 1.6);
  }
  const double amplitude_m = draw(3.6e-3, 6e-3), scale = std::sqrt(rig.k1) / (2.0 * M_PI * 1.125);
  const int noise = std::array{1, 1, 3, 10, 30}[engine() % 5];
  const double kind = draw(0, 1);
  sim::Programme programme;
  if (kind < 0.82) {
    const bool down = kind < 0.65;
    const double transition_s = draw(1.5, 4), dwell_s = draw(15, down ? 45 : 35);
    const bool ends_locked = down && draw(0, 1) < 0.5;
    const double by_hz = down ? -draw(0.03, 0.07) : draw(0.03, 0.06);
    const double to_hz = scale * (down ? draw(0.85, 1.25) : draw(1.55, 1.75));
    const double from_hz = scale * (down ? draw(1.65, 1.9) : draw(1.0, 1.3));
    programme = sweep(steps(from_hz, to_hz, by_hz, ends_locked ? std::vector{0.65} : std::vector<double>{}),
                      amplitude_m, dwell_s, transition_s);
  } else {
    const double rest_s = draw(28, 36), dwell_s = draw(24, 35);
    programme = with_decays(
        sweep({1.62 * scale, 1.55 * scale, 1.48 * scale, 1.42 * scale, 1.42 * scale}, amplitude_m, dwell_s), 3, rest_s);
  }
  return {std::to_string(index) + (has_mount ? " T1" : " T0") +
              (kind < 0.65   ? " down"
               : kind < 0.82 ? " up"
                             : " decays") +
              " x" + std::to_string(noise),
          rig,
          programme,
          {.noise = static_cast<double>(noise), .seed = 5000 + static_cast<std::uint64_t>(index)}};
}

/// A record as the product prepares it, and what is true of it.
struct Prepared {
  dsp::Motion intermediate;
  std::vector<sim::RegimeInterval> truth;
};

Prepared prepared(const Case& tested) {
  const auto rig = std::make_shared<const sim::QzsRig>(tested.rig, tested.programme);
  const support::RigRecord record = support::rig_record(tested.rig, tested.programme, tested.raw);
  return {dsp::prepare(record.recording, {.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0}).intermediate,
          sim::true_regimes(rig, record.x, record.modes, support::rig_intermediate_hz)};
}

struct Score {
  double accuracy = 0.0, stick_recall = 0.0, stick_precision = 0.0, boundary_cycles = 0.0;
  int num_jumps = 0, num_inside = 0;  ///< boundaries between branches that were found; inside their 95 % intervals
};

const sim::ProgrammeNode& node_at(const sim::Programme& programme, double t_s) {
  const sim::ProgrammeNode* node = &programme.nodes.front();
  for (const auto& one : programme.nodes)
    if (one.t_s <= t_s + 0.5 / support::rig_intermediate_hz) node = &one;
  return *node;
}

/// Whether what was found is what is true: any motion is where there is no branch.
bool agree(dsp::Regime found, const std::string& truth) {
  if (truth == "free") return found != dsp::Regime::stick && found != dsp::Regime::excluded;
  return to_string(found) == truth;
}

// Furthest that a true boundary lies from the nearest found one between the same regimes, in cycles. Boundaries that
// are excluded, as the start and hands are, have no counterpart, nor has the end of a branch where the base comes to
// rest.
double boundary_error(const std::vector<sim::RegimeInterval>& truth, const std::vector<dsp::Segment>& found,
                      const sim::Programme& programme) {
  double worst = 0.0;
  for (std::size_t k = 1; k < truth.size(); ++k) {
    const double t = truth[k].from_s;
    if (truth[k - 1].label != "stick" && truth[k].label == "free") continue;
    double nearest = INFINITY;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double from = static_cast<double>(found[i].first) / support::rig_intermediate_hz,
                   to = static_cast<double>(found[i].last) / support::rig_intermediate_hz;
      if (found[i].regime == dsp::Regime::excluded && t >= from - 1.0 && t <= to + 1.0) nearest = 0.0;
      if (i > 0 && agree(found[i].regime, truth[k].label) && agree(found[i - 1].regime, truth[k - 1].label))
        nearest = std::min(nearest, std::abs(from - t));
    }
    worst = std::max(worst, nearest * node_at(programme, t).frequency_hz);
  }
  return worst;
}

// Boundaries between low and high, and how many of them have a true one of the kind within the printed interval.
void count_jumps(const std::vector<sim::RegimeInterval>& truth, const std::vector<dsp::Segment>& found, Score& result) {
  for (std::size_t i = 1; i < found.size(); ++i) {
    const auto moves = [](dsp::Regime regime) { return regime == dsp::Regime::low || regime == dsp::Regime::high; };
    if (!moves(found[i - 1].regime) || !moves(found[i].regime) || !std::isfinite(found[i].first_std_s)) continue;
    const double t = static_cast<double>(found[i].first) / support::rig_intermediate_hz;
    double nearest = INFINITY;
    for (std::size_t k = 1; k < truth.size(); ++k)
      if (agree(found[i].regime, truth[k].label) && agree(found[i - 1].regime, truth[k - 1].label))
        nearest = std::min(nearest, std::abs(truth[k].from_s - t));
    ++result.num_jumps;
    result.num_inside += nearest <= 1.96 * found[i].first_std_s + 0.5 / support::rig_intermediate_hz ? 1 : 0;
  }
}

Score score(const Case& tested) {
  const Prepared record = prepared(tested);
  const std::vector<sim::RegimeInterval>& truth = record.truth;
  const auto found = dsp::segment_regimes(record.intermediate).segments;
  double same = 0.0, all = 0.0, stuck = 0.0, called_stuck = 0.0, both = 0.0;
  std::size_t k = 0;
  for (const dsp::Segment& segment : found) {
    if (segment.regime == dsp::Regime::excluded) continue;
    for (Index i = segment.first; i < segment.last; ++i) {
      const double t = static_cast<double>(i) / support::rig_intermediate_hz;
      while (k + 1 < truth.size() && truth[k].to_s <= t) ++k;
      const bool is_stuck = truth[k].label == "stick", called = segment.regime == dsp::Regime::stick;
      all += 1.0, same += agree(segment.regime, truth[k].label);
      stuck += is_stuck, called_stuck += called, both += is_stuck && called;
    }
  }
  Score result{all > 0.0 ? same / all : 1.0, stuck > 0.0 ? both / stuck : 1.0,
               called_stuck > 0.0 ? both / called_stuck : 1.0, boundary_error(truth, found, tested.programme)};
  count_jumps(truth, found, result);
  return result;
}

void print(const std::string& name, const Score& s) {
  std::printf("%-18s accuracy %.5f  stick recall %.4f precision %.4f  boundaries within %.2f cycles\n", name.c_str(),
              s.accuracy, s.stick_recall, s.stick_precision, s.boundary_cycles);
  std::fflush(stdout);
}

bool meets_bar(const Score& s) {
  return s.accuracy >= 0.995 && s.stick_recall >= 0.99 && s.boundary_cycles <= 1.5;
}

void check(const Score& s) {
  CHECK(s.accuracy >= 0.996);
  CHECK(s.stick_recall >= 0.99);
  CHECK(s.stick_precision >= 0.99);
  CHECK(s.boundary_cycles <= 0.5);
}

}  // namespace

TEST_CASE("a jump, sticking, an up-sweep and free decays are found without a threshold given", "[apps][regimes]") {
  for (const Case& tested : programmes())
    if (tested.name == "12 s dwells" || tested.name == "up, 5 mm" || tested.name == "decays") {
      INFO(tested.name);
      check(score(tested));
    }
}

TEST_CASE("regimes of 26 programmes", "[.][study][regimes]") {
  int good = 0;
  for (const auto& cases : {programmes(), later_programmes()})
    for (const Case& tested : cases) {
      const Score s = score(tested);
      print(tested.name, s);
      good += meets_bar(s);
    }
  std::printf("%d of 26 meet the bar\n", good);
}

// ARDENT_STUDY_SEED gives the first (3000).
TEST_CASE("regimes of a hundred random programmes", "[.][study][regimes]") {
  const char* seed = std::getenv("ARDENT_STUDY_SEED");
  const int first = seed == nullptr ? 3000 : std::atoi(seed);
  int good = 0, count = 0, num_jumps = 0, num_inside = 0;
  for (int index = first; index < first + 100; ++index) try {
      const Case tested = random_programme(index);
      const Score s = score(tested);
      print(tested.name, s);
      ++count;
      good += meets_bar(s);
      num_jumps += s.num_jumps, num_inside += s.num_inside;
    } catch (const sim::Diverged& error) {
      std::printf("%d: %s\n", index, error.what());
    }
  std::printf("%d of %d meet the bar; %d of %d jumps inside their 95 %% intervals\n", good, count, num_inside,
              num_jumps);
  CHECK(good >= count * 3 / 4);
  CHECK(num_inside >= 0.85 * num_jumps);
}

TEST_CASE("regimes of the whole test, both twins, six seeds, noise up to thirtyfold", "[.][study][regimes]") {
  int good = 0;  // of 48
  for (const char* twin : {"T0", "T1"})
    for (const std::uint64_t seed : {1, 71, 72, 73, 74, 75})
      for (const double noise : {1.0, 3.0, 10.0, 30.0}) {
        const Score s = score({"", sim::qzs_twin(twin), sim::stepped_sine_down(), {.noise = noise, .seed = seed}});
        print(twin + (" seed " + std::to_string(seed)) + " x" + std::to_string(static_cast<int>(noise)), s);
        const double least_accuracy = noise <= 3.0 ? 0.999 : noise <= 10.0 ? 0.997 : 0.995;
        good += s.accuracy >= least_accuracy && s.stick_recall >= 0.99 && s.stick_precision >= 0.99 &&
                s.boundary_cycles <= 1.0;
      }
  // On one T1 record at thirtyfold noise a reversal that comes near to a halt is taken for one, and two cycles with it.
  CHECK(good >= 47);
}

TEST_CASE("halts of a few milliseconds, left in, spoil the equation", "[.][study][regimes]") {
  // The payload lingers where it halts twice a cycle, for 1 % of the record in all.
  for (const Case& tested : later_programmes()) {
    if (tested.name != "down, 3.8 mm" && tested.name != "slick, 3.9 mm") continue;
    const support::RigRecord record = support::rig_record(tested.rig, tested.programme, tested.raw);
    const dsp::Prepared prepared =
        dsp::prepare(record.recording, {.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0});
    const auto identified = [&](const dsp::SegmentOptions& options, const char* what) {
      ident::Record found = ident::find_regimes(prepared, options);
      auto ranges = ident::default_ranges({&found});
      std::erase_if(ranges, [](const ident::Range& range) { return range.spec.name != "mixed"; });
      for (ident::Range& range : ranges) range.train_fraction = 0.95;
      dsp::set_displacement_zero(found.prepared, ident::mean_of_first_range(found, ranges, 1));
      const ident::IdentifyOptions how{.methods = {ident::FastRvmOptions{}}};
      const auto library =
          ident::record_library({.order = 0, .terms = {"x", "v", "x^3", "sgn(v)", "ddr"}}, how.target, found.prepared);
      std::vector<ident::Columns> columns{ident::record_columns(library, how.target, found)};
      const ident::RangeResult result = ident::identify(ranges, columns, library, how).front();
      const ident::JudgedFit& fit = result.fits.front();
      std::printf("%s, %s: %d rows, NMSE %.2g, free run %.2g\n", tested.name.c_str(), what,
                  static_cast<int>(result.rows.train.size()), fit.train_centred.value, fit.free_run.nmse);
      return std::pair(fit.train_centred.value, fit.free_run.nmse);
    };
    const auto without = identified({}, "as found"),
               with = identified({.stick_duration_s = 0.02}, "short halts left in");
    CHECK(with.first > 100.0 * without.first);
    CHECK(with.second > 100.0 * without.second);
  }
}

}  // namespace test_rig_regimes
