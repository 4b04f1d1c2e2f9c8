#include "ident/study.hpp"

#include <catch2/catch.hpp>

#include "dsp/prepare.hpp"
#include "support/fault.hpp"
#include "support/oscillator.hpp"

namespace {

/// A Duffing oscillator's exact x, v, a and f as a prepared recording.
ident::Record duffing_record() {
  const dsp::Motion motion = support::motion_of(sim::make_experiment(sim::Duffing{}), 40.0, 50.0);
  dsp::Recording recording{.name = "duffing", .sample_rate_hz = 50.0};
  recording.samples.resize(motion.num_samples(), 4);
  for (const dsp::Role role : {dsp::Role::x, dsp::Role::v, dsp::Role::a, dsp::Role::f}) {
    const std::string name(dsp::to_string(role));
    recording.samples.col(static_cast<Eigen::Index>(recording.channels.size())) = motion.at(name);
    recording.channels.push_back({.name = name, .role = role, .unit = motion.find(name)->unit});
  }
  return {.prepared = dsp::prepare(recording, {.cutoff_hz = 20.0, .rolloff_hz = 16.0})};
}

std::vector<std::string> names_of(const ident::JudgedFit& fit) {
  std::vector<std::string> names;
  for (const ident::ModelTerm& term : fit.model.terms) names.push_back(term.name);
  return names;
}

}  // namespace

TEST_CASE("every case of a study is an identification with its options", "[ident][study_runs]") {
  const ident::Record record = duffing_record();
  std::vector<ident::StudyCase> cases;
  for (const int order : {1, 3, 3, 3})
    cases.push_back({{.order = order, .terms = {"f"}},
                     ident::default_ranges({&record}),
                     {.target = "a", .methods = {ident::FastRvmOptions{}}}});
  cases[2].options.methods = {ident::StlsqOptions{}};
  cases[3].library.variables = {"v", "x"};
  std::size_t num_asked = 0;
  const auto outcomes = ident::study({&record}, cases.size(), [&](std::size_t k) {
    CHECK(k == num_asked++);
    return cases[k];
  });
  REQUIRE(outcomes.size() == cases.size());
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const auto library = ident::record_library(cases[k].library, "a", record.prepared);
    std::vector<ident::Columns> columns{ident::record_columns(library, "a", record)};
    const auto alone = ident::identify(cases[k].ranges, columns, library, cases[k].options);
    REQUIRE(outcomes[k].ranges.size() == alone.size());
    CHECK(outcomes[k].trouble.empty());
    const ident::JudgedFit &fit = outcomes[k].ranges[0].fits[0], &same = alone[0].fits[0];
    CHECK(names_of(fit) == names_of(same));
    CHECK(fit.fit.mean == same.fit.mean);
    CHECK(fit.free_run.nmse == same.free_run.nmse);
    CHECK(fit.judgement.verdict == same.judgement.verdict);
  }
  CHECK(names_of(outcomes[1].ranges[0].fits[0]) == std::vector<std::string>{"x", "v", "x^3", "f"});
}

TEST_CASE("what numerics end is one case's trouble, what is wrong with a case ends the study", "[ident][study_runs]") {
  const ident::Record record = duffing_record();
  ident::StudyCase one{{.order = 3, .terms = {"f"}}, ident::default_ranges({&record}), {.target = "a"}};
  const auto outcomes = ident::study(
      {&record}, 2, [&](std::size_t) { return one; }, 1000);  // bytes
  REQUIRE(outcomes.size() == 2);
  CHECK_THAT(outcomes[0].trouble, Catch::Contains("duffing: needs"));
  CHECK(outcomes[1].trouble == outcomes[0].trouble);
  one.library.terms = {"z"};
  support::check_fault([&] { (void)ident::study({&record}, 1, [&](std::size_t) { return one; }); },
                       dsp::FaultKind::usage, "term.unknown_name", {"z"});
  one.library.terms = {"a"};
  one.options.target = "ddy";
  support::check_fault([&] { (void)ident::study({&record}, 1, [&](std::size_t) { return one; }); },
                       dsp::FaultKind::usage, "library.target", {});
}
