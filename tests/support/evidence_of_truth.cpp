#include "support/evidence_of_truth.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/filter/fft.hpp"
#include "dsp/prepare.hpp"
#include "ident/columns/columns.hpp"
#include "support/labelled_oscillator.hpp"

namespace support {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Samples [first, last).
struct Run {
  Index first = 0, last = 0;
};

std::vector<Run> runs_of(const std::vector<ident::Row>& rows) {
  constexpr Index least = 64;
  std::vector<Run> runs;
  for (const ident::Row& row : rows) {
    if (runs.empty() || runs.back().last != row.sample) runs.push_back({row.sample, row.sample});
    ++runs.back().last;
  }
  std::erase_if(runs, [](const Run& run) { return run.last - run.first < least; });
  return runs;
}

dsp::Prepared prepared(const LabelledRecord& record, double noise, std::uint32_t seed) {
  std::vector<std::string> names;
  for (const auto& channel : record.recording.channels) names.push_back(channel.name);
  return dsp::prepare(recorded(record.exact, names, noise, seed), record.prepare);
}

/// A column for each term, the target behind them.
MatrixXd columns_of(const dsp::Prepared& from, const std::vector<std::string>& terms) {
  const auto library = ident::make_library({.order = 0, .terms = terms}, "a", from.signals);
  const ident::Columns columns = ident::form_columns(library, "a", from);
  MatrixXd all(columns.phi.rows(), std::ssize(terms) + 1);
  for (std::size_t j = 0; j < terms.size(); ++j)
    for (std::size_t i = 0; i < library.terms.size(); ++i)
      if (library.terms[i].name == terms[j]) all.col(static_cast<Index>(j)) = columns.phi.col(static_cast<Index>(i));
  all.rightCols(1) = columns.target;
  return all;
}

/// Spectra of series under Hann's window on each run, up to the cut-off, real and imaginary parts one below the other.
class Spectra {
 public:
  Spectra(std::vector<Run> runs, double rate_hz, double cutoff_hz) : runs_(std::move(runs)) {
    for (const Run& run : runs_) {
      const Index n = run.last - run.first;
      bins_.push_back(std::max<Index>(0, static_cast<Index>(cutoff_hz * static_cast<double>(n) / rate_hz) - 1));
      total_ += bins_.back();
    }
  }
  [[nodiscard]] Index num_bins() const { return total_; }
  [[nodiscard]] MatrixXd of(const MatrixXd& series) const {
    MatrixXd result(2 * total_, series.cols());
    Index at = 0;
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      const Index n = runs_[r].last - runs_[r].first;
      const dsp::RealFft fft(n);
      const VectorXd window = dsp::hann_window(n);
      for (Index j = 0; j < series.cols(); ++j) {
        VectorXd x = series.col(j).segment(runs_[r].first, n);
        x.array() -= x.mean();
        const Eigen::VectorXcd X = fft.forward(x.cwiseProduct(window));
        for (Index k = 0; k < bins_[r]; ++k) {
          result(2 * (at + k), j) = X(k + 1).real();
          result(2 * (at + k) + 1, j) = X(k + 1).imag();
        }
      }
      at += bins_[r];
    }
    return result;
  }
  /// Power in each row of the above, smoothed over neighbouring frequencies.
  [[nodiscard]] VectorXd smoothed(const VectorXd& power) const {
    constexpr Index half_width = 2;
    VectorXd result(2 * total_);
    Index at = 0;
    for (const Index count : bins_) {
      for (Index k = 0; k < count; ++k) {
        const Index first = std::max<Index>(0, k - half_width), last = std::min(count, k + half_width + 1);
        const double mean = power.segment(2 * (at + first), 2 * (last - first)).mean();
        result(2 * (at + k)) = result(2 * (at + k) + 1) = mean;
      }
      at += count;
    }
    return result;
  }

