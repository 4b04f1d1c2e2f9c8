// The faults a person meets, through the built program: exit code, message, and what helps.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "dsp/io/sound_writer.hpp"
#include "support/mat.hpp"
#include "support/program.hpp"
#include "support/staging.hpp"

using support::bytes_of;
using support::Mat;
using support::Scratch;
namespace fs = std::filesystem;

namespace {

/// Two channels of 24 bit at 100 Hz, 8 s unless asked.
void sound(const fs::path& file, Eigen::Index num_frames = 800) {
  dsp::SoundFileWriter writer(file, {.sample_rate_hz = 100, .num_channels = 2});
  writer.write(dsp::FrameBlock::NullaryExpr(num_frames, 2, [](Eigen::Index i, Eigen::Index c) {
    return 0.4 * std::sin(0.13 * static_cast<double>(i * (c + 1)));
  }));
  writer.close();
}

constexpr const char* laser_sidecar =
    "[[channel]]\nname = \"laser\"\nindex = 1\nrole = \"y\"\nsensitivity = \"250 mV/mm\"\nfull_scale = \"10 V\"\n"
    "[[channel]]\nname = \"force\"\nindex = 2\nfull_scale = \"20 N\"\n";

/// A clock, a displacement and something else under a header.
std::string table(const std::string& header) {
  std::string text = header + "\n";
  for (int i = 0; i < 400; ++i)
    text += std::to_string(i) + "e-2," + std::to_string(std::sin(0.1 * i)) + "," + std::to_string(i % 5) + "\n";
  return text;
}

std::vector<double> ramp(int count, double step) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(step * i);
  return values;
}

/// A fault of the list, the files it lies in already made: what the program is asked, and how it is to end.
struct Case {
  std::string fault, command;
  int code;
  std::vector<std::string> pieces;
};

void check_cases(const Scratch& folder, const std::vector<Case>& cases) {
  for (const Case& one : cases) {
    CAPTURE(one.fault, one.command);
    const auto ended = support::run(folder, one.command);
    CHECK(ended.code == one.code);
    for (const std::string& piece : one.pieces) CHECK_THAT(ended.err, Catch::Contains(piece));
    if (one.code != 0) CHECK(ended.out.empty());
    CHECK((!fs::exists(folder / "o") || fs::is_empty(folder / "o")));
    CHECK_FALSE(fs::exists(support::staging_of(folder / "o")));
  }
}

std::string after_first_line(const std::string& text) {
  return text.substr(text.find('\n') + 1);
}

}  // namespace

TEST_CASE("the lines that a missing sensitivity prints can be pasted as they are", "[apps][faults]") {
  const Scratch folder;
  sound(folder / "good.wav");
  const auto refused = support::run(folder, "$ARDENT run good.wav");
  CHECK(refused.code == 3);
  CHECK_THAT(refused.err,
             Catch::Contains("error [calibration.missing] good.wav: no calibration for channel1, channel2"));
  const auto document = nlohmann::json::parse(support::run(folder, "$ARDENT --json run good.wav").out);
  const std::string lines = document["error"]["lines"];
  CHECK(refused.err.substr(refused.err.find("[[channel]]")) == lines);
  (void)folder.file("good.wav.toml", lines);
  const auto info = support::run(folder, "$ARDENT info good.wav");
  CHECK(info.code == 0);
  CHECK_THAT(info.out, Catch::Contains("channel2") && !Catch::Contains("calibrated"));

  const std::string sidecar =
      "[[channel]]\nname = \"base\"\nindex = 2\nfull_scale = \"1 N\"\n"
      "[[channel]]\nname = \"laser\\u001b[31m\\n[[bad]]\"\nindex = 1\nrole = \"y\"\nsensitivity = \"250 mV/mm\"\n";
  (void)folder.file("good.wav.toml", sidecar);
  const auto half = support::run(folder, "$ARDENT run good.wav -q");
  CHECK(half.code == 3);
  CHECK_THAT(half.err, Catch::Contains("\nfull_scale = \"10 V\"") && !Catch::Contains("\x1b"));
  (void)folder.file("good.wav.toml", sidecar + after_first_line(half.err));
  CHECK(support::run(folder, "$ARDENT run good.wav -o done --set library.order=1").code == 0);
}

TEST_CASE("an error is reported once, also where standard output cannot be written", "[apps][faults]") {
  const Scratch folder;
  const auto ended = support::run(folder, "$ARDENT --json terms > /dev/full");
  CHECK(ended.code == 5);
  CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
}

