#include <Eigen/QR>
#include <catch2/catch.hpp>
#include <cmath>

#include "kinds/record.hpp"

namespace {

constexpr std::uint64_t SEED = 20261127;

/// The first record of this kind that `fits`.
template <class Fits>
kinds::Record record_of(const std::string& kind, const Fits& fits) {
  for (std::uint64_t seed = SEED;; ++seed)
    for (std::uint64_t i = 0; i < 36; ++i) {
      const bool right = i % 2 == 0;
      if ((right ? kinds::RIGHT[i / 2 % kinds::RIGHT.size()] : kinds::WRONG[i / 2 % kinds::WRONG.size()]) != kind)
        continue;
      kinds::Record record = kinds::draw_record(seed, i);
      if (fits(record)) return record;
    }
}
kinds::Record record_of(const std::string& kind) {
  return record_of(kind, [](const kinds::Record&) { return true; });
}

Eigen::Map<const Eigen::ArrayXd> array_of(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}
double rms(const Eigen::ArrayXd& values) {
  return std::sqrt(values.square().mean());
}

/// What the candidates that the label names leave of the acceleration.
Eigen::ArrayXd beside_label(const kinds::Record& record) {
  const auto x = array_of(record.signals.x), v = array_of(record.signals.v);
  const auto& p = record.law.polynomial;
  Eigen::ArrayXd rest = array_of(record.signals.a) - p[1] * x - p[2] * v - p[3] * x.square() - p[6] * x.cube() -
                        p[7] * x.square() * v - p[9] * v.cube() - record.law.friction * v.sign();
  if (!record.signals.input.empty()) rest -= record.law.input_gain * array_of(record.signals.input);
  return rest;
}

/// The share that a pivoted QR of scaled columns leaves: a second computation of the label's.
double share_by_qr(const kinds::Record& record) {
  const auto columns = kinds::library_columns(record.signals);
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(columns.front().size()), static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index j = 0; j < matrix.cols(); ++j) matrix.col(j) = array_of(columns[static_cast<std::size_t>(j)]);
  for (Eigen::Index j = 0; j < matrix.cols(); ++j) matrix.col(j) /= matrix.col(j).norm();
  const Eigen::VectorXd a = array_of(record.signals.a).matrix();
  return (a - matrix * matrix.colPivHouseholderQr().solve(a)).norm() / a.norm();
}

}  // namespace

TEST_CASE("labelled kinds: the same seed draws the same record, another seed another", "[kinds]") {
  for (const std::uint64_t index : {0U, 3U}) {
    const kinds::Record first = kinds::draw_record(SEED, index), again = kinds::draw_record(SEED, index),
                        other = kinds::draw_record(SEED + 1, index);
    REQUIRE(first.columns.size() == again.columns.size());
    for (std::size_t j = 0; j < first.columns.size(); ++j) {
      CHECK(first.columns[j].header == again.columns[j].header);
      CHECK(first.columns[j].values == again.columns[j].values);
    }
    CHECK(first.law.polynomial != other.law.polynomial);
  }
}

TEST_CASE("labelled kinds: a right label is the whole law", "[kinds]") {
  for (const std::string_view kind : {"linear", "softening", "asymmetric", "cubic_damping", "self_excited"}) {
    const kinds::Record record = record_of(std::string(kind));
    INFO(record.name);
    // The acceleration is evaluated from the same state: rounding alone, of terms that may cancel.
    CHECK(rms(beside_label(record)) < 1e-12 * rms(array_of(record.signals.a)) * 100);
    CHECK(record.share_left < 1e-9);
  }
}

TEST_CASE("labelled kinds: what a wrong label says to be missing is missing", "[kinds]") {
  for (const std::string_view kind : {"quadratic_damping", "x_abs_x"}) {
    const kinds::Record record = record_of(std::string(kind));
    INFO(record.name);
    const auto& law = record.law;
    const auto x = array_of(record.signals.x), v = array_of(record.signals.v);
    const Eigen::ArrayXd missing =
        kind == "x_abs_x"
            ? Eigen::ArrayXd(-law.shape * law.strength * law.omega * law.omega / law.x_scale * x.abs() * x)
            : Eigen::ArrayXd(-law.strength / law.x_scale * v.abs() * v);
    const double whole = rms(array_of(record.signals.a));
    CHECK(rms(beside_label(record) - missing) < 1e-10 * whole);  // rounding
    CHECK(record.share_term == Approx(rms(missing) / whole).epsilon(1e-9));
    // Two stable orthogonalisations of at most 12 columns with condition numbers far below 1e6.
    CHECK(record.share_left == Approx(share_by_qr(record)).epsilon(1e-6));
    CHECK(record.share_left >= 0.02);
    CHECK(record.share_left <= 0.5);
  }
}

TEST_CASE("labelled kinds: energy that comes in is stored or lost", "[kinds]") {
  // d/dt (v^2 / 2 + potential) = v (damping, friction, input), integrated by Simpson's rule over the samples.
  for (const std::string_view kind : {"hardening", "bistable"}) {
    const kinds::Record record = record_of(std::string(kind), [](const kinds::Record& r) {
      return r.drive != "decay" && r.rate_hz > 40.0 * r.natural_hz;
    });
    INFO(record.name);
    const auto x = array_of(record.signals.x), v = array_of(record.signals.v), input = array_of(record.signals.input);
    const auto& p = record.law.polynomial;
    const Eigen::ArrayXd energy = v.square() / 2 - p[1] * x.square() / 2 - p[6] * x.pow(4) / 4,
                         power = v * (p[2] * v + record.law.input_gain * input);
    const Eigen::Index last = (x.size() - 1) / 2 * 2;
    double work = 0.0;
    for (Eigen::Index i = 0; i < last; i += 2)
      work += (power[i] + 4 * power[i + 1] + power[i + 2]) / (3 * record.rate_hz);
    // 20 samples and more in a period of twice the natural frequency: Simpson's error is below 1e-3 of what flows.
    CHECK(std::abs(work - (energy[last] - energy[0])) < 1e-3 * power.abs().sum() / record.rate_hz);
  }
}
