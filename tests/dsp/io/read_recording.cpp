#include "dsp/io/read_recording.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <ctime>
#include <tuple>

#include "dsp/io/sound_writer.hpp"
#include "dsp/sensors/motion.hpp"
#include "dsp/values/faults.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"
#include "support/tasks.hpp"

using dsp::FaultKind;
using dsp::Role;
using support::check_fault;
using support::Scratch;

namespace {

const std::filesystem::path real_data = ARDENT_REAL_DATA;

bool missing(const std::string& folder) {
  if (std::filesystem::exists(real_data / folder)) return false;
  WARN("skipped: " << (real_data / folder) << " is not there");
  return true;
}

// Four channels of 24 bit at 1000 Hz whose samples are exact in it.
dsp::FrameBlock steps(Eigen::Index frames, Eigen::Index channels) {
  return dsp::FrameBlock::NullaryExpr(frames, channels, [](Eigen::Index i, Eigen::Index j) {
    return std::ldexp(static_cast<double>((i * 37 + j * 1001) % 8191 - 4000), -13);
  });
}

std::filesystem::path sound(const Scratch& scratch, const dsp::FrameBlock& frames, const std::string& name = "rig.wav",
                            double rate_hz = 1000, dsp::SoundContainer container = dsp::SoundContainer::rf64) {
  dsp::SoundFileWriter writer(
      scratch / name,
      {.container = container, .sample_rate_hz = rate_hz, .num_channels = static_cast<int>(frames.cols())});
  writer.write(frames);
  writer.close();
  return scratch / name;
}

constexpr const char* laser_and_accelerometer = R"(
rate = 1000
[[channel]]
name = "acc"
index = 2
role = "ddy"
sensitivity = "100 mV/g"
full_scale = "5 V"
sign = -1
delay = "1 ms"
highpass = 0.4
[[channel]]
name = "laser"
index = 1
role = "y"
unit = "mm"
sensitivity = "250 mV/mm"
full_scale = "10 V"
offset = "2 V"
[[bad]]
from = 0.1
to = 0.2
why = "knocked"
)";

bool has_check(const dsp::Recording& recording, const std::string& name) {
  for (const auto& check : recording.checks)
    if (check.name == name) return true;
  return false;
}

}  // namespace

TEST_CASE("a hundred thousand columns are read in a time that grows with their number", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto seconds = [&](int num_columns) {
    std::string text = "t";
    for (int c = 1; c < num_columns; ++c) text += ",c" + std::to_string(c);
    for (const char* time : {"0", "0.01", "0.02", "0.03"}) {
      text += std::string("\n") + time;
      for (int c = 1; c < num_columns; ++c) text += ",1.5";
    }
    const auto file = scratch.file("wide.csv", text + "\n");
    const std::clock_t begin = std::clock();
    CHECK(dsp::read_recording(file, {}).samples.cols() == num_columns - 1);
    return static_cast<double>(std::clock() - begin);
  };
  // Four times as many: 4 times the time if linear, 16 if quadratic.
  CHECK(seconds(100'000) < 9.0 * seconds(25'000));
}

TEST_CASE("integers become SI by full scale, sensitivity, offset and sign, in the sidecar's order",
          "[dsp][read_recording]") {
  const Scratch scratch;
  const auto frames = steps(500, 2);
  const auto file = sound(scratch, frames);
  scratch.file("rig.wav.toml", laser_and_accelerometer);
  const auto recording = dsp::read_recording(file);
  REQUIRE(recording.channels.size() == 2);
  CHECK(recording.name == "rig.wav");
  CHECK(recording.sample_rate_hz == 1000.0);
  CHECK(recording.channels[0].name == "acc");
  CHECK(recording.channels[0].unit == "m/s^2");
  CHECK(recording.channels[0].delay_s == 1e-3);
  CHECK(recording.channels[0].highpass_hz == std::vector<double>{0.4});
  CHECK(recording.find(Role::y) == 1);
  CHECK(recording.channels[1].unit == "m");
  REQUIRE(recording.bad.size() == 1);
  CHECK(recording.bad[0].why == "knocked");
  // Four roundings at most between the two ways of writing the same product.
  const Eigen::VectorXd acceleration = -frames.col(1) * 5.0 / 0.1 * 9.80665,
                        position = (frames.col(0) * 10.0 - Eigen::VectorXd::Constant(500, 2.0)) / 250.0;
  CHECK((recording.samples.col(0) - acceleration).cwiseAbs().maxCoeff() <= 4 * 1e-16 * 250);
  CHECK((recording.samples.col(1) - position).cwiseAbs().maxCoeff() <= 4 * 1e-16 * 0.05);
}

