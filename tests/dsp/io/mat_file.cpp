#include "dsp/io/mat_file.hpp"

#include <rapidcheck/catch.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "support/fault.hpp"
#include "support/fuzz.hpp"
#include "support/mat.hpp"
#include "support/scratch.hpp"

using dsp::FaultKind;
using support::check_fault;
using support::Mat;
using support::Scratch;

namespace {

std::vector<double> times(int count) {
  std::vector<double> list;
  for (int i = 0; i < count; ++i) list.push_back(i / 250.0);
  return list;
}
std::vector<double> wave(int count) {
  std::vector<double> list;
  for (int i = 0; i < count; ++i) list.push_back(std::sin(0.1 * i));
  return list;
}

dsp::FrameBlock read_all(dsp::SampleSource& source, Eigen::Index size = 100) {
  dsp::FrameBlock all(source.info().num_frames, static_cast<Eigen::Index>(source.info().columns.size())), block;
  Eigen::Index done = 0;
  while (const auto got = source.read(block, size)) {
    all.middleRows(done, got) = block;
    done += got;
  }
  REQUIRE(done == all.rows());
  return all;
}

}  // namespace

TEST_CASE("vectors of a MATLAB file are columns on its clock", "[dsp][mat_file]") {
  const Scratch scratch;
  for (const bool big : {false, true})
    for (const bool packed : {false, true}) {
      const Mat mat{big};
      const auto put = [&](const std::string& bytes) { return packed ? mat.compressed(bytes) : bytes; };
      const auto file = scratch.file("a.mat", mat.header() + put(mat.vector("t", times(1000))) +
                                                  put(mat.vector("x_mm", wave(1000))) + put(mat.vector("k", {3.0})));
      const auto source = dsp::open_source(file);
      CHECK(source->info().container == "MATLAB v5");
      CHECK(source->info().sample_rate_hz == 250.0);
      CHECK(source->info().columns == std::vector<std::string>{"t", "x_mm"});
      CHECK(source->info().units[1] == "mm");
      REQUIRE(source->info().left_out.size() == 1);
      CHECK(source->info().left_out[0] == "k (1x1 double)");
      const auto frames = read_all(*source);
      for (int i = 0; i < 1000; ++i) CHECK(frames(i, 1) == wave(1000)[i]);
      CHECK((read_all(*dsp::open_source(file), 7) - frames).cwiseAbs().maxCoeff() == 0.0);
    }
}

TEST_CASE("a MATLAB file called .wav goes to the reader of MATLAB files", "[dsp][mat_file]") {
  const Scratch scratch;
  const Mat mat;
  const auto source = dsp::open_source(scratch.file("a.wav", mat.header() + mat.vector("x", wave(50))));
  CHECK(source->info().container == "MATLAB v5");
  CHECK(source->info().sample_rate_hz == 0.0);
  CHECK(source->info().checks.back().name == "container.extension");
}

TEST_CASE("Simulink's structure with time gives its signal and its clock", "[dsp][mat_file]") {
  const Scratch scratch;
  const Mat mat;
  const auto theta = mat.structure("theta", {{"time", mat.vector("", times(200))},
                                             {"signals", mat.structure("", {{"values", mat.vector("", wave(200))}})}});
  const auto source = dsp::open_source(scratch.file("a.mat", mat.header() + mat.compressed(theta)));
  CHECK(source->info().columns == std::vector<std::string>{"time", "theta"});
  CHECK(source->info().sample_rate_hz == 250.0);
  CHECK(read_all(*source)(7, 1) == wave(200)[7]);
}

TEST_CASE("what is no real vector is listed where something is missing", "[dsp][mat_file]") {
  const Scratch scratch;
  const Mat mat;
  const std::string bytes = mat.header() + mat.matrix("cells", 1, {1, 1}, mat.vector("", {1.0})) +
                            mat.matrix("z", 6, {2, 1},
                                       mat.element(9, mat.values(std::vector<double>{1, 2})) +
                                           mat.element(9, mat.values(std::vector<double>{1, 2})),
                                       0x800) +
                            mat.matrix("plane", 6, {2, 2}, mat.element(9, mat.values(wave(4)))) +
                            mat.matrix("none", 6, {0, 0}, mat.element(9, ""));
  check_fault(
      [&] { (void)dsp::open_source(scratch.file("a.mat", bytes)); }, FaultKind::input, "mat.no_variable",
      {"cells (1x1 cell)", "z (2x1 complex double)", "plane (2x2 double)", "none (0x0 double)", "want real vectors"});
  check_fault([&] { (void)dsp::open_source(scratch.file("b.mat", mat.header())); }, FaultKind::input, "mat.no_variable",
              {"no variable"});
}