TEST_CASE("what is no recording, or only part of one, ends with 3 and what was found", "[apps][faults]") {
  const Scratch folder;
  sound(folder / "whole.wav");
  (void)folder.file("whole.wav.toml", laser_sidecar);
  const std::string bytes = bytes_of(folder / "whole.wav");
  const auto put = [&](const std::string& name, const std::string& content) {
    (void)folder.file(name, content);
    (void)folder.file(name + ".toml", laser_sidecar);
  };
  put("empty.wav", "");
  put("cut_header.wav", bytes.substr(0, 30));
  put("cut.wav", bytes.substr(0, bytes.size() - 600));
  put("junk.wav", std::string("\x07\x00\x13junk", 7));
  put("prose.wav", "Dear reader,\nno numbers here.\n");
  (void)folder.file("table.wav", table("t,x,other"));
  fs::create_directory(folder / "folder.wav");
  sound(folder / "written.wav", 1'000'000);
  (void)folder.file("written.wav.toml", laser_sidecar);
  check_cases(folder,
              {{"1", "$ARDENT run none.wav -o o", 3, {"[file.missing] none.wav", "No such file"}},
               {"1", "$ARDENT run empty.wav -o o", 3, {"[file.empty] empty.wav", "0 bytes"}},
               {"1", "$ARDENT run folder.wav -o o", 3, {"[file.kind] folder.wav", "a directory"}},
               {"1", "$ARDENT run /dev/zero -o o", 3, {"[file.kind] /dev/zero", "a device"}},
               {"2", "$ARDENT check table.wav", 0, {"[container.extension]", "by its content this is CSV"}},
               {"3", "$ARDENT run cut_header.wav -o o", 3, {"cut_header.wav", "byte"}},
               {"3", "$ARDENT run junk.wav -o o", 3, {"[container.unknown] junk.wav", "byte 0 is 0x07"}},
               {"3", "$ARDENT run prose.wav -o o", 3, {"[container.unknown] prose.wav", "row of numbers"}},
               {"4", "$ARDENT run cut.wav -o o", 3, {"[container.truncated] cut.wav", "800", "700", "--salvage"}},
               {"4", "$ARDENT check cut.wav --salvage", 0, {"[container.truncated]", "800", "700"}},
               {"15",
                "(while :; do touch -c written.wav; done) & writer=$!; sleep 0.2; "
                "$ARDENT run written.wav -o o; code=$?; kill $writer; exit $code",
                3,
                {"[file.changed] written.wav", "changed while it was read"}}});
}

TEST_CASE("a MATLAB file is read for what it is, and what is no vector is listed", "[apps][faults]") {
  const Scratch folder;
  const Mat mat;
  const std::string clock = mat.vector("t", ramp(400, 0.01)), x = mat.vector("x", ramp(400, 1e-3));
  const auto pair = mat.element(9, mat.values(ramp(400, 1.0)));
  const auto put = [&](const std::string& name, const std::string& variables) {
    (void)folder.file(name, mat.header() + variables);
  };
  put("good.wav", clock + x);
  put("cut.mat", clock + x.substr(0, x.size() - 8));
  auto flipped = mat.compressed(x);
  flipped[flipped.size() / 2] = static_cast<char>(flipped[flipped.size() / 2] ^ 4);
  put("flipped.mat", clock + flipped);
  put("none.mat", "");
  put("cells.mat", mat.matrix("x", 1, {1, 1}, mat.vector("", {1.0})));
  put("complex.mat", clock + mat.matrix("x", 6, {400, 1}, pair + pair, 0x800));
  put("counts.mat", clock + mat.matrix("x", 10, {400, 1}, mat.element(3, mat.values(std::vector<std::int16_t>(400)))));
  put("plane.mat", clock + mat.matrix("x", 6, {200, 2}, pair));
  put("empty.mat", clock + mat.matrix("x", 6, {0, 0}, mat.element(9, "")));
  put("huge.mat", clock + mat.matrix("x", 6, {100'000, 100'000}, mat.element(9, mat.values(ramp(1000, 1.0)))));
  const std::string wanted = "Want real vectors";
  check_cases(folder, {{"10", "$ARDENT check good.wav", 0, {"by its content this is MATLAB v5"}},
                       {"11", "$ARDENT run cut.mat -o o", 3, {"[mat.truncated] cut.mat", "byte"}},
                       {"11", "$ARDENT run flipped.mat -o o", 3, {"[mat.damaged] flipped.mat"}},
                       {"11", "$ARDENT run none.mat -o o", 3, {"[mat.no_variable] none.mat: holds no variable"}},
                       {"11", "$ARDENT run cells.mat -o o", 3, {"[mat.no_variable]", "x (1x1 cell)", "vectors"}},
                       {"11", "$ARDENT run complex.mat -o o", 3, {"x (400x1 complex double)", wanted, "ddy"}},
                       {"11", "$ARDENT info counts.mat --strict", 3, {"mat.integer", "400x1 int16"}},
                       {"11", "$ARDENT run plane.mat -o o", 3, {"x (200x2 double)", wanted}},
                       {"11", "$ARDENT run empty.mat -o o", 3, {"x (0x0 double)", wanted}},
                       {"12", "$ARDENT run huge.mat -o o", 3, {"[mat.damaged]", "dimensions"}}});
}