TEST_CASE("block sizes change no bit of what is read", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = sound(scratch, steps(1500, 2));
  scratch.file("rig.wav.toml", laser_and_accelerometer);
  std::string table = "x,f\n";
  for (int i = 0; i < 1500; ++i)
    table += i % 97 < 3 ? "nan,1e-3\n" : std::to_string(std::sin(i)) + (i % 200 == 7 ? ",\n" : ",2\n");
  const auto csv = scratch.file("gaps.csv", table);
  scratch.file("gaps.csv.toml", "rate = 100");
  for (const auto& path : {file, csv}) {
    const auto whole = dsp::read_recording(path);
    REQUIRE(whole.samples.rows() == 1500);
    for (const Eigen::Index size : {1, 7, 1000, 65536}) {
      dsp::RecordingReader reader(path);
      dsp::FrameBlock block;
      Eigen::Index done = 0;
      while (const auto got = reader.read(block, size)) {
        REQUIRE(got <= size);
        REQUIRE(block == whole.samples.middleRows(done, got));
        done += got;
      }
      CHECK(done == 1500);
      CHECK(reader.description().bad.size() == whole.bad.size());
      CHECK(reader.description().checks.size() == whole.checks.size());
    }
  }
}

TEST_CASE("a missing sensitivity is an error that prints the lines to add", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = sound(scratch, steps(10, 2));
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::input, "calibration.missing",
              {"no calibration for channel1, channel2", "rig.wav.toml", "--uncalibrated"},
              {"[[channel]]\nname = \"channel1\"\nindex = 1\n", "sensitivity = \"", "full_scale = \"10 V\""});
  scratch.file("rig.wav.toml",
               "[[channel]]\nname = \"acc\"\nindex = 1\nrole = \"ddy\"\nfull_scale = \"5 m/s^2\"\n"
               "[[channel]]\nname = \"laser\"\nindex = 2\nrole = \"y\"\nsensitivity = \"250 mV/mm\"\n");
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::input, "calibration.missing",
              {"no calibration for laser."}, {"rig.wav.toml:6: channel laser\nfull_scale = \"10 V\""});
}

TEST_CASE("the lines it prints make it work", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = sound(scratch, steps(10, 2));
  const dsp::Fault fault = support::fault_of([&] { (void)dsp::read_recording(file); });
  scratch.file("rig.wav.toml", fault.lines());
  CHECK(dsp::read_recording(file).channels.size() == 2);
}

TEST_CASE("uncalibrated channels stay raw and say so", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto frames = steps(10, 2);
  const auto recording = dsp::read_recording(sound(scratch, frames), {.uncalibrated = true});
  CHECK((recording.samples - frames).cwiseAbs().maxCoeff() == 0.0);
  CHECK_FALSE(recording.channels[0].calibrated);
  CHECK(recording.channels[0].unit.empty());
  CHECK(has_check(recording, "calibration.missing"));
}

TEST_CASE("columns called like roles need no sidecar", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto recording = dsp::read_recording(
      scratch.file("response.csv", "t,x,v,a_mm_per_s2,load_kN,note\n0,1,2,3,4,5\n0.5,2,3,4,5,6\n1.0,3,4,5,6,7\n"));
  CHECK(recording.sample_rate_hz == 2.0);
  REQUIRE(recording.channels.size() == 5);
  CHECK(recording.find(Role::x) == 0);
  CHECK(recording.channels[0].unit == "m");
  CHECK(recording.find(Role::a) == 2);
  CHECK(recording.samples(1, 2) == 4e-3);
  CHECK(recording.channels[3].name == "load");
  CHECK(recording.channels[3].role == Role::f);  // by its name and unit
  CHECK(recording.samples(0, 3) == 4000.0);
  CHECK(recording.channels[4].unit.empty());
}

TEST_CASE("a text column with a role needs a unit", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", "t,top\n0,1\n1,2\n2,3\n");
  scratch.file("a.csv.toml", "[[channel]]\nname = \"top\"\nrole = \"y\"\n");
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::input, "calibration.missing", {"top"},
              {"unit = \"m\""});
  scratch.file("a.csv.toml", "[[channel]]\nname = \"top\"\nrole = \"y\"\nunit = \"mm\"\n");
  CHECK(dsp::read_recording(file).samples(2, 0) == 3 * 1e-3);
}

TEST_CASE("a sensitivity is not applied to a column in units already", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", "t,top_mm,volts_mV\n0,1,1\n1,2,2\n");
  scratch.file("a.csv.toml", "[[channel]]\nname = \"top\"\nsensitivity = \"1 V/mm\"\n");
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::usage, "calibration.twice",
              {"a.csv.toml:1", "mm already"});
  scratch.file("a.csv.toml", "[[channel]]\nname = \"volts\"\nsensitivity = \"1 V/mm\"\n");
  CHECK(dsp::read_recording(file).samples(1, 0) == Approx(2e-6).epsilon(1e-15));
}