TEST_CASE("integers, logicals and the columns of a matrix are read, and what is not is named", "[dsp][mat_file]") {
  const Scratch scratch;
  for (const bool big : {false, true}) {
    const Mat mat{big};
    const std::vector<std::int16_t> counts{1, -2, 3, 32767};
    const std::vector<std::uint8_t> switched{0, 1, 1, 0};
    const std::vector<double> pair{1, 2, 3, 4, 10, 20, 30, 40};  // column by column
    const auto file = scratch.file(
        "a.mat", mat.header() + mat.vector("t", times(4)) +
                     mat.matrix("counts", 10, {4, 1}, mat.element(3, mat.values(counts))) +
                     mat.matrix("on", 9, {1, 4}, mat.element(2, mat.values(switched)), 0x200) +
                     mat.matrix("y_mm", 6, {4, 2}, mat.element(9, mat.values(pair))) +
                     mat.matrix("lying", 6, {2, 4}, mat.element(9, mat.values(pair))) + mat.vector("short", wave(3)) +
                     mat.matrix("square", 6, {4, 4}, mat.element(9, mat.values(wave(16)))) + mat.vector("k", {3.0}));
    const auto source = dsp::open_source(file);
    const auto& info = source->info();
    CHECK(info.columns == std::vector<std::string>{"t", "counts", "on", "y_1", "y_2", "lying_1", "lying_2"});
    CHECK(info.units == std::vector<std::string>{"", "", "", "mm", "mm", "", ""});
    dsp::FrameBlock expected(4, 7);
    expected << 0, 1, 0, 1, 10, 1, 2, 0.004, -2, 1, 2, 20, 3, 4, 0.008, 3, 1, 3, 30, 10, 20, 0.012, 32767, 0, 4, 40, 30,
        40;
    CHECK(read_all(*source) == expected);
    CHECK(info.left_out ==
          std::vector<std::string>{"short (3 values, the longest 4)", "square (4x4 double)", "k (1x1 double)"});
    REQUIRE(info.checks.size() == 2);
    CHECK(info.checks[0].name == "mat.integer");
    CHECK(info.checks[0].channel == "counts");
    CHECK(info.checks[1].name == "mat.left_out");
    CHECK(info.checks[1].status == dsp::CheckStatus::warning);
    CHECK_THAT(info.checks[1].message, Catch::Contains("short (3 values, the longest 4), square (4x4 double)"));
  }
  const Mat mat;
  const auto parameter =
      dsp::open_source(scratch.file("a.mat", mat.header() + mat.vector("x", wave(4)) + mat.vector("k", {3.0})));
  REQUIRE(parameter->info().checks.size() == 1);
  CHECK(parameter->info().checks[0].status == dsp::CheckStatus::note);
  const auto alone = dsp::open_source(
      scratch.file("a.mat", mat.header() + mat.matrix("data", 6, {50, 2}, mat.element(9, mat.values(wave(100))))));
  CHECK(alone->info().columns == std::vector<std::string>{"data_1", "data_2"});
  CHECK(alone->info().num_frames == 50);
}

TEST_CASE("whole numbers of more digits than a double has are counted", "[dsp][mat_file]") {
  const Scratch scratch;
  const Mat mat;
  constexpr std::int64_t edge = std::int64_t{1} << 53;
  const std::vector<std::int64_t> signs{edge + 1, -edge - 1, edge + 2, std::numeric_limits<std::int64_t>::min(), 0};
  const std::vector<std::uint64_t> all{~std::uint64_t{0}, edge, edge * 2 + 4, 1, 0};
  const auto source = dsp::open_source(
      scratch.file("a.mat", mat.header() + mat.matrix("signs", 14, {5, 1}, mat.element(12, mat.values(signs))) +
                                mat.matrix("all", 15, {5, 1}, mat.element(13, mat.values(all)))));
  std::map<std::string, double> rounded;
  for (const dsp::Check& check : source->info().checks)
    if (check.name == "mat.rounded" && check.status == dsp::CheckStatus::warning) rounded[check.channel] = check.value;
  CHECK(rounded == std::map<std::string, double>{{"signs", 2.0}, {"all", 1.0}});
}

TEST_CASE("a truncated MATLAB file is refused, compressed or not", "[dsp][mat_file]") {
  const Scratch scratch;
  const Mat mat;
  for (const bool packed : {false, true}) {
    const auto variable = mat.vector("x", wave(1000));
    const auto bytes = mat.header() + (packed ? mat.compressed(variable) : variable);
    for (const std::size_t size : {bytes.size() - 1, bytes.size() / 2, std::size_t{140}})
      check_fault([&] { (void)dsp::open_source(scratch.file("a.mat", bytes.substr(0, size))); }, FaultKind::input,
                  "mat.truncated", {"the file is cut", "byte 128"});
    check_fault([&] { (void)dsp::open_source(scratch.file("a.mat", bytes.substr(0, 131))); }, FaultKind::input,
                "mat.truncated", {"within a tag"});
  }
}

