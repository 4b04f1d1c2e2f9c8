/// Universal files as their description lays them out, and three as other programs wrote them.

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "dsp/io/sample_source.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"
#include "support/uff.hpp"

namespace test_io_uff_file {

using dsp::FaultKind;
using support::check_fault;
using support::Scratch;
using support::Uff;

namespace {

const std::filesystem::path samples = std::filesystem::path(ARDENT_REAL_DATA) / "format_samples";

struct Read {
  dsp::SourceInfo info;
  dsp::FrameBlock frames;
};

Read read(const std::filesystem::path& file, const dsp::OpenOptions& options = {}) {
  const auto source = dsp::open_source(file, options);
  Read result{source->info(), dsp::FrameBlock(source->info().num_frames, std::ssize(source->info().columns))};
  dsp::FrameBlock block;
  Eigen::Index done = 0;
  while (const auto count = source->read(block, 1000)) {
    result.frames.middleRows(done, count) = block;
    done += count;
  }
  CHECK(done == result.frames.rows());
  return result;
}

Read read(const std::string& text, const dsp::OpenOptions& options = {}) {
  const Scratch scratch;
  return read(scratch.file("a.uff", text), options);
}

Uff decay(std::size_t count = 300) {
  Uff set;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.01 * static_cast<double>(i);
    set.values.push_back(12.5 * std::exp(-t) * std::cos(15.0 * t));
  }
  return set;
}

}  // namespace

TEST_CASE("a universal file is the same numbers as text and as bytes, even and uneven", "[dsp][uff]") {
  const bool is_even = GENERATE(true, false), is_double = GENERATE(true, false);
  for (const auto& [is_binary, is_big] : {std::pair{false, false}, {true, false}, {true, true}}) {
    Uff set = decay();
    set.is_even = is_even, set.is_double = is_double, set.is_binary = is_binary, set.is_big = is_big;
    CAPTURE(is_even, is_double, is_binary, is_big);
    const Read got = read(set.text());
    CHECK(got.info.sample_rate_hz == 100.0);
    REQUIRE(got.info.columns == std::vector<std::string>{"3-Y"});
    CHECK(got.info.units == std::vector<std::string>{"mm"});
    REQUIRE(got.frames.rows() == 300);
    const double relative = is_double ? 1e-12 : is_binary ? 6e-8 : 5e-6;  // of E20.12, float, E13.5
    for (Eigen::Index i = 0; i < 300; ++i) {
      const double wanted = set.values[static_cast<std::size_t>(i)];
      CHECK(std::abs(got.frames(i, 0) - wanted) <= relative * std::abs(wanted));
    }
  }
}

TEST_CASE("sets of one length and rate are columns, all else is named", "[dsp][uff]") {
  Uff first = decay(), second = decay(), third = decay(), other = decay(200), spectrum = decay();
  first.name = "arm";
  second.unit = "NONE";
  second.kind = 12;
  third.name = "arm";
  spectrum.over = 18;
  other.name = "short";
  const Read got = read(support::uff_units(1000.0) + fmt::format("{:6}\n{:6}\nsome model\n{:6}\n", -1, 151, -1) +
                        first.text() + second.text() + other.text() + spectrum.text() + third.text());
  CHECK(got.info.columns == std::vector<std::string>{"arm", "3-Y", "arm set 2"});
  CHECK(got.info.units == std::vector<std::string>{"mm", "mm/s^2", "mm"});  // the second's by its kind and set 164
  REQUIRE(got.info.left_out.size() == 2);
  CHECK(got.info.left_out[0] == "short (200 values, others have 300)");
  CHECK(got.info.left_out[1] == "3-Y (no function of time)");
  check_fault([&] { (void)read(spectrum.text()); }, FaultKind::input, "uff.no_signal", {"no function of time"});
}

TEST_CASE("a universal file that is cut is an error, or what is whole of it where that is asked", "[dsp][uff]") {
  for (const bool is_binary : {false, true}) {
    Uff set = decay();
    set.is_binary = is_binary;
    const std::string one = set.text(), all = one + one;
    for (std::size_t percent = 1; percent < 100; ++percent) {
      const std::string cut = all.substr(0, all.size() * percent / 100);
      CAPTURE(is_binary, percent);
      if (cut.size() < 7 || cut.size() == one.size()) continue;  // one set is a file
      if (cut.size() > one.size()) CHECK(read(cut, {.salvage = true}).frames.cols() == 1);
      check_fault([&] { (void)read(cut); }, FaultKind::input, "container.truncated", {"a.uff"});
    }
  }
}

TEST_CASE("universal files of other programs are read", "[dsp][uff][real]") {
  if (!std::filesystem::exists(samples)) {
    WARN("skipped: " << samples << " is not there");
    return;
  }
  const Read text = read(samples / "Sample_UFF58_ascii.uff"), bytes = read(samples / "Sample_UFF58b_bin.uff");
  CHECK(text.info.sample_rate_hz == 65536.0);
  CHECK(bytes.info.sample_rate_hz == 65536.0);
  CHECK(text.info.units == std::vector<std::string>{"Pa"});
  REQUIRE(text.frames.rows() == 79292);
  REQUIRE(bytes.frames.rows() == 79292);
  CHECK((text.frames - bytes.frames).cwiseAbs().maxCoeff() <= 5e-7);
  const Read four = read(samples / "MPSTD_Set001_4ch_acc.uff");
  CHECK(four.info.sample_rate_hz == 3200.0);
  CHECK(four.info.columns == std::vector<std::string>{"1+Z", "2+Z", "3+Z", "1+Z set 2"});
  REQUIRE(four.frames.rows() == 222400);
  const double deviations[] = {0.03197, 0.02775, 0.02628, 0.02303};  // as those who published it have them
  for (Eigen::Index c = 0; c < 4; ++c) {
    const auto column = four.frames.col(c).array();
    CHECK(std::sqrt((column - column.mean()).square().mean()) == Approx(deviations[c]).margin(5e-6));
  }
}

}  // namespace test_io_uff_file