TEST_CASE("a letter behind a name is no unit where the sidecar states one of another kind", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", "t,acc_V,acc_N,acc_mV\n0,1,1,1\n1,2,2,2\n2,3,3,3\n");
  const std::string vertical = "[[channel]]\nname = \"up\"\ncolumn = \"acc_V\"\nrole = \"ddy\"\nunit = \"g\"\n";
  const std::string north = "[[channel]]\nname = \"north\"\ncolumn = \"acc_N\"\nrole = \"other\"\n";
  scratch.file("a.csv.toml", vertical + north + "sensitivity = \"100 mV/g\"\n");
  const auto recording = dsp::read_recording(file);
  CHECK(recording.samples(1, 0) == Approx(2 * 9.80665).epsilon(1e-15));
  CHECK(recording.samples(1, 1) == Approx(2 * 9.80665 / 0.1).epsilon(1e-15));  // V at the plug
  CHECK_FALSE(has_check(recording, "unit.kind"));
  // Where nothing else is stated the letter counts, and so does what can be nothing but a unit.
  scratch.file("a.csv.toml", "[[channel]]\nname = \"up\"\ncolumn = \"acc_V\"\nrole = \"ddy\"\n");
  CHECK(dsp::read_recording(file).channels[0].unit == "V");
  scratch.file("a.csv.toml", "[[channel]]\nname = \"up\"\ncolumn = \"acc_mV\"\nrole = \"ddy\"\nunit = \"g\"\n");
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::usage, "unit.kind", {"in mV", "sensitivity"});
}

TEST_CASE("one recording may lie in several files", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto frames = steps(100, 3);
  const auto file = sound(scratch, frames.leftCols(1), "a.wav");
  sound(scratch, frames.rightCols(2), "b.w64");
  scratch.file("a.wav.toml", R"(
[[channel]]
name = "r"
full_scale = "1 m"
role = "r"
[[channel]]
name = "y"
file = "b.w64"
full_scale = "1 m"
role = "y"
[[channel]]
name = "f"
file = "b.w64"
full_scale = "1 N"
role = "f"
)");
  dsp::RecordingReader reader(file);
  CHECK(reader.files().size() == 2);
  CHECK(dsp::read_recording(file).samples == frames);
  sound(scratch, frames.topRows(90).rightCols(2), "b.w64");
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::input, "channel.length",
              {"a.wav has 100 frames", "b.w64 has 90"});
  CHECK(dsp::read_recording(file, {.salvage = true}).samples == frames.topRows(90));
  sound(scratch, frames.rightCols(2), "b.w64", 2000);
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::input, "rate.mismatch",
              {"2000 Hz", "a.wav says 1000 Hz"});
}

TEST_CASE("of a recording in several FLACs one has a thread of its own, and none with one thread",
          "[dsp][read_recording]") {
  const Scratch scratch;
  const auto frames = steps(200'000, 2);
  const auto file = sound(scratch, frames.col(0), "a.flac", 1000, dsp::SoundContainer::flac);
  sound(scratch, frames.col(1), "b.flac", 1000, dsp::SoundContainer::flac);
  scratch.file("a.flac.toml", R"(
[[channel]]
name = "y"
full_scale = "1 m"
role = "y"
[[channel]]
name = "r"
file = "b.flac"
full_scale = "1 m"
role = "r"
)");
  const auto before = support::num_tasks();
  for (const int num_threads : {1, 2, 8}) {
    dsp::RecordingReader reader(file, {.num_threads = num_threads});
    REQUIRE(reader.files().size() == 2);
    dsp::FrameBlock block;
    for (Eigen::Index done = 0; reader.read(block, 16384) > 0; done += block.rows()) {
      REQUIRE(block == frames.middleRows(done, block.rows()));
      CHECK(support::num_tasks() - before <= (num_threads > 1 ? 1 : 0));  // it lives while there is something to digest
    }
    CHECK(support::num_tasks() == before);  // it ends with the record
  }
}

TEST_CASE("a rate that contradicts the container is refused with both numbers", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = sound(scratch, steps(10, 1));
  const std::string channel = "\n[[channel]]\nname = \"y\"\nrole = \"y\"\nfull_scale = \"1 m\"\n";
  scratch.file("rig.wav.toml", "rate = 1001" + channel);
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::input, "rate.mismatch",
              {"1000 Hz", "the sidecar says 1001 Hz"});
  sound(scratch, steps(10, 1), "rig.wav", 17067);
  scratch.file("rig.wav.toml", "rate = \"51200/3\"" + channel);
  CHECK(dsp::read_recording(file).sample_rate_hz == 51200.0 / 3);
  const auto csv = scratch.file("a.csv", "t,x\n0,1\n0.01,2\n0.02,3\n");
  scratch.file("a.csv.toml", "rate = 50");
  check_fault([&] { (void)dsp::read_recording(csv); }, FaultKind::input, "rate.mismatch", {"50 Hz", "100 Hz"});
  const auto bare = scratch.file("b.csv", "x\n1\n2\n");
  check_fault([&] { (void)dsp::read_recording(bare); }, FaultKind::input, "rate.missing", {"b.csv.toml"},
              {"rate = \"?\"  # samples a second, in Hz\n"});
  // Pasted as it is, it is no rate.
  scratch.file("b.csv.toml", "rate = \"?\"");
  check_fault([&] { (void)dsp::read_recording(bare); }, FaultKind::usage, "config.range", {"rate", "'?'"});
}

