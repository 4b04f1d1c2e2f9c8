#include "apps/paper/inner_state.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <utility>

#include "apps/paper/findings.hpp"
#include "apps/paper/tables.hpp"
#include "apps/text/json_number.hpp"
#include "apps/text/number_text.hpp"
#include "ident/bodies/bodies.hpp"
#include "ident/validate/metrics.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The states of one ratio as two sensors have them; f is exact.
ident::BodiesRecord noisy_record(const dsp::Motion& motion, const std::string& name, const ReplicateOptions& options,
                                 std::uint64_t sequence) {
  dsp::Recording recording{.name = name, .sample_rate_hz = motion.sample_rate_hz};
  recording.samples.resize(motion.num_samples(), 3);
  const std::vector<Index> all = samples_where("1", motion);
  for (const char* state : {"x", "v"}) {
    const Index column = *state == 'x' ? 0 : 1;
    const VectorXd& exact = motion.at(state);
    const double std = options.noise * std::sqrt((exact.array() - exact.mean()).square().mean());
    recording.samples.col(column) =
        noisy(exact, all, std, options.first_seed, sequence + static_cast<std::uint64_t>(column));
  }
  recording.samples.col(2) = motion.at("f");
  recording.channels = {{.name = "x", .role = dsp::Role::x, .unit = "m"},
                        {.name = "v", .role = dsp::Role::v, .unit = "m/s"},
                        {.name = "f", .role = dsp::Role::f, .unit = "N"}};
  return ident::bodies_record(recording, true);
}

/// True coefficients by equation of the acceleration (1) and of z (2), and term; that of z in the first is known.
std::map<std::pair<int, std::string>, double> true_coefficients(const Section4Case& definition) {
  std::map<std::pair<int, std::string>, double> truth;
  for (const sim::TrueTerm& term : sim::make_experiment(definition.system).truth)
    if (term.row > 1) truth[{term.row - 1, term.name}] = term.value;
  truth.erase({ident::inner_force().body, ident::inner_force().name});
  return truth;
}

}  // namespace

void replicate_inner_state(CaseReplication& replication, const ReplicateOptions& options) {
  const Section4Case& definition = *replication.study.definition;
  if (definition.inner != "hysteresis" || !(options.noise > 0.0)) return;
  constexpr std::uint64_t first_sequence = 7000;  // of noise, apart from that of targets
  std::vector<ident::BodiesRecord> records;
  for (const double ratio : definition.training_ratios)
    records.push_back(noisy_record(section4_record(definition, ratio).motion, fmt::format("ratio {}", ratio), options,
                                   first_sequence + 2 * records.size()));
  const ident::BodiesResult found =
      ident::identify_bodies(ident::joined(records), {.inner = ident::Inner::hysteresis, .train_fraction = 1.0});
  Json& document = replication.document;
  const Json head{{"case", definition.name}, {"seed", options.first_seed}, {"noise", options.noise}};
  const auto add = [&](const char* list, const Json& values) {
    document[list].push_back(head);
    document[list].back().update(values);
  };
  auto truth = true_coefficients(definition);
  bool is_exact = found.silent_because.empty();
  for (Index i = 0; i < found.model.mean.size(); ++i) {
    const ident::BodyTerm& term = found.model.terms[static_cast<std::size_t>(i)];
    if (term == ident::inner_force()) continue;
    const auto known = truth.find({term.body, term.name});
    is_exact = is_exact && known != truth.end();
    add("inner_terms", {{"row", term.body + 1},
                        {"term", term.name},
                        {"true", known == truth.end() ? Json() : Json(known->second)},
                        {"mean", found.model.mean(i)},
                        {"std", found.model.std(i)}});
    if (known != truth.end()) truth.erase(known);
  }
  add("inner_fit", {{"support_exact", is_exact && truth.empty()}, {"silent_because", found.silent_because}});
  if (!found.silent_because.empty()) return;
  const std::vector<double> rest(static_cast<std::size_t>(found.model.layout.num_states()), 0.0);
  for (const HeldOutRun& run : replication.runs) {
    const dsp::Motion& motion = run.record.motion;
    const VectorXd& x = motion.at("x");
    const MatrixXd states =
        ident::run_free(found.model, motion.at("f"), motion.sample_rate_hz, rest, x.cwiseAbs().maxCoeff());
    add("inner_runs",
        {{"ratio", run.record.ratio}, {"signal", "x"}, {"nmse", number_or_null(ident::nmse(states.col(0), x))}});
  }
}

std::string inner_state_text(const CaseReplication& replication) {
  const Json& document = replication.document;
  if (!document.contains("inner_fit")) return {};
  const Json& fit = document["inner_fit"].front();
  if (!fit["silent_because"].get<std::string>().empty())
    return fmt::format("The third state from two: {}\n", fit["silent_because"].get<std::string>());
  PaperTable terms{
      fmt::format("The system itself, its third state z found from x and v with noise of {:.0f} %: support {}",
                  100.0 * number_in(fit["noise"]), fit["support_exact"] == true ? "exact" : "not exact"),
      {"<row", "<term", ">true", ">found", ">standard deviation"},
      {}};
  for (const Json& term : document["inner_terms"])
    terms.rows.push_back(
        {fmt::format("{}", term["row"].get<int>()), term["term"], number_text(number_in(term["true"]), "{:.4g}", "-"),
         number_text(number_in(term["mean"]), "{:.5g}"), number_text(number_in(term["std"]), "{:.2g}")});
  PaperTable runs{"Its free run from rest at held-out ratios, NMSE", {">ratio", "<signal", ">nmse"}, {}};
  if (document.contains("inner_runs"))
    for (const Json& run : document["inner_runs"])
      runs.rows.push_back({number_text(number_in(run["ratio"]), "{:.2f}"), run["signal"],
                           number_text(number_in(run["nmse"]), "{:.2g}", "runs away")});
  return terms.text() + runs.text();
}

}  // namespace apps
