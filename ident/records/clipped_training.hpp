#pragma once
#include <vector>

#include "ident/records/record.hpp"

namespace ident {

/// Throws dsp::Fault sample.clipped (input) where a channel is clipped for more than `max_share` of a range's training
/// stretch, from its beginning to train_to (left out: its train_share of the way to its end). Clipped samples are left
/// out of every fit; too many of them leave a motion out: the largest.
void require_unclipped(const Range& range, const std::vector<const Record*>& records, double max_share);

}  // namespace ident
