#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "apps/output/factors_file.hpp"
#include "support/fault.hpp"
#include "support/program.hpp"

namespace fs = std::filesystem;
using nlohmann::json;
using support::bytes_of;
using support::expect;
using support::Scratch;

namespace {

/// Two tables of one oscillator, and both of them as one.
void make_tables(const Scratch& folder) {
  for (const char* seed : {"1", "2"})
    REQUIRE(support::run(folder, "$ARDENT sim duffing --noise 0.02 --duration 10 --seed " + std::string(seed) +
                                     " -o s" + seed + " && cp s" + seed + "/response.csv t" + seed + ".csv")
                .code == 0);
  REQUIRE(support::run(folder, "(cat t1.csv; tail -n +2 t2.csv) > both.csv").code == 0);
}

constexpr const char* fit_options = " --target a --terms \"1,x,v,x^2,x^3,f\" ";

std::map<std::string, double> means_of(const json& terms, const char* key = "mean") {
  std::map<std::string, double> means;
  for (const json& term : terms) means[term["name"]] = term[key].get<double>();
  return means;
}

}  // namespace

TEST_CASE("tables merged from their R factors give the fit of all their rows", "[apps][merge]") {
  const Scratch folder;
  make_tables(folder);
  for (const char* table : {"t1", "t2"})
    expect(folder,
           "$ARDENT fit " + std::string(table) + ".csv" + fit_options + "--methods ols --save " + table + ".json", 0,
           {});
  const json together = json::parse(
      expect(folder, "$ARDENT merge t1.json t2.json --methods ols,fast_rvm --selection evidence-white --json", 0, {})
          .out);
  // The clock of the second table begins again: as one table it is rows, not time.
  const json whole = json::parse(expect(folder,
                                        std::string("cut -d, -f2- both.csv > rows.csv; $ARDENT fit rows.csv") +
                                            fit_options + "--methods ols,fast_rvm --selection evidence-white --json",
                                        0, {})
                                     .out);
  for (const std::size_t method : {0u, 1u}) {
    const json &joint = together["ranges"][0]["methods"][method], &one = whole["ranges"][0]["methods"][method];
    const auto mean = means_of(joint["terms"]), expected = means_of(one["terms"]);
    CHECK(mean.size() == expected.size());
    for (const auto& [name, value] : expected) CHECK(mean.at(name) == Approx(value).epsilon(1e-8));
  }
  const json& records = together["ranges"][0]["methods"][0]["records"];
  REQUIRE(records.size() == 2);
  CHECK(records[0]["record"] == "t1.csv");
  CHECK(records[0]["nmse_left_out"].get<double>() >= records[0]["nmse"].get<double>());

  // Saved together they are the same two, and one of them alone says that there is nothing to leave out.
  expect(folder, "$ARDENT merge t1.json t2.json --save both.json", 0, {"2 records together"});
  const json again = json::parse(
      expect(folder, "$ARDENT merge both.json --methods ols,fast_rvm --selection evidence-white --json", 0, {}).out);
  CHECK(again == together);
  expect(folder, "$ARDENT merge t1.json", 0, {"nothing to leave out"});
  expect(folder, "$ARDENT merge t1.json both.json", 3, {"[factors.twice]", "t1.csv"});
  expect(folder, "$ARDENT merge t1.json --save both.json", 5, {"[output.exists] both.json"});
  expect(folder, "$ARDENT merge t1.json --save both.json --force", 0, {});
  expect(folder, "$ARDENT merge t1.json --save t1.csv --force", 5, {"[output.foreign] t1.csv"});
  expect(folder, "$ARDENT merge t1.json --save t1.json --force", 2, {"[output.overlap]"});
  expect(folder, "$ARDENT merge t1.json --force", 2, {"--force has no effect without --save"});
  expect(folder, "$ARDENT merge t1.json --range low", 2, {"no file has a range 'low', want one of all"});
}

