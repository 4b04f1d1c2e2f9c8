#include "dsp/io/flac_decoder.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "dsp/filter/dispatch.hpp"

namespace dsp {
namespace {

/// What was read is no block, or one that is left to libsndfile.
struct NotDecoded {};

/// Bits of bytes, the highest first.
class BitReader {
 public:
  static constexpr std::size_t slack_bytes = 16;  // can be read behind `end`: half of them by looking ahead
  BitReader(const unsigned char* at, const unsigned char* end) : at_(at), end_(end) {}

  /// Of 0 to 32 bits.
  std::uint32_t number(int bits) {
    refill();
    const auto value = static_cast<std::uint32_t>(window_ >> 1 >> (63 - bits));
    drop(bits);
    return value;
  }
  /// Of 1 to 32 bits.
  std::int32_t signed_number(int bits) { return static_cast<std::int32_t>(number(bits) << (32 - bits)) >> (32 - bits); }
  /// Zeros before the next one.
  std::uint32_t zeros() {
    std::uint32_t before = 0;
    for (refill(); window_ >> (64 - held_) == 0; refill()) {
      before += static_cast<std::uint32_t>(held_);
      drop(held_);
    }
    const int more = std::countl_zero(window_);
    drop(more + 1);
    return before + static_cast<std::uint32_t>(more);
  }
  /// Rice's code: zeros count for 2^low_bits each; even numbers stand for positive ones, odd ones for negative.
  std::int32_t rice(int low_bits) {
    int high = std::countl_zero(window_ | 1);
    if (high + 1 + low_bits > held_) [[unlikely]] {
      refill();
      high = std::countl_zero(window_ | 1);
      if (high + 1 + low_bits > held_) {
        const std::uint32_t upper = zeros() << low_bits;
        return signed_of(upper | number(low_bits));
      }
    }
    const auto low = static_cast<std::uint32_t>(window_ << high << 1 >> 1 >> (63 - low_bits));
    drop(high + 1 + low_bits);
    return signed_of(static_cast<std::uint32_t>(high) << low_bits | low);
  }
  /// The first byte of which no bit was read.
  [[nodiscard]] const unsigned char* next_byte() const { return at_ - held_ / 8; }

 private:
  static std::int32_t signed_of(std::uint32_t value) {
    return static_cast<std::int32_t>(value >> 1 ^ (0U - (value & 1)));
  }
  // As many whole bytes as fit. Below them the window holds bits of the next byte, which come again as they are.
  void refill() {
    if (at_ - end_ > 8) throw NotDecoded();
    std::uint64_t next = 0;
    std::memcpy(&next, at_, sizeof next);
    if constexpr (std::endian::native == std::endian::little) next = __builtin_bswap64(next);
    window_ |= next >> held_;
    at_ += (63 - held_) >> 3;
    held_ |= 56;  // of 0 to 63: as many whole bytes more as were added
  }
  void drop(int bits) {
    window_ <<= bits;
    held_ -= bits;
  }

