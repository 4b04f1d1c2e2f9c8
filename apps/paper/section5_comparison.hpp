#pragma once
#include <string>
#include <utility>
#include <vector>

#include "apps/paper/paper_comparison.hpp"
#include "apps/paper/section5.hpp"

// The record behind Tables 9-12 of [QZS23] is not public, so nothing here can be refuted by computing it again.
// Verdicts say how the twin T1 by the paper's recipe compares, reasons what our own measurements say about the
// difference.

namespace apps {

inline constexpr const char* section5_methods[] = {"fast_rvm", "slow_rvm", "sindy"};

/// "same size" within a factor of `factor`, else "larger" or "smaller" than printed; "none" where ours is no number.
[[nodiscard]] std::string judge_size(double paper, double ours, double factor);
/// Coefficients: "same sign and size" (a factor of two), "same sign", "other sign", "not kept".
[[nodiscard]] std::string judge_scaled(double paper, double ours);

/// A term as one method finds it: means over the seeds that keep it; NaN where none does.
struct FoundTerm {
  double mean = 0.0, std = 0.0, mean_scaled = 0.0, std_scaled = 0.0, cov = 0.0, t = 0.0;
  std::string unit;
  int kept = 0, fits = 0;
};
/// NMSE and seconds, means over the seeds; free_run NaN where one of them has none.
struct FoundErrors {
  double train = 0.0, test = 0.0, free_run = 0.0, seconds = 0.0, noise_std = 0.0;
};

/// All fits of one regime, way and library.
class Section5View {
 public:
  Section5View(const Section5Replication& replication, const Section5Case& definition, const Section5Way& way,
               const std::string& candidates);
  [[nodiscard]] FoundTerm term(const std::string& method, const std::string& name) const;
  [[nodiscard]] FoundErrors errors(const std::string& method) const;
  /// Terms that a seed's fit by this method keeps, in library order.
  [[nodiscard]] std::vector<std::string> kept(const std::string& method) const;
  [[nodiscard]] double target_rms(bool train) const;  ///< of the first seed's training or test rows, m/s^2
  /// What the damping terms take out of steady motion at the largest amplitude, over the most that the base term can
  /// put in; no more than 1 in truth. NaN without a term in x, v or ddr.
  [[nodiscard]] double damping_over_supply(const std::string& method) const;

 private:
  [[nodiscard]] std::vector<const ident::JudgedFit*> fits(const std::string& method) const;
  std::vector<const Section5Fit*> fits_;
};

/// The same ratio for an equation in x, v and ddr whose columns have these largest magnitudes; coefficients in SI.
[[nodiscard]] double damping_over_supply(const std::vector<std::pair<std::string, double>>& terms, double x_max,
                                         double v_max, double ddr_max);
/// For the print: coefficients of columns that reach 1 in such motion.
[[nodiscard]] double printed_damping_over_supply(int table);

/// Coefficients of variation of F-RVM over those of S-RVM, the same posterior without its noise.
struct CovRatio {
  double mean = 0.0, spread = 0.0;  ///< over the terms; spread: greatest over least, minus 1
  double target_rms = 0.0;          ///< that the printed training error then implies
};
[[nodiscard]] CovRatio printed_cov_ratio(int table);

/// Every printed number of the tables of these regimes: rows of Table 9 have the regime as row and train or test as
/// term.
[[nodiscard]] std::vector<Comparison> compare_section5(const Section5Replication& replication,
                                                       const std::vector<const Section5Case*>& cases);

/// What differs and why, in sentences with our own measurements.
[[nodiscard]] std::vector<std::string> section5_reasons(const Section5Replication& replication,
                                                        const Section5Case& definition);

}  // namespace apps
