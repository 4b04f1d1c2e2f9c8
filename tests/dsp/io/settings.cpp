#include "dsp/io/settings.hpp"

#include <rapidcheck/catch.h>
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <ctime>

#include "support/fault.hpp"
#include "support/scratch.hpp"

using dsp::Fault;
using dsp::FaultKind;
using dsp::Settings;
using support::check_fault;

namespace {

dsp::Setting key(const std::string& table, const std::string& name, dsp::SettingType type, bool required = false) {
  return {.table = table, .key = name, .type = std::move(type), .required = required};
}

const dsp::SettingType a_number{.number = true}, a_text{.text = true}, some_texts{.text = true, .several = true};

/// Checked by these keys, as a reader of documents does first.
Settings checked(std::string_view document, const std::vector<dsp::Setting>& layout, const std::string& name = "c.toml",
                 const std::vector<std::string>& overrides = {}) {
  const auto settings = Settings::from_text(document, name, overrides);
  settings.check(layout, 1);
  return settings;
}

constexpr const char* config = R"toml(schema = 1
[prepare]
rate_hz = 25.6
zero = "none"
[library]
order = 3
terms = ["sgn(v)", "ddr"]
[[range]]
name = "low"
to = 830
[[range]]
name = "high"
from = 1440
)toml";
}  // namespace

TEST_CASE("settings come typed, and nothing where there is none", "[dsp][settings]") {
  const auto settings = Settings::from_text(config, "run.toml");
  const auto prepare = settings.table("prepare");
  CHECK(prepare.number("rate_hz") == 25.6);
  CHECK_FALSE(prepare.number("cutoff_hz").has_value());
  CHECK(prepare.is_text("zero"));
  CHECK_FALSE(prepare.number("zero").has_value());
  CHECK(prepare.text("rate_hz") == "25.6");
  CHECK(prepare.text("zero") == "none");
  CHECK(settings.table("library").number("order") == 3);
  CHECK(settings.table("library").texts("terms") == std::vector<std::string>{"sgn(v)", "ddr"});
  const auto ranges = settings.tables("range");
  REQUIRE(ranges.size() == 2);
  CHECK(ranges[0].number("to") == 830.0);  // a whole number will do
  CHECK(ranges[1].text("name") == "high");
  CHECK_FALSE(settings.has("fit"));
  CHECK_FALSE(settings.table("fit").text("target").has_value());
  CHECK(ranges[1].place("from") == "run.toml:13");
}

TEST_CASE("a key of no layout is an error with its line and the nearest known key", "[dsp][settings]") {
  const std::vector<dsp::Setting> layout{key("", "a", a_number), key("", "fit", {.section = true}),
                                         key("fit", "target", a_text), key("", "range", {.elements = true}),
                                         key("range", "from", a_number)};
  const auto refused = [&](const std::string& document, const std::vector<std::string>& pieces) {
    const auto settings = checked(document, layout, "run.toml");
    check_fault([&] { settings.finish(); }, FaultKind::usage, "config.unknown_key", pieces);
  };
  refused("a = 1\n[fit]\ntargte = \"a\"\n", {"run.toml:3:", "'fit.targte'", "Did you mean 'target'?"});
  refused("[mystery]\nx = 1\n", {"run.toml:1:", "'mystery'", "Known here: a, fit, range"});
  refused("[[range]]\nform = 1\n", {"run.toml:2:", "'[[range]] 1: form'", "Did you mean 'from'?"});
}

TEST_CASE("a key under the wrong heading is told the right one", "[dsp][settings]") {
  const std::vector<dsp::Setting> layout{key("", "prepare", {.section = true}), key("prepare", "cutoff_hz", a_number),
                                         key("", "range", {.elements = true}), key("range", "to", a_number)};
  const auto settings = checked("cutoff_hz = 1\n", layout, "run.toml");
  check_fault([&] { settings.finish(); }, FaultKind::usage, "config.unknown_key",
              {"run.toml:1:", "'cutoff_hz'", "It is a key of [prepare]", "--set prepare.cutoff_hz="});
  const auto other = checked("[prepare]\nto = 1\n[[range]]\n", layout, "run.toml");
  check_fault([&] { other.finish(); }, FaultKind::usage, "config.unknown_key", {"[[range]]", "--set range.0.to="});
}

