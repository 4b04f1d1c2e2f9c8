#include "dsp/io/pcm_samples.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include "dsp/filter/dispatch.hpp"

namespace dsp {
namespace {

using Eigen::Index;

constexpr double lowest_bit = 1.0 / 2147483648.0;  // every width is read as the upper bytes of 32 bits

template <int N>
double fraction(const char* bytes) {
  std::uint32_t bits = 0;
  for (int i = 0; i < N; ++i)
    bits |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) << (8 * (4 - N + i));
  return static_cast<double>(static_cast<std::int32_t>(bits)) * lowest_bit;
}

// Four at a time, moved behind bytes of zeros by one shuffle.
template <int N>
inline __attribute__((always_inline)) void fractions_of(const char* bytes, Index count, double* fractions) {
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
    *reinterpret_cast<Doubles*>(fractions + i) =
        __builtin_convertvector(reinterpret_cast<Integers>(four), Doubles) * lowest_bit;
  }
  for (; i < count; ++i) fractions[i] = fraction<N>(bytes + N * i);
}

ARDENT_DISPATCH void fractions_of_2(const char* bytes, Index count, double* fractions) {
  fractions_of<2>(bytes, count, fractions);
}
ARDENT_DISPATCH void fractions_of_3(const char* bytes, Index count, double* fractions) {
  fractions_of<3>(bytes, count, fractions);
}
ARDENT_DISPATCH void fractions_of_4(const char* bytes, Index count, double* fractions) {
  fractions_of<4>(bytes, count, fractions);
}

}  // namespace

void pcm_to_fractions(const char* bytes, Index count, int sample_bytes, double* fractions) {
  switch (sample_bytes) {
    case 2:
      return fractions_of_2(bytes, count, fractions);
    case 3:
      return fractions_of_3(bytes, count, fractions);
    case 4:
      return fractions_of_4(bytes, count, fractions);
    default:
      throw std::invalid_argument("pcm_to_fractions: want samples of 2, 3 or 4 bytes");
  }
}

}  // namespace dsp
