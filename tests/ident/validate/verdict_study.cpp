#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>

#include "dsp/values/fault.hpp"
#include "ident/columns/columns.hpp"
#include "ident/identify.hpp"
#include "ident/judgement/judge.hpp"
#include "ident/regression/collinearity.hpp"
#include "ident/regression/methods.hpp"
#include "support/evidence_of_truth.hpp"
#include "support/labelled_record.hpp"

using ident::Cause;
using ident::JudgedFit;
using ident::Verdict;

namespace {

/// One case: what it was, what was found, and what the judgement made of it.
struct Outcome {
  std::uint32_t seed = 0;
  support::LabelledRecord record;
  bool right = false;
  std::string verdict = "none", cause, named, why_wrong, sentence, range;
  std::set<Cause> accepted;  ///< causes that are true of a wrong equation
  std::optional<JudgedFit> fit;
  std::optional<support::EvidenceOfTruth> evidence;  ///< against terms that are not the true ones
  double equation_error = std::nan("");  ///< rms of equation less acceleration over that of the latter, on exact data
  [[nodiscard]] bool names_a_cause() const { return !cause.empty() && cause != to_string(Cause::not_found); }
  [[nodiscard]] bool cause_is_true() const {
    return std::any_of(accepted.begin(), accepted.end(), [&](Cause one) { return cause == to_string(one); });
  }
  /// By the flaw alone where there is one, however noisy the record.
  [[nodiscard]] bool cause_is_flaw() const { return record.flaw ? cause == to_string(*record.flaw) : cause_is_true(); }
};

std::optional<double> coefficient_of(const std::vector<std::pair<std::string, double>>& truth,
                                     const std::string& name) {
  for (const auto& [term, value] : truth)
    if (term == name) return value;
  return std::nullopt;
}

bool has(const ident::Model& model, const std::string& name) {
  return std::any_of(model.terms.begin(), model.terms.end(), [&](const auto& term) { return term.name == name; });
}

/// How the found support differs from the true one; the constant, which is a zero of a sensor, aside.
struct Difference {
  std::vector<std::string> extra, lacking;
};
Difference difference(const ident::Model& model, const support::LabelledRecord& record) {
  Difference result;
  for (const auto& term : model.terms)
    if (term.name != "1" && !coefficient_of(record.truth, term.name)) result.extra.push_back(term.name);
  for (const auto& [name, value] : record.truth)
    if (!has(model, name)) result.lacking.push_back(name);
  return result;
}

/// Of terms that are not the true ones: there are more of them than the truth has, so that one is false, or odds of 150
/// or more speak against these coefficients on this record, or would against these terms with any coefficients.
bool is_told_apart(const Outcome& outcome) {
  if (!outcome.evidence) return false;
  const Difference found = difference(outcome.fit->model, outcome.record);
  return found.extra.size() > found.lacking.size() ||
         !(std::max(outcome.evidence->least, outcome.evidence->of_this) < ident::undecided_evidence);
}

/// Empty where the equation is right: the true support or one that the record does not tell from it, with right
/// coefficients.
std::string why_wrong(const Outcome& outcome) {
  std::string why;
  const support::LabelledRecord& record = outcome.record;
  const auto& terms = outcome.fit->model.terms;
  if (is_told_apart(outcome)) {
    if (record.flaw) why = fmt::format("by design: {}; ", to_string(*record.flaw));
    const Difference found = difference(outcome.fit->model, record);
    why += fmt::format("extra [{}] lacking [{}]; ", fmt::join(found.extra, " "), fmt::join(found.lacking, " "));
  }
  for (const auto& term : terms) {
    const auto truth = coefficient_of(record.truth, term.name);
    if (!truth) continue;
    const double error = std::abs(term.mean - *truth);
    if (!(error <= 3.0 * term.std || error <= 0.02 * std::abs(*truth)))
      why += fmt::format("{} off by {:.1f} std = {:.1f} %; ", term.name, error / term.std,
                         100.0 * error / std::abs(*truth));
  }
  return why;
}

/// What is true of a wrong equation: its flaw; noise, where without the flaw the equation would be as wrong
/// (`wrong_without_flaw`); what it lacks of the truth.
std::set<Cause> true_causes(const Outcome& outcome, bool wrong_without_flaw) {
  const support::LabelledRecord& record = outcome.record;
  std::set<Cause> causes;
  if (record.flaw) causes.insert(*record.flaw);
  if (record.noise > 0.0 && (!record.flaw || wrong_without_flaw)) {
    causes.insert(Cause::noise);
    if (record.wide_band) causes.insert(Cause::wide_band);
  }
  if (!outcome.fit) return causes;
  std::vector<std::string> terms, inputs;
  for (const std::string& name : difference(outcome.fit->model, record).lacking)
    (name == "f" || name == "ddr" ? inputs : terms).push_back(name);
  // What is named is an input or a term that the truth has and the equation lacks. Where none is named, the record
  // knows that one is lacking; of friction against another motion that may be said to be a term. Without noise what is
  // left over is a function of the state alone, whose name matters less.
  const auto is_in = [&](const std::vector<std::string>& lacking) {
    return std::find(lacking.begin(), lacking.end(), outcome.named) != lacking.end();
  };
  const bool unnamed_and_known =
      outcome.named.empty() && outcome.evidence && !(outcome.evidence->least < ident::undecided_evidence);
  const bool only_the_state = record.noise == 0.0 && !record.flaw && !terms.empty();
  if (is_in(inputs) || (unnamed_and_known && !inputs.empty())) causes.insert(Cause::missing_input);
  if (record.flaw == Cause::missing_input) return causes;
  if (is_in(terms) || (unnamed_and_known && !terms.empty()) || only_the_state) causes.insert(Cause::missing_term);
  return causes;
}

/// At rest, where friction is whatever it takes, nothing is compared.
double equation_error(const ident::Model& model, const dsp::Motion& exact) {
  if (model.terms.empty()) return 1.0;
  ident::LibraryOptions options{.order = 0};
  for (const auto& term : model.terms) options.terms.push_back(term.name);
  const auto library = ident::make_library(options, "a", exact);
  const ident::Columns columns = ident::form_columns(library, "a", exact, "exact");
  Eigen::VectorXd error = -columns.target;
  for (std::size_t j = 0; j < model.terms.size(); ++j)
    error += model.terms[j].mean * columns.phi.col(static_cast<Eigen::Index>(j));
  const Eigen::ArrayXd moves = (exact.at(exact.find("dy") != nullptr ? "dy" : "v").array() != 0.0).cast<double>();
  return (moves * error.array()).matrix().norm() / columns.target.norm();
}

support::WrittenEquation written(const ident::Model& model) {
  support::WrittenEquation equation;
  for (const auto& term : model.terms) equation.emplace_back(term.name, term.mean);
  return equation;
}

void identify_as_the_product_does(Outcome& outcome) {
  const support::LabelledRecord& record = outcome.record;
  auto ranges = ident::identify(ident::find_regimes(dsp::prepare(record.recording, record.prepare)), record.library,
                                {.methods = ident::MethodSettings().options_of(ident::default_methods())});
  const auto chosen = ident::chosen_fit(ranges);
  if (!chosen) return;
  outcome.range = ranges[chosen->range].spec.name;
  outcome.fit = std::move(ranges[chosen->range].fits[chosen->method]);
  const ident::Judgement& judgement = outcome.fit->judgement;
  outcome.verdict = to_string(judgement.verdict);
  if (judgement.cause) outcome.cause = to_string(*judgement.cause);
  if (judgement.named) outcome.named = judgement.named->what;
  outcome.sentence = judgement.sentence;
  if (const Difference found = difference(outcome.fit->model, record); !found.extra.empty() || !found.lacking.empty())
    outcome.evidence = evidence_of_truth(record, ranges[chosen->range].rows.train, written(outcome.fit->model));
  outcome.why_wrong = why_wrong(outcome);
  outcome.right = outcome.why_wrong.empty();
  outcome.equation_error = equation_error(outcome.fit->model, record.exact);
}

Outcome judged(std::uint32_t seed, bool mended, std::optional<double> cutoff_hz = {}) {
  Outcome outcome{.seed = seed, .record = support::labelled_record(seed, mended)};
  if (cutoff_hz) outcome.record.prepare.cutoff_hz = *cutoff_hz;
  try {
    identify_as_the_product_does(outcome);
  } catch (const dsp::Fault& fault) {
    outcome.sentence = fault.what();
    outcome.why_wrong = "refused: " + fault.name();
  }
  return outcome;
}

Outcome run_case(std::uint32_t seed) {
  Outcome outcome = judged(seed, false);
  if (!outcome.right) {
    const bool noisy = outcome.record.flaw && outcome.record.noise > 0.0;
    outcome.accepted = true_causes(outcome, noisy && !judged(seed, true).right);
    // A band that was not drawn wide is too wide where in the one that is advised all true terms are found.
    if (!outcome.record.flaw && outcome.cause == to_string(Cause::wide_band) && !outcome.cause_is_true()) {
      const Outcome advised = judged(seed, false, outcome.fit->noise.needed_hz);
      if (advised.right && !advised.evidence) outcome.accepted.insert(Cause::wide_band);
    }
  }
  outcome.record.recording.samples.resize(0, 0);
  outcome.record.exact = {};
  return outcome;
}

std::string quoted(std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  std::replace(text.begin(), text.end(), '\n', ' ');
  return '"' + text + '"';
}

std::string truth_text(const support::LabelledRecord& record) {
  std::string text = "a =";
  for (const auto& [name, value] : record.truth) text += fmt::format(" {:+.6g} {}", value, name);
  return text;
}

/// Largest bias by noise of regressors, in standard deviations and as a fraction of its coefficient.
std::pair<double, double> worst_bias(const JudgedFit& fit) {
  std::pair<double, double> worst{0.0, 0.0};
  for (std::size_t i = 0; i < fit.model.terms.size() && fit.noise.bias.size() > 0; ++i) {
    const double bias = std::abs(fit.noise.bias(static_cast<Eigen::Index>(i)));
    worst.first = std::max(worst.first, bias / fit.model.terms[i].std);
    worst.second = std::max(worst.second, bias / std::abs(fit.model.terms[i].mean));
  }
  return worst;
}

double weakest(const JudgedFit& fit) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& term : fit.model.terms)
    least = std::min(least, std::pow(term.mean / term.std_noise, 2) / fit.size.num_effective());
  return least;
}

