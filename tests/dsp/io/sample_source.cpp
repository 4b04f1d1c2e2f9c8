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

TEST_CASE("known formats that are not read are refused with what helps", "[dsp][sample_source]") {
  const Scratch scratch;
  const auto refused = [&](const std::string& bytes, const std::string& name, const std::string& piece) {
    check_fault([&] { (void)dsp::open_source(scratch.file("a", bytes)); }, FaultKind::input, name, {piece});
  };
  refused("\x89HDF\r\n\x1a\n....", "hdf5.damaged", "HDF5 cannot open it");
  refused(std::string(512, ' ') + "\x89HDF\r\n\x1a\n....", "hdf5.damaged", "HDF5 cannot open it");
  refused("{\"data\": [[1, 2]}", "json.syntax", "no JSON at byte");
  refused("PAR1....", "container.unsupported", "read_parquet('a')");
  refused("MDF     4.10", "container.unsupported", "MDF('a')");
  refused("TDSm....", "container.unsupported", "TDMS");
  refused("PK\x03\x04....", "zip.truncated", "ZIP archive that was cut");
  refused("OggS....", "container.lossy", "lossy");
  refused(std::string("ab\0cd", 5), "container.unknown", "byte 2 is 0x00");
  refused("ab\x01\x02\x03\x04\x05\x06", "container.unknown", "byte 2 is 0x01");
}
