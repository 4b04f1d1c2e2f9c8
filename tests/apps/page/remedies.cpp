#include "apps/page/remedies.hpp"

#include <catch2/catch.hpp>

namespace {

/// What is proposed where this is the only equation.
std::string proposed(const ident::JudgedFit& fit) {
  const apps::Config config;
  const std::vector<apps::Input> inputs(1);
  const std::vector<ident::Columns> columns;
  std::vector<ident::RangeResult> ranges(1);
  ranges.front().fits.push_back(fit);
  std::string text;
  for (const apps::Remedy& remedy : apps::remedies({config, inputs, columns, ranges})) text += remedy.why + "\n";
  return text;
}

}  // namespace

TEST_CASE("where only doubt speaks against an equation, more data are proposed", "[apps][page]") {
  ident::JudgedFit fit;
  fit.model.target = "a";
  fit.model.terms = {{.name = "x", .mean = -50.0, .std_noise = 0.1}, {.name = "v", .mean = -0.8, .std_noise = 1.0}};
  fit.judgement.verdict = ident::Verdict::in_part;
  CHECK(proposed(fit) ==
        "Whether the equation needs v: a record with other amplitudes, a longer one, or one with less noise, would "
        "tell.\n");
  fit.judgement.cause = ident::Cause::not_found;
  CHECK(proposed(fit).empty());
  fit.explanations.may_lack_at_motion = true;
  fit.free_run.nmse_centred = 1e-4;
  CHECK(proposed(fit) == "Whether a term is missing: a longer record, or one with less noise, would tell.\n");
  fit.noise.residual_power = 1.0, fit.noise.residual_std = 0.1;  // more is left over than noise, and than matters
  fit.train_centred.value = 0.01;
  CHECK(proposed(fit).empty());
  fit.noise = {};
  fit.judgement.cause = ident::Cause::noise;
  CHECK(proposed(fit).empty());
  fit.judgement = {.verdict = ident::Verdict::describes};
  CHECK(proposed(fit).empty());
}