constexpr const char* csv_head =
    "seed,scenario,noise,wide_band,cutoff_hz,periods,label,verdict,cause,accepted,range,equation,deviations,truth,why_"
    "wrong,"
    "equation_error,free_run_nmse,free_run_reason,train_nmse_centred,test_nmse_centred,n_eff,structural_fraction,"
    "whiteness_p,status,ties,explanation,explained,bias_in_std,bias,noise_share,needed_hz,weakest,fr_centred,fr_floor,"
    "better,named,"
    "revisits,inputs,least_evidence,evidence,"
    "drawn,sentence\n";

std::string csv_line(const Outcome& o) {
  std::vector<std::string_view> accepted;
  for (const Cause cause : o.accepted) accepted.push_back(to_string(cause));
  const JudgedFit none;
  const JudgedFit& fit = o.fit ? *o.fit : none;
  const auto figure = [](const ident::Figure& f) { return f.reason.empty() ? f.value : std::nan(""); };
  std::string deviations, ties;
  for (const auto& term : fit.model.terms) deviations += fmt::format("{:.3g} ", term.std);
  for (const auto& [kept, other] : fit.ties) ties += kept + "~" + other + " ";
  const std::array<std::string, 42> cells{
      std::to_string(o.seed),
      quoted(o.record.scenario),
      fmt::format("{}", o.record.noise),
      o.record.wide_band ? "1" : "0",
      fmt::format("{:.4g}", o.record.prepare.cutoff_hz),
      fmt::format("{:.1f}", o.record.periods),
      o.right ? "right" : "wrong",
      o.verdict,
      o.cause,
      fmt::format("{}", fmt::join(accepted, " ")),
      o.range,
      quoted(o.fit ? to_text(fit.model) : ""),
      quoted(deviations),
      quoted(truth_text(o.record)),
      quoted(o.why_wrong),
      fmt::format("{:.3g}", o.equation_error),
      fmt::format("{:.3g}", fit.free_run.reason.empty() ? fit.free_run.nmse : std::nan("")),
      quoted(fit.free_run.reason),
      fmt::format("{:.3g}", figure(fit.train_centred)),
      fmt::format("{:.3g}", figure(fit.test_centred)),
      fmt::format("{:.4g}", fit.size.num_effective()),
      fmt::format("{:.3g}", fit.size.structural_fraction),
      fmt::format("{:.3g}", fit.whiteness.p_value),
      quoted(std::string(to_string(fit.fit.status))),
      quoted(ties),
      quoted(fit.explanations.recorded ? fit.explanations.recorded->what : ""),
      fmt::format("{:.3g}", fit.explanations.recorded ? fit.explanations.recorded->fraction : 0.0),
      fmt::format("{:.3g}", worst_bias(fit).first),
      fmt::format("{:.3g}", worst_bias(fit).second),
      fmt::format("{:.3g}", std::pow(fit.noise.residual_std, 2) / fit.noise.residual_power),
      fmt::format("{:.3g}", fit.noise.needed_hz),
      fmt::format("{:.3g}", weakest(fit)),
      fmt::format("{:.3g}", fit.free_run.nmse_centred),
      fmt::format("{:.3g}", fit.noise.x_std * fit.noise.x_std / fit.free_run.mean_square),
      quoted(fit.explanations.better ? fmt::format("{}<{}", fit.explanations.better->what,
                                                   fmt::join(fit.explanations.better->instead_of, " "))
                                     : ""),
      quoted(o.named),
      fmt::format("{:.3g}", fit.size.state_dependent_fraction),
      has(fit.model, "f") || has(fit.model, "ddr") ? "1" : "0",
      o.evidence ? fmt::format("{:.3g}", o.evidence->least) : "",
      o.evidence ? fmt::format("{:.3g}", o.evidence->of_this) : "",
      quoted(o.record.drawn),
      quoted(o.sentence)};
  return fmt::format("{}\n", fmt::join(cells, ","));
}

