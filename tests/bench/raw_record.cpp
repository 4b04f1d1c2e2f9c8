// The raw part of a run, with all it does to each sample, against a bare read of the same file; and the decimator alone
// against soxr at its own high quality, both read and calibrated. CPU seconds of one thread, in turn, as ratios of each
// round.
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
#include "dsp/io/sound_writer.hpp"
#include "dsp/prepare.hpp"
#include "dsp/read_recording.hpp"

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

// What `ardent run` does with a raw file.
void whole_part(const std::filesystem::path& file) {
  dsp::RecordingReader reader(file);
  static_cast<void>(dsp::read_intermediate(reader, {{.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0}}));
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

std::string summary(std::vector<double> ratios) {
  std::sort(ratios.begin(), ratios.end());
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", ratios[rounds / 2], ratios.front(), ratios.back());
}

void compare(const std::string& title, const std::filesystem::path& file) {
  std::vector<double> over_read, alone_over_read, soxr_over_alone;
  for (int round = 0; round < rounds; ++round) {
    const double read = bench::cpu_s([&] { bench::bare_read(file); }), whole = bench::cpu_s([&] { whole_part(file); }),
                 alone = bench::cpu_s([&] { decimator_alone(file); }), soxr = bench::cpu_s([&] { soxr_hq(file); });
    over_read.push_back(whole / read);
    alone_over_read.push_back(alone / read);
    soxr_over_alone.push_back(soxr / alone);
  }
  fmt::print("{}: the raw part (calibrate, look for faults, spectrum, decimate) / a bare read = {}\n", title,
             summary(over_read));
  fmt::print("{}: the decimator alone / a bare read = {}, soxr HQ / that = {}\n", title, summary(alone_over_read),
             summary(soxr_over_alone));
}

}  // namespace

void bench::raw_part(const std::filesystem::path& folder) {
  constexpr Eigen::Index num_frames = 600 * rate_hz;  // what costs the same for any length stays small
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