  const unsigned char *at_, *end_;
  std::uint64_t window_ = 0;  ///< the next bits, from the highest down
  int held_ = 0;              ///< how many of them count as read from at_: 56 to 63 behind a refill
};

constexpr int most_coefficients = 32;

/// What a sample is expected to be by those before it: the sum of coefficients, of the latest first, by 2^shift.
struct Predictor {
  int order = 0, shift = 0;
  std::array<std::int64_t, most_coefficients> coefficients{};
};

Predictor fixed_predictor(int order) {
  constexpr std::array<std::array<std::int64_t, 4>, 5> differences{
      {{}, {1}, {2, -1}, {3, -3, 1}, {4, -6, 4, -1}}};  // that of this order vanishes
  Predictor predictor{.order = order};
  std::copy_n(differences[static_cast<std::size_t>(order)].begin(), order, predictor.coefficients.begin());
  return predictor;
}

Predictor read_predictor(BitReader& bits, int order) {
  Predictor predictor{.order = order};
  const int precision = static_cast<int>(bits.number(4)) + 1;
  predictor.shift = bits.signed_number(5);
  if (precision == 16 || predictor.shift < 0) throw NotDecoded();
  for (int j = 0; j < order; ++j) predictor.coefficients[static_cast<std::size_t>(j)] = bits.signed_number(precision);
  return predictor;
}

// Of what a damaged block may hold, too.
std::int32_t sum(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}
std::int32_t difference(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}

/// What the sample here is expected to be. `fixed`: the predictor's order where the compiler is to know it.
template <int fixed>
inline __attribute__((always_inline)) std::int32_t expected(const Predictor& predictor, const std::int32_t* sample) {
  std::int64_t value = 0;
  for (int j = fixed > 0 ? fixed : predictor.order; j-- > 0;)  // the latest last: it is the one that was just made
    value += predictor.coefficients[static_cast<std::size_t>(j)] * sample[-1 - j];
  return static_cast<std::int32_t>(value >> predictor.shift);
}

template <int fixed>
inline __attribute__((always_inline)) void add_expected_of_order(const Predictor& predictor, std::int32_t* sample,
                                                                 const std::int32_t* end) {
  const Predictor by = predictor;  // which the compiler knows to be apart from the samples
  for (; sample < end; ++sample) *sample = sum(*sample, expected<fixed>(by, sample));
}

/// Makes residuals samples in place. The orders that encoders use unless they are asked for more come one by one.
ARDENT_DISPATCH void add_expected(const Predictor& predictor, std::int32_t* sample, const std::int32_t* end) {
  const auto is_done = [&]<int... less>(std::integer_sequence<int, less...>) __attribute__((always_inline)) {
    return ((predictor.order == less + 1 && (add_expected_of_order<less + 1>(predictor, sample, end), true)) || ...);
  };
  if (!is_done(std::make_integer_sequence<int, 12>())) add_expected_of_order<0>(predictor, sample, end);
}

ARDENT_DISPATCH void read_rice(BitReader& bits, int low_bits, std::int32_t* residual, const std::int32_t* end) {
  BitReader own = bits;
  for (; residual < end; ++residual) *residual = own.rice(low_bits);
  bits = own;
}

/// Samples behind those that the predictor needs, whose residuals come in pieces of equal length with a code of their
/// own.
void read_samples(BitReader& bits, const Predictor& predictor, std::vector<std::int32_t>& samples) {
  const auto method = bits.number(2);
  if (method > 1) throw NotDecoded();
  const int code_bits = method == 0 ? 4 : 5;
  const auto pieces_log2 = bits.number(4);
  const auto order = static_cast<std::size_t>(predictor.order), piece = samples.size() >> pieces_log2;
  if (piece << pieces_log2 != samples.size() || piece < order) throw NotDecoded();
  std::int32_t *const begin = samples.data(), *const end = begin + samples.size();
  for (std::int32_t *residual = begin + order, *to = begin + piece; to <= end; residual = to, to += piece) {
    const int low_bits = static_cast<int>(bits.number(code_bits));
    if (low_bits != (1 << code_bits) - 1) {
      read_rice(bits, low_bits, residual, to);
      continue;
    }
    const int plain_bits = static_cast<int>(bits.number(5));
    for (; residual < to; ++residual) *residual = plain_bits == 0 ? 0 : bits.signed_number(plain_bits);
  }
  add_expected(predictor, begin + order, end);
}

/// One channel of a block.
void read_channel(BitReader& bits, int sample_bits, std::vector<std::int32_t>& samples) {
  const auto kind = bits.number(8);
  const int unused = (kind & 1) != 0 ? static_cast<int>(bits.zeros()) + 1 : 0;  // lowest bits, zero in all samples
  sample_bits -= unused;
  if (kind > 0x7f || sample_bits < 1) throw NotDecoded();
  const int type = static_cast<int>(kind >> 1);
  if (type == 0) {
    std::fill(samples.begin(), samples.end(), bits.signed_number(sample_bits));
  } else if (type == 1) {
    for (std::int32_t& sample : samples) sample = bits.signed_number(sample_bits);
  } else {
    const bool fixed = type >= 8 && type <= 12;
    if (!fixed && type < 32) throw NotDecoded();
    const int order = fixed ? type - 8 : type - 31;
    if (samples.size() < static_cast<std::size_t>(order)) throw NotDecoded();
    for (int i = 0; i < order; ++i) samples[static_cast<std::size_t>(i)] = bits.signed_number(sample_bits);
    const Predictor predictor = fixed ? fixed_predictor(order) : read_predictor(bits, order);
    read_samples(bits, predictor, samples);
  }
  if (unused > 0)
    for (std::int32_t& sample : samples) sample <<= unused;
}

/// How two channels may be held: left with what right lacks, what left exceeds with right, or mean with difference.
enum Pairing : unsigned { left_side = 8, side_right = 9, mid_side = 10 };

void part(unsigned pairing, std::vector<std::int32_t>& first, std::vector<std::int32_t>& second) {
  for (std::size_t i = 0; i < first.size(); ++i) {
    const std::int32_t one = first[i], other = second[i];
    if (pairing == left_side) second[i] = difference(one, other);
    if (pairing == side_right) first[i] = sum(one, other);
    if (pairing == mid_side) second[i] = difference(one, other >> 1), first[i] = sum(second[i], other);
  }
}

// The lowest bytes of each sample, lowest first.
template <int bytes>
void put_samples(const std::vector<std::int32_t>& samples, char* to, Eigen::Index step) {
  for (const std::int32_t sample : samples) {
    for (int b = 0; b < bytes; ++b) to[b] = static_cast<char>(sample >> 8 * b);
    to += step;
  }
}

}  // namespace

bool FlacDecoder::takes(const FlacStream& stream) {
  return (stream.bits == 16 || stream.bits == 24) && stream.num_frames > 0 && stream.longest_block > 0;
}

FlacDecoder::FlacDecoder(const InputFile& file, const FlacStream& stream, Eigen::Index num_channels)
    : file_(&file),
      stream_(stream),
      sample_bytes_(stream.bits / 8),
      channels_(static_cast<std::size_t>(num_channels)),
      block_at_(stream.first_block),
      ahead_at_(stream.first_block) {}

std::string_view FlacDecoder::next(Eigen::Index max_frames) {
  if (packed_at_ == packed_end_ && (due_ == stream_.num_frames || !decode_block())) return {};
  const auto count = std::min(static_cast<std::size_t>(max_frames * frame_bytes()), packed_end_ - packed_at_);
  packed_at_ += count;
  return {packed_.data() + (packed_at_ - count), count};
}

void FlacDecoder::read_ahead() {
  constexpr std::size_t piece_bytes = std::size_t{1} << 18;
  const std::size_t done = block_at_ - ahead_at_;
  if (ahead_bytes_ - done >= stream_.longest_block || ahead_at_ + ahead_bytes_ >= file_->size()) return;
  ahead_.erase(ahead_.begin(), ahead_.begin() + static_cast<std::ptrdiff_t>(done));
  ahead_at_ = block_at_;
  ahead_bytes_ -= done;
  ahead_.resize(ahead_bytes_);
  ahead_.resize(stream_.longest_block + piece_bytes + BitReader::slack_bytes);  // with zeros
  ahead_bytes_ += file_->read(ahead_at_ + ahead_bytes_, ahead_.data() + ahead_bytes_,
                              stream_.longest_block + piece_bytes - ahead_bytes_);
}

bool FlacDecoder::decode_block() try {
  read_ahead();
  const unsigned char* const begin = ahead_.data() + (block_at_ - ahead_at_);
  const unsigned char* const end = ahead_.data() + ahead_bytes_;
  const auto bytes_to = [&](const unsigned char* to) {
    return std::string_view(reinterpret_cast<const char*>(begin), static_cast<std::size_t>(to - begin));
  };
  const auto head = flac_block_at(bytes_to(end), stream_);
  if (!head || head->first != due_ || head->length > stream_.num_frames - due_) return false;
  const unsigned pairing = begin[3] >> 4, bits_code = begin[3] >> 1 & 7;
  const bool paired = pairing >= left_side && pairing <= mid_side && channels_.size() == 2;
  if (!paired && pairing + 1 != channels_.size()) return false;
  if (bits_code != 0 && bits_code != (stream_.bits == 16 ? 4 : 6)) return false;
  BitReader bits(begin + head->head_bytes, end);
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const bool is_difference = paired && c == (pairing == side_right ? 0 : 1);
    channels_[c].resize(static_cast<std::size_t>(head->length));
    read_channel(bits, stream_.bits + (is_difference ? 1 : 0), channels_[c]);
  }
  const unsigned char* const behind = bits.next_byte() + 2;  // its checksum
  if (behind > end || flac_block_remainder(bytes_to(behind)) != 0) return false;
  if (paired) part(pairing, channels_[0], channels_[1]);
  pack(head->length);
  due_ += head->length;
  block_at_ += static_cast<std::uint64_t>(behind - begin);
  return true;
} catch (const NotDecoded&) {
  return false;
}

void FlacDecoder::pack(std::int64_t num_frames) {
  packed_at_ = 0;
  packed_end_ = static_cast<std::size_t>(num_frames * frame_bytes());
  packed_.resize(packed_end_);
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    char* const to = packed_.data() + c * static_cast<std::size_t>(sample_bytes_);
    if (sample_bytes_ == 2) put_samples<2>(channels_[c], to, frame_bytes());
    if (sample_bytes_ == 3) put_samples<3>(channels_[c], to, frame_bytes());
  }
}

}  // namespace dsp
