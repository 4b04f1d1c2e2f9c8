#include "apps/reference/setting_reference.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "apps/config/config.hpp"
#include "apps/reference/topics.hpp"
#include "dsp/io/settings.hpp"
#include "dsp/io/sidecar.hpp"
#include "support/program.hpp"

using support::bytes_of;
using support::expect;
using support::Scratch;

namespace {

/// A value that a key takes.
std::string value_for(const dsp::Setting& setting) {
  const dsp::SettingType& type = setting.type;
  if (!setting.fallback.empty()) return setting.fallback;
  if (!type.words.empty()) return dsp::toml_quoted(type.words.back());
  if (type.number || type.whole_number) return type.range.above ? "1" : "0";
  return type.flag ? "true" : "\"x\"";
}

}  // namespace

TEST_CASE("every key is named once and described, but those that are gone", "[apps][reference]") {
  for (const auto* settings : {&apps::config_settings(), &dsp::sidecar_settings()}) {
    std::set<std::string> names;
    for (const dsp::Setting& setting : *settings) {
      CAPTURE(setting.table, setting.key);
      CHECK(names.insert(setting.table + "." + setting.key).second);
      const bool is_role = setting.table == "recording.use";  // roles are described with the signals
      CHECK(setting.meaning.empty() == (is_role || !setting.former.empty()));
    }
  }
}

TEST_CASE("a key of the reference is taken by the reader, its misspelling is not", "[apps][reference]") {
  const Scratch folder;
  int tried = 0;
  for (const dsp::Setting& setting : apps::config_settings()) {
    if (setting.table != "prepare" && setting.table != "segment" && setting.table != "fit" &&
        setting.table != "library" && setting.table != "output")
      continue;
    if (setting.key == "methods" || setting.key == "target" || !setting.former.empty()) continue;
    const auto text = [&](const std::string& key) {
      return "[[recording]]\nfile = \"a.csv\"\n[" + setting.table + "]\n" + key + " = " + value_for(setting) + "\n";
    };
    CAPTURE(setting.table, setting.key, text(setting.key));
    CHECK_NOTHROW(apps::read_config(folder.file("c.toml", text(setting.key))));
    CHECK_THROWS_WITH(apps::read_config(folder.file("c.toml", text(setting.key + "_x"))),
                      Catch::Contains("unknown key"));
    ++tried;
  }
  CHECK(tried > 30);
}

TEST_CASE("what is printed of a key is what its reader applies", "[apps][reference]") {
  const std::string config = apps::to_text(apps::config_page());
  for (const char* piece :
       {"[[recording]]", "[prepare]", "cutoff_hz", "One of \"matched\", \"paper\"; left out: \"matched\".",
        "Number from 0 to 1; left out: 0.01.", "True or false; left out: true.",
        "Whole number from 0 to 24; left out: 3."})
    CHECK_THAT(config, Catch::Contains(piece));
  const std::string sidecar = apps::to_text(apps::sidecar_page());
  for (const char* piece :
       {"[[channel]]", "sensitivity_uncertainty", "Text; must be given.", "\"AC\", \"DC\", \"IEPE\""})
    CHECK_THAT(sidecar, Catch::Contains(piece));
}

TEST_CASE("docs/method.md has the rules of the verdict as the program has them", "[apps][reference]") {
  INFO("to mend: the section 'verdict' of ardent help reference, a level deeper, into docs/method.md");
  CHECK_THAT(bytes_of(ARDENT_DOCS "/method.md"), Catch::Contains(to_markdown(apps::verdict_page(), 3)));
}

TEST_CASE("docs/reference.md is what the program prints", "[apps][reference]") {
  const Scratch folder;
  const auto printed = expect(folder, "$ARDENT help reference", 0, {});
  INFO("to mend: ardent help reference > docs/reference.md");
  CHECK(printed.out == bytes_of(ARDENT_DOCS "/reference.md"));
}
