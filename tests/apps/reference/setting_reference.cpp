#include "apps/reference/setting_reference.hpp"

#include <catch2/catch.hpp>

#include "apps/config/config.hpp"
#include "apps/reference/topics.hpp"
#include "dsp/io/settings.hpp"
#include "dsp/io/sidecar.hpp"
#include "support/program.hpp"

using support::bytes_of;
using support::expect;
using support::Scratch;

namespace {

/// A document that gives every key of one table but those that exclude each other, with a value of the type asked for.
std::string value_for(const dsp::AskedSetting& setting) {
  if (setting.fallback.empty() && setting.words.empty() && (setting.number || setting.whole_number))
    return setting.range.above ? "1" : "0";
  if (!setting.fallback.empty()) return setting.fallback;
  for (const std::string& word : setting.words)
    if (!word.empty()) return dsp::toml_quoted(word);
  if (setting.flag) return "true";
  return "\"x\"";
}

}  // namespace

TEST_CASE("every key that is read is described, and every key that is described is read", "[apps][reference]") {
  CHECK(apps::undescribed(apps::config_settings(), apps::config_help()).empty());
  CHECK(apps::undescribed(dsp::sidecar_settings(), apps::sidecar_help()).empty());
  const std::vector<dsp::AskedSetting> asked{{"fit", "tau"}, {"fit", "new_one"}};
  CHECK(apps::undescribed(asked, {{"fit", "tau", "..."}, {"fit", "old", "..."}, {"fit", "new_one", ""}}) ==
        std::vector<std::string>{"fit.new_one", "fit.old"});
}

TEST_CASE("a key of the reference is taken by the reader, its misspelling is not", "[apps][reference]") {
  const Scratch folder;
  int tried = 0;
  for (const dsp::AskedSetting& setting : apps::config_settings()) {
    if (setting.table != "prepare" && setting.table != "segment" && setting.table != "fit" &&
        setting.table != "library" && setting.table != "output")
      continue;
    if (setting.key == "methods" || setting.key == "target") continue;
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
        "Whole number from 0 to 1000; left out: 3."})
    CHECK_THAT(config, Catch::Contains(piece));
  const std::string sidecar = apps::to_text(apps::sidecar_page());
  for (const char* piece :
       {"[[channel]]", "sensitivity_uncertainty", "Text; must be given.", "\"AC\", \"DC\", \"IEPE\""})
    CHECK_THAT(sidecar, Catch::Contains(piece));
}

TEST_CASE("docs/reference.md is what the program prints", "[apps][reference]") {
  const Scratch folder;
  const auto printed = expect(folder, "$ARDENT help reference", 0, {});
  INFO("to mend: ardent help reference > docs/reference.md");
  CHECK(printed.out == bytes_of(ARDENT_DOCS "/reference.md"));
}
