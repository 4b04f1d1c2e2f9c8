/// TDMS as its description lays it out: every way to place values, clocks, scales and units, and what is damaged.

#include "dsp/io/tdms_file.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "dsp/io/sample_source.hpp"
#include "support/fault.hpp"
#include "support/fuzz.hpp"
#include "support/scratch.hpp"
#include "support/tdms.hpp"

namespace test_io_tdms_file {

using dsp::FaultKind;
using support::check_fault;
using support::Scratch;
using support::Tdms;

namespace {

constexpr std::uint32_t begin = Tdms::new_list;
const std::string a_path = "/'run'/'a'", b_path = "/'run'/'b'";

struct Read {
  dsp::SourceInfo info;
  dsp::FrameBlock frames;
};

Read read(const std::string& bytes, const dsp::OpenOptions& options = {}, Eigen::Index max_frames = 7) {
  const Scratch scratch;
  const auto source = dsp::open_source(scratch.file("a.tdms", bytes), options);
  Read result{source->info(), dsp::FrameBlock(source->info().num_frames, std::ssize(source->info().columns))};
  dsp::FrameBlock block;
  Eigen::Index done = 0;
  while (const auto count = source->read(block, max_frames)) {
    result.frames.middleRows(done, count) = block;
    done += count;
  }
  CHECK(done == result.frames.rows());
  return result;
}

std::vector<double> squares(int first, int count) {
  std::vector<double> values;
  for (int i = first; i < first + count; ++i) values.push_back(i * i % 11);
  return values;
}

std::vector<double> cubes(int first, int count) {
  std::vector<double> values;
  for (int i = first; i < first + count; ++i) values.push_back(i * i * i % 7);
  return values;
}

std::string in_rows(const Tdms& tdms, std::uint32_t a_type, std::uint32_t b_type, int first, int count) {
  std::string raw;
  for (int i = first; i < first + count; ++i)
    raw += tdms.values(a_type, squares(i, 1)) + tdms.values(b_type, cubes(i, 1));
  return raw;
}

std::vector<std::string> two_objects(const Tdms& tdms, std::uint32_t a_type, std::uint32_t b_type, int count) {
  return {tdms.object("/", tdms.none()), tdms.object("/'run'", tdms.none()),
          tdms.object(a_path, tdms.index(a_type, static_cast<std::uint64_t>(count)),
                      {tdms.property("wf_increment", 0.004), tdms.property("unit_string", "mm"),
                       tdms.start(3'800'000'000, 0.25)}),
          tdms.object(b_path, tdms.index(b_type, static_cast<std::uint64_t>(count)),
                      {tdms.property("wf_increment", 0.004), tdms.property("unit_string", "m/s^2")})};
}

void check_two(const Read& got, int count) {
  CHECK(got.info.container == "TDMS");
  CHECK(got.info.sample_rate_hz == 250.0);
  REQUIRE(got.info.columns == std::vector<std::string>{"a", "b"});
  CHECK(got.info.units == std::vector<std::string>{"mm", "m/s^2"});
  REQUIRE(got.frames.rows() == count);
  for (int i = 0; i < count; ++i) {
    CHECK(got.frames(i, 0) == i * i % 11);
    CHECK(got.frames(i, 1) == i * i * i % 7);
  }
}

/// `count` values of each in chunks, then as many in rows, then again in chunks by the index of the first.
std::string three_layouts(const Tdms& tdms, std::uint32_t a_type, std::uint32_t b_type, int count) {
  const auto chunk = [&](int first) {
    return tdms.values(a_type, squares(first, count)) + tdms.values(b_type, cubes(first, count));
  };
  return tdms.segment(begin, two_objects(tdms, a_type, b_type, count), chunk(0) + chunk(count)) +
         tdms.segment(Tdms::interleaved, {}, in_rows(tdms, a_type, b_type, 2 * count, count)) +
         tdms.segment(begin, {tdms.object(a_path, tdms.same()), tdms.object(b_path, tdms.same())}, chunk(3 * count)) +
         tdms.segment(0, {}, chunk(4 * count)) + tdms.segment(0, {}, chunk(5 * count));
}

/// One channel of doubles.
std::string one_channel(const Tdms& tdms, const std::vector<double>& values, const std::vector<std::string>& properties,
                        std::uint32_t type = Tdms::f64) {
  return tdms.segment(begin, {tdms.object(a_path, tdms.index(type, values.size()), properties)},
                      tdms.values(type, values));
}

}  // namespace

TEST_CASE("numbers of every type are read from chunks and rows, in either byte order", "[dsp][tdms]") {
  for (const bool is_big : {false, true})
    for (const std::uint32_t type : {Tdms::i8, Tdms::i16, Tdms::i32, Tdms::i64, Tdms::u8, Tdms::u16, Tdms::u32,
                                     Tdms::u64, Tdms::f32, Tdms::f64, Tdms::f32_unit, Tdms::f64_unit, Tdms::boolean}) {
      CAPTURE(is_big, type);
      const Tdms tdms{is_big};
      check_two(read(three_layouts(tdms, type, Tdms::f64, 50)), 300);
      check_two(read(three_layouts(tdms, Tdms::i16, type, 3)), 18);
    }
}

TEST_CASE("raw data of DAQmx are read from one buffer of rows and from several, scaled", "[dsp][tdms]") {
  const Tdms tdms;
  const auto scaled = [&](std::uint32_t byte) {
    return std::vector<std::string>{tdms.property("wf_increment", 0.004),
                                    tdms.property("unit_string", byte == 0 ? "mm" : "m/s^2"),
                                    tdms.property("NI_Scaling_Status", "unscaled"),
                                    tdms.property("NI_Scale[1]_Scale_Type", "Linear"),
                                    tdms.property("NI_Scale[1]_Linear_Slope", 0.5),
                                    tdms.property("NI_Scale[1]_Linear_Y_Intercept", 0.0),
                                    tdms.property("NI_Scale[1]_Linear_Input_Source", 0.0)};
  };
  for (const std::uint32_t buffers : {1U, 2U}) {
    CAPTURE(buffers);
    const auto chunk = [&](int first) {
      std::string raw(buffers == 1 ? 0 : 5 * 6, '\7');  // of another device
      for (int i = first; i < first + 5; ++i)
        raw += tdms.values(Tdms::i16, {2.0 * (i * i % 11)}) + "??" + tdms.values(Tdms::i16, {2.0 * (i * i * i % 7)});
      return raw;
    };
    const std::string bytes = tdms.segment(begin | Tdms::daqmx,
                                           {tdms.object(a_path, tdms.daqmx_index(5, 0, 6, buffers), scaled(0)),
                                            tdms.object(b_path, tdms.daqmx_index(5, 4, 6, buffers), scaled(4))},
                                           chunk(0) + chunk(5)) +
                              tdms.segment(Tdms::daqmx, {}, chunk(10));
    check_two(read(bytes), 15);
    check_fault([&] { (void)read(bytes.substr(0, bytes.size() - 7)); }, FaultKind::input, "container.truncated", {});
    check_two(read(bytes.substr(0, bytes.size() - 7), {.salvage = true}), buffers == 1 ? 13 : 10);
  }
}

TEST_CASE("the example of the description is read", "[dsp][tdms]") {
  // "Incremental meta information" there: two channels of three 32-bit integers, then the same again.
  const Tdms tdms;
  const std::string first =
      tdms.segment(begin,
                   {tdms.object("/'group'/'channel1'", tdms.index(Tdms::i32, 3), {tdms.property("prop", "valid")}),
                    tdms.object("/'group'/'channel2'", tdms.index(Tdms::i32, 3))},
                   tdms.values(Tdms::i32, {1, 2, 3, 4, 5, 6}));
  CHECK(static_cast<unsigned char>(first[12]) == 143);  // as printed there: next segment and raw data
  CHECK(static_cast<unsigned char>(first[20]) == 119);
  const Read got =
      read(first + tdms.segment(0, {tdms.object("/'group'/'channel1'", tdms.same(), {tdms.property("prop", "error")})},
                                tdms.values(Tdms::i32, {1, 2, 3, 4, 5, 6})));
  REQUIRE(got.info.columns == std::vector<std::string>{"channel1", "channel2"});
  REQUIRE(got.frames.rows() == 6);
  CHECK(got.frames(5, 0) == 3);
  CHECK(got.frames(3, 1) == 4);
}

TEST_CASE("a channel may come, end and change its count from segment to segment", "[dsp][tdms]") {
  const Tdms tdms;
  const std::string bytes =
      tdms.segment(begin, two_objects(tdms, Tdms::f64, Tdms::f32, 4),
                   tdms.values(Tdms::f64, squares(0, 4)) + tdms.values(Tdms::f32, cubes(0, 4))) +
      // Without a new list the other goes on as it was.
      tdms.segment(0, {tdms.object(b_path, tdms.index(Tdms::f32, 6))},
                   tdms.values(Tdms::f64, squares(4, 4)) + tdms.values(Tdms::f32, cubes(4, 6))) +
      tdms.segment(0, {tdms.object(b_path, tdms.none())}, tdms.values(Tdms::f64, squares(8, 4))) +
      tdms.segment(begin, {tdms.object(b_path, tdms.index(Tdms::f32, 2))}, tdms.values(Tdms::f32, cubes(10, 2)));
  check_two(read(bytes), 12);
}

TEST_CASE("what is read of a TDMS file depends on no block size", "[dsp][tdms]") {
  const Tdms tdms;
  std::string bytes = tdms.segment(begin, two_objects(tdms, Tdms::i16, Tdms::f64, 1),
                                   tdms.values(Tdms::i16, squares(0, 1)) + tdms.values(Tdms::f64, cubes(0, 1)));
  std::mt19937 random(20261128);
  int done = 1;
  while (done < 40000) {
    const int count = 1 + static_cast<int>(random() % (done < 1000 ? 5 : 9000));
    bytes += tdms.segment(0,
                          {tdms.object(a_path, tdms.index(Tdms::i16, static_cast<std::uint64_t>(count))),
                           tdms.object(b_path, tdms.index(Tdms::f64, static_cast<std::uint64_t>(count)))},
                          tdms.values(Tdms::i16, squares(done, count)) + tdms.values(Tdms::f64, cubes(done, count)));
    done += count;
  }
  const Read whole = read(bytes, {}, 1 << 20);
  REQUIRE(whole.frames.rows() == done);
  for (int i = 0; i < done; ++i)
    if (whole.frames(i, 0) != double(std::int64_t{i} * i % 11)) FAIL("row " << i);
  for (const Eigen::Index max_frames : {1, 1000, 8191})
    CHECK((read(bytes, {}, max_frames).frames - whole.frames).cwiseAbs().maxCoeff() == 0.0);
}

TEST_CASE("scales of a TDMS channel are applied one behind the other", "[dsp][tdms]") {
  const Tdms tdms;
  const auto text = [&](const std::string& name, const std::string& value) { return tdms.property(name, value); };
  const auto number = [&](const std::string& name, double value) { return tdms.property(name, value); };
  const std::string unscaled = text("NI_Scaling_Status", "unscaled");
  const std::vector<std::string> line{text("NI_Scale[0]_Scale_Type", "Linear"), number("NI_Scale[0]_Linear_Slope", 0.5),
                                      number("NI_Scale[0]_Linear_Y_Intercept", -3.0)};
  const std::vector<std::string> square{
      text("NI_Scale[1]_Scale_Type", "Polynomial"), number("NI_Scale[1]_Polynomial_Coefficients[0]", 1.0),
      number("NI_Scale[1]_Polynomial_Coefficients[1]", 0.0), number("NI_Scale[1]_Polynomial_Coefficients[2]", 2.0),
      number("NI_Scale[1]_Polynomial_Input_Source", 0.0)};
  const std::vector<double> raw{-4, 0, 4, 8, 10};
  const auto scaled = [&](std::vector<std::string> properties) {
    return read(one_channel(tdms, raw, properties, Tdms::i16)).frames;
  };
  std::vector<std::string> both = line;
  both.insert(both.end(), square.begin(), square.end());
  for (const std::string& status : {unscaled, text("other", "")}) {
    std::vector<std::string> one = line, two = both;
    one.push_back(status), two.push_back(status);
    const auto lines = scaled(one), squared = scaled(two);
    for (Eigen::Index i = 0; i < 5; ++i) {
      const double on_line = 0.5 * raw[static_cast<std::size_t>(i)] - 3.0;
      CHECK(lines(i, 0) == on_line);
      CHECK(squared(i, 0) == 1.0 + 2.0 * on_line * on_line);
    }
  }
  std::vector<std::string> done = line;
  done.push_back(text("NI_Scaling_Status", "scaled"));
  CHECK(scaled(done)(0, 0) == -4.0);
  // The driver's own scale 0 is not listed; a table goes from "scaled" to "pre-scaled" values and ends at its ends.
  const auto table = scaled(
      {text("NI_Scale[1]_Scale_Type", "Table"), number("NI_Scale[1]_Table_Input_Source", 0.0),
       number("NI_Scale[1]_Table_Scaled_Values[0]", 0.0), number("NI_Scale[1]_Table_Scaled_Values[1]", 8.0),
       number("NI_Scale[1]_Table_Pre_Scaled_Values[0]", 10.0), number("NI_Scale[1]_Table_Pre_Scaled_Values[1]", 50.0)});
  const std::vector<double> wanted{10, 10, 30, 50, 50};
  for (Eigen::Index i = 0; i < 5; ++i) CHECK(table(i, 0) == wanted[static_cast<std::size_t>(i)]);
  check_fault([&] { (void)scaled({text("NI_Scale[0]_Scale_Type", "RTD")}); }, FaultKind::input, "tdms.no_variable",
              {"RTD", "save them scaled"});
}

TEST_CASE("the clock of a TDMS file is that of its waveforms, its times or its properties", "[dsp][tdms]") {
  const Tdms tdms;
  std::vector<double> times, values = squares(0, 64);
  for (int i = 0; i < 64; ++i) times.push_back(100.75 + i / 64.0);
  const auto with_times = [&](std::uint32_t type) {
    return tdms.segment(begin,
                        {tdms.object("/'run'/'Time'", tdms.index(type, 64)),
                         tdms.object(a_path, tdms.index(Tdms::f64, 64), {tdms.property("unit_string", "mm")})},
                        tdms.values(type, times) + tdms.values(Tdms::f64, values));
  };
  for (const std::uint32_t type : {Tdms::f64, Tdms::time}) {
    const Read got = read(with_times(type));
    CHECK(got.info.sample_rate_hz == 64.0);
    CHECK(got.info.time_column == 0);
    CHECK(got.frames(63, 1) == values[63]);
  }
  CHECK(read(one_channel(tdms, values, {tdms.property("wf_increment", 1.0 / 51200.0)})).info.sample_rate_hz == 51200.0);
  CHECK(read(one_channel(tdms, values, {tdms.property("Sampling Rate", 128.0)})).info.sample_rate_hz == 128.0);
  CHECK(read(one_channel(tdms, values, {tdms.property("wf_increment", 0.5), tdms.property("wf_xunit_string", "ms")}))
            .info.sample_rate_hz == 2000.0);
  CHECK(read(one_channel(tdms, values, {})).info.sample_rate_hz == 0.0);
}

TEST_CASE("channels on another clock, of text or without values are named as left out", "[dsp][tdms]") {
  const Tdms tdms;
  const std::string words = tdms.numbers<std::uint32_t>({2, 4}) + "upin";
  const auto clock = [&](double step_s, double start) {
    return std::vector<std::string>{tdms.property("wf_increment", step_s), tdms.start(3'800'000'000, start)};
  };
  const std::string all = tdms.segment(
      begin,
      {tdms.object(a_path, tdms.index(Tdms::f64, 50), clock(0.01, 0.0)),
       tdms.object("/'run'/'it''s late'", tdms.index(Tdms::f64, 50), clock(0.01, 0.5)),
       tdms.object("/'run'/'fast'", tdms.index(Tdms::f64, 50), clock(0.001, 0.0)),
       tdms.object("/'run'/'short'", tdms.index(Tdms::f64, 5), clock(0.1, 0.0)),
       tdms.object("/'run'/'words'", tdms.text_index(2, words.size())), tdms.object("/'run'/'empty'", tdms.none())},
      tdms.values(Tdms::f64, squares(0, 50)) + tdms.values(Tdms::f64, cubes(0, 50)) +
          tdms.values(Tdms::f64, cubes(0, 50)) + tdms.values(Tdms::f64, cubes(0, 5)) + words);
  const Read got = read(all);
  CHECK(got.info.columns == std::vector<std::string>{"a"});
  CHECK(got.info.sample_rate_hz == 100.0);
  const std::string left_out = fmt::format("{}", fmt::join(got.info.left_out, "; "));
  for (const char* piece :
       {"it's late (50 values that begin 0.5 s later)", "fast (50 values at 1000 Hz, others at 100)",
        "short (5 values, the longest 50)", "words (2 text)", "empty (no values)"})
    CHECK_THAT(left_out, Catch::Contains(piece));
}

TEST_CASE("a TDMS file that the recorder did not finish is refused, or read as far as it is whole", "[dsp][tdms]") {
  const Tdms tdms;
  const auto rows = in_rows(tdms, Tdms::f32, Tdms::f32, 0, 100);
  const auto open_ended = [&](const std::string& raw) {
    return tdms.segment(begin | Tdms::interleaved, two_objects(tdms, Tdms::f32, Tdms::f32, 100), raw, Tdms::unknown);
  };
  for (const std::size_t lost : {0, 1, 11, 400}) {
    CAPTURE(lost);
    const std::string bytes = open_ended(rows.substr(0, rows.size() - lost));
    check_fault([&] { (void)read(bytes); }, FaultKind::input, "container.truncated", {"a.tdms", "--salvage"});
    const Read got = read(bytes, {.salvage = true});
    check_two(got, 100 - static_cast<int>((lost + 7) / 8));
    CHECK(got.info.checks.front().name == "container.truncated");
  }
  // Of a chunk the rows that all channels have.
  const std::string chunk = tdms.values(Tdms::f32, squares(0, 100)) + tdms.values(Tdms::f32, cubes(0, 100));
  const std::string whole = tdms.segment(begin, two_objects(tdms, Tdms::f32, Tdms::f32, 100), chunk);
  check_two(read(whole.substr(0, whole.size() - 90), {.salvage = true}), 77);
  check_two(read(whole + whole.substr(0, 300), {.salvage = true}), 100);
}

TEST_CASE("sizes that no TDMS file can hold are refused before anything is taken for them", "[dsp][tdms]") {
  const Tdms tdms;
  const std::uint64_t much = std::uint64_t{1} << 60;
  const auto refused = [&](const std::string& bytes, const std::string& name, const std::string& piece) {
    for (const bool salvage : {false, true})
      if (name != "container.truncated" || !salvage)
        check_fault([&] { (void)read(bytes, {.salvage = salvage, .max_memory_bytes = 1 << 20}); }, FaultKind::input,
                    name, {"a.tdms", piece});
  };
  const auto with_index = [&](const std::string& index) {
    return tdms.segment(begin, {tdms.object(a_path, index)}, tdms.values(Tdms::f64, squares(0, 4)));
  };
  refused(with_index(tdms.index(Tdms::f64, much)), "container.truncated", "values of its segment");
  refused(with_index(tdms.index(Tdms::f64, ~std::uint64_t{0})), "tdms.damaged", "more values");
  refused(with_index(tdms.index(0x77, 4)), "tdms.damaged", "0x77");
  refused(with_index(tdms.same()), "tdms.damaged", "no earlier index");
  refused(with_index(tdms.number(std::uint32_t{0x1369})), "container.unsupported", "DAQmx");
  refused(with_index(tdms.daqmx_index(4, 3, 4)), "tdms.damaged", "DAQmx");
  refused(with_index(tdms.daqmx_index(much, 0, 64)), "tdms.damaged", "DAQmx");
  refused(tdms.segment(begin, {tdms.object("a", tdms.none())}, "x"), "tdms.damaged", "no path");
  std::string long_name = with_index(tdms.index(Tdms::f64, 4));
  long_name[32] = long_name[33] = long_name[34] = long_name[35] = '\xff';
  refused(long_name, "tdms.damaged", "goes beyond the metadata");
  refused("TDSh" + std::string(100, '\0'), "container.unsupported", "index of a TDMS file");
  std::vector<std::string> objects;
  for (int i = 0; i < 4000; ++i) objects.push_back(tdms.object(fmt::format("/'g'/'{}'", i), tdms.index(Tdms::u8, 1)));
  const std::string wide = tdms.segment(begin, objects, std::string(4000, '\1'));
  CHECK(support::name_of_fault([&] { (void)read(wide, {.max_memory_bytes = 1 << 20}); }) == "memory.limit");
}

TEST_CASE("a damaged TDMS file is read to the end it promises, or refused", "[dsp][tdms]") {
  const Tdms tdms;
  const std::string good = three_layouts(tdms, Tdms::i16, Tdms::f64, 5);
  const Scratch scratch;
  CHECK(rc::check("a byte is another", [&] {
    std::string bytes = good;
    bytes[*rc::gen::inRange<std::size_t>(4, bytes.size())] = *rc::gen::arbitrary<char>();
    const auto file = scratch.file("a.tdms", bytes);
    const bool salvage = *rc::gen::arbitrary<bool>();
    support::check_whole_or_refused([&] { return dsp::open_source(file, {.salvage = salvage, .with_clock = false}); },
                                    7);
  }));
}

}  // namespace test_io_tdms_file
