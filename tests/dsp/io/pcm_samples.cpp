#include "dsp/io/pcm_samples.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

TEST_CASE("integers become fractions of full scale, scaled and shifted channel by channel", "[dsp][pcm_samples]") {
  std::mt19937_64 generator(5);
  for (const int sample_bytes : {2, 3, 4})
    for (const Eigen::Index channels : {1, 3, 4}) {
      const Eigen::Index num_frames = 131;  // two batches and a rest
      const int bits = 8 * sample_bytes;
      std::vector<std::int64_t> integers(static_cast<std::size_t>(num_frames * channels));
      const std::int64_t half = std::int64_t{1} << (bits - 1);
      for (std::int64_t& n : integers) n = static_cast<std::int64_t>(generator() >> (64 - bits)) - half;
      integers.front() = -half, integers.back() = half - 1;
      std::string bytes;
      for (const std::int64_t n : integers)
        for (int i = 0; i < sample_bytes; ++i) bytes += static_cast<char>(n >> (8 * i) & 0xff);
      Eigen::VectorXd scales(channels), shifts(channels);
      for (Eigen::Index c = 0; c < channels; ++c)
        scales(c) = 0.3 / static_cast<double>(c + 1), shifts(c) = 0.1 * static_cast<double>(c) - 0.07;
      dsp::PcmDecoder decoder(sample_bytes, channels);
      CHECK(decoder.frame_bytes() == sample_bytes * channels);
      std::vector<double> fractions(integers.size()), values(integers.size());
      decoder.decode(bytes.data(), num_frames, fractions.data());
      decoder.calibrate(scales, shifts);
      decoder.decode(bytes.data(), num_frames, values.data());
      bool exact = true;
      for (std::size_t i = 0; i < integers.size(); ++i) {
        const double fraction = std::ldexp(static_cast<double>(integers[i]), 1 - bits);
        const auto c = static_cast<Eigen::Index>(i) % channels;
        const volatile double scaled = fraction * scales(c);  // rounded before it is shifted
        exact = exact && fractions[i] == fraction && values[i] == scaled + shifts(c);
      }
      INFO(sample_bytes << " bytes, " << channels << " channels");
      CHECK(exact);
    }
  CHECK_THROWS_AS(dsp::PcmDecoder(1, 1), std::invalid_argument);
  CHECK_THROWS_AS(dsp::PcmDecoder(3, 0), std::invalid_argument);
}
