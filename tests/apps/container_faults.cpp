// Recordings whose containers or clocks are not what they should be, as the program meets them.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <functional>

#include "support/program.hpp"

using support::bytes_of;
using support::expect;
using support::Scratch;

namespace {

/// Half a minute of the rig in rig/recording.wav, 24 bits at 256 Hz, with its sidecar.
const Scratch& bench() {
  static const Scratch folder;
  static const support::Ended made =
      support::run(folder, "$ARDENT -q sim qzs --raw -o rig --container wav --rate 256 --duration 30");
  REQUIRE(made.code == 0);
  return folder;
}

std::string wav() {
  return bytes_of(bench() / "rig/recording.wav");
}

/// The recording with little-endian bytes of its header replaced, under a name of its own, with a sidecar.
std::string patched(std::string bytes, const std::string& name, std::size_t at, std::uint64_t value, int count) {
  for (int i = 0; i < count; ++i) bytes[at + static_cast<std::size_t>(i)] = static_cast<char>(value >> 8 * i & 0xff);
  (void)bench().file(name + ".toml", bytes_of(bench() / "rig/recording.wav.toml"));
  (void)bench().file(name, bytes);
  return name;
}

std::size_t data_size_at() {
  return wav().find("data") + 4;
}

std::string table(int num_rows, const std::function<std::string(int)>& row, const std::string& header = "t,x,v,a\n") {
  std::string text = header;
  for (int i = 0; i < num_rows; ++i) text += row(i) + "\n";
  return text;
}

/// t, x, v, a of a decaying oscillation, its clock as given.
std::string decay(int i, const std::string& time) {
  const double t = 0.01 * i, e = std::exp(-0.1 * t);
  return time + "," + std::to_string(e * std::sin(6 * t)) + "," + std::to_string(6 * e * std::cos(6 * t)) + "," +
         std::to_string(-36 * e * std::sin(6 * t));
}

}  // namespace

TEST_CASE("a recorder that died leaves a size of 0: refused, salvaged on request", "[apps][faults]") {
  const std::string file = patched(wav(), "dead.wav", data_size_at(), 0, 4);
  expect(bench(), "$ARDENT check " + file, 3, {"[container.unfinished]", "dead.wav", "7680", "--salvage"});
  expect(bench(), "$ARDENT check --salvage " + file, 0, {"warning", "[container.unfinished]", "0 frames", "7680"});
}

TEST_CASE("a WAV that grew past 4 GiB is refused by its size, salvaged on request", "[apps][faults]") {
  constexpr std::uint64_t num_bytes = (std::uint64_t{1} << 32) + 12 * 7680;  // the size wraps to the 7680 frames
  const std::string file = patched(wav(), "wrapped.wav", data_size_at(), num_bytes & 0xffffffff, 4);
  std::filesystem::resize_file(bench() / file, data_size_at() + 4 + num_bytes);  // a hole: takes no room
  expect(bench(), "$ARDENT info " + file, 3, {"[container.wrapped]", "4 GiB", "--salvage"});
  const auto salvaged = support::run(bench(), "$ARDENT info --salvage " + file);
  CHECK(salvaged.code == 0);
  CHECK_THAT(salvaged.out, Catch::Contains("357921"));  // 2^32 / 12 and the 7680 behind it
  std::filesystem::remove(bench() / file);
}

TEST_CASE("sizes a stream left open are read to the end, with a note", "[apps][faults]") {
  for (const std::uint64_t size : {std::uint64_t{0}, std::uint64_t{0xffffffff}}) {
    std::string bytes = wav();
    for (std::size_t i = 0; i < 4; ++i) bytes[data_size_at() + i] = '\xff';
    const std::string file = patched(bytes, "open.wav", 4, size, 4);
    expect(bench(), "$ARDENT check " + file, 0, {"note", "container."});
  }
}

