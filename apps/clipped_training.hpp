#pragma once
#include <vector>

#include "apps/config/inputs.hpp"
#include "ident/ranges.hpp"

namespace apps {

/// Throws dsp::Fault sample.clipped (input) where a channel is clipped for more than `max_share` of a range's training
/// interval, from its beginning to train_to (left out: 60 % of the way to its end). Clipped samples are left out of
/// every fit; too many of them leave a motion out: the largest.
void require_unclipped(const ident::Range& range, const std::vector<Input>& inputs, double max_fraction);

}  // namespace apps