constexpr std::array verdicts{"describes", "in_part", "does_not", "undecided", "none"};

std::string table(const std::vector<Outcome>& outcomes) {
  std::string text = fmt::format("{:<34} {:<6} {:>5}", "scenario", "label", "all");
  for (const char* verdict : verdicts) text += fmt::format(" {:>9}", verdict);
  text += fmt::format(" {:>6} {:>5}\n", "named", "true");
  for (const std::string& scenario : support::scenario_names())
    for (const bool right : {true, false}) {
      std::map<std::string, int> counts;
      int all = 0, named = 0, named_true = 0;
      for (const Outcome& o : outcomes) {
        if (o.record.scenario != scenario || o.right != right) continue;
        ++all, ++counts[o.verdict], named += o.names_a_cause(), named_true += o.names_a_cause() && o.cause_is_true();
      }
      if (all == 0) continue;
      text += fmt::format("{:<34} {:<6} {:>5}", scenario, right ? "right" : "wrong", all);
      for (const char* verdict : verdicts) text += fmt::format(" {:>9}", counts[verdict]);
      text += fmt::format(" {:>6} {:>5}\n", named, named_true);
    }
  return text;
}

/// Fractions of the right and of the wrong ones.
struct Rates {
  int num_right = 0, num_wrong = 0, num_named = 0;
  double right_describes = 0.0, right_does_not = 0.0, wrong_describes = 0.0, wrong_does_not = 0.0, named = 0.0,
         named_true = 0.0, named_flaw = 0.0;
};

