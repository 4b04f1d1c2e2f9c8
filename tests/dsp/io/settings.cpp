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

TEST_CASE("settings come typed, with their fallbacks", "[dsp][settings]") {
  const auto settings = Settings::from_text(config, "run.toml");
  const auto prepare = settings.table("prepare");
  CHECK(prepare.number("rate_hz", 1.0) == 25.6);
  CHECK(prepare.number("cutoff_hz", 10.24) == 10.24);
  CHECK(prepare.is_text("zero"));
  CHECK(prepare.choice("zero", "regime-mean", {"regime-mean", "none"}) == "none");
  CHECK(settings.table("library").integer("order", 0) == 3);
  CHECK(settings.table("library").texts("terms") == std::vector<std::string>{"sgn(v)", "ddr"});
  const auto ranges = settings.tables("range");
  REQUIRE(ranges.size() == 2);
  CHECK(ranges[0].need_number("to") == 830.0);  // a whole number will do
  CHECK(ranges[1].text("name", "") == "high");
  CHECK_FALSE(settings.has("fit"));
  CHECK_FALSE(settings.table("fit").find_text("target").has_value());
  CHECK(ranges[1].place("from") == "run.toml:13");
}

TEST_CASE("a key nobody asked for is an error with its line and the nearest known key", "[dsp][settings]") {
  const auto settings = Settings::from_text("a = 1\n[fit]\ntargte = \"a\"\n", "run.toml");
  (void)settings.number("a", 0);
  (void)settings.table("fit").text("target", "a");
  check_fault([&] { settings.finish(); }, FaultKind::usage, "config.unknown_key",
              {"run.toml:3:", "'fit.targte'", "Did you mean 'target'?"});
  const auto whole = Settings::from_text("[mystery]\nx = 1\n", "run.toml");
  (void)whole.has("schema");
  check_fault([&] { whole.finish(); }, FaultKind::usage, "config.unknown_key", {"run.toml:1:", "'mystery'", "schema"});
  const auto inner = Settings::from_text("[[range]]\nform = 1\n", "run.toml");
  for (const auto& range : inner.tables("range")) (void)range.number("from", 0);
  check_fault([&] { inner.finish(); }, FaultKind::usage, "config.unknown_key",
              {"run.toml:2:", "'[[range]] 1: form'", "Did you mean 'from'?"});
}

TEST_CASE("a key under the wrong heading is told the right one", "[dsp][settings]") {
  const auto settings = Settings::from_text("cutoff_hz = 1\n[prepare]\nto = 1\n[[range]]\n", "run.toml");
  (void)settings.table("prepare").number("cutoff_hz", 0);
  for (const auto& range : settings.tables("range")) (void)range.number("to", 0);
  check_fault([&] { settings.finish(); }, FaultKind::usage, "config.unknown_key",
              {"run.toml:1:", "'cutoff_hz'", "It is a key of [prepare]", "--set prepare.cutoff_hz="});
  const auto other = Settings::from_text("[prepare]\nto = 1\n[[range]]\n", "run.toml");
  (void)other.table("prepare").number("cutoff_hz", 0);
  for (const auto& range : other.tables("range")) (void)range.number("to", 0);
  check_fault([&] { other.finish(); }, FaultKind::usage, "config.unknown_key", {"[[range]]", "--set range.0.to="});
}

TEST_CASE("what was asked of a key is known afterwards: type, range, words and default", "[dsp][settings]") {
  const auto first = Settings::from_text("[[range]]\n[[range]]\n", "a.toml");
  for (const auto& range : first.tables("range")) (void)range.number("to", 5.0, {.from = 0.0, .above = true});
  (void)first.choice("way", "slow", {"slow", "fast"});
  std::vector<dsp::AskedSetting> all = first.asked();
  REQUIRE(all.size() == 3);  // both elements of an array are one table
  CHECK((all[0].key == "range" && all[0].tables));
  CHECK((all[1].table == "range" && all[1].number && all[1].range.above && all[1].fallback == "5"));
  CHECK((all[2].text && all[2].words.size() == 2 && all[2].fallback == "\"slow\""));
  const auto second = Settings::from_text("way = 3", "b.toml");
  (void)second.find_number("way");
  (void)second.need_number("way");
  dsp::add_asked(all, second.asked());
  REQUIRE(all.size() == 3);
  CHECK((all[2].text && all[2].number && all[2].required && all[2].words.size() == 2));
}

