#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>

#include "kinds/record.hpp"

namespace {

using Eigen::ArrayXd;
constexpr std::uint64_t SEED = 20261127;

double rms(const ArrayXd& values) {
  return std::sqrt(values.square().mean());
}

/// What the terms of the label leave of the acceleration.
ArrayXd beside_label(const kinds::Record& record) {
  const ArrayXd &x = record.signals.x, &v = record.signals.v;
  const auto& p = record.law.polynomial;
  ArrayXd rest = record.signals.a - p[1] * x - p[2] * v - p[3] * x.square() - p[6] * x.cube() - p[7] * x.square() * v -
                 p[9] * v.cube() - record.law.friction * v.sign();
  if (record.signals.input.size() > 0) rest -= record.law.input_gain * record.signals.input;
  return rest;
}

}  // namespace

TEST_CASE("labelled kinds: the same seed draws the same record, another seed another", "[kinds]") {
  for (const std::uint64_t index : {0U, 3U}) {
    const kinds::Record first = kinds::draw_record(SEED, index), again = kinds::draw_record(SEED, index);
    REQUIRE(first.columns.size() == again.columns.size());
    for (std::size_t j = 0; j < first.columns.size(); ++j) {
      CHECK(first.columns[j].header == again.columns[j].header);
      CHECK((first.columns[j].values == again.columns[j].values).all());
    }
    CHECK(first.law.polynomial != kinds::draw_record(SEED + 1, index).law.polynomial);
  }
}

TEST_CASE("labelled kinds: a right label is the whole law, and energy that comes in is stored or lost", "[kinds]") {
  // linear, softening, asymmetric, bistable, cubic_damping, self_excited
  for (const std::uint64_t index : {0U, 4U, 6U, 8U, 14U, 18U}) {
    const kinds::Record record = kinds::draw_record(SEED, index);
    const ArrayXd &x = record.signals.x, &v = record.signals.v;
    const auto& p = record.law.polynomial;
    INFO(record.name);
    // Rounding alone, of terms up to some hundred times as large as their sum.
    CHECK(rms(beside_label(record)) < 1e-12 * rms(record.signals.a));
    CHECK(record.share_left < 1e-12);

    // d/dt (v^2 / 2 + potential) = v (damping + input), by Simpson's rule over the samples. Its error is (w dt)^4 / 180
    // of what flows; with 12 samples in a period and power at twice the frequency of the motion that is up to 0.7 %.
    ArrayXd power = v * (p[2] * v + p[7] * x.square() * v + p[9] * v.cube());
    if (record.signals.input.size() > 0) power += v * record.law.input_gain * record.signals.input;
    const ArrayXd energy = v.square() / 2 - p[1] * x.square() / 2 - p[3] * x.cube() / 3 - p[6] * x.pow(4) / 4;
    const Eigen::Index last = (x.size() - 1) / 2 * 2;
    double work = 0.0;
    for (Eigen::Index i = 0; i < last; i += 2) work += (power[i] + 4 * power[i + 1] + power[i + 2]) / 3;
    CHECK(std::abs(work / record.rate_hz - (energy[last] - energy[0])) < 0.007 * power.abs().sum() / record.rate_hz);
  }
}

TEST_CASE("labelled kinds: what a wrong label says to be missing is missing", "[kinds]") {
  for (const std::uint64_t index : {7U, 27U}) {  // quadratic_damping, x_abs_x
    const kinds::Record record = kinds::draw_record(SEED, index);
    const kinds::Law& law = record.law;
    const ArrayXd &x = record.signals.x, &v = record.signals.v, &a = record.signals.a;
    INFO(record.name);
    const bool spring = law.kind == "x_abs_x";
    const ArrayXd& moved = spring ? x : v;
    const double unit = (spring ? law.shape * law.omega * law.omega : 1.0) * law.strength / law.x_scale;
    const ArrayXd missing = -unit * moved.abs() * moved;
    CHECK(rms(beside_label(record) - missing) < 1e-12 * rms(a));  // rounding
    CHECK(record.share_term == Approx(rms(missing) / rms(a)).epsilon(1e-12));
    // The normal equations beside the label's QR: they lose the square of a condition number below 1e4.
    const Eigen::MatrixXd columns = kinds::library_columns(record.signals);
    const Eigen::VectorXd best = (columns.transpose() * columns).ldlt().solve(columns.transpose() * a.matrix());
    CHECK(record.share_left == Approx(rms(a - (columns * best).array()) / rms(a)).epsilon(1e-6));
    CHECK((record.share_left >= 0.02 && record.share_left <= 0.5));
  }
}