Rates rates_of(const std::vector<Outcome>& outcomes) {
  Rates r;
  std::map<std::pair<bool, std::string>, int> counts;
  int named_true = 0, named_flaw = 0;
  for (const Outcome& o : outcomes) {
    ++(o.right ? r.num_right : r.num_wrong);
    ++counts[{o.right, o.verdict}];
    if (!o.right && o.names_a_cause()) ++r.num_named, named_true += o.cause_is_true(), named_flaw += o.cause_is_flaw();
  }
  const auto fraction = [](int part, int all) { return all == 0 ? 0.0 : static_cast<double>(part) / all; };
  r.right_describes = fraction(counts[{true, "describes"}], r.num_right);
  r.right_does_not = fraction(counts[{true, "does_not"}], r.num_right);
  r.wrong_describes = fraction(counts[{false, "describes"}], r.num_wrong);
  r.wrong_does_not = fraction(counts[{false, "does_not"}], r.num_wrong);
  r.named = fraction(r.num_named, r.num_wrong);
  r.named_true = fraction(named_true, r.num_named);
  r.named_flaw = fraction(named_flaw, r.num_named);
  return r;
}

std::uint32_t from_environment(const char* name, std::uint32_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : static_cast<std::uint32_t>(std::stoul(text));
}

}  // namespace

