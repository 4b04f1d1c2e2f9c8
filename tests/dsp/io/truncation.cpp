/// Every format that is read, cut at every hundredth of its length: an error, or a remark beside what is read; never a
/// shorter record in silence. A text that is cut at the end of a line, and nothing else, cannot be told from a whole
/// one.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "dsp/io/sample_source.hpp"
#include "dsp/io/sound_writer.hpp"
#include "support/mat.hpp"
#include "support/scratch.hpp"
#include "support/tdms.hpp"
#include "support/uff.hpp"

namespace test_io_truncation {

using support::bytes_of;
using support::Scratch;
using support::Tdms;

namespace {

constexpr int num_rows = 400;

double value(int i) {
  return i * i % 7 + 0.5;
}

std::vector<double> column(double step) {
  std::vector<double> values;
  for (int i = 0; i < num_rows; ++i) values.push_back(step > 0.0 ? step * i : value(i));
  return values;
}

std::string rows(const std::string& header, const char* form) {
  std::string text = header;
  for (int i = 0; i < num_rows; ++i) text += fmt::format(fmt::runtime(form), i / 250.0, value(i));
  return text;
}

std::string sound(const Scratch& scratch, const std::string& name) {
  dsp::SoundFileWriter writer(scratch / name, {.sample_rate_hz = 250, .num_channels = 1});
  writer.write(dsp::FrameBlock::NullaryExpr(
      num_rows, 1, [](Eigen::Index i, Eigen::Index) { return 0.1 * value(static_cast<int>(i)); }));
  writer.close();
  return bytes_of(scratch / name);
}

std::string universal(bool is_binary) {
  support::Uff set{column(0.0)};
  set.is_binary = is_binary;
  return set.text();
}

std::string tdms(bool in_rows) {
  const Tdms writer;
  const auto object = [&](const char* path) {
    return writer.object(path, writer.index(Tdms::f64, num_rows), {writer.property("wf_increment", 0.004)});
  };
  std::string raw = writer.values(Tdms::f64, column(0.0));
  return writer.segment(Tdms::new_list | (in_rows ? Tdms::interleaved : 0), {object("/'g'/'x'"), object("/'g'/'y'")},
                        raw + raw) +
         writer.segment(in_rows ? Tdms::interleaved : 0, {}, raw + raw);
}

std::string labview() {
  return rows(
      "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n"
      "Multi_Headings\tNo\nX_Columns\tOne\nTime_Pref\tAbsolute\n***End_of_Header***\t\n\t\nChannels\t1\t\n"
      "Samples\t400\t\nY_Unit_Label\tmm\t\nX_Dimension\tTime\t\nX0\t0.0\t\nDelta_X\t0.004\t\n***End_of_Header***\t\t\n"
      "X_Value\tx\tComment\n",
      "{:.6f}\t{:.6f}\n");
}

std::string sample(const char* name) {
  return bytes_of(std::filesystem::path(ARDENT_DATA).parent_path() / "tests/dsp/io/samples" / name);
}

struct Format {
  std::string name, bytes;
  bool is_text = false;
};

std::vector<Format> formats(const Scratch& scratch) {
  const support::Mat mat;
  std::vector<Format> all{
      {"table.csv", rows("t_s,x_mm\n", "{:.6f},{:.6f}\n"), true},
      {"labview.lvm", labview(), true},
      {"columns.json", rows("[", "{{\"t\": {:.6f}, \"x_mm\": {:.6f}}},\n") + "{\"t\": 1.6, \"x_mm\": 2.0}]\n"},
      {"lines.jsonl", rows("", "{{\"t\": {:.6f}, \"x_mm\": {:.6f}}}\n"), true},
      {"text.uff", universal(false)},
      {"bytes.uff", universal(true)},
      {"chunks.tdms", tdms(false)},
      {"rows.tdms", tdms(true)},
      {"level5.mat", mat.header() + mat.vector("t", column(0.004)) + mat.vector("x_mm", column(0.0))},
      {"packed.mat", mat.header() + mat.compressed(mat.vector("t", column(0.004)) + mat.vector("x_mm", column(0.0)))}};
  for (const char* name : {"sound.wav", "sound.flac", "sound.caf", "sound.w64", "sound.rf64", "sound.aiff"})
    all.push_back({name, sound(scratch, name)});
  for (const char* name :
       {"numpy.npz", "numpy.npy", "records.npy", "scipy_v4.mat", "scipy_struct.mat", "h5py.h5", "matlab_v73.mat"})
    all.push_back({name, sample(name)});
  return all;
}

struct Read {
  std::int64_t num_frames = 0;
  std::size_t num_columns = 0;
  std::vector<std::string> remarks;
};

/// Nothing where it is refused, which has to be for its content.
std::optional<Read> read(const std::filesystem::path& file, bool salvage) {
  try {
    const auto source = dsp::open_source(file, {.salvage = salvage});
    Read result;
    dsp::FrameBlock block;
    while (const auto count = source->read(block, 1000)) result.num_frames += count;
    CHECK(result.num_frames == source->info().num_frames);
    result.num_columns = source->info().columns.size();
    for (const dsp::Check& check : source->info().checks)
      if (check.status == dsp::CheckStatus::warning) result.remarks.push_back(check.name);
    return result;
  } catch (const dsp::Fault& fault) {
    CHECK(fault.kind() == dsp::FaultKind::input);
    return std::nullopt;
  }
}

}  // namespace

TEST_CASE("every format that is cut is an error, or read with a remark", "[dsp][truncation]") {
  const Scratch scratch;
  for (const Format& format : formats(scratch)) {
    INFO(format.name);
    REQUIRE(!format.bytes.empty());
    const auto whole = read(scratch.file(format.name, format.bytes), false);
    REQUIRE(whole);
    for (std::size_t part = 1; part < 100; ++part)
      for (const bool salvage : {false, true}) {
        const std::size_t size = std::max<std::size_t>(1, format.bytes.size() * part / 100);
        if (format.is_text && format.bytes[size - 1] == '\n') continue;
        INFO(part << " %, " << (salvage ? "--salvage" : ""));
        const auto cut = read(scratch.file(format.name, format.bytes.substr(0, size)), salvage);
        if (!cut) continue;
        CHECK(cut->num_frames <= whole->num_frames);
        CHECK(cut->remarks.size() > whole->remarks.size());
      }
  }
}

}  // namespace test_io_truncation
