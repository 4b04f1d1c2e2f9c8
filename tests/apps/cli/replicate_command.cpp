#include "apps/cli/replicate_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/paper/comparison.hpp"
#include "apps/paper/inner_state.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"

using nlohmann::json;

namespace {

json replicate(const support::Scratch& scratch, apps::ReplicateArguments arguments) {
  arguments.folder = scratch / "out";
  arguments.force = true;
  apps::Console console({.verbosity = -1, .progress = apps::ProgressMode::never});
  apps::run_replicate(arguments, console);
  return json::parse(support::bytes_of(scratch / "out" / "replicate.json"));
}

std::string text(const apps::Json& row, const char* key) {
  return row.at(key).get<std::string>();
}

double value(const apps::Json& row, const char* key) {
  return apps::number_in(row.at(key));
}

// Verdicts of the case's printed numbers, counted by quantity, method and verdict.
std::map<std::string, int> verdicts(const char* name) {
  const auto replication = apps::replicate_case(*apps::find_section4_case(name), {.first_seed = 80000});
  std::map<std::string, int> counts;
  for (const auto& c : apps::compare_with_paper(replication))
    ++counts[fmt::format("{} {} {}", text(c, "quantity"), text(c, "method"), text(c, "verdict"))];
  return counts;
}

}  // namespace

TEST_CASE("replicate writes the table, the figure and the JSON of what was asked", "[apps][replicate]") {
  const support::Scratch scratch;
  const auto document = replicate(scratch, {.items = {"table-1", "fig-3"}, .folder = {}, .first_seed = 7, .tau = {}});
  CHECK(std::filesystem::exists(scratch / "out" / "table-1.txt"));
  CHECK(std::filesystem::exists(scratch / "out" / "fig-3.svg"));
  CHECK_FALSE(std::filesystem::exists(scratch / "out" / "fig-2.svg"));
  CHECK_FALSE(std::filesystem::exists(scratch / "out" / "table-2.txt"));
  const std::string page = support::bytes_of(scratch / "out" / "replicate.html");
  for (const char* piece : {"Content-Security-Policy", "Table 1: duffing", "Figure 3: coulomb", "verdict on the print",
                            "not an uncertainty", "id=\"fig-3-0\""})
    CHECK_THAT(page, Catch::Contains(piece));
  const auto& fits = document.at("fits");
  REQUIRE(fits.size() == 2 * 2 * 7);  // two cases, two rows, seven methods
  for (const auto& fit : fits) {
    CHECK((fit.at("case") == "duffing" || fit.at("case") == "coulomb"));
    CHECK(fit.at("seed") == 7);
    CHECK(fit.at("noise") == 0.1);
    for (const char* key :
         {"row", "method", "selection", "support_exact", "false_terms", "missing_terms", "terms", "seconds"})
      CHECK(fit.contains(key));
    for (const auto& term : fit.at("terms"))
      for (const char* key : {"name", "true", "mean", "std"}) CHECK(term.contains(key));
  }
  REQUIRE(document.at("free_run").size() == 2 * 4 * 2 * 3);  // cases, ratios, signals, methods
  for (const auto& run : document.at("free_run")) CHECK(run.at("nmse").get<double>() < 0.1);
  for (const auto& entry : document.at("paper"))
    for (const char* key : {"table", "row", "term", "method", "paper", "ours", "ours_std", "verdict"})
      CHECK(entry.contains(key));
  CHECK_THAT(support::bytes_of(scratch / "out" / "table-1.txt"), Catch::Contains("not an uncertainty"));
  CHECK_THAT(support::bytes_of(scratch / "out" / "fig-3.svg"), Catch::Contains("free-run NMSE"));
}

TEST_CASE("a folder of results is replaced whole, only when asked to, and never through a link", "[apps][replicate]") {
  const support::Scratch scratch;
  (void)replicate(scratch, {.items = {"table-2"}, .folder = {}, .tau = {}});
  REQUIRE(std::filesystem::exists(scratch / "out" / "table-2.txt"));
  apps::Console console({.verbosity = -1, .progress = apps::ProgressMode::never});
  apps::ReplicateArguments again{.items = {"table-1"}, .folder = scratch / "out", .tau = {}};
  support::check_fault([&] { apps::run_replicate(again, console); }, dsp::FaultKind::output, "output.exists",
                       {"--force"});
  again.force = true;
  apps::run_replicate(again, console);
  CHECK(std::filesystem::exists(scratch / "out" / "table-1.txt"));
  CHECK_FALSE(std::filesystem::exists(scratch / "out" / "table-2.txt"));
  CHECK(std::filesystem::exists(scratch / "out" / "manifest.json"));
  std::filesystem::create_symlink(scratch / "out", scratch / "link");
  again.folder = scratch / "link";
  support::check_fault([&] { apps::run_replicate(again, console); }, dsp::FaultKind::output, "output.symlink", {});
}

