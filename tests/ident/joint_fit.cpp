#include "ident/joint_fit.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "ident/regression/methods.hpp"
#include "support/fault.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Rows of a x + b v + c with noise, and the record that is made of them.
struct Made {
  MatrixXd phi;
  VectorXd target;
  ident::RecordFactors record;
};

Made made(unsigned seed, Index rows, double noise, const VectorXd& truth = Eigen::Vector3d(-50.0, -0.8, 0.3)) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Made result{MatrixXd(rows, 3), VectorXd(rows), {}};
  for (Index i = 0; i < rows; ++i) {
    result.phi.row(i) << normal(random), 20.0 * normal(random), 1.0;
    result.target(i) = result.phi.row(i).dot(truth) + noise * normal(random);
  }
  ident::RecordFactors& record = result.record;
  record.record = "record " + std::to_string(seed);
  record.range = "all";
  record.sources = {{record.record, std::string(64, 'a')}};
  record.target = "a";
  record.target_unit = "m/s^2";
  record.terms = {{"x", "m", 1.0}, {"v", "m/s", 2.0}, {"1", "1", 1.0}};
  record.white = ident::r_factor(result.phi, result.target);
  for (Index first = 0; first < rows; first += 40) {
    const Index count = std::min<Index>(40, rows - first);
    record.blocks.push_back(
        {static_cast<double>(first), static_cast<double>(first + count), result.target.segment(first, count).sum(),
         ident::r_factor(result.phi.middleRows(first, count), result.target.segment(first, count))});
  }
  return result;
}

VectorXd least_squares(const std::vector<const Made*>& parts) {
  Index rows = 0;
  for (const Made* part : parts) rows += part->phi.rows();
  MatrixXd phi(rows, 3);
  VectorXd target(rows);
  rows = 0;
  for (const Made* part : parts) {
    phi.middleRows(rows, part->phi.rows()) = part->phi;
    target.segment(rows, part->phi.rows()) = part->target;
    rows += part->phi.rows();
  }
  return phi.colPivHouseholderQr().solve(target);
}

double nmse(const Made& part, const VectorXd& c) {
  return (part.target - part.phi * c).squaredNorm() / (part.target.array() - part.target.mean()).matrix().squaredNorm();
}

}  // namespace

TEST_CASE("joint least squares is least squares on the stacked rows, and so is leaving one out", "[ident][joint]") {
  const Made a = made(1, 130, 0.5), b = made(2, 90, 1.0), c = made(3, 200, 0.2);
  const auto result = ident::joint_fit({&a.record, &b.record, &c.record}, {ident::OlsOptions{}});
  REQUIRE(result.fits.size() == 1);
  const ident::JointFit& fit = result.fits.front();
  const VectorXd together = least_squares({&a, &b, &c});
  CHECK((fit.fit.mean - together).norm() < 1e-12 * together.norm());
  const std::vector<const Made*> all{&a, &b, &c};
  MatrixXd left_out(3, 3);
  for (std::size_t i = 0; i < 3; ++i) {
    std::vector<const Made*> others = all;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const VectorXd own = least_squares(others);
    left_out.col(static_cast<Index>(i)) = own;
    CHECK(fit.records[i].nmse == Approx(nmse(*all[i], together)).epsilon(1e-9));
    CHECK(fit.records[i].nmse_left_out == Approx(nmse(*all[i], own)).epsilon(1e-9));
    REQUIRE(fit.records[i].left_out.terms.size() == 3);
    CHECK(fit.records[i].left_out.terms[0].mean == Approx(own(0)).epsilon(1e-10));
  }
  const MatrixXd about = left_out.colwise() - left_out.rowwise().mean();
  const VectorXd jackknife = (about.rowwise().squaredNorm() * (2.0 / 3.0)).cwiseSqrt();
  CHECK((fit.std_over_records - jackknife).norm() < 1e-9 * jackknife.norm());
}

TEST_CASE("the tree of a merge depends on the number of records alone", "[ident][joint]") {
  for (const std::size_t count : {1u, 2u, 3u, 5u, 8u, 13u}) {
    std::vector<ident::RFactor> factors;
    for (std::size_t i = 0; i < count; ++i) factors.push_back(made(static_cast<unsigned>(i), 60, 1.0).record.white);
    const ident::RFactor whole = ident::merge(factors);
    CHECK(whole.num_samples == static_cast<Index>(60 * count));
    // What two processes that each have a power of two of them would send.
    if (count == 8) {
      const ident::RFactor first = ident::merge({factors.begin(), factors.begin() + 4}),
                           second = ident::merge({factors.begin() + 4, factors.end()});
      CHECK(ident::merge(first, second).R == whole.R);
    }
    CHECK(ident::merge(factors).R == whole.R);
  }
}