TEST_CASE("tables of every make are read, a damaged one is refused with its line", "[apps][faults]") {
  const Scratch folder;
  const std::string plain = table("t,x,other");
  const auto replaced = [&](char from, char to) {
    std::string text = plain;
    std::replace(text.begin(), text.end(), from, to);
    return text;
  };
  std::string crlf, comma = replaced(',', ';');
  for (const char c : plain) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  std::replace(comma.begin(), comma.end(), '.', ',');
  const std::vector<std::pair<std::string, std::string>> good{{"bom", "\xef\xbb\xbf" + plain},
                                                              {"crlf", crlf},
                                                              {"semicolon", replaced(',', ';')},
                                                              {"decimal_comma", comma},
                                                              {"quotes", "\"t\",\"x\",\"other\"" + plain.substr(9)},
                                                              {"comments", "# made by hand\n% twice\n" + plain}};
  for (const auto& [name, text] : good) {
    CAPTURE(name);
    (void)folder.file(name + ".csv", text);
    const auto info = support::run(folder, "$ARDENT info " + name + ".csv");
    CHECK(info.code == 0);
    CHECK_THAT(info.out,
               Catch::Contains("rate       100 Hz") && Catch::Contains("samples    400") && Catch::Contains("role x "));
  }
  (void)folder.file("bare.csv", after_first_line(plain));
  (void)folder.file("bare.csv.toml", "rate = 100\n");
  CHECK_THAT(support::run(folder, "$ARDENT info bare.csv").out, Catch::Contains("channel3"));
  (void)folder.file("cut.csv", plain.substr(0, plain.size() - 3));
  (void)folder.file("ragged.csv", "t,x\n0,1\n1,2\n2\n3,4\n");
  auto word = plain;
  word.insert(word.find("1e-2,") + 5, "two");
  (void)folder.file("word.csv", word);
  check_cases(folder, {{"13", "$ARDENT run cut.csv -o o", 3, {"[table.cut] cut.csv:401:", "--salvage"}},
                       {"13", "$ARDENT run ragged.csv -o o", 3, {"[table.ragged] ragged.csv:4: 1 columns, want 2"}},
                       {"13", "$ARDENT run word.csv -o o", 3, {"[table.cell] word.csv:3: column 2: 'two"}}});
}

TEST_CASE("a record too short for any row is no fault of what was typed", "[apps][faults]") {
  const Scratch folder;
  for (const int rows : {3, 10, 40}) {
    std::string text = "t [s],x [m],f [N]\n";
    for (int i = 0; i < rows; ++i)
      text += fmt::format("{:.2f},{:.6f},{:.6f}\n", 0.05 * i, std::sin(0.1 * i), std::cos(0.1 * i));
    (void)folder.file("short.csv", text);
    for (const char* command : {"$ARDENT check short.csv", "$ARDENT run short.csv -o o"}) {
      const auto ended = support::expect(folder, command, 3, {"error ["});
      CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') >= 1);
      CHECK_FALSE(fs::exists(folder / "o"));
    }
  }
  CHECK(folder.file("c.toml", "[[recording]]\nfile = \"short.csv\"\n[[range]]\nfrom = 0.2\nto = 0.3\n").extension() ==
        ".toml");
  support::expect(folder, "$ARDENT check c.toml", 2, {"[range.empty] c.toml:3"});
}

