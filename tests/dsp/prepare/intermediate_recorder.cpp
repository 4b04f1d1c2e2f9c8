#include "dsp/prepare/intermediate_recorder.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/signals.hpp"

using Eigen::Index;

namespace {

dsp::Recording description(double rate_hz) {
  dsp::Recording result{.name = "made up", .sample_rate_hz = rate_hz};
  result.channels = {{.name = "top", .role = dsp::Role::y, .unit = "m"},
                     {.name = "base", .role = dsp::Role::r, .unit = "m"}};
  return result;
}

dsp::Recording through(const dsp::FrameBlock& frames, const std::optional<dsp::DecimateOptions>& options, Index block) {
  dsp::IntermediateRecorder recorder(description(2560.0), frames.rows(), options);
  for (Index first = 0; first < frames.rows(); first += block)
    recorder.push(frames.middleRows(first, std::min(block, frames.rows() - first)));
  return recorder.finish();
}

}  // namespace

TEST_CASE("what arrives at the intermediate rate does not depend on the blocks it came in",
          "[dsp][intermediate_recorder]") {
  dsp::FrameBlock frames(20000, 2);
  frames.col(0) = support::gaussian(20000, 1);
  frames.col(1) = support::gaussian(20000, 2);
  const dsp::DecimateOptions options{.output_rate_hz = 256.0, .passband_end_hz = 30.0, .stopband_start_hz = 226.0};
  const auto whole = through(frames, options, 20000);
  CHECK(whole.sample_rate_hz == 256.0);
  CHECK(whole.samples == dsp::decimate(frames, 2560.0, options));
  for (const Index block : {1, 7, 1000}) CHECK(through(frames, options, block).samples == whole.samples);
  CHECK(through(frames, std::nullopt, 333).samples == frames);
}

TEST_CASE("a sample that is no number is refused with its index", "[dsp][intermediate_recorder]") {
  dsp::FrameBlock frames = dsp::FrameBlock::Zero(100, 2);
  frames(42, 1) = std::nan("");
  dsp::IntermediateRecorder recorder(description(2560.0), 200, std::nullopt);
  recorder.push(dsp::FrameBlock::Zero(100, 2));
  CHECK_THROWS_WITH(recorder.push(frames), Catch::Contains("base is nan at 0.0554687 s"));
}

TEST_CASE("what is kept is what came, however much was announced", "[dsp][intermediate_recorder]") {
  dsp::FrameBlock frames(5000, 2);
  frames.col(0) = support::gaussian(5000, 1);
  frames.col(1) = support::gaussian(5000, 2);
  for (const Index announced : {1000, 5000, 9000}) {
    dsp::IntermediateRecorder recorder(description(2560.0), announced, std::nullopt);
    recorder.push(frames.topRows(3000));
    CHECK_THROWS_AS(recorder.push(dsp::FrameBlock::Zero(10, 3)), std::invalid_argument);
    recorder.push(frames.bottomRows(2000));
    CHECK(recorder.finish().samples == frames);
  }
}