TEST_CASE("a key that is gone says what is in its place", "[dsp][settings]") {
  const auto settings = checked("old = 1\n", {{.key = "old", .former = "Remove the line"}, key("", "older", a_number)});
  check_fault([&] { settings.finish(); }, FaultKind::usage, "config.former_key",
              {"c.toml:1: old: is no key any more. Remove the line"});
  const auto near = checked("olds = 1\n", {{.key = "old", .former = "Remove the line"}, key("", "other", a_number)});
  check_fault([&] { near.finish(); }, FaultKind::usage, "config.unknown_key", {"Known here: other"});
}

TEST_CASE("a table of notes may hold anything", "[dsp][settings]") {
  const auto settings =
      checked("sensor = { model = \"ZX2\", serial = 12, day = 2022-11-02 }", {key("", "sensor", {.table = true})});
  const auto notes = settings.notes("sensor");
  CHECK(notes.at("model") == "ZX2");
  CHECK(notes.at("serial") == "12");
  CHECK(notes.at("day") == "2022-11-02");
  settings.finish();
}

TEST_CASE("wrong types and values out of range say what was found and wanted, and count as absent", "[dsp][settings]") {
  const auto faulty = [](const std::string& line, const dsp::SettingType& type, const char* name,
                         std::vector<std::string> parts) {
    const auto settings = checked("\n" + line + "\n", {key("", line.substr(0, 1), type)});
    parts.push_back("c.toml:2: ");
    CAPTURE(line);
    CHECK_FALSE(settings.number(line.substr(0, 1)).has_value());
    CHECK_FALSE(settings.text(line.substr(0, 1)).has_value());
    CHECK(settings.has(line.substr(0, 1)));
    check_fault([&] { settings.finish(); }, FaultKind::usage, name, parts);
  };
  faulty("n = \"three\"", a_number, "config.type", {"n: got the text 'three', want a number"});
  faulty("r = -1", {.number = true, .range = {.from = 0, .above = true}}, "config.range",
         {"r: got -1, want a number, above 0"});
  faulty("r = -1", {.number = true, .range = {.from = 0, .to = 4}}, "config.range", {"0 to 4"});
  faulty("k = 2.5", {.whole_number = true}, "config.type", {"whole number"});
  faulty("b = 1", {.flag = true}, "config.type", {"true or false"});
  faulty("w = \"fst_rvm\"", {.text = true, .words = {"fast_rvm", "sindy"}}, "config.range",
         {"fast_rvm, sindy", "Did you mean 'fast_rvm'?"});
  faulty("v = nan", a_number, "config.range", {"nan", "finite"});
  faulty("t = 3", {.text = true, .example = "\"10 V\""}, "config.type", {"a text in quotes such as \"10 V\""});
  faulty("t = [\"a\", 3]", some_texts, "config.type", {"got 3", "or an array of them"});
  faulty("h = [\"a\"]", {.number = true, .text = true, .several = true}, "config.type", {"got the text 'a'", "number"});
  faulty("d = 2023", {.date = true}, "config.type", {"2023-05-04T10:12:30Z"});
  faulty("s = 1", {.section = true}, "config.type", {"want a table [s]"});
  faulty("e = 1", {.elements = true}, "config.type", {"[[e]]"});
  faulty("e = [1]", {.elements = true}, "config.type", {"got 1", "[[e]]"});
  const auto settings =
      checked("n = 1\nr = 1\n", {key("", "n", a_number), key("", "r", a_number), key("", "title", a_text, true)});
  check_fault([&] { settings.finish(); }, FaultKind::usage, "config.missing",
              {"c.toml", "title: missing; want a text in quotes"});
  check_fault([&] { settings.exclusive("n", "r"); }, FaultKind::usage, "config.range", {"cannot be given beside 'n'"});
}

