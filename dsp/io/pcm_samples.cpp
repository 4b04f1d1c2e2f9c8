#include "dsp/io/pcm_samples.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include "dsp/filter/dispatch.hpp"

namespace dsp {
namespace {

using Eigen::Index;

constexpr double lowest_bit = 1.0 / 2147483648.0;  // every width is read as the upper bytes of 32 bits
constexpr Index frames_together = 64;

template <int N>
double integer(const char* bytes) {
  std::uint32_t bits = 0;
  for (int i = 0; i < N; ++i)
    bits |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) << (8 * (4 - N + i));
  return static_cast<double>(static_cast<std::int32_t>(bits));
}

// Four samples at a time, moved behind bytes of zeros by one shuffle. Scale and shift of sample i are those of sample i
// of every batch.
template <int N>
inline __attribute__((always_inline)) void decode_batch(const char* bytes, Index count, const double* scale,
                                                        const double* shift, double* values) {
  typedef unsigned char Bytes __attribute__((vector_size(16)));
  typedef std::uint64_t Halves __attribute__((vector_size(16)));
  typedef std::int32_t Integers __attribute__((vector_size(16)));
  typedef double Doubles __attribute__((vector_size(32), aligned(8), may_alias));
  Index i = 0;
  for (; std::endian::native == std::endian::little && i + 4 <= count; i += 4) {
    std::uint64_t first = 0, second = 0;
    std::memcpy(&first, bytes + N * i, 8);
    std::memcpy(&second, bytes + N * i + 8, 4 * N - 8);
    Bytes four = reinterpret_cast<Bytes>(Halves{first, second});
    if constexpr (N == 2)
      four = __builtin_shufflevector(four, Bytes{}, 16, 16, 0, 1, 16, 16, 2, 3, 16, 16, 4, 5, 16, 16, 6, 7);
    if constexpr (N == 3)
      four = __builtin_shufflevector(four, Bytes{}, 16, 0, 1, 2, 16, 3, 4, 5, 16, 6, 7, 8, 16, 9, 10, 11);
    const Doubles numbers = __builtin_convertvector(reinterpret_cast<Integers>(four), Doubles);
    *reinterpret_cast<Doubles*>(values + i) =
        numbers * *reinterpret_cast<const Doubles*>(scale + i) + *reinterpret_cast<const Doubles*>(shift + i);
  }
  for (; i < count; ++i) values[i] = integer<N>(bytes + N * i) * scale[i] + shift[i];
}

ARDENT_DISPATCH void decode_2(const char* bytes, Index count, const double* scale, const double* shift,
                              double* values) {
  decode_batch<2>(bytes, count, scale, shift, values);
}
ARDENT_DISPATCH void decode_3(const char* bytes, Index count, const double* scale, const double* shift,
                              double* values) {
  decode_batch<3>(bytes, count, scale, shift, values);
}
ARDENT_DISPATCH void decode_4(const char* bytes, Index count, const double* scale, const double* shift,
                              double* values) {
  decode_batch<4>(bytes, count, scale, shift, values);
}

}  // namespace

PcmDecoder::PcmDecoder(int sample_bytes, Index num_channels)
    : sample_bytes_(sample_bytes), num_channels_(num_channels) {
  if (sample_bytes < 2 || sample_bytes > 4 || num_channels < 1)
    throw std::invalid_argument("PcmDecoder: want samples of 2, 3 or 4 bytes, of one channel at least");
  calibrate(Eigen::VectorXd::Ones(num_channels), Eigen::VectorXd::Zero(num_channels));
}

void PcmDecoder::calibrate(const Eigen::VectorXd& scales, const Eigen::VectorXd& shifts) {
  scales_ = lowest_bit * scales.array().replicate(frames_together, 1);  // exact: a power of two
  shifts_ = shifts.array().replicate(frames_together, 1);
}

void PcmDecoder::decode(const char* bytes, Index num_frames, double* values) const {
  const auto decode_some = sample_bytes_ == 2 ? decode_2 : sample_bytes_ == 3 ? decode_3 : decode_4;
  for (Index first = 0; first < num_frames; first += frames_together) {
    const Index count = std::min(frames_together, num_frames - first);
    decode_some(bytes + first * frame_bytes(), count * num_channels_, scales_.data(), shifts_.data(),
                values + first * num_channels_);
  }
}

}  // namespace dsp
