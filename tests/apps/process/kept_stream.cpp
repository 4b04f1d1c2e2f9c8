/// A recording that comes through a pipe is read like the file it is.

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "support/program.hpp"
#include "support/tdms.hpp"

namespace test_kept_stream {

using support::bytes_of;
using support::expect;
using support::Scratch;
using support::Tdms;

namespace {

double displacement_mm(int i) {
  return 8.0 * std::exp(-0.2 * 0.01 * i) * std::cos(2.0 * 0.01 * i * 3.14159265);
}

// Ten seconds of a decay at 100 Hz.
std::string decay(bool with_time = true) {
  std::string text = with_time ? "time_s,x_mm\n" : "x_mm\n";
  for (int i = 0; i < 1000; ++i)
    text += (with_time ? fmt::format("{:.2f},", 0.01 * i) : "") + fmt::format("{:.9f}\n", displacement_mm(i));
  return text;
}

// What info says of a recording, but for its name.
std::string info(const Scratch& folder, const std::string& command) {
  const std::string text = expect(folder, command, 0, {}).out;
  return text.substr(text.find('\n'));
}

}  // namespace

TEST_CASE("a recording is the same from a file, standard input, a pipe and a descriptor", "[apps][kept_stream]") {
  const Scratch folder;
  (void)folder.file("x.csv", decay());
  REQUIRE(::mkfifo((folder / "pipe").c_str(), 0600) == 0);
  const std::string wanted = info(folder, "$ARDENT info x.csv");
  CHECK_THAT(wanted, Catch::Contains("1000") && Catch::Contains("100 Hz"));
  for (const char* command :
       {"$ARDENT info - < x.csv", "cat x.csv | $ARDENT info -", "cat x.csv | $ARDENT info /dev/stdin",
        "cat x.csv | sh -c 'exec $ARDENT info /dev/fd/7 7<&0'", "cat x.csv > pipe & $ARDENT info pipe",
        "(sleep 1; cat x.csv) | $ARDENT info -", "(cat x.csv; cat) < /dev/null | $ARDENT info -"})
    CHECK(info(folder, command) == wanted);
  // Standard input begins where a command before has left it.
  (void)folder.file("title.csv", "some title\n" + decay());
  CHECK(info(folder, "(read title; $ARDENT info -) < title.csv") == wanted);
}

TEST_CASE("a run, a check, a fit and a prediction take standard input", "[apps][kept_stream]") {
  const Scratch folder;
  (void)folder.file("x.csv", decay());
  expect(folder, "$ARDENT run x.csv -q --set library.order=1", 0, {});
  expect(folder, "cat x.csv | $ARDENT run - -q --set library.order=1", 0, {});
  CHECK(bytes_of(folder / "stdin-run/coefficients.csv") == bytes_of(folder / "x-run/coefficients.csv"));
  CHECK(bytes_of(folder / "stdin-run/prepared.csv") == bytes_of(folder / "x-run/prepared.csv"));
  expect(folder, "cat x.csv | $ARDENT check - --set library.order=1", 0, {"training rows"});
  expect(folder, "cat x.csv | $ARDENT predict x-run -", 0, {"stdin-predict"});
  std::string line = "u,w\n";
  for (int i = 0; i < 50; ++i) line += fmt::format("{},{}\n", 0.1 * i, 0.3 * i + i % 3 * 0.01);
  (void)folder.file("line.csv", line);
  expect(folder, "cat line.csv | $ARDENT fit - --target w --terms 1,u,u^2", 0, {"w = ", " u"});
}

TEST_CASE("the format of standard input is found, and its sidecar is in the current folder", "[apps][kept_stream]") {
  const Scratch folder;
  const Tdms tdms;
  std::vector<double> values;
  for (int i = 0; i < 1000; ++i) values.push_back(displacement_mm(i));
  const std::string object = tdms.object("/'g'/'x'", tdms.index(Tdms::f64, values.size()),
                                         {tdms.property("wf_increment", 0.01), tdms.property("unit_string", "mm")});
  (void)folder.file("x.tdms", tdms.segment(Tdms::new_list, {object}, tdms.values(Tdms::f64, values)));
  expect(folder, "cat x.tdms | $ARDENT info -", 0, {"TDMS", "100 Hz", "unit m"});
  const std::filesystem::path samples = std::filesystem::path(ARDENT_DATA).parent_path() / "tests/dsp/io/samples";
  for (const auto& [name, container] : {std::pair{"h5py.h5", "HDF5"},
                                        {"matlab_v73.mat", "MATLAB v7.3"},
                                        {"scipy_v4.mat", "MATLAB v4"},
                                        {"numpy.npz", "NumPy npz"}})
    expect(folder, fmt::format("cat {} | $ARDENT info -", (samples / name).string()), 0, {container, "250 Hz"});
  (void)folder.file("bare.csv", decay(false));
  expect(folder, "cat bare.csv | $ARDENT check -", 3, {"[rate.missing]", "stdin.toml"});
  (void)folder.file("stdin.toml", "rate = 100\n");
  expect(folder, "cat bare.csv | $ARDENT info -", 0, {"100 Hz"});
}

TEST_CASE("a stream without a recording ends with one line", "[apps][kept_stream]") {
  const Scratch folder;
  REQUIRE(::mkfifo((folder / "pipe").c_str(), 0600) == 0);
  for (const auto& [command, name] : {std::pair{"$ARDENT run - < /dev/null", "[file.empty] standard input: is empty"},
                                      {"true | $ARDENT check -", "[file.empty] standard input: is empty"},
                                      {"$ARDENT info pipe", "[file.empty] pipe, a pipe: is empty"},
                                      {"$ARDENT info - <&-", "[file.read] standard input: cannot be read"},
                                      {"$ARDENT info - < .", "[file.read] standard input: cannot be read"},
                                      {"printf 'a\\0b' | $ARDENT info -", "[container.unknown]"}}) {
    const support::Ended ended = expect(folder, command, 3, {name});
    CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
  }
}

}  // namespace test_kept_stream
