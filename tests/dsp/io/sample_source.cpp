#include "dsp/io/sample_source.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "dsp/io/sound_writer.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"

using dsp::FaultKind;
using support::check_fault;
using support::Scratch;

TEST_CASE("what is no file is named for what it is", "[dsp][sample_source]") {
  const Scratch scratch;
  const auto refused = [](const std::filesystem::path& path, const std::string& name, const std::string& piece) {
    check_fault([&] { (void)dsp::open_source(path); }, FaultKind::input, name, {piece});
  };
  refused(scratch / "nothing.wav", "file.missing", "No such file");
  (void)scratch.file("drive_1.wav", "RIFF");
  refused(scratch / "drvie_1.wav", "file.missing", "drive_1.wav'?");
  refused(scratch / "", "file.kind", "a directory");
  refused("/dev/null", "file.kind", "a device");
  refused(scratch.file("empty.wav", ""), "file.empty", "0 bytes");
  REQUIRE(::mkfifo((scratch / "pipe").c_str(), 0600) == 0);
  refused(scratch / "pipe", "file.kind", "a pipe");
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  (scratch / "socket").string().copy(address.sun_path, sizeof address.sun_path - 1);
  REQUIRE(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  refused(scratch / "socket", "file.kind", "a socket");
  ::close(socket);
}

TEST_CASE("the reader is chosen by content, and a wrong name is remarked on", "[dsp][sample_source]") {
  const Scratch scratch;
  dsp::SoundFileWriter writer(scratch / "sound.csv", {.sample_rate_hz = 100, .num_channels = 1});
  writer.write(dsp::FrameBlock::Zero(10, 1));
  writer.close();
  const auto sound = dsp::open_source(scratch / "sound.csv");
  CHECK(sound->info().container == "WAV, 24 bit");
  REQUIRE(sound->info().checks.size() == 1);
  CHECK(sound->info().checks[0].name == "container.extension");
  CHECK(sound->info().checks[0].status == dsp::CheckStatus::warning);
  const auto text = dsp::open_source(scratch.file("text.wav", "x,y\n1,2\n3,4\n"));
  CHECK(text->info().container == "CSV, comma separated");
  CHECK(text->info().checks.size() == 1);
  CHECK(dsp::open_source(scratch.file("text.csv", "x,y\n1,2\n3,4\n"))->info().checks.empty());
  CHECK(dsp::open_source(scratch.file("text.dat", "x,y\n1,2\n3,4\n"))->info().checks.empty());
}

TEST_CASE("control codes in a header are escaped, not taken for another container", "[dsp][sample_source]") {
  const Scratch scratch;
  const auto table = dsp::open_source(scratch.file("a.csv", "t,\x1b[31mred\x07,\xff\n0,1,2\n1,3,4\n"));
  CHECK(table->info().columns == std::vector<std::string>{"t", "\\x1b[31mred\\x07", "\xc3\xbf"});
}

namespace {

// With one empty member.
std::string empty_archive(const std::string& member) {
  const auto number = [](std::size_t value, std::size_t count) {
    std::string bytes(count, '\0');
    for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<char>(value >> 8 * i & 0xff);
    return bytes;
  };
  const std::string local = "PK\x03\x04" + std::string(22, '\0') + number(member.size(), 2) + number(0, 2) + member;
  const std::string list =
      "PK\x01\x02" + std::string(24, '\0') + number(member.size(), 2) + std::string(16, '\0') + member;
  return local + list + "PK\x05\x06" + number(0, 4) + number(1, 2) + number(1, 2) + number(list.size(), 4) +
         number(local.size(), 4) + number(0, 2);
}

}  // namespace

TEST_CASE("known formats that are not read are refused with what helps", "[dsp][sample_source]") {
  const Scratch scratch;
  const auto refused = [&](const std::string& bytes, const std::string& name, const std::string& piece) {
    check_fault([&] { (void)dsp::open_source(scratch.file("a", bytes)); }, FaultKind::input, name, {piece});
  };
  refused("\x89HDF\r\n\x1a\n....", "hdf5.damaged", "HDF5 cannot open it");
  refused(std::string(512, ' ') + "\x89HDF\r\n\x1a\n....", "hdf5.damaged", "HDF5 cannot open it");
  refused("{\"data\": [[1, 2]}", "json.syntax", "no JSON at byte");
  const std::string path = (scratch / "a").string();
  refused("PAR1....", "container.unsupported", "read_parquet('" + path + "')");
  refused("MDF     4.10", "container.unsupported", "MDF('" + path + "')");
  refused("\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "container.unsupported", "read_excel('" + path + "')");
  refused(empty_archive("xl/workbook.xml"), "container.unsupported", "read_excel('" + path + "')");
  refused(empty_archive("content.csv"), "container.unsupported", "unzip '" + path + "'");
  refused("\x1f\x8b\x08", "container.unsupported", "gunzip < '" + path + "'");
  check_fault([&] { (void)dsp::open_source(scratch.file("a.csv.gz", "\x1f\x8b\x08")); }, FaultKind::input,
              "container.unsupported", {"gunzip -k '" + path + ".csv.gz'"});
  check_fault([&] { (void)dsp::open_source(scratch.file("$(rm a).gz", "\x1f\x8b\x08")); }, FaultKind::input,
              "container.unsupported", {"gunzip -k 'FILE'"});
  refused("PK\x03\x04....", "zip.truncated", "ZIP archive that was cut");
  refused("OggS....", "container.lossy", "lossy");
  refused(std::string("ab\0cd", 5), "container.unknown", "byte 2 is 0x00");
  refused("ab\x01\x02\x03\x04\x05\x06", "container.unknown", "byte 2 is 0x01");
}
