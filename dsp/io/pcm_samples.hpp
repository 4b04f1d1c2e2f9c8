#pragma once
#include <Eigen/Core>

namespace dsp {

/// Integers of 2, 3 or 4 bytes, lowest byte first, as fractions of full scale: n / 2^15, n / 2^23 or n / 2^31, which
/// are exact. `bytes` holds count * sample_bytes of them. Throws std::invalid_argument for another width.
void pcm_to_fractions(const char* bytes, Eigen::Index count, int sample_bytes, double* fractions);

}  // namespace dsp