TEST_CASE("runs are merged from their folders, each record with its blocks of time", "[apps][merge]") {
  const Scratch folder;
  make_tables(folder);
  expect(folder, "$ARDENT run t1.csv -o r1 --set fit.stage=regression && $ARDENT run t2.csv -o r2", 0, {});
  const auto records = apps::read_factors(folder / "r1");
  REQUIRE(records.size() == 1);
  const ident::RecordFactors& record = records.front();
  CHECK(record.record == "t1.csv");
  CHECK(record.rate_hz > 0.0);
  CHECK(record.sources.front().sha256 == json::parse(bytes_of(folder / "r1/manifest.json"))["inputs"][0]["sha256"]);
  const json metrics = json::parse(bytes_of(folder / "r1/metrics.json"));
  CHECK(record.num_rows() == metrics["ranges"][0]["num_train"]);
  CHECK(record.evidence.num_samples <= std::lround(metrics["ranges"][0]["methods"][0]["num_effective"].get<double>()));
  // Of one record alone its own intervals: to 20 %, as the sensors stand at other values.
  const json alone = json::parse(expect(folder, "$ARDENT merge r1 --json", 0, {}).out);
  const json equation = json::parse(bytes_of(folder / "r1/equation.json"));
  const auto merged = means_of(alone["ranges"][0]["methods"][0]["terms"], "std"),
             own = means_of(equation["ranges"][0]["methods"][0]["terms"], "std");
  for (const auto& [name, deviation] : own) {
    CAPTURE(name, deviation, merged.at(name));
    CHECK(merged.at(name) == Approx(deviation).epsilon(0.2));
  }
  CHECK(record.blocks.size() > 8);
  for (std::size_t i = 1; i < record.blocks.size(); ++i) CHECK(record.blocks[i].from_s >= record.blocks[i - 1].to_s);
  expect(folder, "$ARDENT run t2.csv -o off --set prepare.zero=0.01 && $ARDENT merge r1 off", 0,
         {"warning", "the zero of x differs between records", "0.01 m (t2.csv)"});
  const json joint = json::parse(expect(folder, "$ARDENT merge r1 r2 --json", 0, {}).out);
  const json& terms = joint["ranges"][0]["methods"][0]["terms"];
  const auto mean = means_of(terms), deviation = means_of(terms, "std");
  for (const auto& [name, truth] :
       std::map<std::string, double>{{"x", -25.0}, {"v", -1.0}, {"x^3", -2500.0}, {"f", 100.0}}) {
    CAPTURE(name, mean.at(name), deviation.at(name));
    CHECK(std::abs(mean.at(name) - truth) < 4.0 * deviation.at(name));
  }
}

TEST_CASE("R factors are read back bit for bit", "[apps][factors]") {
  const Scratch folder;
  make_tables(folder);
  expect(folder, std::string("$ARDENT fit t1.csv") + fit_options + "--save t1.json", 0, {});
  const auto records = apps::read_factors(folder / "t1.json");
  CHECK(apps::factors_json(records) == bytes_of(folder / "t1.json"));
}

TEST_CASE("every field of a file of R factors is looked at", "[apps][factors]") {
  const Scratch folder;
  make_tables(folder);
  expect(folder, std::string("$ARDENT fit t1.csv") + fit_options + "--save t1.json", 0, {});
  const json good = json::parse(bytes_of(folder / "t1.json"));
  int count = 0;
  const auto refused = [&](const json& document, const std::string& name, const std::vector<std::string>& pieces) {
    support::check_fault([&] { (void)apps::read_factors(folder.file("bad.json", document.dump())); },
                         dsp::FaultKind::input, name, pieces);
    ++count;
  };
  const json::json_pointer record("/records/0");
  // Without any one member, and with one of another kind in its place.
  for (const std::string parent : {"", "/records/0", "/records/0/files/0", "/records/0/terms/1", "/records/0/white",
                                   "/records/0/evidence", "/records/0/blocks/2"}) {
    const json::json_pointer at(parent);
    const json members = good.at(at);
    for (const auto& [key, value] : members.items()) {
      if (key == "version") continue;
      json without = good, other = good;
      without.at(at).erase(key);
      other.at(at)[key] = value.is_object() ? json(1) : json::object();
      CAPTURE(parent, key);
      if (key != "evidence" && key != "coordinates")
        refused(without, key == "kind" ? "factors.file" : "factors.damaged",
                {key == "kind" ? "" : key + " is missing"});
      refused(other, "factors.damaged", {key});
    }
  }
  CHECK(count >= 59);
  const auto with = [&](const std::string& place, const json& value) {
    json document = good;
    document[json::json_pointer(place)] = value;
    return document;
  };
  refused(with("/schema", 2), "factors.schema", {"schema 2, want 1"});
  refused(with("/kind", "else"), "factors.file", {"holds no R factors"});
  refused(with("/records", json::array()), "factors.damaged", {"at least one record"});
  refused(with("/records/0/white/R/3", nullptr), "factors.damaged",
          {"records[0].white.R[3]", "got null, want a number"});
  refused(with("/records/0/white/R", json::array({1.0})), "factors.damaged", {"want a list of 28 numbers"});
  refused(with("/records/0/white/num_rows", 0), "factors.damaged", {"1 or more"});
  refused(with("/records/0/white/num_rows", 7), "factors.damaged", {"blocks of 7 rows"});
  refused(with("/records/0/terms/2/name", "x"), "factors.damaged", {"not there yet"});
  refused(with("/records/0/terms/2/name", "x^^2"), "factors.damaged", {"terms[2].name"});
  refused(with("/records/0/terms/2/scale", -1.0), "factors.damaged", {"0 or more"});
  refused(with("/records/0/files/0/sha256", "abc"), "factors.damaged", {"SHA-256"});
  refused(with("/records/0/blocks/1/to_s", 0.0), "factors.damaged", {"more than from_s"});
  expect(folder, "$ARDENT merge t1.csv", 3, {"[factors.file]", "t1.csv"});
  expect(folder, "$ARDENT merge gone.json", 3, {"[factors.file]", "gone.json"});
  expect(folder, "head -c 500 t1.json > cut.json; $ARDENT merge cut.json", 3, {"[factors.file]", "cut.json"});
}
