#include "apps/config/study_cells.hpp"

#include <catch2/catch.hpp>

#include "support/fault.hpp"
#include "support/scratch.hpp"

TEST_CASE("an axis is read from what was typed", "[apps][study_cells]") {
  const apps::StudyAxis cutoff = apps::parse_axis("cutoff_hz=6,8,10.24");
  CHECK(cutoff.key == "prepare.cutoff_hz");
  CHECK(cutoff.values == std::vector<std::string>{"6", "8", "10.24"});
  const apps::StudyAxis terms = apps::parse_axis("library.terms=[\"x\", \"v\"],[\"x\",\"exp(x,)\"]");
  CHECK(terms.key == "library.terms");
  CHECK(terms.values == std::vector<std::string>{"[\"x\", \"v\"]", "[\"x\",\"exp(x,)\"]"});
  for (const char* text : {"tau", "=1,2", "speed=1", "tau=1,,2", "tau="}) {
    CAPTURE(text);
    support::check_fault([&] { (void)apps::parse_axis(text); }, dsp::FaultKind::usage, "study.over",
                         {text, "want KEY"});
  }
}

TEST_CASE("cells are each value alone, or every combination", "[apps][study_cells]") {
  const std::vector<apps::StudyAxis> axes{{"library.order", {"1", "2", "3"}}, {"fit.tau", {"5", "10"}}};
  const auto alone = apps::study_cells(axes, false), grid = apps::study_cells(axes, true);
  REQUIRE(alone.size() == 1 + 3 + 2);
  CHECK(alone[0].label() == "as it is");
  CHECK(alone[4].label() == "fit.tau=5");
  CHECK(alone[4].axis == 1);
  REQUIRE(grid.size() == 3 * 2);
  CHECK(grid[1].label() == "library.order=1 fit.tau=10");
  CHECK(grid[1].axis == -1);
}

TEST_CASE("what a study varies of itself are settings that a config has", "[apps][study_cells]") {
  const support::Scratch folder;
  const auto file = folder.file("c.toml", "[[recording]]\nfile = \"a.csv\"\n");
  const std::vector<apps::StudyAxis> axes = apps::default_axes(apps::read_config(file), 100.0, 100'000);
  CHECK(axes.size() >= 5);
  for (const apps::StudyAxis& axis : axes)
    for (const std::string& value : axis.values) {
      CAPTURE(axis.key, value);
      CHECK_NOTHROW(apps::read_config(file, {axis.key + "=" + value}));
    }
}

TEST_CASE("the best cut-off is best on its worst range and keeps the motion", "[apps][study_cells]") {
  const auto result = [](const char* value, bool keeps_motion, std::vector<std::pair<ident::Verdict, double>> ranges) {
    apps::StudyResult one;
    one.cell.setting = {{"prepare.cutoff_hz", value}};
    one.keeps_motion = keeps_motion;
    for (const auto& [verdict, nmse] : ranges) {
      ident::JudgedFit fit;
      fit.judgement.verdict = verdict;
      fit.free_run.nmse_centred = nmse;
      one.ranges.push_back({});
      one.ranges.back().fits.push_back(std::move(fit));
    }
    return one;
  };
  using ident::Verdict;
  const auto in_parts =
                 result("40", true, {{Verdict::in_part, 0.02}, {Verdict::in_part, 0.02}, {Verdict::in_part, 0.02}}),
             whole = result("20", true, {{Verdict::describes, 0.005}}),
             closer = result("15", true, {{Verdict::describes, 0.002}}),
             narrow = result("5", false, {{Verdict::describes, 1e-5}});
  CHECK(apps::best_cutoff({in_parts, whole}) == 1);
  CHECK(apps::best_cutoff({in_parts, whole, closer, narrow}) == 2);
  CHECK(apps::best_cutoff({narrow}) == -1);
  CHECK(apps::best_cutoff({apps::StudyResult{}}) == -1);
}