TEST_CASE("seconds are per seed, whichever is the first", "[apps][replicate]") {
  auto replication = apps::replicate_case(*apps::find_section4_case("duffing"), {.num_seeds = 2, .first_seed = 0});
  for (apps::Json& fit : replication.document["fits"]) fit["seconds"] = 1.0;
  replication.document["accumulate"][0]["seconds"] = 0.25;
  for (const auto& c : apps::compare_with_paper(replication))
    if (c["quantity"] == "seconds") CHECK(value(c, "ours") == 2.25);  // two rows
}

TEST_CASE("replicate says what it does not know", "[apps][replicate]") {
  const support::Scratch scratch;
  const auto fault = [&](apps::ReplicateArguments arguments, const std::string& name, const std::string& piece) {
    support::check_fault([&] { (void)replicate(scratch, arguments); }, dsp::FaultKind::usage, name, {piece});
  };
  fault({.items = {"table-99"}, .folder = {}, .tau = {}}, "replicate.item",
        "'table-99' is not known; there are table-1 to table-12");
  fault({.items = {}, .folder = {}, .tau = {}}, "replicate.item", "nothing to do");
  fault({.items = {"all"}, .folder = {}, .num_seeds = 0, .tau = {}}, "replicate.seeds", "--seeds 0");
  fault({.items = {"all"}, .folder = {}, .noise = -1.0, .tau = {}}, "replicate.noise", "--noise -1");
  fault({.items = {"all"}, .folder = {}, .selection = "best", .tau = {}}, "replicate.selection",
        "evidence-white, evidence or type2");
  fault({.items = {"all"}, .folder = {}, .tau = -2.0}, "replicate.tau", "--tau -2");
}

TEST_CASE("selection and tau reach the fits", "[apps][replicate]") {
  const support::Scratch scratch;
  const auto type2 = replicate(scratch, {.items = {"table-1"}, .folder = {}, .selection = "type2", .tau = {}});
  int false_terms = 0;
  for (const auto& fit : type2.at("fits"))
    if (fit.at("method") == "fast_rvm") false_terms += static_cast<int>(fit.at("false_terms").size());
  CHECK(false_terms >= 1);
  const auto strict = replicate(scratch, {.items = {"table-1"}, .folder = {}, .tau = 1e5});
  for (const auto& fit : strict.at("fits"))
    if (fit.at("method") == "fast_rvm" && fit.at("row") == "2") CHECK(fit.at("missing_terms").size() >= 2);
}

TEST_CASE("the two-state equivalent of Bouc-Wen diverges at 0.75 and says so", "[apps][replicate]") {
  const auto replication = apps::replicate_case(*apps::find_section4_case("bouc-wen-2"), {.first_seed = 80100});
  int diverged = 0;
  for (const auto& score : replication.document["one_step"]) {
    INFO(score.dump());
    if (score["signal"] == "a") CHECK(value(score, "nmse") <= 0.013);
  }
  for (const auto& score : replication.document["free_run"]) {
    INFO(score.dump());
    if (value(score, "ratio") == 0.75) {
      CHECK(score["nmse"].is_null());
      CHECK_THAT(text(score, "status"), Catch::Contains("diverged") && Catch::Contains("t = "));
      ++diverged;
    } else if (score["signal"] == "v") {
      CHECK(value(score, "nmse") <= 0.006);
    }
  }
  CHECK(diverged == 6);  // two signals, three methods
}

