// The raw part of a run against a bare read of the same file, and against soxr at its own high quality: CPU seconds of
// one thread, in turn, as ratios of each round.
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
#include "dsp/decimate.hpp"
#include "dsp/read_recording.hpp"
#include "dsp/sound_file.hpp"

namespace {

constexpr int num_channels = 4, rate_hz = 25600, rounds = 7;
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

void ours(const std::filesystem::path& file) {
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

void compare(const std::string& title, const std::filesystem::path& file) {
  std::vector<double> over_read, under_soxr;
  for (int round = 0; round < rounds; ++round) {
    const double read = bench::cpu_s([&] { bench::bare_read(file); }), mine = bench::cpu_s([&] { ours(file); }),
                 soxr = bench::cpu_s([&] { soxr_hq(file); });
    over_read.push_back(mine / read);
    under_soxr.push_back(soxr / mine);
  }
  std::sort(over_read.begin(), over_read.end());
  std::sort(under_soxr.begin(), under_soxr.end());
  fmt::print(
      "{}: read, calibrate and decimate = {:.2f} x a bare read ({:.2f} to {:.2f}); soxr HQ = {:.2f} x that ({:.2f} to "
      "{:.2f})\n",
      title, over_read[rounds / 2], over_read.front(), over_read.back(), under_soxr[rounds / 2], under_soxr.front(),
      under_soxr.back());
}

}  // namespace

void bench::raw_part(const std::filesystem::path& folder) {
  constexpr Eigen::Index num_frames = 200 * rate_hz;
  for (const auto& [name, container] :
       {std::pair{"bench.wav", dsp::SoundContainer::rf64}, std::pair{"bench.flac", dsp::SoundContainer::flac}}) {
    const auto file = folder / name;
    dsp::SoundFileWriter writer(
        file,
        {.container = container, .sample_rate_hz = rate_hz, .num_channels = num_channels, .num_frames = num_frames});
    for (Eigen::Index first = 0; first < num_frames; first += block)
      writer.write(frames_at(first, std::min(block, num_frames - first)));
    writer.close();
    write_sidecar(file);
    compare(name, file);
  }
}
