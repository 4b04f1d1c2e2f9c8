#pragma once
#include <rapidcheck.h>

#include <memory>

#include "dsp/io/sample_source.hpp"
#include "dsp/values/fault.hpp"

namespace support {

/// A damaged file is read to the end it promises, or refused as bad input; never anything else. `open` makes its
/// source.
template <class Open>
void check_whole_or_refused(const Open& open, Eigen::Index block_frames) {
  try {
    const std::unique_ptr<dsp::SampleSource> source = open();
    dsp::FrameBlock block;
    Eigen::Index done = 0;
    while (const auto got = source->read(block, block_frames)) done += got;
    RC_ASSERT(done == source->info().num_frames);
  } catch (const dsp::Fault& fault) {
    RC_ASSERT(fault.kind() == dsp::FaultKind::input);
  }
}

}  // namespace support
