#pragma once
#include <vector>

#include "ident/evidence/evidence_rows.hpp"
#include "ident/selection/best_subsets.hpp"
#include "ident/selection/effective_size.hpp"
#include "ident/selection/state_space.hpp"
#include "ident/validate/independent_rows.hpp"

namespace ident {

/// Above this fraction of the rows a residual is white: chance correlations of white ones cost up to a tenth.
inline constexpr double white_enough = 0.9;

/// What the rows of a range are worth beside models of its candidates, by what these leave. Models have coefficients of
/// their own in each record; one misfit as a function of the state is expected in all.
class ModelSizes {
 public:
  /// All must outlive it.
  ModelSizes(const EvidenceRows& rows, const StateSpace& state, const IndependentRows& independence);
  [[nodiscard]] const RecordProblems& problems() const& { return problems_; }
  void problems() const&& = delete;
  [[nodiscard]] EffectiveSize of(const Subset& model) const;

 private:
  /// A record's candidates, and what probes beside them can tell of its target.
  struct Probed {
    RFactor candidates;
    Eigen::Index num_probes = 0;  ///< dimensions beyond the candidates
    double rss = 0.0;             ///< what candidates and probes leave of a target of unit norm
    Eigen::MatrixXd triangle;     ///< R of [Phi Z t]
  };
  [[nodiscard]] static std::vector<Probed> probed(const EvidenceRows& rows, const StateSpace& state);
  [[nodiscard]] static RecordProblems problems_of(const std::vector<Probed>& records, const EvidenceRows& rows);
  ModelSizes(const EvidenceRows& rows, const StateSpace& state, const IndependentRows& independence,
             const std::vector<Probed>& records);
  [[nodiscard]] double least_fraction(const Eigen::VectorXd& r) const;
  void set_revisits(const Eigen::VectorXd& left, EffectiveSize& size) const;
  /// What a model leaves, as a fraction of all targets' squares, beside all else of the candidates and the probes.
  struct Rest {
    double rss = 0.0, dimensions = 0.0;
  };
  [[nodiscard]] Rest beside_common_functions(const Subset& model) const;
  [[nodiscard]] double explained_by_extra_functions(const Subset& model, const EffectiveSize& size) const;

  const EvidenceRows& rows_;
  const IndependentRows& independence_;
  RecordProblems problems_;
  Eigen::Index most_probes_ = 0;  ///< of any record
  bool has_inputs_ = true;        ///< of the state
  double noise_fraction_ = 1.0;
  double rss_of_all_ = 0.0;                 ///< of one record
  std::vector<Eigen::MatrixXd> triangles_;  ///< of each of several: R of [Phi Z t]
  std::vector<RowPair> pairs_;
  Eigen::VectorXd all_leave_;     ///< the residual of all candidates
  double fraction_of_all_ = 1.0;  ///< by its autocorrelation
};

}  // namespace ident
