// What a run left, as compare, report and frc read it: manifest, equation and metrics, the table's header, the truth.
#include <array>

#include "apps/output/bodies_file.hpp"
#include "apps/output/equation_file.hpp"
#include "apps/output/steps_table.hpp"
#include "dsp/values/fault.hpp"
#include "fuzz/harness.hpp"
#include "fuzz/program.hpp"
#include "ident/bodies/driven_bodies.hpp"
#include "ident/equation/equation_oscillator.hpp"
#include "support/scratch.hpp"

namespace {

constexpr std::array names{"manifest.json", "equation.json", "metrics.json", "prepared.csv", "truth.json", "steps.csv"};

void read_bodies_response(const std::filesystem::path& run) {
  const ident::BodiesModel model = apps::read_bodies(run).model;
  if (model.layout.imposed) return;
  (void)ident::drawn_coefficients(model.mean, model.covariance, 1, 0);
  for (const std::string& drive : ident::drives_of(model.layout)) {
    const sim::DrivenSystem driven = driven_bodies(model, drive, 1);
    (void)driven.period(2.0, 0.01, 0.01 * driven.rest);
  }
}

void read_response(const std::filesystem::path& run) {
  if (apps::is_bodies_run(run)) return read_bodies_response(run);
  (void)apps::read_final_steps(run);
  const auto equation = apps::read_equation(run, "", "");
  (void)ident::drawn_coefficients(equation.mean, equation.covariance, 1, 0);
  const auto driven = ident::equation_oscillator(equation, equation.mean);
  (void)sim::run_period(driven.oscillator, 2.0, 0.01, {}, 64);
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  const support::Scratch scratch;
  const WorkingFolder here(scratch / "");
  const std::string truth = R"({"terms": [{"name": "x", "target": "a", "value": -355.3}]})";
  std::vector<std::string> all;
  for (const char* method : {"fast_rvm", "sindy"}) {
    scratch.file("a.csv", small_record());
    run_program({"run", "a.csv", "-q", "--force", "-o", "run", "--set", "library.order=1", "--set",
                 std::string("fit.methods=") + method});
    const auto of = [&](const char* name) { return support::bytes_of(scratch / "run" / name); };
    all.push_back(joined({of(names[0]), of(names[1]), of(names[2]), "t,x,v,a,f\n", truth}));
  }
  const std::string driven =
      R"json({"chosen": {"range": "mixed", "method": "fast_rvm"}, "ranges": [{"name": "mixed",
"verdict": "describes", "methods": [{"method": "fast_rvm", "target": "a", "text": "a = x",
"verdict": "describes", "terms": [{"name": "x", "mean": -300, "std": 1, "scale": 0.03},
{"name": "sgn(v)", "mean": -0.1, "std": 0.01, "scale": 1}, {"name": "ddr", "mean": -1, "std": 0, "scale": null}],
"covariance": [[1, 0, 0], [0, 1e-4, 0], [0, 0, 0]]}]}]})json";
  const std::string steps = apps::steps_csv({}) + "\"a\",0,9,1.5,0.001,0.002,0.003,10,up,slip,0.1,final\n";
  all.push_back(joined({"{}", driven, R"({"ranges":[]})", "t,x,ddr\n", truth, steps}));
  const std::string bodies =
      R"json({"frame": "ground", "length_unit": "m", "recording": "a.csv", "inputs": ["f"], "bodies": [
{"body": 1, "target": "a1", "zero": 0, "largest": 0.1, "terms": [{"name": "x1", "mean": -300, "std": 1},
{"name": "sgn(v1)", "mean": -0.1, "std": 0.01}, {"name": "f", "mean": 1, "std": 0.01}]},
{"body": 2, "target": "a2", "zero": 0, "terms": [{"name": "(x2 - x1)", "mean": -99, "std": 1}]}],
"covariance": [[1, 0, 0, 0], [0, 1e-4, 0, 0], [0, 0, 1e-4, 0], [0, 0, 0, 1]], "modes": [], "couplings": [],
"verdict": "describes", "free_runs": []})json";
  all.push_back(joined({"{}", bodies, R"({"ranges":[]})", "t,x1,x2,f\n", truth}));
  return all;
}

void fuzz::run(const std::string& input) {
  const support::Scratch scratch;
  const auto given = parts(input);
  for (std::size_t i = 0; i < std::min(given.size(), names.size()); ++i) scratch.file(names[i], given[i]);
  const std::string folder = scratch / "";
  run_program({"compare", folder, "--truth", scratch / "truth.json"});
  run_program({"compare", folder, folder, "--json"});
  run_program({"report", folder, "--json"});
  read_response(folder);
}
