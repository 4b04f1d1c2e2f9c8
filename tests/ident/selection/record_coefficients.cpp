#include "ident/selection/record_coefficients.hpp"

#include <Eigen/QR>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <string>

#include "ident/identify.hpp"
#include "support/oscillator.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

struct Record {
  MatrixXd phi;
  VectorXd target;
};

/// Six candidates; the target is 2 phi0 - phi3 + own phi4 + noise.
Record made(double own, double noise, unsigned seed) {
  Record record{support::gaussian(400, 6, seed), {}};
  record.target = 2.0 * record.phi.col(0) - record.phi.col(3) + own * record.phi.col(4) +
                  noise * support::gaussian(400, 1, 7000 + seed);
  return record;
}

ident::RecordProblems problems_of(const std::vector<Record>& records) {
  std::vector<ident::RFactor> factors;
  for (const Record& record : records) factors.push_back(ident::r_factor(record.phi, record.target));
  return ident::RecordProblems(factors);
}

/// By least squares on stacked rows, a column for each record in place of a differing one.
double stacked_rss(const std::vector<Record>& records, const std::vector<Index>& common,
                   const std::vector<Index>& differing) {
  const Index count = std::ssize(records), k = std::ssize(common), d = std::ssize(differing);
  MatrixXd phi = MatrixXd::Zero(400 * count, k + d * count);
  VectorXd target(phi.rows());
  for (Index r = 0; r < count; ++r) {
    const Record& record = records[static_cast<std::size_t>(r)];
    target.segment(400 * r, 400) = record.target;
    for (Index j = 0; j < k; ++j) phi.block(400 * r, j, 400, 1) = record.phi.col(common[static_cast<std::size_t>(j)]);
    for (Index j = 0; j < d; ++j)
      phi.block(400 * r, k + d * r + j, 400, 1) = record.phi.col(differing[static_cast<std::size_t>(j)]);
  }
  if (phi.cols() == 0) return 1.0;
  return (target - phi * phi.colPivHouseholderQr().solve(target)).squaredNorm() / target.squaredNorm();
}

}  // namespace

TEST_CASE("what common and differing coefficients leave is least squares on the stacked rows", "[ident][records]") {
  const std::vector<Record> records{made(0.5, 0.3, 1), made(1.5, 0.3, 2), made(-1.0, 0.3, 3)};
  const ident::RecordProblems problems = problems_of(records);
  for (const auto& [common, differing] : {std::pair<std::vector<Index>, std::vector<Index>>{{0, 3, 4}, {}},
                                          {{0, 3}, {4}},
                                          {{1}, {0, 3, 4}},
                                          {{}, {0, 1, 2, 3, 4, 5}},
                                          {{}, {}}})
    CHECK(ident::shared_rss(problems, common, differing) ==
          Approx(stacked_rss(records, common, differing)).epsilon(1e-9));
  // All coefficients of each record are what best_subsets sums up.
  CHECK(ident::least_squares_rss(problems, {0, 4}) == Approx(stacked_rss(records, {}, {0, 4})).epsilon(1e-9));
}

TEST_CASE("the coefficients that differ between records are found, and no others", "[ident][records]") {
  int exact = 0, same = 0;
  constexpr int draws = 50;
  for (unsigned seed = 0; seed < draws; ++seed) {
    const auto found = [&](double second, double third) {
      const ident::RecordProblems problems =
          problems_of({made(1.0, 0.5, 100 + seed), made(second, 0.5, 300 + seed), made(third, 0.5, 500 + seed)});
      return ident::record_coefficients(problems, {0, 3, 4}, {1200.0, 1200.0});
    };
    // A coefficient's standard error is 0.5 / sqrt(400) = 0.025: 0.3 are twelve of them.
    exact += found(1.3, 1.0) == ident::RecordCoefficients{{0, 3, 4}, {4}};
    same += found(1.0, 1.0) == ident::RecordCoefficients{{0, 3, 4}, {}};
  }
  // By chance one of three differs where chi^2 of 2 exceeds 2 ln 1200 + 2 ln 3: with probability 3 e^-8.2 a draw; one
  // of three candidates comes in where that of 1 exceeds ln 1200 + 2 ln 6: 0.003.
  CHECK(exact >= draws - 1);
  CHECK(same >= draws - 1);
}

TEST_CASE("a weak common term comes in behind the others, and its neighbour is common again", "[ident][records]") {
  // Column 1 is much like column 4; without it the records seem to differ in 4, which stands for both.
  const auto record = [](double likeness, unsigned seed) {
    Record one = made(0.0, 0.2, seed);
    one.phi.col(1) = likeness * one.phi.col(4) + std::sqrt(1.0 - likeness * likeness) * one.phi.col(1);
    one.target += one.phi.col(4) + 0.4 * one.phi.col(1);
    return one;
  };
  const ident::RecordProblems problems = problems_of({record(0.95, 11), record(-0.95, 12)});
  const ident::RecordCoefficients found = ident::record_coefficients(problems, {0, 3, 4}, {800.0, 800.0});
  CHECK(found == ident::RecordCoefficients{{0, 1, 3, 4}, {}});
}

