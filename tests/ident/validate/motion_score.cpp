#include "ident/validate/motion_score.hpp"

#include <Eigen/QR>
#include <catch2/catch.hpp>
#include <cmath>

#include "dsp/prepare.hpp"
#include "support/labelled_oscillator.hpp"

using Catch::Detail::Approx;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A driven oscillator whose x, v and a have noise that is most of a in its band, in the columns x, v, f and x^3.
struct Noisy {
  ident::CandidateLibrary library;
  std::vector<ident::Columns> recordings;
  std::vector<ident::Row> rows;
  dsp::Prepared prepared;

  explicit Noisy(std::uint32_t seed, double noise = 0.05) {
    support::Oscillator p{.k = 36.0, .c = 0.3, .force_gain = 1.0, .amplitude = 0.02, .omega = 6.0};
    for (int i = 0; i < 12; ++i) p.drive.tones.push_back({0.05, 4.0 + 0.37 * i, 0.7 * i * i, 0.0});
    static const dsp::Motion motion = support::motion_of(p, 120.0, 100.0);
    prepared = dsp::prepare(support::recorded(motion, {"x", "v", "a", "f"}, noise, seed), {.cutoff_hz = 30.0});
    library = ident::make_library({.order = 0, .terms = {"x", "v", "f", "x^3"}}, "a", prepared.signals);
    recordings.push_back(ident::form_columns(library, "a", prepared));
    const dsp::Motion& signals = *recordings.front().signals;
    for (Index i = signals.edge_samples; i < signals.num_samples() - signals.edge_samples; ++i) rows.push_back({0, i});
  }
  [[nodiscard]] VectorXd column(const VectorXd& of) const {
    VectorXd result(std::ssize(rows));
    for (Index i = 0; i < result.size(); ++i) result(i) = of(rows[static_cast<std::size_t>(i)].sample);
    return result;
  }
  [[nodiscard]] VectorXd column(const std::string& name) const {
    for (std::size_t j = 0; j < library.terms.size(); ++j)
      if (library.terms[j].name == name) return column(recordings.front().phi.col(static_cast<Index>(j)));
    return {};
  }
  /// Of a series beside the least squares of these terms.
  [[nodiscard]] ident::MotionScore::Score score(const std::vector<std::string>& terms, const VectorXd& series) const {
    MatrixXd phi(std::ssize(rows), std::ssize(terms));
    for (std::size_t j = 0; j < terms.size(); ++j) phi.col(static_cast<Index>(j)) = column(terms[j]);
    const VectorXd target = column(recordings.front().target), mean = phi.colPivHouseholderQr().solve(target);
    ident::Model model;
    model.target = "a";
    for (std::size_t j = 0; j < terms.size(); ++j)
      for (std::size_t i = 0; i < library.terms.size(); ++i)
        if (library.terms[i].name == terms[j])
          model.terms.push_back(
              {.name = terms[j], .column = static_cast<Index>(i), .mean = mean(static_cast<Index>(j))});
    const VectorXd residual = target - phi * mean;
    const ident::MotionScore score(model, rows, recordings, residual);
    REQUIRE(score.can_tell());
    return score.of(series);
  }
};

}  // namespace

TEST_CASE("the score of a series that nothing is missing of is a standard normal deviate", "[ident][motion_score]") {
  constexpr int draws = 100;
  constexpr double once_in_ten = 2.706;  // chi-square of one degree of freedom
  double sum = 0.0;
  int num_beyond = 0;
  for (int draw = 0; draw < draws; ++draw) {
    const Noisy noisy(100 + static_cast<std::uint32_t>(draw));
    const auto [z, fraction, gain] = noisy.score({"x", "v", "f"}, noisy.column("x^3"));
    sum += z * z / draws;
    num_beyond += gain > once_in_ten;
    CHECK(gain > 0.5 * z * z);  // the residual has the level that the channels tell
  }
  // chi^2 of as many degrees: four standard errors. By the larger of two levels of noise it is seldom more.
  CHECK(sum == Approx(1.0).margin(4.0 * std::sqrt(2.0 / draws)));
  CHECK(num_beyond <= draws / 10 + 12);  // four standard errors of a binomial count
  CHECK(num_beyond >= 1);
}

TEST_CASE("damping that noise drowns in the whole band shows where the motion is", "[ident][motion_score]") {
  const Noisy noisy(7);
  const VectorXd v = noisy.column("v");
  const auto found = noisy.score({"x", "f"}, v);
  CHECK(found.z < -10.0);
  CHECK(noisy.score({"x", "f"}, -2.0 * v).z == Approx(-found.z));
  CHECK(found.fraction > 0.5);
  CHECK(found.gain < 0.9 * found.z * found.z);  // most of the residual is what is missing
  CHECK(found.gain > 100.0);                    // of z = 10, all but certain by any level
  // A series that the kept terms make up has no score of its own.
  CHECK(noisy.score({"x", "f"}, noisy.column("x") - 3.0 * noisy.column("f")).z == 0.0);
}

TEST_CASE("rows of a table have no noise that is known, and no score", "[ident][motion_score]") {
  Noisy noisy(1);
  noisy.recordings.front().noise.reset();
  ident::Model model;
  model.target = "a";
  model.terms = {{.name = "x", .column = 0, .mean = -36.0}};
  const VectorXd residual = VectorXd::Ones(std::ssize(noisy.rows));
  CHECK_FALSE(ident::MotionScore(model, noisy.rows, noisy.recordings, residual).can_tell());
}