TEST_CASE("where a state was not measured the system itself is found from the others", "[apps][replicate]") {
  auto replication = apps::replicate_case(*apps::find_section4_case("bouc-wen-2"), {.first_seed = 80101});
  apps::replicate_inner_state(replication, {.first_seed = 80101});
  REQUIRE(replication.document.contains("inner_fit"));
  const auto& fit = replication.document["inner_fit"].front();
  INFO(fit.dump());
  CHECK(fit["support_exact"] == true);
  int covered = 0;
  const auto& terms = replication.document["inner_terms"];
  for (const auto& term : terms) {
    INFO(term.dump());
    const double error = std::abs(value(term, "mean") - value(term, "true"));
    covered += error < 1.96 * value(term, "std") ? 1 : 0;
    CHECK(error < 4.0 * value(term, "std"));
  }
  CHECK(covered >= static_cast<int>(terms.size()) - 1);
  REQUIRE(replication.document["inner_runs"].size() == 3);
  for (const auto& run : replication.document["inner_runs"]) {
    INFO(run.dump());
    CHECK(value(run, "nmse") < 1e-3);
  }
  auto measured = apps::replicate_case(*apps::find_section4_case("bouc-wen"), {.first_seed = 80101});
  apps::replicate_inner_state(measured, {.first_seed = 80101});
  CHECK_FALSE(measured.document.contains("inner_fit"));
}

TEST_CASE("free runs of exact equations stay close to the truth at ratios held out", "[apps][replicate]") {
  // What one draw in a thousand may reach: about three times the worst of twenty.
  const std::map<std::string, double> bars{
      {"bouc-wen", 1e-4}, {"valanis-3", 5e-5}, {"valanis-2", 8e-3}, {"valanis-1", 3e-2}, {"valanis-4", 3e-2}};
  for (const auto& [name, bar] : bars) {
    const auto replication = apps::replicate_case(*apps::find_section4_case(name), {.first_seed = 80200});
    for (const apps::Json* run :
         apps::matching(replication.document["free_run"], {{"signal", "x"}, {"method", "fast_rvm"}})) {
      INFO(name << " " << run->dump());
      CHECK(value(*run, "nmse") <= bar);
    }
  }
}

TEST_CASE("free runs over twenty seeds keep to the ambitious bars but for one in fifty", "[apps][replicate][slow]") {
  struct Bar {
    const char* name;
    double all, at_125;  // Duffing at 1.25 is sensitive to its initial state
  };
  int over = 0, runs = 0;
  for (const Bar bar : {Bar{"duffing", 3e-4, 3e-2},
                        {"coulomb", 7.5e-4, 0.0},
                        {"bouc-wen", 5e-5, 0.0},
                        {"valanis-1", 1.7e-2, 0.0},
                        {"valanis-2", 4e-3, 0.0},
                        {"valanis-3", 2e-5, 0.0},
                        {"valanis-4", 1.7e-2, 0.0}}) {
    double largest = 0.0;
    int above = 0, all = 0;
    const auto replication =
        apps::replicate_case(*apps::find_section4_case(bar.name), {.num_seeds = 20, .first_seed = 123450});
    for (const apps::Json* run :
         apps::matching(replication.document["free_run"], {{"signal", "x"}, {"method", "fast_rvm"}})) {
      const double limit = value(*run, "ratio") == 1.25 && bar.at_125 > 0.0 ? bar.at_125 : bar.all;
      largest = std::max(largest, value(*run, "nmse") / limit);
      above += !(value(*run, "nmse") <= limit);
      ++all;
    }
    std::printf("%-10s %2d of %2d free runs above the bar, the worst at %.2f of it\n", bar.name, above, all, largest);
    INFO(bar.name);
    CHECK(largest <= 2.0);
    over += above;
    runs += all;
  }
  CHECK(over <= runs / 50);
}