TEST_CASE("impossible headers and lossy codecs are refused", "[apps][faults]") {
  const std::size_t format = wav().find("fmt ") + 8;
  const auto refused = [&](std::size_t at, std::uint64_t value, int count, const char* name, const char* piece) {
    expect(bench(), "$ARDENT info " + patched(wav(), "bad.wav", at, value, count), 3, {name, "bad.wav", piece});
  };
  refused(format + 2, 0, 2, "[container.damaged]", "header cannot be read");
  refused(format + 2, 65535, 2, "[container.damaged]", "Too many channels");
  refused(format + 4, 0, 4, "[container.damaged]", "header cannot be read");
  refused(format + 4, 1'000'000'000, 4, "[container.limit]", "1 to 100000000 Hz");
  const auto coded = [&](int tag, int bits) {
    std::string bytes = wav();
    bytes[format] = static_cast<char>(tag);
    bytes[format + 14] = static_cast<char>(bits);
    bytes[format + 12] = static_cast<char>(4 * bits / 8);  // bytes a frame
    (void)bench().file("coded.wav", bytes);
  };
  for (const int law : {6, 7}) {  // A and mu
    coded(law, 8);
    expect(bench(), "$ARDENT info coded.wav", 3, {"[container.lossy]", "coded.wav", "FLAC"});
  }
  // IMA ADPCM in blocks of 36 bytes: 4 + 32 bytes for 65 samples of one channel.
  const auto little = [](std::uint32_t value, int count) {
    std::string bytes;
    for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
    return bytes;
  };
  const std::string adpcm = "WAVEfmt " + little(20, 4) + little(0x11, 2) + little(1, 2) + little(8000, 4) +
                            little(4430, 4) + little(36, 2) + little(4, 2) + little(2, 2) + little(65, 2) + "fact" +
                            little(4, 4) + little(650, 4) + "data" + little(360, 4) + std::string(360, '\0');
  (void)bench().file("adpcm.wav", "RIFF" + little(static_cast<std::uint32_t>(adpcm.size()), 4) + adpcm);
  expect(bench(), "$ARDENT info adpcm.wav", 3, {"[container.lossy]", "adpcm.wav", "FLAC"});
  (void)bench().file("vorbis.ogg", "OggS" + std::string(2, '\2') + std::string(60, '\0'));
  expect(bench(), "$ARDENT info vorbis.ogg", 3, {"[container.lossy]", "vorbis.ogg", "Ogg", "FLAC"});
}

TEST_CASE("a FLAC cut short is reported where its header is believed, and refused where it is read", "[apps][faults]") {
  const Scratch folder;
  REQUIRE(support::run(folder, "$ARDENT -q sim qzs --raw -o rig --container flac --rate 256 --duration 60").code == 0);
  expect(folder, "$ARDENT info rig/recording.flac", 0, {"15360"});
  CHECK(support::run(folder, "$ARDENT info rig/recording.flac").out.find("container.truncated") == std::string::npos);
  const auto size = std::filesystem::file_size(folder / "rig/recording.flac");
  for (const double fraction : {0.98, 0.5, 0.05}) {
    CAPTURE(fraction);
    std::filesystem::resize_file(folder / "rig/recording.flac",
                                 static_cast<std::uintmax_t>(fraction * static_cast<double>(size)));
    expect(folder, "$ARDENT info rig/recording.flac", 0,
           {"warning", "container.truncated", "promises 15360 frames", "last"});
    expect(folder, "$ARDENT check rig/recording.flac", 3, {"[container.truncated]", "15360", "--salvage"});
  }
}

TEST_CASE("a universal file is told by its first line, whatever is before it", "[apps][faults]") {
  const Scratch folder;
  const std::string set = "    -1\n    58\nacceleration\nNONE\n    -1\n";
  for (const std::string before : {"", "\n", "\xef\xbb\xbf", "\xef\xbb\xbf\r\n   \n"}) {
    (void)folder.file("sets.uff", before + set);
    expect(folder, "$ARDENT run sets.uff -o run", 3, {"[container.truncated]", "sets.uff", "header of a data set"});
  }
  // A number alone on a line is no such file.
  (void)folder.file("minus.csv", "\n-1\n1\n-1\n");
  CHECK(support::run(folder, "$ARDENT info minus.csv").err.find("UFF") == std::string::npos);
  CHECK_FALSE(std::filesystem::exists(folder / "run"));
}

TEST_CASE("a clock that goes back, repeats or trembles is refused with its line", "[apps][faults]") {
  const Scratch folder;
  const auto time = [](int i) { return std::to_string(0.01 * i); };
  const auto with = [&](const std::function<std::string(int)>& clock) {
    (void)folder.file("c.csv", table(2000, [&](int i) { return decay(i, clock(i)); }));
  };
  with([&](int i) { return i == 700 ? "3.5" : time(i); });
  expect(folder, "$ARDENT run c.csv -o run", 3, {"[clock.backwards]", "c.csv:702", "back from 6.99", "to 3.5 s"});
  with([&](int i) { return time(i == 700 ? 699 : i); });
  expect(folder, "$ARDENT run c.csv -o run", 3, {"[clock.repeated]", "c.csv:702", "time 6.99 s occurs twice"});
  with([&](int i) { return std::to_string(0.01 * i + 0.003 * (i * 7919 % 13) / 13.0); });
  expect(folder, "$ARDENT run c.csv -o run", 3,
         {"[clock.jitter]", "c.csv:2", "off an even 99.99", "clock = \"interpolate\""});
  CHECK_FALSE(std::filesystem::exists(folder / "run"));
}

TEST_CASE("rows of which the newest is first are turned round by the line that is shown", "[apps][faults]") {
  const Scratch folder;
  std::string text = table(2000, [&](int i) { return decay(1999 - i, std::to_string(0.01 * (1999 - i))); });
  text.pop_back();  // as exports end
  (void)folder.file("newest.csv", text);
  const support::Ended refused = support::run(folder, "$ARDENT run newest.csv -o run");
  CHECK(refused.code == 3);
  const std::string ask = "Turn them round: ";
  const auto at = refused.err.find(ask);
  REQUIRE(at != std::string::npos);
  const std::string line = refused.err.substr(at + ask.size(), refused.err.find('\n', at) - at - ask.size());
  CHECK(support::run(folder, "{ " + line + "; }").code == 0);
  expect(folder, "$ARDENT info newest.csv.forwards", 0, {"100 Hz", "2000"});
}

TEST_CASE("a clock that trembles within a hundredth of a step keeps its round rate, with a warning", "[apps][faults]") {
  const Scratch folder;
  for (const double late : {0.004, 0.008}) {  // of a step, every other stamp
    (void)folder.file("c.csv",
                      table(2000, [&](int i) { return decay(i, std::to_string(0.01 * i + 0.01 * late * (i % 2))); }));
    CAPTURE(late);
    expect(folder, "$ARDENT info c.csv", 0, {"rate       100 Hz", "clock.jitter"});
    expect(folder, "$ARDENT run c.csv --force -o steady", 0,
           {"warning", "[clock.jitter]", "off an even 100 Hz by up to " + std::to_string(late / 2).substr(0, 5)});
  }
  // A rate that is not round, and no further from it than that, is left as measured.
  (void)folder.file("c.csv",
                    table(2000, [&](int i) { return decay(i, std::to_string(0.010002 * i + 0.00008 * (i % 2))); }));
  CHECK(support::run(folder, "$ARDENT info c.csv").out.find("100 Hz") == std::string::npos);
}

TEST_CASE("a gap in the clock is named and its neighbourhood left out", "[apps][faults]") {
  const Scratch folder;
  (void)folder.file("gap.csv", table(2950, [](int row) {
                      const int i = row < 1500 ? row : row + 50;
                      return decay(i, std::to_string(0.01 * i));
                    }));
  expect(folder, "$ARDENT run gap.csv -o run", 0, {"warning", "clock.gap"});
  CHECK_THAT(bytes_of(folder / "run/segments.json"),
             Catch::Contains("\"label\":\"excluded\"") && Catch::Contains("gap in the clock"));
}

TEST_CASE("a sidecar's rate that the container contradicts is refused with both", "[apps][faults]") {
  std::string sidecar = bytes_of(bench() / "rig/recording.wav.toml");
  sidecar.replace(sidecar.find("rate = 256"), 10, "rate = 250");
  (void)bench().file("rig/other.toml", sidecar);
  (void)bench().file("other.toml", "[[recording]]\nfile = \"rig/recording.wav\"\nsidecar = \"rig/other.toml\"\n");
  expect(bench(), "$ARDENT run other.toml -o run", 3, {"[rate.mismatch]", "256", "250"});
}

TEST_CASE("files of one recording must share rate and length, or be cut on request", "[apps][faults]") {
  const Scratch folder;
  const auto column = [&](const std::string& name, const std::string& header, int n, double step) {
    (void)folder.file(
        name,
        table(
            n, [&](int i) { return std::to_string(step * i) + "," + std::to_string(std::sin(6 * step * i)); }, header));
  };
  (void)folder.file("y.csv.toml",
                    "[[channel]]\nname = \"y\"\nrole = \"y\"\nunit = \"m\"\n"
                    "[[channel]]\nname = \"r\"\nrole = \"r\"\nunit = \"m\"\nfile = \"r.csv\"\n");
  column("y.csv", "t,y\n", 2000, 0.01);
  column("r.csv", "t,r\n", 4000, 0.005);
  expect(folder, "$ARDENT run y.csv -o run", 3, {"[rate.mismatch]", "100", "200", "r.csv"});
  column("r.csv", "t,r\n", 1900, 0.01);
  expect(folder, "$ARDENT run y.csv -o run", 3, {"[channel.length]", "2000", "1900", "--salvage"});
  expect(folder, "$ARDENT check --salvage y.csv", 0, {"warning", "1900"});
}
