#include <cmath>

#include "dsp/io/sound_writer.hpp"
#include "fuzz/harness.hpp"
#include "support/scratch.hpp"

std::vector<std::string> fuzz::seeds() {
  const support::Scratch folder;
  dsp::FrameBlock frames(40, 2);
  for (Eigen::Index i = 0; i < frames.rows(); ++i)
    frames.row(i) << 0.4 * std::sin(0.3 * static_cast<double>(i)), 0.1 * static_cast<double>(i % 3);
  std::vector<std::string> all;
  for (const char* name : {"wav", "rf64", "w64", "caf", "flac", "aiff"})
    for (const auto format : {dsp::SampleFormat::pcm16, dsp::SampleFormat::pcm24, dsp::SampleFormat::float32}) {
      const auto container = dsp::sound_container(name);
      if (container == dsp::SoundContainer::flac && format == dsp::SampleFormat::float32) continue;
      dsp::SoundFileWriter writer(folder / "a", {.container = container,
                                                 .format = format,
                                                 .sample_rate_hz = 256.0,
                                                 .num_channels = 2,
                                                 .num_frames = frames.rows(),
                                                 .comment = "a"});
      writer.write(frames);
      writer.close();
      all.push_back(support::bytes_of(folder / "a"));
    }
  return all;
}
