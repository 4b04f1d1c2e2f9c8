/// Containers of named arrays, written by other software (NumPy, SciPy, h5py; tests/dsp/io/samples) or by hand: the
/// same record of 60 values at 250 Hz in all of them, x = i^2 mod 7 + 0.5 in mm.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "dsp/io/array_file.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/io/sample_source.hpp"
#include "dsp/io/sidecar.hpp"
#include "support/fault.hpp"
#include "support/mat.hpp"
#include "support/scratch.hpp"

using support::Scratch;

namespace {

constexpr int num_rows = 60;

std::filesystem::path sample(const std::string& name) {
  return std::filesystem::path(ARDENT_DATA).parent_path() / "tests/dsp/io/samples" / name;
}

std::string bytes_of_sample(const std::string& name) {
  std::ifstream file(sample(name), std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void check_record(const std::filesystem::path& file, const std::string& container, bool is_named = true) {
  INFO(file);
  const auto source = dsp::open_source(file);
  const dsp::SourceInfo& info = source->info();
  CHECK(info.container == container);
  CHECK(info.sample_rate_hz == 250.0);
  REQUIRE(info.num_frames == num_rows);
  const auto column = static_cast<Eigen::Index>(info.columns.size()) - 1;
  if (is_named) CHECK(info.units.back() == "mm");
  dsp::FrameBlock block;
  int row = 0;
  while (const auto count = source->read(block, 7))
    for (Eigen::Index i = 0; i < count; ++i, ++row) CHECK(block(i, column) == row * row % 7 + 0.5);
  CHECK(row == num_rows);
}

}  // namespace

TEST_CASE("what NumPy, SciPy and h5py write is read to the last digit", "[dsp][array_file]") {
  check_record(sample("numpy.npz"), "NumPy npz");
  check_record(sample("numpy.npy"), "NumPy npy", false);
  check_record(sample("records.npy"), "NumPy npy");
  check_record(sample("scipy_v4.mat"), "MATLAB v4");
  check_record(sample("scipy_struct.mat"), "MATLAB v5");
  check_record(sample("h5py.h5"), "HDF5");
  check_record(sample("h5py_labels.h5"), "HDF5");
  check_record(sample("matlab_v73.mat"), "MATLAB v7.3");
}

TEST_CASE("JSON is read as columns, records, rows with names, counted keys and a record a line", "[dsp][array_file]") {
  const Scratch scratch;
  std::string t, x, records, rows, lines, counted_t, counted_x;
  for (int i = 0; i < num_rows; ++i) {
    const std::string comma = i > 0 ? "," : "", time = fmt::format("{}", i / 250.0),
                      value = fmt::format("{}", i * i % 7 + 0.5);
    const std::string record = fmt::format("{{\"t\": {}, \"x_mm\": {}}}", time, value);
    t += comma + time;
    x += comma + value;
    records += comma + record;
    rows += fmt::format("{}[{},{}]", comma, time, value);
    lines += record + "\n";
    counted_t += fmt::format("{}\"{}\":{}", comma, i, time);
    counted_x += fmt::format("{}\"{}\":{}", comma, i, value);
  }
  for (const std::string& text : {fmt::format("{{\"t\":[{}],\"x_mm\":[{}]}}", t, x), "[" + records + "]", lines,
                                  fmt::format("{{\"columns\":[\"t\",\"x_mm\"],\"data\":[{}]}}", rows),
                                  fmt::format("{{\"t\":{{{}}},\"x_mm\":{{{}}}}}", counted_t, counted_x),
                                  fmt::format("{{\"dt\":0.004,\"run\":{{\"x_mm\":[{}]}}}}", x)}) {
    INFO(text.substr(0, 100));
    check_record(scratch.file("a.json", text), "JSON");
  }
  support::check_fault([&] { (void)dsp::open_source(scratch.file("b.json", "{\"t\":[1,2,}")); }, dsp::FaultKind::input,
                       "json.syntax", {"byte 11"});
}

TEST_CASE("names, units and the rate stand beside the numbers under keys as people choose them", "[dsp][array_file]") {
  const Scratch scratch;
  std::string t, x, rows;
  for (int i = 0; i < num_rows; ++i) {
    const std::string comma = i > 0 ? "," : "";
    t += fmt::format("{}{}", comma, i / 250.0);
    x += fmt::format("{}{}", comma, i * i % 7 + 0.5);
    rows += fmt::format("{}[{},{}]", comma, i / 250.0, i * i % 7 + 0.5);
  }
  struct Row {
    std::string text, name;
  };
  for (const auto& [text, name] :
       {Row{fmt::format("{{\"sampleRateHz\":250,\"signals\":{{\"disp_mm\":[{}]}}}}", x), "disp_mm"},
        Row{fmt::format("{{\"dt_ms\":4,\"units\":{{\"disp\":\"mm\"}},\"disp\":[{}]}}", x), "disp"},
        Row{fmt::format("{{\"rate\":250,\"disp_unit\":\"mm\",\"disp\":[{}]}}", x), "disp"},
        Row{fmt::format("{{\"time\":{{\"unit\":\"s\",\"values\":[{}]}},\"disp\":{{\"unit\":\"mm\",\"values\":[{}]}}}}",
                        t, x),
            "disp"},
        Row{fmt::format("{{\"units\":[\"s\",\"mm\"],\"fields\":[\"time\",\"disp\"],\"rows\":[{}]}}", rows), "disp"},
        Row{fmt::format(
                "{{\"about\":{{\"fs\":250,\"names\":[\"f\",\"disp\"],\"unit\":[\"-\",\"mm\"]}},\"data\":[[{}],[{}]]}}",
                t, x),
            "disp"},
        Row{fmt::format("{{\"fs\":250,\"channels\":[{{\"name\":\"disp\",\"unit\":\"mm\",\"data\":[{}]}}]}}", x),
            "disp"}}) {
    INFO(text.substr(0, 100));
    const auto file = scratch.file("a.json", text);
    check_record(file, "JSON");
    CHECK(dsp::open_source(file)->info().columns.back() == name);
  }
  // A unit that is not known is shown, and not taken for none.
  const auto file = scratch.file("a.json", fmt::format("{{\"fs\":250,\"x_unit\":\"furlong\",\"x\":[{}]}}", x));
  CHECK(dsp::open_source(file)->info().columns.back() == "x (furlong)");
  // A column on the stated rate is the clock; a ramp of another slope is none.
  const auto beside = [&](const char* rate) {
    return dsp::open_source(scratch.file("a.json", fmt::format("{{\"fs\":{},\"data\":[{}]}}", rate, rows)))
        ->info()
        .time_column;
  };
  CHECK(beside("250") == 0);
  CHECK(beside("100") == -1);
}

TEST_CASE("cells of text beside a matrix of MATLAB name its columns and their units", "[dsp][array_file]") {
  const support::Mat mat;
  std::vector<double> values;
  for (int i = 0; i < num_rows; ++i) values.push_back(i / 250.0);
  for (int i = 0; i < num_rows; ++i) values.push_back(i * i % 7 + 0.5);
  const auto cell = [&](const std::string& name, const std::vector<std::string>& texts) {
    std::string all;
    for (const std::string& text : texts)
      all += mat.matrix("", 4, {1, static_cast<std::uint32_t>(text.size())}, mat.element(16, text));
    return mat.matrix(name, 1, {1, static_cast<std::uint32_t>(texts.size())}, all);
  };
  const Scratch scratch;
  const auto file =
      scratch.file("a.mat", mat.header() + mat.matrix("data", 6, {num_rows, 2}, mat.element(9, mat.values(values))) +
                                cell("labels", {"Time", "disp"}) + cell("units", {"s", "mm"}));
  check_record(file, "MATLAB v5");
  CHECK(dsp::open_source(file)->info().columns.back() == "disp");
  const auto vectors = scratch.file(
      "b.mat", mat.header() + mat.vector("t", {values.begin(), values.begin() + num_rows}) +
                   mat.vector("disp", {values.begin() + num_rows, values.end()}) + cell("units", {"s", "mm"}));
  check_record(vectors, "MATLAB v5");
}

TEST_CASE("a container of arrays that was cut is refused, or salvaged with a warning", "[dsp][array_file]") {
  const Scratch scratch;
  for (const std::string name :
       {"numpy.npz", "numpy.npy", "records.npy", "scipy_v4.mat", "scipy_struct.mat", "h5py.h5", "matlab_v73.mat"}) {
    const std::string bytes = bytes_of_sample(name);
    REQUIRE(!bytes.empty());
    for (std::size_t part = 1; part < 100; ++part) {
      const auto file = scratch.file(name, bytes.substr(0, std::max<std::size_t>(1, bytes.size() * part / 100)));
      INFO(name << ", " << part << " %");
      const dsp::Fault fault = support::fault_of([&] { (void)dsp::open_source(file); });
      CHECK(fault.kind() == dsp::FaultKind::input);
    }
  }
  const std::string bytes = bytes_of_sample("records.npy");
  const auto cut = scratch.file("cut.npy", bytes.substr(0, bytes.size() - 12 * 10 - 5));
  const auto source = dsp::open_source(cut, {.salvage = true});
  CHECK(source->info().num_frames == num_rows - 11);
  CHECK(source->info().checks.front().name == "container.truncated");
}

TEST_CASE("arrays in memory are a recording as if they came from a file, whatever their numbers and strides",
          "[dsp][array_file]") {
  struct Row {
    float x;
    std::int16_t f;
  };
  std::vector<Row> rows;
  for (int i = 0; i < num_rows; ++i)
    rows.push_back({static_cast<float>(i * i % 7) + 0.5F, static_cast<std::int16_t>(3 * i)});
  const auto array = [&](const char* name, std::size_t offset, dsp::NumberFormat format) {
    dsp::FileArray one{.group = "", .name = name, .kind = "numbers", .shape = {num_rows}};
    one.values = format.values();
    const char* const bytes = reinterpret_cast<const char*>(rows.data()) + offset;
    one.read = dsp::strided(format, {num_rows}, {sizeof(Row)}, 0,
                            [bytes](std::uint64_t at, std::size_t) { return bytes + at; });
    return one;
  };
  const dsp::ArrayContents arrays{
      .container = "arrays",
      .prefix = "array",
      .arrays = {array("x", offsetof(Row, x), {'f', 4}), array("f", offsetof(Row, f), {'i', 2})},
      .name = "rig"};
  const std::string about =
      "rate = 250\n[[channel]]\nname = \"x\"\nunit = \"mm\"\n[[channel]]\nname = \"f\"\nunit = \"kN\"\n";
  dsp::RecordingReader reader(arrays, dsp::parse_sidecar(about, "rig.toml"));
  const dsp::Recording read = dsp::read_recording(reader, std::size_t{1} << 20);
  CHECK(read.name == "rig");
  CHECK(read.sample_rate_hz == 250.0);
  REQUIRE(read.samples.rows() == num_rows);
  REQUIRE(read.channels.size() == 2);
  CHECK(read.channels[0].role == dsp::Role::x);
  CHECK(read.channels[1].unit == "N");
  for (int i = 0; i < num_rows; ++i) {
    CHECK(read.samples(i, 0) == (i * i % 7 + 0.5) * 1e-3);
    CHECK(read.samples(i, 1) == 3.0 * i * 1e3);
  }
  const dsp::Sidecar elsewhere =
      dsp::parse_sidecar("rate = 250\n[[channel]]\nname = \"x\"\nfile = \"x.wav\"\n", "rig.toml");
  CHECK(support::name_of_fault([&] { dsp::RecordingReader(arrays, elsewhere); }) == "channel.file");
}