TEST_CASE("without rate and roles both are asked for at once", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", "3,1\n1,2\n2,1\n");
  std::vector<std::string> names;
  std::string lines;
  try {
    (void)dsp::read_recording(file);
  } catch (const dsp::SeveralFaults& faults) {
    for (const dsp::Fault& fault : faults.all()) {
      names.push_back(fault.name());
      lines += fault.lines();
    }
  }
  CHECK(names == std::vector<std::string>{"rate.missing", "motion.none"});
  scratch.file("a.csv.toml", "rate = 100\n" + lines.substr(lines.find('#', lines.find('\n'))));
  CHECK(dsp::read_recording(file).sample_rate_hz == 100.0);  // the lines can be pasted
}

TEST_CASE("a draft is written whatever is the matter with the clock, and says it", "[dsp][read_recording]") {
  const Scratch scratch;
  std::string uneven = "t,base_mm,payload_mm\n";
  for (int i = 0; i < 20; ++i) uneven += fmt::format("{},{},{}\n", 0.1 * i + 0.02 * (i % 3), i % 5, i % 7);
  const auto file = scratch.file("u.csv", uneven);
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::input, "clock.jitter", {"uneven"});
  const std::string draft = dsp::draft_sidecar(file);
  CHECK_THAT(draft, Catch::Matchers::Contains("is uneven") &&
                        Catch::Matchers::Contains("# rate = 10\n# clock = \"interpolate\"\n"));
  CHECK_THAT(draft, Catch::Matchers::Contains("role = \"r\"  # by its name and unit") &&
                        Catch::Matchers::Contains("role = \"y\"  # by its name and unit"));
  scratch.file("u.csv.toml", "rate = 10\nclock = \"interpolate\"\n" + draft);
  CHECK(dsp::read_recording(file).find(Role::y) == 1);
}

TEST_CASE("roles and names must be distinct, and `use` does it", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", "t,p_mm,q_mm\n0,1,10\n1,2,20\n");
  scratch.file("a.csv.toml", "[[channel]]\nname = \"p\"\nrole = \"y\"\n[[channel]]\nname = \"q\"\nrole = \"y\"\n");
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::usage, "channel.role",
              {"'p' and 'q'", "role y", "use ="});
  const auto recording = dsp::read_recording(file, {.use = {{"y", "q"}}});
  CHECK(recording.find(Role::y) == 1);
  CHECK(recording.channels[0].role == Role::other);
  check_fault(
      [&] {
        (void)dsp::read_recording(file, {.use = {{"y", "z"}}});
      },
      FaultKind::usage, "channel.name", {"only p, q"});
  check_fault(
      [&] {
        (void)dsp::read_recording(file, {.use = {{"why", "p"}}});
      },
      FaultKind::usage, "channel.role", {"role must be"});
  check_fault(
      [&] {
        (void)dsp::read_recording(file, {.use = {{"ddy", "p"}, {"y", "q"}}});
      },
      FaultKind::usage, "unit.role", {"'p' is in m", "m/s^2"});
  const auto twice = scratch.file("b.csv", "t,x,x\n0,1,2\n1,2,3\n");
  check_fault([&] { (void)dsp::read_recording(twice); }, FaultKind::usage, "channel.name",
              {"two channels are called 'x'"});
}

TEST_CASE("a channel that is not in the file is named beside what is", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", "t,p_mm\n0,1\n1,2\n");
  scratch.file("a.csv.toml", "[[channel]]\nname = \"q\"\n");
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::input, "channel.column",
              {"no column 'q'", "t, p_mm"});
  scratch.file("a.csv.toml", "[[channel]]\nname = \"q\"\nindex = 3\n");
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::usage, "channel.index",
              {"has 2 columns, got index 3"});
  scratch.file("a.csv.toml", "[[channel]]\nname = \"q\"\nindex = 1\n");
  check_fault([&] { (void)dsp::read_recording(file); }, FaultKind::usage, "channel.index", {"which is its clock"});
}