namespace {

struct Joint {
  std::set<std::string> kept, differing;
  std::vector<ident::ModelTerm> terms;
};

/// One equation of several motions with noise on the acceleration, all rows of each.
Joint joint_fit_of(std::vector<dsp::Motion> motions, const ident::LibraryOptions& options, double noise,
                   unsigned seed) {
  const ident::CandidateLibrary library = ident::make_library(options, "a", motions.front());
  std::vector<ident::Columns> columns;
  for (std::size_t r = 0; r < motions.size(); ++r)
    for (dsp::Signal& signal : motions[r].signals)
      if (signal.name == "a") {
        const double std = std::sqrt((signal.values.array() - signal.values.mean()).square().mean());
        signal.values +=
            noise * std * support::gaussian(signal.values.size(), 1, seed + 1000 * static_cast<unsigned>(r));
        columns.push_back(ident::form_columns(library, "a", motions[r], "run" + std::to_string(r + 1)));
      }
  ident::Range all;
  all.spec.name = "all";
  all.train_fraction = 1.0;
  const auto result =
      ident::identify(all, columns, library, {.target = "a", .methods = {ident::FastRvmOptions{}}, .free_run = false});
  Joint joint{{}, {}, result.fits.front().model.terms};
  for (const ident::ModelTerm& term : joint.terms) {
    joint.kept.insert(term.name);
    if (term.recording > 0) joint.differing.insert(term.name);
  }
  return joint;
}

}  // namespace

TEST_CASE("several records of one Duffing oscillator have one equation", "[ident][records]") {
  std::vector<dsp::Motion> motions;
  for (const double force : {60.0, 100.0, 140.0})
    motions.push_back(support::motion_of(sim::make_experiment(sim::Duffing{.force_n = force}), 30.0, 50.0));
  // The candidate is cos(omega t); the force is its coefficient and differs.
  for (unsigned seed = 0; seed < 12; ++seed) {
    const Joint found = joint_fit_of(motions, {.order = 3, .terms = {"f"}}, 0.1, 8100 + seed);
    CAPTURE(seed);
    CHECK(found.kept == std::set<std::string>{"f", "v", "x", "x^3"});
    CHECK(found.differing == std::set<std::string>{"f"});
  }
}

TEST_CASE("friction that differs between records is told from what does not", "[ident][records]") {
  const auto motion = [](double friction, double ratio) {
    return support::motion_of(sim::make_experiment(sim::Coulomb{.c_f = friction, .ratio = ratio}), 10.0, 125.0);
  };
  const std::vector<dsp::Motion> alike{motion(10.0, 1.0), motion(10.0, 0.9), motion(10.0, 1.1)},
      unlike{motion(10.0, 1.0), motion(15.0, 0.9), motion(20.0, 1.1)};
  for (unsigned seed = 0; seed < 12; ++seed) {
    CAPTURE(seed);
    const Joint same = joint_fit_of(alike, {.order = 3, .terms = {"sgn(v)", "f"}}, 0.02, 8300 + seed);
    CHECK(same.kept == std::set<std::string>{"f", "sgn(v)", "v", "x"});
    CHECK(same.differing.empty());
    const Joint other = joint_fit_of(unlike, {.order = 3, .terms = {"sgn(v)", "f"}}, 0.02, 8400 + seed);
    CHECK(other.kept == std::set<std::string>{"f", "sgn(v)", "v", "x"});
    CHECK(other.differing == std::set<std::string>{"sgn(v)"});
  }
}

TEST_CASE("intervals of common and differing coefficients cover", "[ident][records]") {
  int covered = 0, all = 0;
  for (unsigned seed = 0; seed < 25; ++seed) {
    std::vector<dsp::Motion> motions;
    const double friction[] = {10.0, 20.0};
    for (const double own : friction)
      motions.push_back(support::motion_of(sim::make_experiment(sim::Coulomb{.c_f = own}), 10.0, 125.0));
    const Joint found = joint_fit_of(motions, {.order = 3, .terms = {"sgn(v)", "f"}}, 0.02, 8600 + seed);
    const std::map<std::string, double> truth{{"x", -1000.0}, {"v", -2.0}, {"f", 100.0}};
    for (const ident::ModelTerm& term : found.terms) {
      const double value = term.name == "sgn(v)" && term.recording > 0 ? -friction[term.recording - 1]
                           : truth.count(term.name) > 0                ? truth.at(term.name)
                                                                       : 0.0;
      ++all;
      covered += std::abs(term.mean - value) <= 1.96 * term.std;
    }
  }
  std::printf("joint Coulomb, 25 runs: %d of %d coefficients covered\n", covered, all);
  CHECK(all >= 5 * 24);
  CHECK(covered >= 0.89 * all);  // 0.95 less three standard deviations of 125
}

TEST_CASE("the equation of a recording is what is common and its own", "[ident][records]") {
  ident::Model model{.target = "a", .target_unit = "m/s^2", .terms = {}, .covariance = MatrixXd::Identity(3, 3)};
  model.terms.push_back({.name = "x", .mean = -50.0, .std = 1.0});
  model.terms.push_back({.name = "sgn(v)", .mean = -1.0, .std = 1.0, .recording = 1, .recording_name = "one"});
  model.terms.push_back({.name = "sgn(v)", .mean = -3.0, .std = 1.0, .recording = 2, .recording_name = "two"});
  CHECK(to_text(model) == "a = -50 x + c1 sgn(v), c1 = -1 in one, -3 in two");
  const ident::Model second = equation_of(model, 2), other = equation_of(model, 0);
  CHECK(to_text(second) == "a = -50 x - 3 sgn(v)");
  CHECK(second.covariance == MatrixXd::Identity(2, 2));
  CHECK(to_text(other) == "a = -50 x - 2 sgn(v)");
  // Of the mean of two: 1/2; of a further recording besides: the sample variance of -1 and -3, which is 2.
  CHECK(other.covariance(1, 1) == Approx(2.5));
  CHECK(other.terms[1].std == Approx(std::sqrt(2.5)));
  CHECK_FALSE(differs_by_recording(other));
  // A term that was offered to a recording and not kept is none of its equation.
  model.terms.pop_back();
  model.covariance = model.covariance.topLeftCorner(model.covariance.rows() - 1, model.covariance.cols() - 1).eval();
  CHECK(equation_of(model, 2).terms.size() + 1 == equation_of(model, 1).terms.size());
}