TEST_CASE("a drawn body that friction would hold at every scale of its drive moves all the same", "[ident][verdicts]") {
  const auto record = support::labelled_record(9117);
  const auto& x = record.exact.at("x");
  CHECK(x.allFinite());
  CHECK(x.cwiseAbs().maxCoeff() > 0.0);
}

// What a judgement is worth: equations whose right answer is known, identified and judged as a stranger's records are.
// The labels come from what was simulated; whether noise is a cause beside a flaw, from the same record without the
// flaw; whether a band is too wide that was not drawn so, from the same record in the band that the product advises. A
// right equation has the true terms, or as many that the record does not tell from them by the noise that was simulated
// (evidence_of_truth), with coefficients within three total standard deviations or 2 %.
// ARDENT_STUDY_CASES (300) and ARDENT_STUDY_SEED (1) give the number of cases and the first seed; ARDENT_STUDY_OUT
// names a file that gets a line of CSV a case.
TEST_CASE("a verdict is right of equations whose truth is known, and its cause is one", "[.][study][verdicts]") {
  const std::uint32_t num_cases = from_environment("ARDENT_STUDY_CASES", 300),
                      first_seed = from_environment("ARDENT_STUDY_SEED", 1);
  std::ofstream csv;
  if (const char* file = std::getenv("ARDENT_STUDY_OUT")) csv.open(file);
  csv << csv_head;
  std::vector<Outcome> outcomes;
  for (std::uint32_t i = 0; i < num_cases; ++i) {
    outcomes.push_back(run_case(first_seed + i));
    csv << csv_line(outcomes.back()) << std::flush;
  }
  const Rates r = rates_of(outcomes);
  fmt::print(
      "{}\n{} cases from seed {}: {} right, of which {:.1f} % describes, {:.1f} % does_not; {} wrong, of which "
      "{:.1f} % describes, {:.1f} % does_not; a cause named for {:.1f} % of the wrong, true for {:.1f} % of "
      "these {} ({:.1f} % where of a flawed record its flaw alone is true)\n",
      table(outcomes), num_cases, first_seed, r.num_right, 100 * r.right_describes, 100 * r.right_does_not, r.num_wrong,
      100 * r.wrong_describes, 100 * r.wrong_does_not, 100 * r.named, 100 * r.named_true, r.num_named,
      100 * r.named_flaw);
  // What is asked, and what must not be lost of what is reached.
  CHECK_NOFAIL(r.right_describes >= 0.80);
  CHECK_NOFAIL(r.right_does_not <= 0.03);
  CHECK_NOFAIL(r.wrong_describes <= 0.02);
  CHECK_NOFAIL(r.wrong_does_not >= 0.80);
  CHECK_NOFAIL(r.named >= 0.60);
  CHECK_NOFAIL(r.named_true >= 0.90);
  CHECK(r.right_describes >= 0.70);
  CHECK(r.wrong_describes <= 0.10);
  CHECK(r.wrong_does_not >= 0.70);
  CHECK(r.named >= 0.60);
  CHECK(r.named_true >= 0.80);
  CHECK(r.named_flaw >= 0.60);
}