TEST_CASE("what a sidecar says wrongly is refused with its line", "[apps][faults]") {
  const Scratch folder;
  const std::string channel = "[[channel]]\nname = \"laser\"\nindex = 1\nrole = \"y\"\n";
  const auto put = [&](const std::string& name, const std::string& sidecar) {
    sound(folder / (name + ".wav"));
    (void)folder.file(name + ".wav.toml", sidecar);
  };
  put("rate", std::string("rate = 200\n") + laser_sidecar);
  sound(folder / "longer.wav", 900);
  put("length", std::string(laser_sidecar) + "file = \"longer.wav\"\n");
  put("gram", channel + "unit = \"gram\"\n");
  put("volts", channel + "unit = \"mm\"\nfull_scale = \"10 V\"\n");
  put("role",
      channel + "full_scale = \"10 mm\"\n[[channel]]\nname = \"two\"\nindex = 2\nrole = \"y\"\nfull_scale = \"1 m\"\n");
  put("name", channel + "full_scale = \"10 mm\"\n[[channel]]\nname = \"laser\"\nindex = 2\nfull_scale = \"1 m\"\n");
  put("index", "[[channel]]\nname = \"far\"\nindex = 3\nfull_scale = \"1 m\"\n");
  for (const char* value : {"0", "-250", "nan"})
    put(std::string("value") + value, channel + "sensitivity = \"" + value + " mV/mm\"\nfull_scale = \"10 V\"\n");
  check_cases(folder,
              {{"27", "$ARDENT run rate.wav -o o", 3, {"[rate.mismatch]", "100 Hz", "200 Hz"}},
               {"28", "$ARDENT run length.wav -o o", 3, {"[channel.length]", "800", "900", "--salvage"}},
               {"28", "$ARDENT check length.wav --salvage", 0, {"[channel.length]", "the first 800 were used"}},
               {"33", "$ARDENT run volts.wav -o o", 3, {"[calibration.missing]", "\nsensitivity = \"250 mV/mm\""}},
               {"34", "$ARDENT run gram.wav -o o", 2, {"[unit.unknown] gram.wav.toml:5:", "g means gravity"}},
               {"35", "$ARDENT run role.wav -o o", 2, {"[channel.role]", "laser", "two"}},
               {"35", "$ARDENT run name.wav -o o", 2, {"[channel.name] name.wav.toml:", "laser"}},
               {"35", "$ARDENT run index.wav -o o", 2, {"[channel.index] index.wav.toml:", "2 columns, got index 3"}},
               {"36", "$ARDENT run value0.wav -o o", 2, {"[calibration.value] value0.wav.toml:5:"}},
               {"36", "$ARDENT run value-250.wav -o o", 2, {"[calibration.value] value-250.wav.toml:5:"}},
               {"36", "$ARDENT run valuenan.wav -o o", 2, {"[calibration.value] valuenan.wav.toml:5:"}}});
}

