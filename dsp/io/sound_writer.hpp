#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/sample_source.hpp"

namespace dsp {

enum class SoundContainer { rf64, wav, w64, caf, flac, aiff };
enum class SampleFormat { pcm16, pcm24, float32, float64 };
/// "rf64", "wav", ...; throws std::invalid_argument that lists them.
[[nodiscard]] SoundContainer sound_container(std::string_view name);
/// File name extension without a dot.
[[nodiscard]] std::string extension(SoundContainer container);

struct SoundFileOptions {
  SoundContainer container = SoundContainer::rf64;
  SampleFormat format = SampleFormat::pcm24;
  double sample_rate_hz = 0.0;  ///< required: whole
  int num_channels = 0;         ///< required
  std::int64_t num_frames = 0;  ///< required for WAV and AIFF, whose sizes have 32 bits: beyond is refused at once
  std::string comment{};
  std::filesystem::path shown{};  ///< what messages call the file; empty: its path
};

/// Streams frames into a new file. It grows under a name of its own beside `file` and takes the place of `file` in
/// close(); without close() nothing is left. PCM: fractions of full scale, rounded to the nearest step (ties to even)
/// and clipped.
class SoundFileWriter {
 public:
  /// Throws Fault: container.limit (usage; with the remedy) for what the container cannot hold, output.open (output).
  SoundFileWriter(const std::filesystem::path& file, const SoundFileOptions& options);
  ~SoundFileWriter();
  /// frames: any number x num_channels. Throws Fault output.write; std::invalid_argument for NaN in a PCM file.
  void write(const Eigen::Ref<const FrameBlock>& frames);
  /// Throws Fault output.write.
  void close();
  [[nodiscard]] const std::vector<std::int64_t>& num_clipped() const&;  ///< per channel
  void num_clipped() const&& = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace dsp
