#include "apps/config/config.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "dsp/io/settings.hpp"
#include "dsp/io/toml_values.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"

using support::check_fault;
using support::Scratch;

namespace {

constexpr auto full = R"toml(schema = 1
[[recording]]
file = "data/a.csv"
[[recording]]
file = "data/b.csv"
sidecar = "b.meta.toml"
salvage = true
use = { x = "laser 2" }
[prepare]
recipe = "paper"
rate_hz = 25.6
cutoff_hz = 10.24
zero = -0.002
acceleration = "displacement"
[library]
order = 2
variables = ["x", "v", "y"]
terms = ["sgn(v)", "ddr"]
[fit]
target = "ddy"
methods = ["fast_rvm", "lasso"]
selection = "type2"
tau = 12
threshold = 0.1
threshold_on = "raw"
[[range]]
name = "low"
from = 0
to = 830
train_to = 500
where = "abs(v) > 0.004"
[[range]]
name = "second"
recording = "b"
)toml";

void refused(const std::string& text, const std::string& name, const std::vector<std::string>& pieces) {
  const Scratch folder;
  CAPTURE(text);
  check_fault([&] { (void)apps::read_config(folder.file("c.toml", text)); }, dsp::FaultKind::usage, name, pieces);
}

/// A table of two runs, side by side.
std::string two_runs() {
  std::string text = "Time (s) Run #1,x (mm) Run #1,Time (s) Run #2,x (mm) Run #2\n";
  for (int i = 0; i < 20; ++i) text += fmt::format("{0:.2f},{1},{0:.2f},{2}\n", i / 50.0, i * i % 7, i * i % 11);
  return text;
}

const std::string recording = "[[recording]]\nfile = \"a.csv\"\n";

}  // namespace

TEST_CASE("a config is read with its paths from its own folder", "[apps][config]") {
  const Scratch folder;
  const apps::Config config = apps::read_config(folder.file("c.toml", full));
  REQUIRE(config.recordings.size() == 2);
  CHECK(config.recordings[0].file == folder / "data/a.csv");
  CHECK(config.recordings[1].sidecar == folder / "b.meta.toml");
  CHECK(config.recordings[1].salvage);
  CHECK(config.recordings[1].use.at("x") == "laser 2");
  CHECK(config.prepare.recipe == dsp::Recipe::paper);
  CHECK(config.prepare.rate_hz == 25.6);
  CHECK(config.prepare.rolloff_hz == 0.0);
  CHECK(config.zero.kind == apps::ZeroChoice::Kind::value);
  CHECK(config.zero.value_m == -0.002);
  CHECK(config.library.order == 2);
  CHECK(config.library.variables == std::vector<std::string>{"x", "v", "y"});
  CHECK(config.fit.target == "ddy");
  CHECK(config.fit.methods == std::vector{ident::Method::fast_rvm, ident::Method::lasso});
  const auto options = config.fit.settings.options_of({ident::Method::fast_rvm, ident::Method::stlsq});
  CHECK(std::get<ident::FastRvmOptions>(options[0]).selection == ident::Selection::type2);
  CHECK(std::get<ident::FastRvmOptions>(options[0]).tau == 12.0);
  CHECK(std::get<ident::StlsqOptions>(options[1]).threshold == 0.1);
  CHECK_FALSE(std::get<ident::StlsqOptions>(options[1]).unit_norm);
  REQUIRE(config.ranges.size() == 2);
  CHECK(config.ranges[0].recording == 0);
  CHECK(config.ranges[0].spec.train_to_s == 500.0);
  CHECK(config.ranges[1].recording == 2);
}

TEST_CASE("a bare recording is a config of defaults, and --set goes on top", "[apps][config]") {
  const apps::Config plain = apps::read_config("some/where/a.csv");
  CHECK(plain.recordings.front().file == "some/where/a.csv");
  CHECK(plain.library.order == 3);
  CHECK(plain.fit.target == "a");
  CHECK(plain.ranges.empty());
  const apps::Config set = apps::read_config(
      "a.csv", {"library.order=2", "fit.target=ddy", "prepare.zero=none", "range.0.name=low", "range.0.to=5"});
  CHECK(set.library.order == 2);
  CHECK(set.fit.target == "ddy");
  CHECK(set.zero.kind == apps::ZeroChoice::Kind::none);
  REQUIRE(set.ranges.size() == 1);
  CHECK(set.ranges.front().spec.to_s == 5.0);
}

TEST_CASE("a config written down reads back as itself, to the byte", "[apps][config]") {
  const Scratch folder;
  const apps::Config config = apps::read_config(folder.file("c.toml", full));
  const std::string written = apps::to_toml(config, folder / "run");
  CHECK_THAT(written, Catch::Contains("file = \"../data/a.csv\""));
  std::filesystem::create_directory(folder / "run");
  const apps::Config again = apps::read_config(folder.file("run/config.toml", written));
  CHECK(apps::to_toml(again, folder / "run") == written);
  CHECK(again.prepare.cutoff_hz == config.prepare.cutoff_hz);
  CHECK(again.ranges[0].spec.where == config.ranges[0].spec.where);
}

