#pragma once

namespace dsp {

/// Four doubles that are computed with at once, and where they lie at any address.
typedef double Lanes __attribute__((vector_size(4 * sizeof(double))));
typedef double UnalignedLanes __attribute__((vector_size(4 * sizeof(double)), aligned(8), may_alias));

}  // namespace dsp