TEST_CASE("a message shows what is in a file that a sidecar names only where it came with the recording",
          "[dsp][read_recording]") {
  const Scratch scratch;
  std::filesystem::create_directories(scratch / "sent/parts");
  const std::string header = "t,pass-phrase\n0,1\n1,hunter2\n", cells = "0,1\n1,hunter2\n",
                    text = "user,pass\nhunter2,me\n";
  const std::string clock = "t,u\n0 s,1\nhunter2,2\n", moments = "t,u\n10:00:00,1\nhunter2,2\n";
  std::string late = "t,x\n";
  for (int i = 0; i < 300; ++i) late += fmt::format("10:{:02}:{:02},1\n", i / 60, i % 60);
  for (const std::string& content :
       {header, cells, text, clock, moments, late + "hunter2,1\n", late + "10:05:00,hunter2\n"}) {
    CAPTURE(content.substr(0, 40));
    const std::string rows = content.starts_with(late) ? late + "10:05:00,1\n" : "t,x\n0,1\n1,2\n";  // as many as there
    const auto file = scratch.file("sent/a.csv", rows);
    const auto message = [&](const std::string& name, const std::string& how) {
      scratch.file("sent/a.csv.toml",
                   "rate = 1\n[[channel]]\nname = \"x\"\n[[channel]]\nname = \"q\"\nfile = \"" + name + "\"\n" + how);
      const dsp::Fault fault = support::fault_of([&] { (void)dsp::read_recording(file); });
      CHECK(fault.kind() == FaultKind::input);
      return std::string(fault.what());
    };
    scratch.file("secret.txt", content);
    scratch.file("sent/own.txt", content);
    scratch.file("sent/parts/own.txt", content);
    std::filesystem::remove(scratch / "sent/link.txt");
    std::filesystem::create_symlink(scratch / "secret.txt", scratch / "sent/link.txt");
    const auto shows = [](const std::string& said) {
      return said.find("hunter2") != std::string::npos || said.find("pass") != std::string::npos;
    };
    for (const char* how : {"", "index = 2\n"}) {
      for (const std::string& name :
           {std::string("../secret.txt"), (scratch / "secret.txt").string(), std::string("link.txt")}) {
        const std::string said = message(name, how);
        CAPTURE(said);
        CHECK_FALSE(shows(said));
        CHECK_THAT(said, Catch::Contains(".txt"));
      }
      for (const char* name : {"own.txt", "parts/own.txt"}) {
        const std::string said = message(name, how);
        CAPTURE(said);
        CHECK((shows(said) || said.find("there are") != std::string::npos));
      }
    }
  }
}

TEST_CASE("gaps are bridged by straight lines and marked, however long; a channel without a value is refused",
          "[dsp][read_recording]") {
  const Scratch scratch;
  const auto with_gap = [&](int from, int to, int rows) {
    std::string table = "x\n";
    for (int i = 0; i < rows; ++i)
      table += i >= from && i < to ? (i % 2 ? "NaN\n" : "inf\n") : std::to_string(2 * i) + "\n";
    scratch.file("a.csv.toml", "rate = 10");
    return scratch.file("a.csv", table);
  };
  const auto middle = dsp::read_recording(with_gap(40, 45, 200));
  for (int i = 0; i < 200; ++i) CHECK(middle.samples(i, 0) == Approx(2.0 * i).epsilon(1e-15).margin(1e-300));
  REQUIRE(middle.bad.size() == 1);
  CHECK(middle.bad[0].from_s == 4.0);
  CHECK(middle.bad[0].to_s == 4.5);
  CHECK(has_check(middle, "sample.missing"));
  const auto ends = dsp::read_recording(with_gap(195, 200, 200));
  CHECK(ends.samples(199, 0) == 2.0 * 194);
  const auto late = dsp::read_recording(with_gap(0, 150, 200));  // its sensor was not on yet
  CHECK(late.samples(0, 0) == 300.0);
  CHECK(late.samples(150, 0) == 300.0);
  REQUIRE(late.bad.size() == 1);
  CHECK(late.bad[0].to_s == 15.0);
  check_fault([&] { (void)dsp::read_recording(with_gap(0, 200, 200)); }, FaultKind::input, "sample.missing",
              {"no value at all"});
  for (const auto& [from, to, rows] : {std::tuple(40, 51, 500), std::tuple(40, 46, 100), std::tuple(40, 400, 500)}) {
    const auto gap = dsp::read_recording(with_gap(from, to, rows));
    for (int i = 0; i < rows; ++i) CHECK(gap.samples(i, 0) == Approx(2.0 * i).epsilon(1e-12).margin(1e-300));
    REQUIRE(gap.bad.size() == 1);
    CHECK(gap.bad[0].from_s == Approx(0.1 * from));
    CHECK(gap.bad[0].to_s == Approx(0.1 * to));
  }
  scratch.file("b.csv.toml", "rate = 10");
  check_fault([&] { (void)dsp::read_recording(scratch.file("b.csv", "x\n1\n1e300\n2\n")); }, FaultKind::input,
              "sample.huge", {"1e+300 at 0.1 s"});
  CHECK(dsp::read_recording(scratch.file("b.csv", "x\n1\n1e-310\n1e-400\n")).samples(1, 0) == 1e-310);
}

