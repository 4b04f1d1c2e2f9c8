// The faults a person meets, through the built program: exit code, message, and what helps.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "dsp/sound_file.hpp"
#include "support/program.hpp"

using support::Scratch;
namespace fs = std::filesystem;

namespace {

/// Two channels of 24 bit at 100 Hz, 8 s.
void sound(const fs::path& file) {
  dsp::SoundFileWriter writer(file, {.sample_rate_hz = 100, .num_channels = 2});
  writer.write(dsp::FrameBlock::NullaryExpr(
      800, 2, [](Eigen::Index i, Eigen::Index c) { return 0.4 * std::sin(0.13 * static_cast<double>(i * (c + 1))); }));
  writer.close();
}

std::string after_first_line(const std::string& text) {
  return text.substr(text.find('\n') + 1);
}

}  // namespace

TEST_CASE("the lines that a missing sensitivity prints can be pasted as they are", "[apps][faults]") {
  const Scratch folder;
  sound(folder / "good.wav");
  const auto refused = support::run(folder, "$ARDENT run good.wav");
  CHECK(refused.code == 3);
  CHECK_THAT(refused.err,
             Catch::Contains("error [calibration.missing] good.wav: no calibration for channel1, channel2"));
  const auto document = nlohmann::json::parse(support::run(folder, "$ARDENT --json run good.wav").out);
  const std::string lines = document["error"]["lines"];
  CHECK(refused.err.substr(refused.err.find("[[channel]]")) == lines);
  (void)folder.file("good.wav.toml", lines);
  const auto info = support::run(folder, "$ARDENT info good.wav");
  CHECK(info.code == 0);
  CHECK_THAT(info.out, Catch::Contains("channel2") && !Catch::Contains("calibrated"));

  const std::string sidecar =
      "[[channel]]\nname = \"base\"\nindex = 2\nfull_scale = \"1 N\"\n"
      "[[channel]]\nname = \"laser\\u001b[31m\\n[[bad]]\"\nindex = 1\nrole = \"y\"\nsensitivity = \"250 mV/mm\"\n";
  (void)folder.file("good.wav.toml", sidecar);
  const auto half = support::run(folder, "$ARDENT run good.wav -q");
  CHECK(half.code == 3);
  CHECK_THAT(half.err, Catch::Contains("\nfull_scale = \"10 V\"") && !Catch::Contains("\x1b"));
  (void)folder.file("good.wav.toml", sidecar + after_first_line(half.err));
  CHECK(support::run(folder, "$ARDENT run good.wav -o done --set library.order=1").code == 0);
}

TEST_CASE("an error is told once, also where standard output takes nothing", "[apps][faults]") {
  const Scratch folder;
  const auto ended = support::run(folder, "$ARDENT --json terms > /dev/full");
  CHECK(ended.code == 5);
  CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
}
