#pragma once
#include <Eigen/Core>
#include <utility>
#include <vector>

#include "dsp/filter/short_low_pass.hpp"
#include "dsp/prepare.hpp"
#include "dsp/prepare/filtered_stretch.hpp"
#include "ident/library/library.hpp"
#include "ident/switches/crossings.hpp"

namespace ident {

/// Terms of one recording as a recorder would have delivered them: formed in continuous time, where sgn(g), abs(g) and
/// comparisons switch at the very time at which g passes zero, then sampled at the intermediate rate behind an
/// anti-alias filter. Jumps and kinks keep their times between two samples, and products of band-limited signals are
/// formed at a rate at which they do not fold into the band of the regressor columns. Two zeros closer than a tenth of
/// a wave of the state band's end may go unseen.
class ExactSwitches {
 public:
  /// For all terms of a library, with their switches where the prepared signals have their zeros. `prepared` must
  /// outlive it.
  ExactSwitches(const dsp::Prepared& prepared, const CandidateLibrary& library);
  /// Places the switches again under an equation, whose jumps the state band has rounded (crossings.hpp).
  void settle(const WeightedTerms& equation);
  /// From now on columns are wanted within this stretch only: beside it they and the switches may be anything.
  void limit_to(const dsp::Stretch& wanted);
  [[nodiscard]] const dsp::Stretch& wanted() const& { return wanted_; }
  void wanted() const&& = delete;
  /// Frees what they were placed with, once every column is formed: they are to be placed under no equation next.
  void release() { crossings_.release(); }
  /// Whether columns that depend on the equation are to be formed again before they are used under this one: it has
  /// terms, or the one they were formed under last had, or that was within a stretch which does not hold the wanted
  /// one.
  [[nodiscard]] bool must_form(const WeightedTerms& equation) const;
  /// Of each sample at the intermediate rate, the fraction for which terms act; beside that they are zero.
  void act_for(Eigen::VectorXd fraction) { acting_ = std::move(fraction); }
  /// A signal's samples, or a term's, as far as it acts.
  [[nodiscard]] Eigen::VectorXd acting(Eigen::VectorXd samples) const;
  [[nodiscard]] const Eigen::VectorXd& acting_fraction() const& { return acting_; }  ///< empty: all of each
  void acting_fraction() const&& = delete;
  [[nodiscard]] const dsp::Prepared& prepared() const& { return prepared_; }
  void prepared() const&& = delete;
  [[nodiscard]] const Crossings& crossings() const& { return crossings_; }
  void crossings() const&& = delete;
  /// Whether the term's column depends on the equation.
  [[nodiscard]] bool depends_on_equation(const Expression& term) const;
  /// The term at the intermediate rate, below the end of the column filter's band. Samples that are not
  /// finite are replaced by 0; those outside the wanted interval are unspecified.
  [[nodiscard]] Eigen::VectorXd samples(const Expression& term) const;

 private:
  [[nodiscard]] Eigen::Index rate_factor(const Expression& term) const;
  [[nodiscard]] std::vector<double> breaks(const Expression& term) const;
  void sharpen(const Crossings::Bound& bound, const std::vector<double>& times, const dsp::ShortLowPass& low_pass,
               double rate_hz, Eigen::Index first, Eigen::VectorXd& values) const;

  const dsp::Prepared& prepared_;
  Crossings crossings_;
  bool has_equation_ = false;     ///< they were placed under one
  dsp::Stretch wanted_, formed_;  ///< formed_: wanted when they were placed last
  Eigen::VectorXd acting_;
  double stop_hz_;  ///< columns are gone from here on
};

}  // namespace ident