TEST_CASE("two channels on one column are refused", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto csv = scratch.file("a.csv", "t,x,f\n0,1,1\n0.5,2,2\n");
  const auto refused = [&](const std::string& first, const std::string& second) {
    scratch.file("a.csv.toml", "[[channel]]\nname = \"x\"\nunit = \"m\"\n" + first +
                                   "[[channel]]\nname = \"twice\"\nunit = \"m\"\n" + second);
    check_fault([&] { (void)dsp::read_recording(csv); }, FaultKind::usage, "channel.index",
                {"a.csv.toml:", "channels 'x' and 'twice' both are column 2 of a.csv"});
  };
  refused("index = 2\n", "index = 2\n");
  refused("", "index = 2\n\n");
  refused("", "column = \"x\"\n");
}

TEST_CASE("a second file that begins a fraction of a sample late is shifted, one beyond half a sample is refused",
          "[dsp][read_recording]") {
  const Scratch scratch;
  const auto table = [](const std::string& name, double late_s) {
    std::string text = "t," + name + "\n";
    for (int i = 0; i < 400; ++i)
      text += std::to_string(late_s + 0.01 * i) + "," + std::to_string(std::sin(6.0 * (late_s + 0.01 * i))) + "\n";
    return text;
  };
  const auto first = scratch.file("y.csv", table("y", 0.0));
  scratch.file("y.csv.toml",
               "[[channel]]\nname = \"y\"\nrole = \"y\"\nunit = \"m\"\n"
               "[[channel]]\nname = \"r\"\nrole = \"r\"\nunit = \"m\"\nfile = \"r.csv\"\ndelay = \"1 ms\"\n");
  scratch.file("r.csv", table("r", 0.005));
  auto recording = dsp::read_recording(first);
  CHECK(recording.channels[1].delay_s == Approx(0.001 - 0.005).margin(1e-12));
  REQUIRE(has_check(recording, "clock.start"));
  for (const auto& check : recording.checks)
    if (check.name == "clock.start")
      CHECK_THAT(check.message, Catch::Contains("r.csv: starts at 0.005 s, y.csv at 0 s"));
  recording.channels[1].delay_s -= 0.001;  // which is not true of these samples
  dsp::remove_delays(recording);
  // Six decimals in the tables; the ends lean on samples predicted beyond them.
  CHECK((recording.samples.col(0) - recording.samples.col(1)).segment(50, 300).cwiseAbs().maxCoeff() <= 1e-4);
  scratch.file("r.csv", table("r", 0.006));
  check_fault([&] { (void)dsp::read_recording(first); }, FaultKind::input, "clock.start", {"more than half a sample"});
  scratch.file("r.csv", table("r", 0.00005));
  CHECK_FALSE(has_check(dsp::read_recording(first), "clock.start"));
}

TEST_CASE("two files are on one clock only if they begin on one day", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto table = [](const std::string& name, const std::string& date) {
    std::string text = (date.empty() ? "" : "Date;") + ("Time;" + name + "\n");
    for (int i = 0; i < 100; ++i)
      text += (date.empty() ? "" : date + ";") + fmt::format("10:00:{:05.2f};{}\n", 0.1 * i, i % 7);
    return text;
  };
  const auto first = scratch.file("y.csv", table("y", "2026-11-20"));
  scratch.file("y.csv.toml",
               "[[channel]]\nname = \"y\"\nrole = \"y\"\nunit = \"m\"\n"
               "[[channel]]\nname = \"r\"\nrole = \"r\"\nunit = \"m\"\nfile = \"r.csv\"\n");
  for (const char* same : {"2026-11-20", "20.11.2026", ""}) {
    scratch.file("r.csv", table("r", same));
    CHECK(dsp::read_recording(first).samples.rows() == 100);
  }
  scratch.file("r.csv", table("r", "2026-11-21"));
  check_fault([&] { (void)dsp::read_recording(first); }, FaultKind::input, "clock.start",
              {"r.csv: starts at 2026-11-21 10:00:00, y.csv at 2026-11-20 10:00:00", "Cut the files"});
}

