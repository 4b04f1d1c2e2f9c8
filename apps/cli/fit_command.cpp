#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "apps/cli/command.hpp"
#include "apps/cli/method_options.hpp"
#include "apps/config/term_list.hpp"
#include "apps/output/factors_file.hpp"
#include "apps/output/fit_outcome.hpp"
#include "apps/output/metrics_file.hpp"
#include "apps/output/report_text.hpp"
#include "apps/process/sha256.hpp"
#include "dsp/signal_table.hpp"
#include "ident/columns/columns.hpp"
#include "ident/identify.hpp"
#include "ident/judgement/judge.hpp"

namespace apps {
namespace {

struct FitArguments {
  std::filesystem::path table, save;
  std::string target, terms, where;
  MethodArguments methods;
};

/// Regression of one column of a table on expressions of the others, all rows at once, printed. 4 if no method selected
/// anything, or the rows determine none of the fits.
int fit(const FitArguments& arguments, const GlobalOptions& global, Console& console) {
  const dsp::SignalTable read = dsp::read_signal_table(arguments.table);
  for (const auto& [column, name] : read.renamed)
    console.note(fmt::format("column '{}' is called {} here", column, name));
  const dsp::Motion& table = read.signals;
  const dsp::Signal* target = table.find(arguments.target);
  if (target == nullptr) {
    std::string known;
    for (const dsp::Signal& signal : table.signals) known += (known.empty() ? "" : ", ") + signal.name;
    throw dsp::Fault(dsp::FaultKind::usage, "target.unknown",
                     fmt::format("--target: {} has no column '{}', want one of {}.", arguments.table.string(),
                                 arguments.target, known));
  }
  const ident::CandidateLibrary library =
      ident::make_library({.order = 0, .variables = {}, .terms = read_terms(arguments.terms)}, arguments.target, table);
  std::vector<ident::Columns> columns;
  columns.push_back(ident::form_columns(library, arguments.target, table, arguments.table.filename().string(),
                                        shown_poll(console, "forming columns")));
  dsp::RangeSpec all;
  all.name = "all";
  all.to_s = all.train_to_s.emplace(static_cast<double>(table.num_samples()));
  all.where = arguments.where;
  all.place = "--where";
  const ident::IdentifyOptions options{.target = arguments.target,
                                       .target_unit = target->unit,
                                       .methods = options_of(arguments.methods),
                                       .num_threads = thread_count(global),
                                       .most_blocks = arguments.save.empty() ? 0 : most_factor_blocks,
                                       .free_run = false,
                                       .poll = shown_poll(console, "fitting")};
  std::vector<ident::RangeResult> ranges{ident::identify({all, 1, {}}, columns, library, options)};
  ident::judge(ranges);
  for (const ident::DroppedTerm& term : ranges.front().dropped)
    console.warning("term.left_out", fmt::format("{} is left out: {}", term.name, term.reason));
  refuse_warnings(global.strict, console);
  std::vector<ident::RecordFactors> saved;
  if (!arguments.save.empty())
    saved = record_factors(ranges, columns, {{{arguments.table.filename().string(), sha256_file(arguments.table)}}},
                           library, options);
  save_factors(arguments.save, saved, {arguments.table}, global.force);
  console.result(console.json() ? metrics_json(ranges, options) : report_text(ranges));
  return outcome_of(ranges.front().fits, arguments.table.string(), console);
}

}  // namespace

Command fit_command() {
  const auto typed = std::make_shared<FitArguments>();
  const std::vector<Option> first{
      {"TABLE", &typed->table, "CSV or another table that `run` reads.", {.required = true, .is_recording = true}},
      {"--target", &typed->target, "Column to explain.", {.required = true}},
      {"--terms", &typed->terms, "Candidate terms: \"1,x,x^2\", or a file with one term a line.", {.required = true}}};
  const std::vector<Option> last{
      {"--where", &typed->where, "Condition on the rows: \"v >= 0\"."},
      {"--save",
       &typed->save,
       "Write R factors of the rows into this file: `ardent merge` fits several tables together.",
       {.name = "FILE"}}};
  return {.name = "fit",
          .help = "Regression on a table: one column from expressions of the others",
          .group = made_group,
          .unused = {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}},
          .options = joined(joined(first, method_options(typed->methods)), last),
          .run = [typed](const GlobalOptions& global, Console& console) { return fit(*typed, global, console); },
          .more = methods_help(),
          .examples = {"ardent fit table.csv --target a --terms \"1,x,v,x^3\"",
                       "ardent fit table.csv --target dz --terms terms.txt --where \"v >= 0\" --methods fast_rvm,ols",
                       "ardent fit monday.csv --target a --terms terms.txt --save monday.json"}};
}

}  // namespace apps
