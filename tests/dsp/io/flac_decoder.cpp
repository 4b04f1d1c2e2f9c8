#include "dsp/io/flac_decoder.hpp"

#include <sndfile.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "support/fuzz.hpp"
#include "support/scratch.hpp"

namespace {

using support::Scratch;

// Sample i of a channel of each kind that encoders hold in a way of its own.
constexpr const char* kinds[] = {
    "silence", "one value", "full noise", "a little noise", "a tone", "steps of 16", "a tone that begins loud"};
std::int64_t sample(int kind, int bits, std::size_t i, std::mt19937& generator) {
  const double full = std::ldexp(1.0, bits - 1), t = static_cast<double>(i);
  const auto noise = [&](int of_bits) {
    return static_cast<std::int64_t>(generator() >> (32 - of_bits)) - (1 << (of_bits - 1));
  };
  switch (kind) {
    case 0:
      return 0;
    case 1:
      return -3;
    case 2:
      return noise(bits);
    case 3:
      return noise(3);
    case 4:
      return static_cast<std::int64_t>(0.6 * full * std::sin(0.01 * t) + 0.3 * full * std::sin(0.3 * t)) + noise(6);
    case 5:
      return 16 * static_cast<std::int64_t>(0.05 * full * std::sin(0.02 * t));
    default:
      return i % 4096 < 20 ? noise(bits) : noise(2);
  }
}

std::vector<int> samples_of(int kind, int bits, int channels) {
  constexpr std::size_t num_frames = 3 * 4096 + 77;
  std::mt19937 generator(7);
  std::vector<int> samples;
  for (std::size_t i = 0; i < num_frames; ++i)
    for (int c = 0; c < channels; ++c)  // alike, as pairs of channels are held by what differs
      samples.push_back(static_cast<int>(sample(kind, bits, i + static_cast<std::size_t>(c / 2), generator)) +
                        (kind > 2 ? c % 2 : 0));
  return samples;
}

void write(const std::filesystem::path& file, const std::vector<int>& samples, int bits, int channels,
           double compression) {
  SF_INFO info{};
  info.samplerate = 25600, info.channels = channels;
  info.format = SF_FORMAT_FLAC | (bits == 16 ? SF_FORMAT_PCM_16 : SF_FORMAT_PCM_24);
  SNDFILE* const sound = sf_open(file.c_str(), SFM_WRITE, &info);
  REQUIRE(sound != nullptr);
  sf_command(sound, SFC_SET_COMPRESSION_LEVEL, &compression, sizeof compression);
  std::vector<int> upper;  // as libsndfile takes them: 32 bits wide
  for (const int one : samples) upper.push_back(static_cast<int>(static_cast<unsigned>(one) << (32 - bits)));
  REQUIRE(sf_write_int(sound, upper.data(), std::ssize(upper)) == std::ssize(upper));
  sf_close(sound);
}

std::string decoded(const dsp::InputFile& input, int channels, Eigen::Index at_once) {
  const auto stream = dsp::flac_stream(input);
  REQUIRE(dsp::FlacDecoder::takes(stream));
  dsp::FlacDecoder decoder(input, stream, channels);
  std::string bytes;
  for (auto some = decoder.next(at_once); !some.empty(); some = decoder.next(at_once)) bytes += some;
  return bytes;
}

}  // namespace

TEST_CASE("a FLAC is decoded to the samples that were written, however an encoder holds them", "[dsp][flac_decoder]") {
  const Scratch scratch;
  for (const int bits : {16, 24})
    for (const int channels : {1, 2, 3, 8})
      for (int kind = 0; kind < std::ssize(kinds); ++kind) {
        const auto samples = samples_of(kind, bits, channels);
        std::string want;
        for (const int one : samples)
          for (int b = 0; b < bits; b += 8) want += static_cast<char>(one >> b);
        for (const double compression : {0.0, 0.3, 1.0}) {  // fixed predictors, mid and side, most coefficients
          INFO(bits << " bits, " << channels << " channels, " << kinds[kind] << ", compression " << compression);
          write(scratch / "a.flac", samples, bits, channels, compression);
          const dsp::InputFile input(scratch / "a.flac");
          CHECK((decoded(input, channels, 1000) == want));
        }
      }
}

TEST_CASE("a FLAC with a byte that is another is decoded up to the block before it", "[dsp][flac_decoder]") {
  const Scratch scratch;
  const auto samples = samples_of(4, 24, 2);
  write(scratch / "a.flac", samples, 24, 2, 1.0);
  const std::string whole = support::bytes_of(scratch / "a.flac");
  const std::string want = decoded(dsp::InputFile(scratch / "a.flac"), 2, 65536);
  std::mt19937 generator(3);
  for (int draw = 0; draw < 300; ++draw) {
    std::string bytes = whole;
    const std::size_t at = 100 + generator() % (whole.size() - 100);
    bytes[at] = static_cast<char>(bytes[at] ^ (1 + generator() % 255));
    const dsp::InputFile input(scratch.file("b.flac", bytes));
    if (dsp::flac_stream(input).first_block > at) continue;
    const std::string got = decoded(input, 2, 65536);
    INFO("byte " << at);
    CHECK(got.size() < want.size());
    CHECK((got == want.substr(0, got.size())));
  }
}
