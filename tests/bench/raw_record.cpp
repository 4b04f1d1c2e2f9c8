#include <fmt/format.h>
#include <sndfile.h>
#include <soxr.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "bench/bench.hpp"
#include "dsp/filter/decimate.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/io/sound_writer.hpp"
#include "dsp/prepare.hpp"

namespace {

constexpr int num_channels = 4, rate_hz = 25600;
constexpr Eigen::Index block = 65536;

// Twenty lines of a measured-looking record: two tones and a little of every frequency.
dsp::FrameBlock frames_at(Eigen::Index first, Eigen::Index count) {
  dsp::FrameBlock frames(count, num_channels);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double t = static_cast<double>(first + i) / rate_hz;
    for (int c = 0; c < num_channels; ++c)
      frames(i, c) = 0.3 * std::sin(2 * std::numbers::pi * (1.4 + c) * t) +
                     0.02 * std::sin(2 * std::numbers::pi * 50.0 * t) + 1e-4 * std::sin(1e4 * t * t * (c + 1));
  }
  return frames;
}

void write_sidecar(const std::filesystem::path& recording) {
  std::ofstream out(recording.string() + ".toml");
  out << "schema = 1\n";
  for (int c = 1; c <= num_channels; ++c)
    out << fmt::format(
        "[[channel]]\nname = \"c{0}\"\nindex = {0}\nunit = \"m\"\nsensitivity = \"114 mV/mm\"\nfull_scale = \"5 V\"\n",
        c);
}

void decimator_alone(const std::filesystem::path& file) {
  dsp::RecordingReader reader(file);
  dsp::Decimator decimator(rate_hz, num_channels,
                           {.output_rate_hz = 256.0, .passband_end_hz = 30.0, .stopband_start_hz = 226.0});
  dsp::FrameBlock frames;
  while (reader.read(frames, block) > 0) static_cast<void>(decimator.push(frames));
  static_cast<void>(decimator.finish());
}

void soxr_hq(const std::filesystem::path& file) {
  SF_INFO info{};
  SNDFILE* sound = sf_open(file.c_str(), SFM_READ, &info);
  const soxr_io_spec_t io = soxr_io_spec(SOXR_FLOAT64_I, SOXR_FLOAT64_I);
  const soxr_quality_spec_t quality = soxr_quality_spec(SOXR_HQ, 0);
  const soxr_runtime_spec_t one_thread = soxr_runtime_spec(1);
  soxr_t resampler = soxr_create(rate_hz, 25.6, num_channels, nullptr, &io, &quality, &one_thread);
  std::vector<double> in(static_cast<std::size_t>(block * num_channels)), out(4096);
  for (sf_count_t count = 1; count > 0;) {
    count = sf_readf_double(sound, in.data(), block);
    std::size_t made = 0;
    soxr_process(resampler, count > 0 ? in.data() : nullptr, static_cast<std::size_t>(count), nullptr, out.data(), 1000,
                 &made);
  }
  soxr_delete(resampler);
  sf_close(sound);
}

// A record in this container, written when first asked for.
std::filesystem::path record(const std::filesystem::path& folder, const std::string& name,
                             dsp::SoundContainer container) {
  constexpr Eigen::Index num_frames = 600 * rate_hz;  // what costs the same for any length stays small
  const auto file = folder / name;
  if (std::filesystem::exists(file)) return file;
  dsp::SoundFileWriter writer(
      file,
      {.container = container, .sample_rate_hz = rate_hz, .num_channels = num_channels, .num_frames = num_frames});
  for (Eigen::Index first = 0; first < num_frames; first += block)
    writer.write(frames_at(first, std::min(block, num_frames - first)));
  writer.close();
  write_sidecar(file);
  return file;
}

}  // namespace

void bench::raw_part(const std::filesystem::path& file) {
  dsp::RecordingReader reader(file);
  static_cast<void>(dsp::read_intermediate(reader, {{.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0}}));
}

void bench::register_raw_part(const std::filesystem::path& folder) {
  for (const auto& [name, container] :
       {std::pair{"rf64", dsp::SoundContainer::rf64}, std::pair{"flac", dsp::SoundContainer::flac}}) {
    const auto on_record = [folder, file = std::string("bench.") + name, container = container](auto work) {
      return [=] { work(record(folder, file, container)); };
    };
    add(std::string("bare_read/") + name, on_record(bench::bare_read));
    add(std::string("raw_part/") + name, on_record(bench::raw_part));
    add(std::string("decimator/") + name, on_record(decimator_alone));
    add(std::string("soxr/") + name, on_record(soxr_hq));
  }
}