TEST_CASE("every flipped bit of a compressed variable is found", "[dsp][mat_file]") {
  const Scratch scratch;
  const Mat mat;
  const auto bytes = mat.header() + mat.compressed(mat.vector("x", wave(200)));
  for (std::size_t at = 136; at < bytes.size(); at += 11) {
    auto flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << at % 8));
    check_fault([&] { (void)dsp::open_source(scratch.file("a.mat", flipped)); }, FaultKind::input, "mat.damaged",
                {"damaged"});
  }
}

TEST_CASE("huge dimensions and bombs are refused before anything is allocated", "[dsp][mat_file]") {
  const Scratch scratch;
  const Mat mat;
  const auto huge = mat.matrix("x", 6, {100'000, 100'000}, mat.element(9, mat.values(wave(1000))));
  for (const auto& variable : {huge, mat.compressed(huge)})
    check_fault([&] { (void)dsp::open_source(scratch.file("a.mat", mat.header() + variable)); }, FaultKind::input,
                "mat.damaged", {"dimensions and its bytes disagree"});
  const auto cells = mat.matrix("x", 1, {0xffffffff, 0xffffffff}, "");
  CHECK(support::name_of_fault([&] { (void)dsp::open_source(scratch.file("a.mat", mat.header() + cells)); }) ==
        "mat.damaged");
  const auto bomb = mat.header() + mat.compressed(mat.vector("x", std::vector<double>(1'000'000, 0.0)));
  CHECK(bomb.size() < 20'000);
  check_fault([&] { (void)dsp::open_source(scratch.file("b.mat", bomb), {.max_memory_bytes = 1'000'000}); },
              FaultKind::input, "mat.size", {"1000000 bytes allowed", "--max-memory"});
  std::string nested = mat.vector("", {1.0});
  for (int i = 0; i < 100; ++i) nested = mat.matrix("", 1, {1, 1}, nested);
  CHECK(support::name_of_fault([&] { (void)dsp::open_source(scratch.file("c.mat", mat.header() + nested)); }) ==
        "mat.damaged");
}

TEST_CASE("no damage whatever crashes the reader of MATLAB files", "[dsp][mat_file]") {
  const Scratch scratch;
  std::vector<std::string> originals;
  for (const bool big : {false, true}) {
    const Mat mat{big};
    const auto theta = mat.structure("theta", {{"time", mat.vector("", times(20))},
                                               {"signals", mat.structure("", {{"values", mat.vector("", wave(20))}})}});
    originals.push_back(mat.header() + mat.vector("t", times(20)) + mat.vector("x", wave(20)) + theta);
  }
  rc::prop("flipped and cut", [&] {
    auto bytes = *rc::gen::elementOf(originals);
    const int flips = *rc::gen::inRange(0, 4);
    for (int i = 0; i < flips; ++i)
      bytes[*rc::gen::inRange<std::size_t>(0, bytes.size())] = *rc::gen::arbitrary<char>();
    if (*rc::gen::inRange(0, 4) == 0) bytes.resize(*rc::gen::inRange<std::size_t>(1, bytes.size()));
    const auto file = scratch.file("fuzz.mat", bytes);
    support::check_whole_or_refused([&] { return dsp::open_source(file, {.max_memory_bytes = 1 << 20}); }, 7);
  });
}

TEST_CASE("a time column that is not there is refused with those that are", "[dsp][mat_file]") {
  const Scratch scratch;
  const Mat mat;
  const auto file = scratch.file("a.mat", mat.header() + mat.vector("t", times(100)) + mat.vector("x", wave(100)));
  check_fault([&] { (void)dsp::open_source(file, {.time_column = "clock"}); }, FaultKind::input, "channel.column",
              {"no time column 'clock'; there are t, x"});
}

TEST_CASE("stamps of few digits are a clock within them", "[dsp][mat_file]") {
  const Scratch scratch;
  const Mat mat;
  std::vector<float> singles;
  std::vector<std::int32_t> milliseconds;
  for (int i = 0; i < 100; ++i) {
    singles.push_back(static_cast<float>(1000.0 + i / 250.0));  // half a unit in the last place is 3 % of 1 ms
    milliseconds.push_back(4 * i);
  }
  const auto rate_hz = [&](const std::string& stamps) {
    return dsp::open_source(scratch.file("a.mat", mat.header() + stamps + mat.vector("x", wave(100))))
        ->info()
        .sample_rate_hz;
  };
  CHECK(rate_hz(mat.matrix("t", 7, {100, 1}, mat.element(7, mat.values(singles)))) == 250.0);
  CHECK(rate_hz(mat.matrix("t_ms", 12, {100, 1}, mat.element(5, mat.values(milliseconds)))) == 250.0);
}
