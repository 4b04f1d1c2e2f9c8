#pragma once
#include <Eigen/Core>
#include <vector>

#include "dsp/filter/fft.hpp"
#include "ident/columns/columns.hpp"
#include "ident/equation/model.hpp"
#include "ident/ranges/ranges.hpp"

namespace ident {

/// Whether a residual has something of a series where the motion is: noise of an acceleration lies mostly above, and
/// drowns in the whole band what is plain there. With spectra of the rows between gaps, each frequency up to which the
/// target is more than noise weighted by 1 / S, S the density that noise of the channels leaves in the residual at most
/// and sensors that are not quite linear beside it,
///     z = Re(c* W r) / sqrt(c* W c)
/// of what series c and residual r hold beyond the kept terms by the same weights: a standard normal deviate where
/// nothing but that noise is left over.
class MotionScore {
 public:
  /// `residual`: of the model, on rows of these recordings; all must outlive it.
  MotionScore(const Model& model, const std::vector<Row>& rows, const std::vector<Columns>& recordings,
              const Eigen::Ref<const Eigen::VectorXd>& residual);
  /// False: no noise is known, or there are no more frequencies than terms.
  [[nodiscard]] bool can_tell() const { return kept_.cols() > 0 && residual_.size() > 0; }
  struct Score {
    double z = 0.0;         ///< 0 too where the kept terms make up the series
    double fraction = 0.0;  ///< of the weighted power of the residual
    /// Twice the log likelihood that the series as a further term adds: by that noise z^2, and no more than by noise of
    /// whatever level the residual has, which may be above what the channels tell.
    double gain = 0.0;
  };
  /// `series`: a value per row.
  [[nodiscard]] Score of(const Eigen::Ref<const Eigen::VectorXd>& series) const;

 private:
  /// Rows between two gaps, but for the last few where the transform is fast without them.
  struct Piece {
    Eigen::Index first = 0;
    dsp::RealFft fft;
    Eigen::VectorXd window;  ///< Hann's
    Eigen::VectorXd weight;  ///< 1 / sqrt(S) from the first frequency above zero on
  };
  [[nodiscard]] Eigen::VectorXd weighted(const Eigen::Ref<const Eigen::VectorXd>& series) const;

  std::vector<Piece> pieces_;
  Eigen::MatrixXd kept_;      ///< an orthonormal basis of the weighted kept terms
  Eigen::VectorXd residual_;  ///< weighted, beyond them
};

}  // namespace ident