TEST_CASE("a table of notes may hold anything", "[dsp][settings]") {
  const auto settings = Settings::from_text("sensor = { model = \"ZX2\", serial = 12, day = 2022-11-02 }", "s.toml");
  const auto notes = settings.notes("sensor");
  CHECK(notes.at("model") == "ZX2");
  CHECK(notes.at("serial") == "12");
  CHECK(notes.at("day") == "2022-11-02");
  settings.finish();
}

TEST_CASE("wrong types and values out of range say what was found and wanted", "[dsp][settings]") {
  const auto faulty = [](const std::string& line, const auto& read, const char* name, std::vector<std::string> parts) {
    const auto settings = Settings::from_text("\n" + line + "\n", "c.toml");
    parts.push_back("c.toml:2: ");
    check_fault(
        [&] {
          read(settings);
          settings.finish();
        },
        FaultKind::usage, name, parts);
  };
  faulty("n = \"three\"", [](const Settings& s) { CHECK(s.number("n", 7) == 7.0); }, "config.type",
         {"n: got the text 'three', want a number"});
  faulty("r = -1", [](const Settings& s) { (void)s.number("r", 0, {.from = 0, .above = true}); }, "config.range",
         {"r: got -1, want a number, above 0"});
  faulty("r = -1", [](const Settings& s) { (void)s.number("r", 0, {.from = 0, .to = 4}); }, "config.range", {"0 to 4"});
  faulty("k = 2.5", [](const Settings& s) { CHECK(s.integer("k", 3) == 3); }, "config.type", {"whole number"});
  faulty("b = 1", [](const Settings& s) { CHECK(s.flag("b", true)); }, "config.type", {"true or false"});
  faulty("w = \"fst_rvm\"",
         [](const Settings& s) {
           CHECK(s.choice("w", "a", {"fast_rvm", "sindy"}) == "a");
         },
         "config.range", {"fast_rvm, sindy", "Did you mean 'fast_rvm'?"});
  faulty("v = nan", [](const Settings& s) { (void)s.number("v", 0); }, "config.range", {"nan", "finite"});
  const auto settings = Settings::from_text("n = 1\nr = 1\nk = 2.5\n", "c.toml");
  check_fault([&] { (void)settings.need_text("title"); }, FaultKind::usage, "config.missing", {"c.toml", "title"});
  check_fault([&] { (void)settings.table("k"); }, FaultKind::usage, "config.type", {"want a table [k]"});
  check_fault([&] { (void)settings.tables("k"); }, FaultKind::usage, "config.type", {"[[k]]"});
  check_fault([&] { settings.exclusive("n", "r"); }, FaultKind::usage, "config.range", {"cannot be given beside 'n'"});
}

TEST_CASE("all that is wrong with a document is said at once", "[dsp][settings]") {
  const auto settings =
      Settings::from_text("a = \"one\"\nb = -1\nz = 0\n[fit]\ntarget = 3\ntau = 2\nmore = 1\n", "c.toml");
  (void)settings.number("a", 0);
  (void)settings.number("b", 0, {.from = 0});
  const auto read_fit = [](const Settings& fit) {
    (void)fit.need_text("target");  // breaks off: nobody comes to ask for tau
    (void)fit.number("tau", 0);
  };
  settings.attempt([&] { read_fit(settings.table("fit")); });
  const auto whole = [&] {
    const auto all = Settings::from_text("[fit]\ntarget = \"a\"\n", "");
    read_fit(all.table("fit"));
    return all.asked();
  };
  std::vector<std::string> said;
  try {
    settings.finish(whole);
  } catch (const dsp::SeveralFaults& faults) {
    for (const Fault& fault : faults.all()) said.emplace_back(fault.what());
  }
  std::sort(said.begin(), said.end());
  const auto begins = [&](std::size_t i, const char* with) {
    CAPTURE(i, said);
    CHECK((said.size() > i && said[i].starts_with(with)));
  };
  CHECK(said.size() == 5);
  begins(0, "c.toml:1: a: got the text 'one'");
  begins(1, "c.toml:2: b: got -1");
  begins(2, "c.toml:3: unknown key 'z'");
  begins(3, "c.toml:5: fit.target: got 3");
  begins(4, "c.toml:7: unknown key 'fit.more'");
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
  Settings::from_text("", "c.toml").check_schema(1);
  Settings::from_text("schema = 1", "c.toml").check_schema(1);
  check_fault([] { Settings::from_text("\nschema = 2", "c.toml").check_schema(1); }, FaultKind::usage, "config.schema",
              {"c.toml:2", "got 2", "reads 1", "newer version"});
}

