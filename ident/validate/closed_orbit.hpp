#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/ranges/ranges.hpp"

namespace ident {

/// Rows that show one closed orbit only, a steady sine or a limit cycle, with fewer independent equations than there
/// are candidates. Of a periodic motion every term is periodic: at each spectral line a linear equation has a real and
/// an imaginary part, and nothing between the lines. However many samples there are, they repeat these.
struct ClosedOrbit {
  double hz = 0.0;  ///< once round
  Eigen::Index num_lines = 0, num_candidates = 0;
  /// Of the candidates and the target behind them, a row for each part of each line, over the standard deviation of the
  /// target's noise there: 2 num_lines x (num_candidates + 1).
  Eigen::MatrixXd equations;
  [[nodiscard]] Eigen::Index num_equations() const { return 2 * num_lines; }
};

/// Of rows of one recording that has an x; nothing where they are no closed orbit, or one of as many equations as
/// candidates. It is one where x is a sum of the harmonics of one frequency (and a slow drift of its sensor), but for
/// what is a ten-thousandth of its power or has no line that stands out of its noise. Lines are those of the target,
/// in the band of the columns, with ten times the power that lies between them. `terms`: candidates, columns of the
/// recordings.
[[nodiscard]] std::optional<ClosedOrbit> closed_orbit(const std::vector<Row>& rows,
                                                      const std::vector<Columns>& recordings,
                                                      const std::vector<Eigen::Index>& terms);

/// Which share of the variance of the recorded force f on these rows 1, x and v explain; 0 where there is none. Of a
/// motion and a force that share one frequency it is all, however the amplitude comes and goes, and whether the force
/// drives the motion or a machine imposes it.
inline constexpr double mostly_along_motion = 0.5;
[[nodiscard]] double share_along_motion(const std::vector<Row>& rows, const std::vector<Columns>& recordings);

/// To what standard deviation the coefficients of kept candidates (positions) are known by a closed orbit: the 95 %
/// intervals by which they are in every equation of up to four candidates, or as many as are kept, that fits its lines
/// as well, zero where it is in none. An oscillator has a spring, a damper, a force and one nonlinear term. Nothing
/// where so few terms always fit: as many equations as terms.
[[nodiscard]] std::optional<Eigen::VectorXd> stds_of_orbit(const ClosedOrbit& orbit,
                                                           const std::vector<Eigen::Index>& kept,
                                                           const Eigen::Ref<const Eigen::VectorXd>& means);

}  // namespace ident