TEST_CASE("a recording larger than the memory allowed is refused before it is read", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = sound(scratch, steps(1000, 2));
  check_fault([&] { (void)dsp::read_recording(file, {.uncalibrated = true, .max_memory_bytes = 15'999}); },
              FaultKind::numerics, "memory.limit", {"needs 0.016 MB of memory, 0.016 MB"});
}

TEST_CASE("frames held until a late channel begins count with what is taken beside the reader",
          "[dsp][read_recording]") {
  const Scratch scratch;
  std::string text = "t,x,f\n";
  for (int i = 0; i < 1000; ++i)
    text += fmt::format("{:.2f},{},{}\n", 0.01 * i, i % 7, i < 700 ? "NaN" : std::to_string(i % 5));
  const auto file = scratch.file("late.csv", text);
  dsp::FrameBlock block;
  for (const bool fits : {true, false}) {
    dsp::RecordingReader reader(file, {.max_memory_bytes = 100'000});
    reader.set_bytes_beside(fits ? 100'000.0 - 16.0 * 700 : 100'001.0 - 16.0 * 700);  // two channels of 8 bytes
    if (fits)
      CHECK(reader.read(block, 2000) == 1000);
    else
      check_fault([&] { (void)reader.read(block, 2000); }, FaultKind::numerics, "memory.limit", {"late.csv", "0.1 MB"});
  }
}

TEST_CASE("a drafted sidecar holds what is known, leaves out what is not, and can be read", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto csv = scratch.file("a.csv", "t_s,x_mm,load_kN,what\n0,1,1,1\n0.5,2,2,2\n");
  const auto text = dsp::draft_sidecar(csv);
  CHECK_THAT(text,
             Catch::Contains("# rate = 2 ") && Catch::Contains("role = \"x\"") && Catch::Contains("unit = \"kN\""));
  scratch.file("a.csv.toml", text);
  CHECK(dsp::read_recording(csv).samples(1, 0) == 2 * 1e-3);
  const auto wav = sound(scratch, steps(10, 2));
  scratch.file("rig.wav.toml", dsp::draft_sidecar(wav));
  CHECK(support::name_of_fault([&] { (void)dsp::read_recording(wav); }) == "calibration.missing");
}

TEST_CASE("the friction frame reads the same from CSV and from MATLAB", "[dsp][read_recording][real]") {
  if (missing("friction_frame")) return;
  const Scratch scratch;
  for (const std::string load : {"250g", "450g"}) {
    const auto folder = real_data / "friction_frame";
    const auto csv = scratch.file("csv.toml",
                                  "[[channel]]\nname = \"top\"\ncolumn = \"x_top_mm\"\nrole = \"y\"\n"
                                  "[[channel]]\nname = \"base\"\ncolumn = \"y_base\"\nrole = \"r\"\n");
    const auto mat = scratch.file("mat.toml",
                                  "[[channel]]\nname = \"top\"\ncolumn = \"x\"\nrole = \"y\"\nunit = \"mm\"\n"
                                  "[[channel]]\nname = \"base\"\ncolumn = \"y\"\nfile = \"s_b_" +
                                      load + "_y.mat\"\nrole = \"r\"\nunit = \"mm\"\n");
    const auto a = dsp::read_recording(folder / ("frame_" + load + ".csv"), {.sidecar = csv});
    const auto b = dsp::read_recording(folder / ("s_b_" + load + "_x.mat"), {.sidecar = mat});
    CHECK(a.samples.rows() == 2501);
    CHECK(a.sample_rate_hz == 250.0);
    CHECK(b.sample_rate_hz == 250.0);
    CHECK(a.clock_start_s == (load == "250g" ? 0.0 : 17.0));
    // The text was printed from the MATLAB numbers and is off by up to 9e-14 mm.
    CHECK((a.samples - b.samples).cwiseAbs().maxCoeff() < 1e-16);
    CHECK(a.find(Role::r) == 1);
  }
}

TEST_CASE("the pneumatic laser's uneven clock is refused, then interpolated with its three gaps marked",
          "[dsp][read_recording][real]") {
  if (missing("pneumatic_laser")) return;
  const Scratch scratch;
  const auto file = real_data / "pneumatic_laser/O-ring_5bar.csv";
  const std::string time = "[[channel]]\nname = \"time\"\nindex = 1\nrole = \"t\"\nunit = \"ms\"\n";
  const std::string rest = "[[channel]]\nname = \"laser\"\nindex = 5\nrole = \"y\"\nunit = \"mm\"\n";
  check_fault([&] { (void)dsp::read_recording(file, {.sidecar = scratch.file("s.toml", time + rest)}); },
              FaultKind::input, "clock.jitter", {"uneven"}, {"clock = \"interpolate\""});
  // With nothing said of it, its clock is found, and the lines that settle unit, unevenness and roles can be pasted.
  std::string lines;
  std::vector<std::string> names;
  try {
    (void)dsp::read_recording(file, {.sidecar = scratch.file("s.toml", "")});
  } catch (const dsp::SeveralFaults& faults) {
    for (const dsp::Fault& fault : faults.all()) {
      names.push_back(fault.name());
      lines += fault.lines();
    }
  }
  CHECK(names == std::vector<std::string>{"clock.unit", "motion.none"});
  const auto found = dsp::read_recording(file, {.sidecar = scratch.file("s.toml", lines)});
  CHECK(found.sample_rate_hz == 100.0);
  CHECK(found.samples.rows() == 10629);
  REQUIRE(found.channels.size() == 6);
  CHECK(found.samples(0, 3) == 0.018);  // channel5
  const auto recording = dsp::read_recording(
      file, {.sidecar = scratch.file("s.toml", "rate = 100\nclock = \"interpolate\"\n" + time + rest)});
  CHECK(recording.samples.rows() == 10629);
  REQUIRE(recording.bad.size() == 3);
  CHECK(recording.bad[0].to_s == Approx(0.277));
  CHECK(recording.samples(0, 0) == 0.018e-3);
  // Halfway between rows at 277 and 287 ms lies no frame; 280 ms does: 0.3 of the way from 0.838 to 0.890.
  CHECK(recording.samples(28, 0) == Approx(1e-3 * (0.7 * 0.838 + 0.3 * 0.890)).epsilon(1e-12));
}

TEST_CASE("records of the laboratory are read as their owners describe them", "[dsp][read_recording][real]") {
  if (missing("silverbox_multisine") || missing("pendulum") || missing("impact_51k2") || missing("shaker_beam_51k2"))
    return;
  const Scratch scratch;
  SECTION("silverbox: trailing commas, no clock") {
    const auto sidecar = scratch.file("s.toml",
                                      "rate = \"1e7/16384\"\n[[channel]]\nname = \"V1\"\nrole = \"f\"\nunit = \"V\"\n"
                                      "[[channel]]\nname = \"V2\"\nrole = \"y\"\nunit = \"V\"\n");
    const auto recording =
        dsp::read_recording(real_data / "silverbox_multisine/snls80mv_rows_40496_118723.csv", {.sidecar = sidecar});
    CHECK(recording.sample_rate_hz == 610.3515625);
    CHECK(recording.samples.rows() == 78228);
    CHECK(recording.samples(1, 1) == -0.038037);
  }
  SECTION("pendulum: the same angle from text and from Simulink's structure") {
    const auto csv = dsp::read_recording(real_data / "pendulum/freeswing_10kHz.csv");
    const auto sidecar = scratch.file("p.toml", "[[channel]]\nname = \"theta\"\ncolumn = \"Theta1\"\nunit = \"rad\"\n");
    const auto mat =
        dsp::read_recording(real_data / "pendulum/SingleDataFreeSwing_1_Dt_0_0001.mat", {.sidecar = sidecar});
    CHECK(csv.sample_rate_hz == 10'000.0);
    CHECK(mat.sample_rate_hz == 10'000.0);
    CHECK(csv.samples.rows() == 231'757);
    CHECK((csv.samples - mat.samples).cwiseAbs().maxCoeff() < 0.6e-8);  // the text has 8 decimals
  }
  SECTION("impact: the rate of the header, not of stamps printed too coarsely") {
    const auto recording = dsp::read_recording(real_data / "impact_51k2/Test_008.lvm");
    CHECK(recording.sample_rate_hz == 51'200.0);
    REQUIRE(recording.channels.size() == 2);
    const auto first = recording.samples.col(0).array() - recording.samples(0, 0);
    CHECK(first.minCoeff() == Approx(-12'807).epsilon(1e-4));
    CHECK(first.maxCoeff() == Approx(39'401).epsilon(1e-4));
  }
  SECTION("shaker: the stamps, because the header contradicts them") {
    const auto recording = dsp::read_recording(real_data / "shaker_beam_51k2/data_set_1_downsampled_by_16.lvm");
    CHECK(recording.sample_rate_hz == 3200.0);
    CHECK(recording.samples.rows() == 63'041);
    CHECK(has_check(recording, "clock.header"));
    CHECK(recording.samples.col(1).mean() / 4.4482216152605 == Approx(-5.17).epsilon(1e-3));
  }
}

TEST_CASE("what an uncalibrated number was taken for is said, and which of two units counts", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", "t,top_mm,volts\n0,1,1\n1,2,2\n");
  const auto remark = [&](const std::string& channel) {
    scratch.file("a.csv.toml", "[[channel]]\n" + channel);
    const auto recording = dsp::read_recording(file);
    const auto found = std::find_if(recording.checks.begin(), recording.checks.end(),
                                    [](const dsp::Check& check) { return check.name == "calibration"; });
    return std::make_pair(recording.samples(1, 0), found == recording.checks.end() ? "" : found->message);
  };
  const auto [plug, taken] = remark("name = \"volts\"\nsensitivity = \"1 V/mm\"\n");
  CHECK(plug == Approx(2e-3).epsilon(1e-15));
  CHECK_THAT(taken, Catch::Contains("1.0 in the file taken as 1 V"));
  const auto [stated, followed] = remark("name = \"top\"\nunit = \"um\"\n");
  CHECK(stated == Approx(2e-6).epsilon(1e-15));
  CHECK_THAT(followed, Catch::Contains("the column says mm, the sidecar um: the sidecar was followed"));
}

TEST_CASE("a reader that is moved goes on where it was", "[dsp][read_recording]") {
  const Scratch scratch;
  const auto file = scratch.file("a.csv", "x,f\n1,2\n3,4\n5,6\n");
  scratch.file("a.csv.toml", "rate = 100");
  dsp::RecordingReader first(file), other(file);
  dsp::FrameBlock block;
  REQUIRE(first.read(block, 2) == 2);
  other = std::move(first);
  dsp::RecordingReader last(std::move(other));
  REQUIRE(last.read(block, 2) == 1);
  CHECK(block(0, 1) == 6.0);
}