 private:
  std::vector<Run> runs_;
  std::vector<Index> bins_;
  Index total_ = 0;
};

VectorXd coefficients(const WrittenEquation& equation) {
  VectorXd values(std::ssize(equation));
  for (std::size_t i = 0; i < equation.size(); ++i) values(static_cast<Index>(i)) = equation[i].second;
  return values;
}

std::vector<std::string> terms_of(const WrittenEquation& equation) {
  std::vector<std::string> names;
  for (const auto& [name, value] : equation) names.push_back(name);
  return names;
}

}  // namespace

EvidenceOfTruth evidence_of_truth(const LabelledRecord& record, const std::vector<ident::Row>& rows,
                                  const WrittenEquation& found) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  if (record.noise == 0.0 || found.empty()) return {infinite, infinite};
  LabelledRecord sensed = record;  // with what the truth needs among its channels: z, f
  for (const auto& [name, value] : record.truth) {
    const auto& channels = record.recording.channels;
    const bool is_channel = name == "f" || name == "z";
    if (is_channel && std::none_of(channels.begin(), channels.end(), [&](const auto& one) { return one.name == name; }))
      sensed.recording.channels.push_back({.name = name, .role = dsp::role_from_string(name), .unit = "N"});
  }
  WrittenEquation smooth;  // the true terms that noise moves by their slopes
  for (const auto& term : record.truth)
    if (!term.first.starts_with("sgn")) smooth.push_back(term);

  const dsp::Prepared clean = prepared(sensed, 0.0, 1), noisy = dsp::prepare(record.recording, record.prepare);
  const Spectra spectra(runs_of(rows), clean.signals.sample_rate_hz, record.prepare.cutoff_hz);
  if (spectra.num_bins() == 0) return {infinite, infinite};
  const auto residual = [&](const dsp::Prepared& of, const WrittenEquation& equation) -> VectorXd {
    const MatrixXd columns = columns_of(of, terms_of(equation));
    return columns.rightCols(1) - columns.leftCols(columns.cols() - 1) * coefficients(equation);
  };
  const VectorXd rest = residual(clean, smooth);
  constexpr std::uint32_t draws = 12;
  VectorXd power = VectorXd::Zero(spectra.of(rest).rows());
  for (std::uint32_t draw = 0; draw < draws; ++draw)
    power += spectra.of(residual(prepared(sensed, record.noise, 900001 + draw), smooth) - rest).cwiseAbs2() / draws;
  const VectorXd weight = spectra.smoothed(power).cwiseSqrt().cwiseInverse();

  const MatrixXd kept = columns_of(clean, terms_of(found));
  const MatrixXd truth = columns_of(clean, terms_of(record.truth));
  const VectorXd law = truth.leftCols(truth.cols() - 1) * coefficients(record.truth);
  const MatrixXd K = weight.asDiagonal() * spectra.of(kept.leftCols(kept.cols() - 1));
  const VectorXd y = weight.asDiagonal() * spectra.of(law);
  EvidenceOfTruth result;
  result.least = (y - K * K.colPivHouseholderQr().solve(y)).squaredNorm();
  const VectorXd of_found = weight.asDiagonal() * spectra.of(residual(noisy, found));
  VectorXd true_rest = residual(prepared(sensed, record.noise, record.seed), smooth);
  for (std::size_t j = 0; j < record.truth.size(); ++j)  // signs where they truly are
    if (record.truth[j].first.starts_with("sgn"))
      true_rest -= record.truth[j].second * truth.col(static_cast<Index>(j));
  const VectorXd of_true = weight.asDiagonal() * spectra.of(true_rest);
  // Twice what noise makes of it: the truth is no function of the state here, where friction holds the body.
  const bool truth_fails = of_true.squaredNorm() > 2.0 * static_cast<double>(of_true.size());
  result.of_this = truth_fails ? infinite : of_found.squaredNorm() - of_true.squaredNorm();
  return result;
}

}  // namespace support