TEST_CASE("where a coefficient differs between records only the spread over them says so", "[ident][joint]") {
  std::vector<Made> parts;
  for (unsigned i = 0; i < 12; ++i)
    parts.push_back(made(i, 400, 0.5, Eigen::Vector3d(-50.0 + (i % 2 == 0 ? 1.0 : -1.0), -0.8, 0.3)));
  std::vector<const ident::RecordFactors*> records;
  for (const Made& part : parts) records.push_back(&part.record);
  const auto result = ident::joint_fit(records, {ident::FastRvmOptions{.selection = ident::Selection::evidence_white}});
  const ident::JointFit& fit = result.fits.front();
  REQUIRE(fit.model.terms.size() == 3);
  CHECK(fit.model.terms[0].name == "x");
  CHECK(fit.std_over_records(0) > 5.0 * fit.model.terms[0].std);  // 1 / sqrt(11)
  CHECK(fit.std_over_records(0) == Approx(1.0 / std::sqrt(11.0)).epsilon(0.2));
  CHECK(fit.std_over_records(1) < 5.0 * fit.model.terms[1].std);
}

TEST_CASE("which coefficients differ between records is found from their R factors", "[ident][joint][records]") {
  std::vector<Made> parts;
  for (unsigned i = 0; i < 4; ++i)
    parts.push_back(made(40 + i, 400, 0.5, Eigen::Vector3d(i % 2 == 0 ? -49.0 : -51.0, -0.8, 0.3)));
  std::vector<const ident::RecordFactors*> records;
  for (const Made& part : parts) records.push_back(&part.record);
  const auto result = ident::joint_fit(records, {ident::FastRvmOptions{}});
  const ident::JointFit& fit = result.fits.front();
  int own = 0, common = 0;
  for (const ident::ModelTerm& term : fit.model.terms) {
    if (term.recording == 0) {
      ++common;
      CHECK(term.name != "x");
      continue;
    }
    ++own;
    CHECK(term.name == "x");
    CHECK(term.recording_name == records[static_cast<std::size_t>(term.recording) - 1]->record);
    CHECK(std::abs(term.mean - (term.recording % 2 == 1 ? -49.0 : -51.0)) < 4.0 * term.std);
    CHECK(term.std == Approx(0.5 / 20.0).epsilon(0.2));
  }
  CHECK(own == 4);
  CHECK(common == 2);
  // Each record's error is the noise: 0.25 beside 49^2 + (0.8 * 20)^2; that of the others' mean misses x by 1 or more.
  for (const ident::RecordCheck& check : fit.records) {
    CHECK(check.nmse < 2e-4);
    CHECK(check.nmse_left_out > 3e-5);
    CHECK(check.left_out.terms.size() == 3);
  }
}

TEST_CASE("only candidates that all records have are fitted, of one target in one unit", "[ident][joint]") {
  Made a = made(1, 80, 0.1), b = made(2, 80, 0.1);
  b.record.terms[1].name = "v^2";
  const auto result = ident::joint_fit({&a.record, &b.record}, {ident::OlsOptions{}});
  CHECK(result.terms == std::vector<std::string>{"x", "1"});
  REQUIRE(result.left_out.size() == 2);
  CHECK(result.left_out[0] == "v (not in record 2)");
  CHECK(result.left_out[1] == "v^2 (not in record 1)");
  b.record.target_unit = "mm/s^2";
  support::check_fault(
      [&] {
        (void)ident::joint_fit({&a.record, &b.record}, {ident::OlsOptions{}});
      },
      dsp::FaultKind::input, "factors.target", {"record 2", "mm/s^2", "m/s^2"});
  Made c = made(3, 80, 0.1);
  for (auto& term : c.record.terms) term.name += "^3";
  support::check_fault(
      [&] {
        (void)ident::joint_fit({&a.record, &c.record}, {ident::OlsOptions{}});
      },
      dsp::FaultKind::input, "factors.terms", {"no candidate"});
}
