// Raw recordings give the same bytes whatever the blocks and threads.
#include <catch2/catch.hpp>
#include <cstring>

#include "dsp/io/input_file.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/io/sound_file.hpp"
#include "dsp/io/sound_writer.hpp"
#include "dsp/prepare.hpp"
#include "support/program.hpp"

namespace test_streamed_runs {

using support::bytes_of;
using support::expect;
using support::Scratch;

namespace {

bool same_bits(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

bool same_bits(const dsp::Motion& a, const dsp::Motion& b) {
  bool same = a.signals.size() == b.signals.size() && a.excluded == b.excluded;
  for (std::size_t i = 0; same && i < a.signals.size(); ++i)
    same = a.signals[i].name == b.signals[i].name && same_bits(a.signals[i].values, b.signals[i].values);
  return same;
}

/// Ten seconds of the rig at 25.6 kHz: more than three blocks of 65536 frames.
const Scratch& bench() {
  static const Scratch folder;
  static const support::Ended made =
      support::run(folder, "$ARDENT -q sim qzs --raw -o rig --container flac --duration 10 --set hold=1:5:5.2");
  REQUIRE(made.code == 0);
  return folder;
}

}  // namespace

TEST_CASE("a raw recording is prepared to the same bits by blocks of any size", "[apps][streamed_runs]") {
  const auto prepared = [](Eigen::Index block_frames) {
    dsp::RecordingReader reader(bench() / "rig/recording.flac");
    REQUIRE(reader.num_frames() > 3 * 65536);
    return dsp::prepare(reader, {.rate_hz = 25.6, .cutoff_hz = 10.24}, {.block_frames = block_frames});
  };
  const auto usual = prepared(8192);
  REQUIRE(usual.signals.num_samples() == 256);
  for (const Eigen::Index block_frames : {1, 7, 1000, 65536}) {
    CAPTURE(block_frames);
    const auto other = prepared(block_frames);
    CHECK(same_bits(other.signals, usual.signals));
    CHECK(same_bits(other.intermediate, usual.intermediate));
    CHECK(other.excluded.size() == usual.excluded.size());
  }
}

TEST_CASE("a raw recording is identified to the same bytes by one thread and two", "[apps][streamed_runs]") {
  const std::string settings =
      " rig/recording.flac --set prepare.rate_hz=25.6 --set prepare.cutoff_hz=10.24 --set library.order=3";
  expect(bench(), "$ARDENT run --threads 1 -o one" + settings, 0, {});
  expect(bench(), "$ARDENT run --threads 2 -o two" + settings, 0, {});
  for (const char* name : {"prepared.csv", "equation.json", "equation.txt", "predictions.csv", "segments.json",
                           "quality.json", "config.toml"}) {
    CAPTURE(name);
    const std::string one = bytes_of(bench() / (std::string("one/") + name));
    CHECK_FALSE(one.empty());
    CHECK((one == bytes_of(bench() / (std::string("two/") + name))));
  }
}

#ifndef ARDENT_SANITIZED
TEST_CASE("an hour at 256 Hz takes no more memory than half an hour's 150 MB and 55 kB for each further second",
          "[apps][streamed_runs]") {
  const Scratch folder;
  const std::filesystem::path whole = ARDENT_DATA "/qzs_256.flac";
  (void)folder.file("rig.toml", bytes_of(whole.string() + ".toml"));
  {  // in a scope of its own: a program started from here would count the frames as its own
    dsp::FrameBlock frames;
    constexpr Eigen::Index half_an_hour = 1800 * 256;
    REQUIRE(dsp::open_sound_file(std::make_unique<dsp::InputFile>(whole), {})->read(frames, half_an_hour) ==
            half_an_hour);
    dsp::SoundFileWriter writer(folder / "hour.wav",
                                {.format = dsp::SampleFormat::pcm24, .sample_rate_hz = 256, .num_channels = 4});
    for (int half = 0; half < 2; ++half) writer.write(frames);
    writer.close();
  }
  (void)folder.file("hour.toml",
                    "[[recording]]\nfile = \"hour.wav\"\nsidecar = \"rig.toml\"\n[prepare]\nrate_hz = 25.6\n"
                    "cutoff_hz = 10.24\n");
  CHECK(expect(folder, "$ARDENT -q run hour.toml -o hour", 0, {}).peak_kb <= 150'000 + 1800 * 55);
}
#endif

}  // namespace test_streamed_runs