TEST_CASE("every key that is given another value than its default is written with it", "[apps][config]") {
  const Scratch folder;
  const auto other_value = [](const dsp::Setting& setting) -> std::string {
    const dsp::SettingType& type = setting.type;
    if (setting.key == "methods") return "[\"ols\"]";
    if (type.flag) return setting.fallback == "true" ? "false" : "true";
    for (const std::string& word : type.words)
      if (const std::string text = dsp::toml_quoted(word); text != setting.fallback && text != setting.left_out)
        return text;
    if (type.number || type.whole_number) return type.range.to <= 1.0 ? "0.5" : "3";
    return type.several ? "[\"x\"]" : "\"x\"";
  };
  int tried = 0;
  for (const dsp::Setting& setting : apps::config_settings()) {
    const std::string path = setting.table + "." + setting.key;
    const bool is_single = setting.table.find('.') == std::string::npos && setting.table != "recording" &&
                           setting.table != "range" && setting.table != "study" && !setting.table.empty();
    if (!is_single || !setting.former.empty() || path == "library.only" || path == "output.full") continue;
    const std::string text =
        recording + "[" + setting.table + "]\n" + setting.key + " = " + other_value(setting) + "\n";
    CAPTURE(text);
    const std::string written = apps::to_toml(apps::read_config(folder.file("c.toml", text)), folder / "");
    CHECK(dsp::toml_values(written, "").at(path) == dsp::toml_values(text, "").at(path));
    ++tried;
  }
  CHECK(tried > 30);
}

TEST_CASE("an unknown key is named with its line and the nearest key", "[apps][config]") {
  refused(recording + "[prepare]\ncutof_hz = 10\n", "config.unknown_key", {"c.toml:4", "cutof_hz", "cutoff_hz"});
  refused("[[recordings]]\nfile = \"a.csv\"\n", "config.unknown_key", {"c.toml:1", "recordings"});
}

TEST_CASE("wrong types and values out of range are refused with what is allowed", "[apps][config]") {
  refused(recording + "[prepare]\nrate_hz = \"fast\"\n", "config.type", {"c.toml:4", "rate_hz"});
  refused(recording + "[prepare]\nrate_hz = -1\n", "config.range", {"c.toml:4", "rate_hz", "-1"});
  refused(recording + "[prepare]\nrecipe = \"both\"\n", "config.range", {"c.toml:4", "matched", "paper"});
  refused(recording + "[prepare]\nrate_hz = 20\ncutoff_hz = 15\n", "config.range",
          {"c.toml:5", "15", "less than", "10"});
  refused(recording + "[prepare]\ncutoff_hz = 5\nrolloff_hz = 6\n", "config.range", {"c.toml:5", "cutoff_hz"});
  refused(recording + "[fit]\nmethods = [\"magic\"]\n", "config.range", {"c.toml:4", "fast_rvm"});
  refused(recording + "[fit]\nmethods = []\n", "config.range", {"c.toml:4"});
  refused(recording + "[library]\norder = 0\n", "config.missing", {"c.toml:4", "terms"});
  refused(recording + "[library]\norder = 1e9\n", "config.type", {"c.toml:4", "order"});
}

TEST_CASE("ranges that make no sense are refused with their line", "[apps][config]") {
  refused(recording + "[[range]]\nname = \"a\"\nfrom = 5\nto = 3\n", "config.range", {"c.toml:6", "to"});
  refused(recording + "[[range]]\nname = \"a\"\nto = 3\ntrain_to = 4\n", "config.range", {"c.toml:6", "train_to"});
  refused(recording + "[[range]]\nname = \"a\"\n[[range]]\nname = \"a\"\n", "config.range", {"c.toml", "a"});
  refused(recording + "[[range]]\nname = \"a\"\nrecording = 2\n", "config.range", {"c.toml:5"});
  refused(recording + "[[range]]\nname = \"a\"\nrecording = \"b\"\n", "range.recording", {"c.toml:5", "b", "a"});
}

TEST_CASE("another schema, a broken document, a sidecar and no recording are distinguished", "[apps][config]") {
  refused("schema = 2\n" + recording, "config.schema", {"c.toml:1", "2"});
  refused("schema = 0\n" + recording, "config.range", {"c.toml:1"});
  refused("schema = \n", "config.syntax", {"c.toml:1"});
  refused("[[channel]]\nname = \"a\"\n", "config.missing", {"sidecar"});
  refused("[fit]\ntarget = \"a\"\n", "config.missing", {"[[recording]]"});
  refused("a = " + std::string(100'000, '[') + std::string(100'000, ']') + "\n", "config.syntax", {"c.toml"});
}

TEST_CASE("every run of a table is a recording where the sidecar or the config says all", "[apps][config]") {
  const Scratch folder;
  const auto table = folder.file("a.csv", two_runs());
  const auto named = [&](const apps::Config& config) {
    std::vector<std::pair<std::string, int>> names;
    for (const apps::RecordingConfig& one : config.recordings) names.emplace_back(one.name, one.run);
    return names;
  };
  using Names = std::vector<std::pair<std::string, int>>;
  const Names both{{"a.csv run 1", 1}, {"a.csv run 2", 2}};
  CHECK(named(apps::read_config(table)) == Names{{"a.csv", 0}});
  const auto config = apps::read_config(folder.file("c.toml", recording + "run = \"all\"\n"));
  CHECK(named(config) == both);
  const auto again = apps::read_config(folder.file("again.toml", apps::to_toml(config, folder / "")));
  CHECK(named(again) == both);
  CHECK(named(apps::read_config(folder.file("d.toml", recording + "run = 2\n"))) == Names{{"a.csv run 2", 2}});
  (void)folder.file("a.csv.toml", "run = \"all\"\n");
  CHECK(named(apps::read_config(table)) == both);
  refused(recording + "run = \"both\"\n", "config.range", {"run"});
}
