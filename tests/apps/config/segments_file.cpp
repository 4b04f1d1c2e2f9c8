#include "apps/config/segments_file.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "support/fault.hpp"
#include "support/program.hpp"

using nlohmann::json;
using support::Scratch;

namespace {

const std::string intermediate_file = std::string(ARDENT_DATA) + "/qzs_256.flac";

/// A recording that is prepared already: 100 s at 10 Hz, the first second ruled out.
dsp::Prepared prepared() {
  dsp::Prepared result{.name = "a.wav"};
  for (dsp::Motion* motion : {&result.intermediate, &result.signals}) {
    motion->sample_rate_hz = 10.0;
    motion->signals.push_back({"x", "m", Eigen::VectorXd::Zero(1000)});
    motion->excluded.assign(1000, 0);
    dsp::mark(*motion, {0.0, 1.0, "start"});
  }
  result.excluded = {{0.0, 1.0, "start"}};
  return result;
}

}  // namespace

TEST_CASE("intervals label samples: excluded wins, then the later one, and gaps are excluded",
          "[apps][segments_file]") {
  auto record = prepared();
  using dsp::Regime;
  const auto found = apps::apply_segments({{Regime::excluded, 20.0, 25.0, "a knock", {}},
                                           {Regime::low, 0.0, 50.0, "", {}},
                                           {Regime::high, 40.0, 60.0, "by eye", {}},
                                           {Regime::stick, 70.0, 100.0, "", {}}},
                                          "s.json", record);
  std::vector<Regime> labels;
  Eigen::Index next = 0;
  for (const auto& segment : found.segments) {
    CHECK(segment.first == next);
    next = segment.last;
    labels.push_back(segment.regime);
  }
  CHECK(next == 1000);
  CHECK(labels == std::vector{Regime::excluded, Regime::low, Regime::excluded, Regime::low, Regime::high,
                              Regime::excluded, Regime::stick});
  CHECK(found.segments[4].first == 400);
  CHECK(found.segments[4].reason == "by eye");
  // What a person ruled out is ruled out for every range, those given by time too.
  CHECK(record.signals.excluded[220] == 1);
  CHECK(record.signals.excluded[650] == 1);
  CHECK(record.signals.excluded[300] == 0);
  REQUIRE(record.excluded.size() == 3);
  CHECK_THAT(record.excluded[2].why, Catch::Contains("no interval of s.json"));
}

TEST_CASE("a segments file that makes no sense is refused with its number", "[apps][segments_file]") {
  const Scratch folder;
  const auto refused = [&](const std::string& text, const char* name, const std::vector<std::string>& pieces) {
    const auto file = folder.file("s.json", text);
    support::check_fault([&] { (void)apps::read_segments(file); }, dsp::FaultKind::usage, name, pieces);
  };
  refused("[{\"label\": \"low\" \"from_s\": 0}]", "segments.syntax", {"s.json", "line 1"});
  refused("[]", "segments.syntax", {"list of intervals"});
  refused("[{\"label\": \"medium\", \"from_s\": 0, \"to_s\": 1}]", "segments.label", {"interval 1", "medium", "high"});
  refused("[{\"label\": \"low\", \"from_s\": 2, \"to_s\": 1}]", "segments.time", {"interval 1", "from_s 2"});
  refused("[{\"label\": \"low\", \"from_s\": \"2\", \"to_s\": 1}]", "segments.time", {"from_s"});
  refused("[{\"label\": \"low\", \"from_s\": 0, \"to_s\": 1, \"probability\": \"likely\"}]", "segments.syntax",
          {"probability"});
  refused("[{\"lable\": \"low\", \"from_s\": 0, \"to_s\": 1}]", "segments.syntax", {"lable"});
  auto record = prepared();
  support::check_fault(
      [&] {
        (void)apps::apply_segments({{dsp::Regime::low, 0, 1, "", "b.wav"}}, "s.json", record);
      },
      dsp::FaultKind::usage, "segments.recording", {"a.wav"});
}

TEST_CASE("segments handed back unedited change nothing, and edited ones are followed", "[apps][segments_file]") {
  const Scratch folder;
  const auto run = [&](const std::string& name, const std::string& segment) {
    (void)folder.file(name + ".toml", "schema = 1\n[[recording]]\nfile = \"" + intermediate_file +
                                          "\"\n[prepare]\nrate_hz = 25.6\ncutoff_hz = 10.24\n[library]\norder = 0\n"
                                          "terms = [\"x\", \"v\", \"x^3\", \"sgn(v)\", \"ddr\"]\n"
                                          "[fit]\nmethods = [\"ols\"]\n[segment]\n" +
                                          segment);
    const auto ended = support::run(folder, "$ARDENT -q --force run " + name + ".toml -o " + name);
    CAPTURE(ended.err);
    REQUIRE(ended.code == 0);
    return json::parse(support::bytes_of(folder / (name + "/metrics.json")))["ranges"];
  };
  const json found = run("found", "");
  REQUIRE(found.size() == 3);
  const auto text = support::bytes_of(folder / "found/segments.json");
  CHECK(run("same", "file = \"found/segments.json\"\n").at(0)["methods"][0]["terms"] ==
        found[0]["methods"][0]["terms"]);
  CHECK(support::bytes_of(folder / "same/segments.json") == text);

  json edited = json::parse(text);
  int estimated = 0;
  for (const auto& row : edited) {
    if (row["label"] == "low" || row["label"] == "high") CHECK(row["probability"].get<double>() > 0.9);
    estimated += row["from_std_s"].is_number() ? 1 : 0;
  }
  CHECK(estimated > 0);
  for (auto& row : edited)
    if (row["label"] == "high") row["label"] = "excluded";
  (void)folder.file("edited.json", edited.dump());
  const json without = run("edited", "file = \"edited.json\"\nsplit = \"sgn(v)\"\n");
  REQUIRE(without.size() == 2);  // stick and one regime of motion, split by direction
  CHECK(without[0]["name"] == "low+");
  CHECK(without[1]["name"] == "low-");
  CHECK(without[0]["num_train"].get<double>() + without[1]["num_train"].get<double>() ==
        Approx(found[0]["num_train"].get<double>()).epsilon(0.01));
  const auto config = support::bytes_of(folder / "edited/config.toml");
  CHECK_THAT(config, Catch::Contains("where = \"v > 0\"") && !Catch::Contains("split"));
}
