#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/ranges/ranges.hpp"

namespace ident {

/// The largest value of each cycle, from one upward passage through the mean to the next; a passage goes from more than
/// `noise_swing` below it to as much above: noise passes the mean many times where a motion passes it once.
[[nodiscard]] std::vector<double> crests(const Eigen::Ref<const Eigen::VectorXd>& displacement,
                                         double noise_swing = 0.0);

/// Of x, in every stretch without a gap of a range's rows. Cycles are told from noise of x, where that is known.
using Crests = std::vector<std::vector<double>>;
[[nodiscard]] Crests crests_of(const RangeRows& rows, const std::vector<Columns>& recordings);

/// How often crests that were lost came back: the sum of their rises, or of their falls where that is less, over the
/// largest of them; turns by less than `least` do not count. Trajectories of a plane do not cross, so crests of a
/// motion that x and v alone rule rise or fall for ever (successive crossings of a section are monotone, the lemma
/// behind the theorem of Poincare and Bendixson): what comes back is due to an input or to a further state.
[[nodiscard]] double renewed_amplitude(const std::vector<double>& crests, double least);

}  // namespace ident
