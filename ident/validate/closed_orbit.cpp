#include "ident/validate/closed_orbit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "dsp/filter/strongest_line.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/linear.hpp"
#include "ident/equation/interval_95.hpp"
#include "ident/ranges/rows_of_terms.hpp"

namespace ident {
namespace {

using dsp::two_pi;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index most_harmonics = 40;

/// Harmonics of one frequency and a slow course beside them, fitted to series at these times.
class Comb {
 public:
  Comb(VectorXd times, double hz, Index num_harmonics) : times_(std::move(times)), hz_(hz) {
    const double middle = 0.5 * (times_.minCoeff() + times_.maxCoeff()), half = times_.maxCoeff() - middle;
    const VectorXd u = (times_.array() - middle) / half;
    shapes_.resize(times_.size(), slow + 2 * num_harmonics);
    for (Index power = 0; power < slow; ++power) shapes_.col(power) = u.array().pow(static_cast<double>(power));
    for (Index k = 1; k <= num_harmonics; ++k) {
      const Eigen::ArrayXd phase = two_pi * hz * static_cast<double>(k) * times_.array();
      shapes_.col(slow + 2 * k - 2) = phase.cos();
      shapes_.col(slow + 2 * k - 1) = phase.sin();
    }
    products_ = shapes_.transpose() * shapes_;
  }
  /// Cosine and sine of harmonics 1, 2, ...
  [[nodiscard]] VectorXd lines(const VectorXd& series) const { return fit(series).tail(shapes_.cols() - slow); }
  [[nodiscard]] VectorXd remainder(const VectorXd& series) const { return series - shapes_ * fit(series); }
  /// The frequency with which the harmonics fit better, by a step of Gauss and Newton.
  [[nodiscard]] double better_hz(const VectorXd& series) const {
    const VectorXd lines_of = fit(series);
    VectorXd change = VectorXd::Zero(times_.size());  // by a hertz
    for (Index k = 1; slow + 2 * k <= shapes_.cols(); ++k)
      change.array() += two_pi * static_cast<double>(k) * times_.array() *
                        (lines_of(slow + 2 * k - 1) * shapes_.col(slow + 2 * k - 2) -
                         lines_of(slow + 2 * k - 2) * shapes_.col(slow + 2 * k - 1))
                            .array();
    const VectorXd own = remainder(change);
    return hz_ + own.dot(series) / own.squaredNorm();
  }
  /// Mean power of a line of the remainder between two harmonics and around one.
  [[nodiscard]] double noise_at(const VectorXd& rest, Index harmonic) const {
    constexpr std::array between{-0.4, -0.3, -0.2, 0.2, 0.3, 0.4};
    double sum = 0.0;
    for (const double beside : between) {
      const Eigen::ArrayXd phase = two_pi * hz_ * (static_cast<double>(harmonic) + beside) * times_.array();
      sum += std::pow((phase.cos() * rest.array()).sum(), 2) + std::pow((phase.sin() * rest.array()).sum(), 2);
    }
    return sum / static_cast<double>(between.size()) * std::pow(2.0 / static_cast<double>(times_.size()), 2);
  }

