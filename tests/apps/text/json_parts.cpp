#include "apps/text/json_parts.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "apps/config/segments_file.hpp"
#include "apps/output/factors_file.hpp"
#include "apps/output/run_json.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"

using support::check_fault;

namespace {

std::string repeated(int count, const std::string& piece) {
  std::string text;
  for (int i = 0; i < count; ++i) text += piece;
  return text;
}

std::string object_of(int num_keys) {
  std::string text = "{";
  for (int i = 0; i < num_keys; ++i) text += (i == 0 ? "\"" : ",\"") + std::to_string(i) + "\":0";
  return text + "}";
}

}  // namespace

TEST_CASE("what a document of anybody holds is what is written", "[apps][json_parts]") {
  const std::string text = R"json({"a":[1,{"b":null}],"c":{"d":"e"},"f":2.5})json";
  CHECK(apps::parsed_json(text).dump() == text);
  CHECK(apps::parsed_json(object_of(1000)).size() == 1000);
  // Keys are counted object by object, one beside the other and one within the other.
  CHECK(apps::parsed_json("[" + object_of(900) + "," + object_of(900) + "]").size() == 2);
  CHECK(apps::parsed_json("{\"a\":" + object_of(900) + "," + object_of(900).substr(1)).size() == 901);
  CHECK(apps::parsed_json(repeated(60, "[") + repeated(60, "]")).size() == 1);
  CHECK_THROWS_AS(apps::parsed_json("[1,"), nlohmann::json::exception);
}

TEST_CASE("a document that is too deep, or an object of too many keys, is refused by whoever reads it",
          "[apps][json_parts]") {
  const support::Scratch folder;
  for (const auto& [text, piece] :
       {std::pair<std::string, std::string>{repeated(100'000, "["), "64 levels"},
        {repeated(100'000, "{\"a\":"), "64 levels"},
        {object_of(1001), "more than 1000 keys"},
        {"[" + object_of(200'000), "more than 1000 keys"},
        {"{\"a\":" + object_of(500) + "," + object_of(1001).substr(1), "more than 1000 keys"}}) {
    CHECK_THROWS_AS(apps::parsed_json(text), std::invalid_argument);
    const auto file = folder.file("a.json", text);
    check_fault([&] { (void)apps::read_run_json(file); }, dsp::FaultKind::input, "run.damaged", {"a.json", piece});
    check_fault([&] { (void)apps::read_segments(file); }, dsp::FaultKind::usage, "segments.syntax", {"a.json", piece});
    CHECK(support::fault_of([&] { (void)apps::read_factors(file); }).kind() == dsp::FaultKind::input);
  }
}