TEST_CASE("all that is wrong with a document is said at once", "[dsp][settings]") {
  const auto settings =
      checked("a = \"one\"\nb = -1\nz = 0\n[fit]\ntarget = 3\ntau = 2\nmore = 1\n[[part]]\n",
              {key("", "a", a_number), key("", "b", {.number = true, .range = {.from = 0}}),
               key("", "fit", {.section = true}), key("fit", "target", a_text), key("fit", "tau", a_number),
               key("", "part", {.elements = true}), key("part", "file", a_text, true)});
  CHECK(settings.table("fit").number("tau") == 2.0);
  CHECK(settings.tables("part").empty());  // it lacks what it must have
  settings.attempt([&] { throw settings.fault("b", "config.range", "is unlucky"); });
  std::vector<std::string> said;
  try {
    settings.finish();
  } catch (const dsp::SeveralFaults& faults) {
    for (const Fault& fault : faults.all()) said.emplace_back(fault.what());
  }
  std::sort(said.begin(), said.end());
  const auto begins = [&](std::size_t i, const char* with) {
    CAPTURE(i, said);
    CHECK((said.size() > i && said[i].starts_with(with)));
  };
  CHECK(said.size() == 7);
  begins(0, "c.toml:1: a: got the text 'one'");
  begins(1, "c.toml:2: b: got -1");
  begins(2, "c.toml:2: b: is unlucky");
  begins(3, "c.toml:3: unknown key 'z'");
  begins(4, "c.toml:5: fit.target: got 3");
  begins(5, "c.toml:7: unknown key 'fit.more'");
  begins(6, "c.toml:8: [[part]] 1: file: missing");
}