 private:
  static constexpr Index slow = 4;  // a cubic
  [[nodiscard]] VectorXd fit(const VectorXd& series) const {
    return dsp::solve_symmetric(products_, shapes_.transpose() * series);
  }
  VectorXd times_;
  double hz_;
  MatrixXd shapes_, products_;
};

/// About as many rows as tell the lines, over all of the time, without a period that harmonics could be folded by.
std::vector<Row> thinned(const std::vector<Row>& rows) {
  constexpr std::size_t enough = 20'000;
  constexpr double golden = 0.6180339887498949;
  const std::size_t step = 1 + rows.size() / enough;
  std::vector<Row> result;
  for (std::size_t i = 0; i * step < rows.size(); ++i) {
    const double turn = golden * static_cast<double>(i);
    const auto at = i * step + static_cast<std::size_t>((turn - std::floor(turn)) * static_cast<double>(step));
    if (at < rows.size()) result.push_back(rows[at]);
  }
  return result;
}

VectorXd times_of(const std::vector<Row>& rows, double rate_hz) {
  VectorXd times(std::ssize(rows));
  for (Index i = 0; i < times.size(); ++i)
    times(i) = static_cast<double>(rows[static_cast<std::size_t>(i)].sample) / rate_hz;
  return times;
}

VectorXd on(const std::vector<Row>& rows, const VectorXd& samples) {
  VectorXd values(std::ssize(rows));
  for (Index i = 0; i < values.size(); ++i) values(i) = samples(rows[static_cast<std::size_t>(i)].sample);
  return values;
}

dsp::IndexRange longest_stretch(const std::vector<Row>& rows) {
  dsp::IndexRange longest;
  for (Index first = 0, end = 0; first < std::ssize(rows); first = end) {
    end = end_of_stretch(rows, first, std::ssize(rows));
    if (end - first > longest.last - longest.first) longest = {first, end};
  }
  return longest;
}

/// Whether nothing stands out of what the harmonics leave of x, on successive rows.
bool is_noise(const VectorXd& rest, double rate_hz, double band_hz) {
  const double num_lines = band_hz * static_cast<double>(rest.size()) / rate_hz;
  // Of five neighbours among lines of white noise in the band, whose power is a gamma variate of five, some hold as
  // much as 25 lines have on average in one record of a thousand.
  constexpr double least = 100.0, stands_out = 25.0;
  return num_lines >= least && dsp::strongest_line(rest, rate_hz).fraction * num_lines < stands_out;
}

/// The frequency of the orbit that x on these rows is; 0: it is none.
double orbit_hz(const std::vector<Row>& rows, const Columns& recording) {
  constexpr double least_periods = 8.0;
  constexpr double next_to_nothing = 1e-4;  // of the power of x: 1 % of its amplitude
  constexpr int rounds = 6;
  constexpr Index few = 5;  // harmonics that settle the frequency
  const dsp::Motion& motion = *recording.signals;
  const VectorXd& samples = motion.find("x")->values;
  const double rate_hz = motion.sample_rate_hz;
  const dsp::IndexRange stretch = longest_stretch(rows);
  const std::vector<Row> longest(rows.begin() + stretch.first, rows.begin() + stretch.last);
  if (longest.size() < 2) return 0.0;
  const VectorXd of_longest = on(longest, samples);
  const double strongest = dsp::strongest_line(of_longest, rate_hz).frequency_hz;
  if (!(strongest * static_cast<double>(longest.size()) >= least_periods * rate_hz)) return 0.0;
  const std::vector<Row> all = thinned(rows), part = thinned(longest);
  const VectorXd x = on(all, samples);
  const double power = (x.array() - x.mean()).square().sum();
  for (const double times : {1.0, 2.0, 3.0}) {  // a subharmonic may be weaker
    double hz = strongest / times;
    for (const std::vector<Row>* some : {&part, &all})
      for (int i = 0; i < rounds; ++i) hz = Comb(times_of(*some, rate_hz), hz, few).better_hz(on(*some, samples));
    if (!(std::abs(hz * times - strongest) < 0.1 * strongest)) continue;
    const auto num = std::min(most_harmonics, static_cast<Index>(0.5 * rate_hz / hz) - 1);
    if (num < 1) continue;
    if (Comb(times_of(all, rate_hz), hz, num).remainder(x).squaredNorm() <= next_to_nothing * power) return hz;
    if (part.size() == longest.size() &&
        is_noise(Comb(times_of(longest, rate_hz), hz, num).remainder(of_longest), rate_hz, recording.band_hz))
      return hz;
  }
  return 0.0;
}

/// Below which the chi-square of so many degrees of freedom stays in 99 of 100 cases (Wilson and Hilferty).
double chi_square_99(double freedom) {
  constexpr double deviate = 2.326;
  const double part = 2.0 / (9.0 * freedom);
  return freedom * std::pow(1.0 - part + deviate * std::sqrt(part), 3);
}

/// Least squares on some candidates of an orbit's equations.
struct OrbitFit {
  VectorXd mean, std;
  double chi_square = 0.0;
};
OrbitFit fit_of(const MatrixXd& products, const std::vector<Index>& terms) {
  const Index k = std::ssize(terms), target = products.rows() - 1;
  MatrixXd own(k, k);
  VectorXd right(k);
  for (Index i = 0; i < k; ++i) {
    right(i) = products(terms[static_cast<std::size_t>(i)], target);
    for (Index j = 0; j < k; ++j)
      own(i, j) = products(terms[static_cast<std::size_t>(i)], terms[static_cast<std::size_t>(j)]);
  }
  const VectorXd scale = own.diagonal().cwiseSqrt().cwiseMax(std::numeric_limits<double>::min());
  const MatrixXd even = scale.cwiseInverse().asDiagonal() * own * scale.cwiseInverse().asDiagonal();
  const VectorXd scaled = dsp::solve_symmetric(even, right.cwiseQuotient(scale));
  OrbitFit result{scaled.cwiseQuotient(scale), {}, products(target, target) - scaled.dot(right.cwiseQuotient(scale))};
  result.std = dsp::inverse_of_symmetric(even).diagonal().cwiseMax(0.0).cwiseSqrt().cwiseQuotient(scale);
  return result;
}

/// The next choice of as many of n in order; false behind the last.
bool advance(std::vector<Index>& chosen, Index n) {
  for (Index i = std::ssize(chosen) - 1; i >= 0; --i) {
    if (chosen[static_cast<std::size_t>(i)] >= n - std::ssize(chosen) + i) continue;
    Index value = ++chosen[static_cast<std::size_t>(i)];
    for (Index j = i + 1; j < std::ssize(chosen); ++j) chosen[static_cast<std::size_t>(j)] = ++value;
    return true;
  }
  return false;
}

}  // namespace

std::optional<ClosedOrbit> closed_orbit(const std::vector<Row>& rows, const std::vector<Columns>& recordings,
                                        const std::vector<Index>& terms) {
  if (rows.empty() || rows.front().recording != rows.back().recording) return std::nullopt;
  const Columns& recording = recordings[rows.front().recording];
  if (recording.prepared == nullptr || recording.signals->find("x") == nullptr) return std::nullopt;
  const double hz = orbit_hz(rows, recording);
  const double rate_hz = recording.signals->sample_rate_hz, top_hz = std::min(recording.band_hz, 0.5 * rate_hz);
  const auto num = std::min(most_harmonics, static_cast<Index>(hz > 0.0 ? top_hz / hz : 0.0));
  if (num < 1) return std::nullopt;
  const std::vector<Row> some = thinned(rows);
  const Comb comb(times_of(some, rate_hz), hz, num);
  const VectorXd target = on(some, recording.target), rest = comb.remainder(target), of_target = comb.lines(target);
  constexpr double above = 10.0;  // six lines beside it are exceeded so far by noise in one of 350
  ClosedOrbit orbit{.hz = hz, .num_candidates = std::ssize(terms)};
  std::vector<std::pair<Index, double>> found;  // harmonics, standard deviation
  for (Index k = 1; k <= num; ++k) {
    const double noise = comb.noise_at(rest, k), power = of_target.segment(2 * k - 2, 2).squaredNorm();
    if (power > above * noise && noise > 0.0) found.emplace_back(k, std::sqrt(0.5 * noise));
  }
  orbit.num_lines = std::ssize(found);
  if (orbit.num_lines == 0 || orbit.num_equations() >= orbit.num_candidates) return std::nullopt;
  orbit.equations.resize(orbit.num_equations(), orbit.num_candidates + 1);
  const RowsOfTerms columns(some, recordings, terms);
  MatrixXd values(std::ssize(some), orbit.num_candidates);
  columns.read(0, values);
  for (Index j = 0; j <= orbit.num_candidates; ++j) {
    const VectorXd lines = j < orbit.num_candidates ? comb.lines(values.col(j)) : of_target;
    for (Index i = 0; i < orbit.num_lines; ++i) {
      const auto [k, std] = found[static_cast<std::size_t>(i)];
      orbit.equations.col(j).segment(2 * i, 2) = lines.segment(2 * k - 2, 2) / std;
    }
  }
  return orbit;
}

std::optional<VectorXd> stds_of_orbit(const ClosedOrbit& orbit, const std::vector<Index>& kept,
                                      const Eigen::Ref<const VectorXd>& means) {
  constexpr Index oscillator = 4, most = 6;  // of 25 candidates 177,100 choices
  const Index largest = std::min(
      {std::max(oscillator, std::ssize(kept)), orbit.num_candidates, orbit.num_candidates > 25 ? oscillator : most});
  if (orbit.num_equations() <= std::max(largest, std::ssize(kept))) return std::nullopt;
  const MatrixXd products = orbit.equations.transpose() * orbit.equations;
  const auto freedom = [&](Index terms) { return static_cast<double>(orbit.num_equations() - terms); };
  // Where the kept terms do not fit to noise either, what fits as badly as they do fits as well.
  const double misfit =
      kept.empty() ? 1.0 : std::max(1.0, fit_of(products, kept).chi_square / freedom(std::ssize(kept)));
  VectorXd half = VectorXd::Zero(std::ssize(kept));
  for (Index size = 1; size <= largest; ++size) {
    std::vector<Index> chosen(static_cast<std::size_t>(size));
    for (Index i = 0; i < size; ++i) chosen[static_cast<std::size_t>(i)] = i;
    do {
      const OrbitFit fit = fit_of(products, chosen);
      if (!fit.mean.allFinite() || fit.chi_square > misfit * chi_square_99(freedom(size))) continue;
      for (Index j = 0; j < half.size(); ++j) {
        const auto at = std::find(chosen.begin(), chosen.end(), kept[static_cast<std::size_t>(j)]);
        const Index i = at - chosen.begin();
        const double off = at == chosen.end()
                               ? std::abs(means(j))
                               : std::abs(fit.mean(i) - means(j)) + interval_95 * std::sqrt(misfit) * fit.std(i);
        half(j) = std::max(half(j), off);
      }
    } while (advance(chosen, orbit.num_candidates));
  }
  return half / interval_95;
}

double share_along_motion(const std::vector<Row>& rows, const std::vector<Columns>& recordings) {
  MatrixXd beside(std::ssize(rows), 4);  // 1, x, v; f
  beside.col(0).setOnes();
  for (Index i = 0; i < beside.rows(); ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    const dsp::Motion& motion = *recordings[row.recording].signals;
    for (Index j = 1; j < 4; ++j) {
      const dsp::Signal* const signal = motion.find(j == 1 ? "x" : j == 2 ? "v" : "f");
      if (signal == nullptr) return 0.0;
      beside(i, j) = signal->values(row.sample);
    }
  }
  if (beside.rows() < beside.cols()) return 0.0;
  const auto f = beside.col(3);
  const double all = (f.array() - f.mean()).square().sum();
  const double left_over = dsp::Qr(beside).triangle()(3, 3);
  return all > 0.0 ? 1.0 - left_over * left_over / all : 0.0;
}

}  // namespace ident