TEST_CASE("names of any length and bytes do not stop a run", "[apps][faults]") {
  const Scratch folder;
  (void)folder.file("long.csv", table("t,x," + std::string(10'000, 'n')));
  (void)folder.file("odd.csv", table("t,x,\x1b[31m\xff\xc0 \x07"));
  for (const std::string name : {"long", "odd"}) {
    CAPTURE(name);
    const auto ended = support::run(folder, "$ARDENT run " + name + ".csv -o " + name + " --set library.order=1");
    CHECK(ended.code == 0);
    CHECK(ended.err.find_first_of("\x1b\x07\xff") == std::string::npos);
    CHECK_THAT(bytes_of(folder / (name + "/prepared.csv")).substr(0, 200), Catch::Contains(",x,v,a,"));
    CHECK(support::run(folder, "$ARDENT fit " + name + ".csv --target x --terms 1,t").code == 0);
  }
}

TEST_CASE("raw numbers are marked in everything that comes of them", "[apps][faults]") {
  const Scratch folder;
  sound(folder / "raw.wav");
  (void)folder.file("raw.wav.toml", "[[channel]]\nname = \"laser\"\nindex = 1\nrole = \"x\"\n");
  const auto ended = support::run(folder, "$ARDENT run raw.wav --uncalibrated -o raw --set library.order=1");
  REQUIRE(ended.code == 0);
  CHECK_THAT(ended.out, Catch::StartsWith("NOT CALIBRATED") && Catch::Contains("raw.wav: laser"));
  CHECK_THAT(ended.err, Catch::Contains("warning [calibration.missing] raw.wav: laser"));
  for (const std::string name : {"equation.json", "metrics.json", "quality.json", "manifest.json"}) {
    CAPTURE(name);
    const auto document = nlohmann::json::parse(bytes_of(folder / ("raw/" + name)));
    CHECK(document["calibrated"] == false);
  }
  for (const std::string name : {"equation.json", "equation.txt", "metrics.json"}) {
    CAPTURE(name);
    const std::string text = bytes_of(folder / ("raw/" + name));
    CHECK_THAT(text, Catch::Contains("raw.wav: laser") && !Catch::Contains("1/s") && !Catch::Contains("m/s"));
  }
  CHECK_THAT(bytes_of(folder / "raw/equation.tex"), Catch::StartsWith("% NOT CALIBRATED"));
  CHECK_THAT(bytes_of(folder / "raw/config.toml"), Catch::Contains("uncalibrated = true"));
  for (const std::string name : {"prepared.csv", "predictions.csv"}) {
    const std::string text = bytes_of(folder / ("raw/" + name));
    CHECK(text.substr(0, text.find('\n')).ends_with(",uncalibrated"));
    CHECK(text.ends_with(",1\n"));
  }
  const auto info = support::run(folder, "$ARDENT info raw.wav");
  CHECK_THAT(info.out, Catch::Contains("not calibrated") && !Catch::Contains("--uncalibrated"));
}

TEST_CASE("an option is honoured or refused, never ignored", "[apps][faults]") {
  const Scratch folder;
  (void)folder.file("a.csv", table("t,x,other"));
  sound(folder / "raw.wav");
  const std::string fit = "$ARDENT fit a.csv --target x --terms ";
  check_cases(folder, {{"", "$ARDENT sim duffing -o o --dry-run", 2, {"--dry-run"}},
                       {"", "$ARDENT init a.csv -o o --dry-run", 2, {"--dry-run"}},
                       {"", "$ARDENT replicate duffing -o o --dry-run", 2, {"--dry-run"}},
                       {"", "$ARDENT replicate duffing -o o --seed 3", 2, {"--seed", "--first-seed"}},
                       {"", "$ARDENT sim duffing -o o --from 3", 2, {"--from"}},
                       {"", "$ARDENT sim duffing -o o --rate 100", 2, {"--rate"}},
                       {"", fit + "1,t -o o", 2, {"fit: --output has no effect"}},
                       {"", fit + "'1,t,sqrt(-1-t)' --strict", 3, {"[strict.warning]", "sqrt(-1-t)"}},
                       {"", "$ARDENT info raw.wav --strict", 3, {"[strict.warning]", "not calibrated"}},
                       {"", fit + "1,t --tau -1", 2, {"want a finite number not below 0, got -1."}}});
  const auto made = support::run(folder, "$ARDENT --json init a.csv");
  CHECK(made.code == 0);
  CHECK(nlohmann::json::parse(made.out)["files"] == std::vector<std::string>{"a.csv.toml", "a.toml"});
}

TEST_CASE("a first sidecar is found by the config beside it, wherever they are put", "[apps][faults]") {
  const Scratch folder;
  sound(folder / "g.wav");
  fs::create_directory(folder / "notes");
  REQUIRE(support::run(folder, "cd notes && $ARDENT init ../g.wav -o .").code == 0);
  (void)folder.file("notes/g.wav.toml", laser_sidecar);
  const auto checked = support::run(folder, "cd notes && $ARDENT check g.toml");
  CHECK(checked.code == 0);
  CHECK_THAT(checked.err, !Catch::Contains("calibration.missing"));
}

TEST_CASE("messages say once what is wrong, where, and in the words that were written", "[apps][faults]") {
  const Scratch folder;
  (void)folder.file("a.csv", table("t,x,other"));
  (void)folder.file("table.wav", table("t,x,other"));
  (void)folder.file("nothing.toml", "schema = 1\n");
  const std::string fit = "$ARDENT fit a.csv --target x --terms ";
  check_cases(folder, {{"", fit + "'t^'", 2, {"'t^': position 3: the expression ends where a value is wanted\n"}},
                       {"", fit + "'t other'", 2, {"expression 't other': position"}},
                       {"", fit + "'t!'", 2, {"'t!': position 2: '!' where an operator is wanted"}},
                       {"", fit + "nofile.txt", 2, {"[config.file] nofile.txt: No such file", "--terms"}},
                       {"", "$ARDENT run nothing.toml -o o", 2, {"nothing.toml:1: no [[recording]]"}},
                       {"", "$ARDENT check table.wav", 0, {"warning [container.extension] table.wav: by its content"}},
                       {"", "$ARDENT sim foo -o o", 2, {"no system 'foo'", "duffing", "qzs"}}});
  (void)folder.file("b.csv", table("t,x,other"));
  (void)folder.file("two.toml", "[[recording]]\nfile = \"a.csv\"\n[[recording]]\nfile = \"b.csv\"\n");
  const auto checks = nlohmann::json::parse(support::run(folder, "$ARDENT --json check two.toml").out)["checks"];
  std::vector<std::string> recordings;
  for (const auto& check : checks)
    if (check["name"] == "prepare.edges") recordings.push_back(check["recording"]);
  CHECK(recordings == std::vector<std::string>{"a.csv", "b.csv"});
}