TEST_CASE("syntax errors carry file and line", "[dsp][settings]") {
  check_fault([] { (void)Settings::from_text("a = 1\nb = \n", "c.toml"); }, FaultKind::usage, "config.syntax",
              {"c.toml:2:"});
  check_fault([] { (void)Settings::from_text("a = 1\na = 2\n", "c.toml"); }, FaultKind::usage, "config.syntax",
              {"c.toml:2:"});
  check_fault([] { (void)Settings::from_text("a = " + std::string(100'000, '['), "c.toml"); }, FaultKind::usage,
              "config.syntax", {"c.toml:1:"});
}

TEST_CASE("another schema is refused with the version that can read it", "[dsp][settings]") {
  const std::vector<dsp::Setting> layout{dsp::schema_setting(1)};
  checked("", layout).finish();
  checked("schema = 1", layout).finish();
  check_fault([&] { (void)checked("\nschema = 2\nnew = 1", layout); }, FaultKind::usage, "config.schema",
              {"c.toml:2", "got 2", "reads 1", "newer version"});
}

TEST_CASE("overrides replace, add and reach into arrays", "[dsp][settings]") {
  const auto settings =
      Settings::from_text(config, "run.toml",
                          {"prepare.rate_hz=51.2", "fit.target=ddy", "range.0.to=5", "range.2.name=mixed",
                           "library.terms=[\"x*v\", \"x\"]", "library.terms.2=abs(x)", "library.terms.1=v"});
  CHECK(settings.table("prepare").number("rate_hz") == 51.2);
  CHECK(settings.table("fit").text("target") == "ddy");
  CHECK(settings.tables("range").at(0).number("to") == 5.0);
  CHECK(settings.tables("range").at(2).text("name") == "mixed");
  CHECK(settings.table("library").texts("terms") == std::vector<std::string>{"x*v", "v", "abs(x)"});
}

TEST_CASE("a fault in an override names the override", "[dsp][settings]") {
  const std::vector<dsp::Setting> layout{dsp::schema_setting(1),
                                         key("", "prepare", {.section = true}),
                                         key("prepare", "rate_hz", a_number),
                                         key("prepare", "zero", a_text),
                                         key("", "library", {.section = true}),
                                         key("library", "order", a_number),
                                         key("library", "terms", some_texts),
                                         key("", "range", {.elements = true}),
                                         key("range", "name", a_text),
                                         key("range", "from", a_number),
                                         key("range", "to", a_number),
                                         key("", "fit", {.section = true}),
                                         key("fit", "target", a_text)};
  const auto read = [&](const std::string& override) { checked(config, layout, "run.toml", {override}).finish(); };
  check_fault([&] { read("range.0.to=soon"); }, FaultKind::usage, "config.type",
              {"--set range.0.to=soon: range.0.to: got the text 'soon'"});
  check_fault([&] { read("fit.targt=a"); }, FaultKind::usage, "config.unknown_key",
              {"--set fit.targt=a: unknown key 'fit.targt'", "Did you mean 'target'?"});
  for (const char* bad : {"novalue", "=3", "a..b=1", "range.7.to=1", "schema.x=1"})
    check_fault([&] { (void)Settings::from_text(config, "run.toml", {bad}); }, FaultKind::usage, "config.override",
                {"--set ", bad});
}

TEST_CASE("a settings file that is not there or not a file is a fault", "[dsp][settings]") {
  const support::Scratch scratch;
  check_fault([&] { (void)Settings::from_file(scratch / "none.toml"); }, FaultKind::usage, "config.file",
              {"No such file"});
  const auto long_one = scratch.file("long.toml", "");
  std::filesystem::resize_file(long_one, 20'000'000);
  check_fault([&] { (void)Settings::from_file(long_one); }, FaultKind::usage, "config.file",
              {"long.toml: has 20000000 bytes, want at most 16777216"});
  check_fault([&] { (void)Settings::from_file(scratch / ""); }, FaultKind::usage, "config.file", {"regular file"});
  CHECK(Settings::from_file(scratch.file("c.toml", "a = 7")).number("a") == 7);
}

TEST_CASE("a key of thousands of parts is refused with its line, wherever it is written", "[dsp][settings]") {
  std::string long_key = "a";
  for (int i = 0; i < 50'000; ++i) long_key += i % 3 == 0 ? ".a" : i % 3 == 1 ? " . 'b.c'" : ".\"d\\\"\"";
  const auto refused = [](const std::string& document, const std::vector<std::string>& overrides, const char* name,
                          const std::vector<std::string>& pieces) {
    check_fault([&] { (void)Settings::from_text(document, "deep.toml", overrides); }, FaultKind::usage, name, pieces);
  };
  refused("x = \"\"\"1.2\n\"\"\"\"\n" + long_key + " = 1\n", {}, "config.syntax", {"deep.toml:3:", "16 parts"});
  refused("# 1.2\n[" + long_key + "]\n", {}, "config.syntax", {"deep.toml:2:"});
  refused("[[" + long_key + "]]\n", {}, "config.syntax", {"deep.toml:1:"});
  refused("x = { " + long_key + " = 1 }\n", {}, "config.syntax", {"deep.toml:1:"});
  std::string path = "a";
  for (int i = 0; i < 50'000; ++i) path += ".a";
  refused("a = 1", {path + "=1"}, "config.override", {"--set a.a", "16 parts"});

  const auto fine = Settings::from_text(
      "a.b.c = '1.2.3.4.5.6.7.8.9.1.2.3.4.5.6.7.8.9'\nd = [1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 8.5, 9.5, 1.5, 2.5, 3.5, "
      "4.5, 5.5, 6.5, 7.5, 8.5]  # e.f.g.h.i.j.k.l.m.n.o.p.q.r.s.t.u.v.w.x.y.z\n",
      "fine.toml");
  CHECK(fine.numbers("d").size() == 17);
  CHECK(fine.table("a").table("b").text("c")->size() == 35);
}

TEST_CASE("a document that is too deep, too full or too long is refused before it is taken apart", "[dsp][settings]") {
  const auto text_of = [](int count, const std::string& piece) {
    std::string text;
    for (int i = 0; i < count; ++i) text += piece;
    return text;
  };
  const auto refused = [](const std::string& text, const std::vector<std::string>& pieces) {
    check_fault([&] { (void)Settings::from_text(text, "a.toml"); }, FaultKind::usage, "config.syntax", pieces);
  };
  refused("a = 1\nb = " + text_of(17, "[") + text_of(17, "]"), {"a.toml:2:", "16 deep"});
  refused("\nb = " + text_of(50'000, "{ a = "), {"a.toml:2:", "16 deep"});
  std::string keys, tables;
  for (int i = 0; i < 30'001; ++i)
    keys += "k" + std::to_string(i) + " = 1\n", tables += "[k" + std::to_string(i) + ".a.b]\n";
  refused(keys, {"a.toml:30001:", "more than 30000 keys"});
  refused(tables, {"a.toml:30001:", "more than 30000 keys"});
  refused("a = [" + text_of(30'001, "1,\n") + "]", {"a.toml:29999:", "30000"});
  refused("#" + text_of(1 << 12, std::string(1 << 12, 'a')), {"a.toml:1:", "16777217 bytes, want at most 16777216"});

  const auto fine = Settings::from_text("a = " + text_of(16, "[") + "1" + text_of(16, "]") + "\nb = '" +
                                            text_of(50'000, "[={,") + "'  # " + text_of(50'000, "[={,"),
                                        "fine.toml");
  CHECK(fine.text("b")->size() == 200'000);
}

TEST_CASE("of many unknown keys the first are said, in a time that grows as they do", "[dsp][settings]") {
  const auto faults_of = [](int count) {
    std::string text = "[prepare]\n";
    for (int i = 0; i < count; ++i) text += "k" + std::to_string(i) + " = 1\n";
    const auto settings = checked(text, {key("", "prepare", {.section = true}), key("prepare", "rate_hz", a_number)});
    try {
      settings.finish();
    } catch (const dsp::SeveralFaults& several) {
      return several.all();
    }
    return std::vector<Fault>();
  };
  const std::vector<Fault> few = faults_of(100), many = faults_of(101);
  CHECK(few.size() == 100);
  CHECK_THAT(few.back().what(), Catch::Contains("unknown key"));
  REQUIRE(many.size() == 101);
  CHECK(std::string(many.back().what()) == "more is wrong. Mend the above first");
  CHECK(many.back().name() == "config.unknown_key");
  const auto seconds = [&](int count) {
    double least = 1e9;
    for (int i = 0; i < 3; ++i) {
      const std::clock_t begin = std::clock();
      CHECK(faults_of(count).size() == 101);
      least = std::min(least, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    }
    return least;
  };
  CHECK(seconds(28'000) < 8.0 * seconds(7'000));  // four times as many; with their square it would be 16
}

TEST_CASE("a pipe in place of a settings file is refused at once", "[dsp][settings]") {
  const support::Scratch scratch;
  const auto pipe = scratch / "pipe.toml";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  check_fault([&] { (void)Settings::from_file(pipe); }, FaultKind::usage, "config.file", {"a pipe"});
}

TEST_CASE("any text survives being quoted", "[dsp][settings]") {
  rc::prop("quoted and read again", [](const std::vector<std::uint8_t>& codes) {
    std::string any;
    for (const auto code : codes) any += static_cast<char>(code & 0x7f);
    const auto settings = Settings::from_text("a = " + dsp::toml_quoted(any), "q.toml");
    RC_ASSERT(settings.text("a") == any);
  });
}

TEST_CASE("no text whatever crashes the reader of settings", "[dsp][settings]") {
  rc::prop("parsed or refused", [](std::string any) {
    try {
      (void)Settings::from_text(any, "fuzz.toml", {any});
    } catch (const dsp::Fault& fault) {
      RC_ASSERT(fault.kind() == FaultKind::usage);
    }
  });
}