TEST_CASE("the printed equations run free beside ours, and a friction we lack is not within noise",
          "[apps][replicate][paper]") {
  const auto runs = [](const char* name, const apps::ReplicateOptions& options) {
    auto comparisons = apps::compare_with_paper(apps::replicate_case(*apps::find_section4_case(name), options));
    std::vector<apps::Json> of_runs(comparisons.begin(), comparisons.end());
    std::erase_if(of_runs, [](const apps::Json& c) { return c["quantity"] != "free_run"; });
    return of_runs;
  };
  // Displacement errors of the printed fast RVM found by another program (numpy, another integrator), to two digits.
  struct Known {
    const char* name;
    double least, most;
  };
  for (const Known known :
       {Known{"duffing", 2.1e-5, 2.9e-3}, {"coulomb", 1.3e-5, 3.1e-5}, {"bouc-wen", 3.3e-6, 7.9e-6}}) {
    double least = HUGE_VAL, most = 0.0;
    for (const auto& c : runs(known.name, {.first_seed = 80000, .noise = 0.01})) {
      INFO(known.name << " " << c.dump());
      if (c["method"] == "sindy") continue;  // its threshold leaves sgn(v) out at any noise
      CHECK(c["verdict"] == "within noise");
      CHECK(value(c, "ours") < value(c, "expected"));  // of ten times our noise
      if (c["method"] != "fast_rvm" || c["term"] != "x") continue;
      least = std::min(least, value(c, "paper"));
      most = std::max(most, value(c, "paper"));
    }
    CHECK(least == Approx(known.least).epsilon(0.05));
    CHECK(most == Approx(known.most).epsilon(0.05));
  }
  for (const auto& c : runs("coulomb", {.first_seed = 80000})) {
    CHECK(c["verdict"] == "not reproducible");
    CHECK_THAT(text(c, "reason"), Catch::Contains("keeps sgn(v)"));
  }
  for (const auto& c : runs("bouc-wen-2", {.first_seed = 80000})) {
    if (value(c, "ratio") != 0.75) continue;
    CHECK(c["verdict"] == "not reproducible");
    CHECK(c["paper"].is_null() == (c["method"] == "sindy"));
    if (c["method"] == "fast_rvm") CHECK(value(c, "paper") == Approx(c["term"] == "x" ? 0.85 : 0.0092).epsilon(0.02));
  }
}

TEST_CASE("the expected error of a free run is the mean over draws of the noise", "[apps][replicate][paper]") {
  constexpr int num_seeds = 60;
  const auto replication =
      apps::replicate_case(*apps::find_section4_case("bouc-wen"), {.num_seeds = num_seeds, .first_seed = 80300});
  for (const auto& c : apps::compare_with_paper(replication)) {
    if (c["quantity"] != "free_run" || c["method"] != "fast_rvm") continue;
    const auto same = apps::matching(replication.document["free_run"],
                                     {{"method", c["method"]}, {"ratio", c["ratio"]}, {"signal", c["term"]}});
    REQUIRE(same.size() == num_seeds);
    const double mean = apps::mean_of(same, "/nmse");
    INFO(c.dump());
    // The mean of the squares of one normal error has a standard deviation of sqrt(2 / 60) = 0.18; of several less.
    CHECK(std::abs(mean / value(c, "expected") - 1.0) <= 4.0 * 0.18);
  }
}

TEST_CASE("the verdicts on the paper's tables", "[apps][replicate][paper]") {
  const auto duffing = verdicts("duffing");
  CHECK(duffing.at("mean fast_rvm within noise") == 5);
  CHECK(duffing.at("mean sindy within noise") == 5);
  CHECK(duffing.at("cov slow_rvm within noise") == 5);
  CHECK(duffing.at("cov fast_rvm not reproducible") == 5);  // none of them is an uncertainty
  const auto coulomb = verdicts("coulomb");
  CHECK(coulomb.at("cov slow_rvm misprint") == 1);
  CHECK(coulomb.at("cov fast_rvm misprint") == 2);
  const auto bouc_wen = verdicts("bouc-wen");
  CHECK(bouc_wen.at("mean slow_rvm within noise") == 6);
  CHECK(bouc_wen.at("cov fast_rvm misprint") == 2);
  const auto valanis = verdicts("valanis-4");
  CHECK(valanis.at("mean fast_rvm not reproducible") == 1);  // 39.0006 v sin(x)
  CHECK(valanis.at("mean sindy not reproducible") == 3);     // x^2, x v and what it does to v sin(x)
  // The reasons are computed: without the record at resonance all that Table 8 prints would be within noise, and no
  // single alternative is named as one where it is not.
  for (const auto& [name, alternative] : {std::pair{"valanis-4", "without the record at ratio 1"},
                                          {"bouc-wen-2", "v^2 and |x| v beside the printed terms"}}) {
    const auto replication = apps::replicate_case(*apps::find_section4_case(name), {.first_seed = 80000});
    for (const auto& c : apps::compare_with_paper(replication)) {
      if (c["quantity"] != "mean" || c["verdict"] != "not reproducible") continue;
      INFO(name << " " << c.dump());
      CHECK_THAT(text(c, "reason"), Catch::Contains(alternative) && Catch::Contains("would explain the print"));
    }
  }
}