TEST_CASE("overrides replace, add and reach into arrays", "[dsp][settings]") {
  const auto settings =
      Settings::from_text(config, "run.toml",
                          {"prepare.rate_hz=51.2", "fit.target=ddy", "range.0.to=5", "range.2.name=mixed",
                           "library.terms=[\"x*v\", \"x\"]", "library.terms.2=abs(x)", "library.terms.1=v"});
  CHECK(settings.table("prepare").number("rate_hz", 0) == 51.2);
  CHECK(settings.table("fit").text("target", "a") == "ddy");
  CHECK(settings.tables("range").at(0).number("to", 0) == 5.0);
  CHECK(settings.tables("range").at(2).text("name", "") == "mixed");
  CHECK(settings.table("library").texts("terms") == std::vector<std::string>{"x*v", "v", "abs(x)"});
}

TEST_CASE("a fault in an override names the override", "[dsp][settings]") {
  const auto read = [](const std::string& override) {
    const auto settings = Settings::from_text(config, "run.toml", {override});
    for (const char* key : {"schema", "prepare", "library", "range", "fit"}) (void)settings.has(key);
    (void)settings.table("fit").has("target");
    for (const char* key : {"rate_hz", "zero"}) (void)settings.table("prepare").has(key);
    for (const char* key : {"order", "terms"}) (void)settings.table("library").has(key);
    for (const auto& range : settings.tables("range")) {
      for (const char* key : {"name", "from"}) (void)range.has(key);
      (void)range.number("to", 0);
    }
    settings.finish();
  };
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
  CHECK(Settings::from_file(scratch.file("c.toml", "a = 7")).integer("a", 0) == 7);
}

TEST_CASE("a key of thousands of parts is refused with its line, wherever it is written", "[dsp][settings]") {
  std::string key = "a";
  for (int i = 0; i < 50'000; ++i) key += i % 3 == 0 ? ".a" : i % 3 == 1 ? " . 'b.c'" : ".\"d\\\"\"";
  const auto refused = [](const std::string& text, const std::vector<std::string>& overrides, const char* name,
                          const std::vector<std::string>& pieces) {
    check_fault([&] { (void)Settings::from_text(text, "deep.toml", overrides); }, FaultKind::usage, name, pieces);
  };
  refused("x = \"\"\"1.2\n\"\"\"\"\n" + key + " = 1\n", {}, "config.syntax", {"deep.toml:3:", "16 parts"});
  refused("# 1.2\n[" + key + "]\n", {}, "config.syntax", {"deep.toml:2:"});
  refused("[[" + key + "]]\n", {}, "config.syntax", {"deep.toml:1:"});
  refused("x = { " + key + " = 1 }\n", {}, "config.syntax", {"deep.toml:1:"});
  std::string path = "a";
  for (int i = 0; i < 50'000; ++i) path += ".a";
  refused("a = 1", {path + "=1"}, "config.override", {"--set a.a", "16 parts"});

  const auto fine = Settings::from_text(
      "a.b.c = '1.2.3.4.5.6.7.8.9.1.2.3.4.5.6.7.8.9'\nd = [1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 8.5, 9.5, 1.5, 2.5, 3.5, "
      "4.5, 5.5, 6.5, 7.5, 8.5]  # e.f.g.h.i.j.k.l.m.n.o.p.q.r.s.t.u.v.w.x.y.z\n",
      "fine.toml");
  CHECK(fine.numbers("d").size() == 17);
  CHECK(fine.table("a").table("b").text("c", "").size() == 35);
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
  CHECK(fine.text("b", "").size() == 200'000);
}

TEST_CASE("of many unknown keys the first are said, in a time that grows as they do", "[dsp][settings]") {
  const auto faults_of = [](int count) {
    std::string text = "[prepare]\n";
    for (int i = 0; i < count; ++i) text += "k" + std::to_string(i) + " = 1\n";
    const auto settings = Settings::from_text(text, "a.toml");
    (void)settings.table("prepare").number("rate_hz", 1.0);
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
    std::string text;
    for (const auto code : codes) text += static_cast<char>(code & 0x7f);
    const auto settings = Settings::from_text("a = " + dsp::toml_quoted(text), "q.toml");
    RC_ASSERT(settings.need_text("a") == text);
  });
}

TEST_CASE("no text whatever crashes the reader of settings", "[dsp][settings]") {
  rc::prop("parsed or refused", [](std::string text) {
    try {
      (void)Settings::from_text(text, "fuzz.toml", {text});
    } catch (const dsp::Fault& fault) {
      RC_ASSERT(fault.kind() == FaultKind::usage);
    }
  });
}
