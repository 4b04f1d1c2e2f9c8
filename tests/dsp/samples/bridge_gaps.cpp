#include "dsp/samples/bridge_gaps.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <ctime>
#include <limits>

#include "support/fault.hpp"

using dsp::FaultKind;
using dsp::FrameBlock;
using support::check_fault;

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Two channels that count up; the second has nothing before frame `late`, and the first a gap of three behind it.
FrameBlock with_late_channel(Eigen::Index num_frames, Eigen::Index late) {
  FrameBlock frames(num_frames, 2);
  for (Eigen::Index i = 0; i < num_frames; ++i) frames.row(i).setConstant(static_cast<double>(i));
  frames.col(1).head(late).setConstant(none);
  frames.col(0).segment(late + 5, 3).setConstant(none);
  return frames;
}

dsp::GapBridge bridge_of(std::size_t max_memory_bytes = std::size_t{4} << 30) {
  return dsp::GapBridge({"a.csv", {"x", "f"}, 10.0, max_memory_bytes});
}

/// All that comes out of pushing blocks of one size and taking those of another as soon as they are ready.
FrameBlock through(const FrameBlock& frames, Eigen::Index pushed, Eigen::Index taken) {
  dsp::GapBridge bridge = bridge_of();
  FrameBlock all(frames.rows(), 2), block;
  Eigen::Index done = 0;
  const auto take_all = [&] {
    while (const Eigen::Index count = bridge.take(block, taken)) {
      REQUIRE(block.rows() == count);
      REQUIRE(done + count <= frames.rows());
      all.middleRows(done, count) = block;
      done += count;
    }
  };
  for (Eigen::Index first = 0; first < frames.rows(); first += pushed) {
    bridge.push(frames.middleRows(first, std::min(pushed, frames.rows() - first)));
    take_all();
  }
  bridge.finish();
  take_all();
  CHECK(done == frames.rows());
  return all;
}

}  // namespace

TEST_CASE("frames leave a bridge once each, in their order, whatever the blocks", "[dsp][bridge_gaps]") {
  const FrameBlock frames = with_late_channel(1000, 700);
  FrameBlock wanted = frames;
  wanted.col(1).head(700).setConstant(700.0);  // the nearest value there is
  wanted.col(0).segment(705, 3) << 705.0, 706.0, 707.0;
  for (const Eigen::Index pushed : {1, 7, 64, 1000})
    for (const Eigen::Index taken : {1, 7, 64, 100, 5000}) {
      CAPTURE(pushed, taken);
      CHECK((through(frames, pushed, taken) - wanted).cwiseAbs().maxCoeff() <= 1e-12 * 1000.0);
    }
}

TEST_CASE("what is held until a late channel begins takes time in proportion to it", "[dsp][bridge_gaps]") {
  const auto seconds = [](Eigen::Index num_frames) {
    const FrameBlock frames = with_late_channel(num_frames, num_frames - 100);
    const std::clock_t begin = std::clock();
    (void)through(frames, 64, 64);
    return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  };
  (void)seconds(20'000);
  // Sixteen times as much: quadratic would be 256 times as long, a slow machine's caches at most double 16.
  CHECK(seconds(800'000) <= 64.0 * std::max(seconds(50'000), 1e-3));
}

TEST_CASE("what is held until a late channel begins stays within the memory allowed", "[dsp][bridge_gaps]") {
  const FrameBlock frames = with_late_channel(1000, 700);
  dsp::GapBridge enough = bridge_of(16 * 700);
  enough.push(frames);
  CHECK(enough.num_ready() == 1000);
  dsp::GapBridge scarce = bridge_of(16 * 699);
  check_fault([&] { scarce.push(frames); }, FaultKind::numerics, "memory.limit", {"a.csv", "0.0112 MB"});
  dsp::GapBridge beside = bridge_of(16 * 700);
  beside.set_bytes_beside(1.0);
  check_fault([&] { beside.push(frames); }, FaultKind::numerics, "memory.limit", {"a.csv"});
}

TEST_CASE("a gap of any length is bridged, in memory that does not grow with it", "[dsp][bridge_gaps]") {
  constexpr Eigen::Index block = 1 << 18;
  dsp::GapBridge bridge = bridge_of();
  FrameBlock frames = FrameBlock::Constant(block, 2, 3.0), taken;
  bridge.push(frames);
  frames.col(0).setConstant(none);
  std::int64_t num_taken = 0, most_held = 0;
  for (int i = 1; i <= 80; ++i) {  // 42 million values: 128 MB hold 17
    bridge.push(frames);
    while (const Eigen::Index count = bridge.take(taken, block)) {
      num_taken += count;
      CHECK((taken.array() - 3.0).abs().maxCoeff() < 1e-12);
    }
    most_held = std::max(most_held, (i + 1) * block - num_taken);
  }
  CHECK(most_held * 2 <= (1 << 24) + 2 * block);
  bridge.finish();
  while (const Eigen::Index count = bridge.take(taken, block)) num_taken += count;
  CHECK(num_taken == 81 * block);
  CHECK(bridge.bridged().back().to_s == Approx(81 * block / 10.0));
}

TEST_CASE("a parabola bridges up to three samples, a line more", "[dsp][bridge_gaps]") {
  const auto curve = [](Eigen::Index i) {
    return 3.0 + 0.5 * static_cast<double>(i) - 0.01 * static_cast<double>(i * i);
  };
  FrameBlock frames(1000, 2);
  for (Eigen::Index i = 0; i < frames.rows(); ++i) frames.row(i).setConstant(curve(i));
  for (const Eigen::Index count : {1, 2, 3, 4}) frames.col(0).segment(100 * count, count).setConstant(none);
  const FrameBlock bridged = through(frames, 64, 100);
  for (const Eigen::Index count : {1, 2, 3})
    for (Eigen::Index i = 100 * count; i < 100 * count + count; ++i)
      CHECK(bridged(i, 0) == Approx(curve(i)).epsilon(1e-12));
  const Eigen::Index last = 399 + 4 + 1;
  CHECK(bridged(401, 0) == Approx(0.6 * curve(399) + 0.4 * curve(last)).epsilon(1e-12));
}
