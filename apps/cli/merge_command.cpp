#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>
#include <utility>

#include "apps/cli/command.hpp"
#include "apps/cli/method_options.hpp"
#include "apps/output/bodies_file.hpp"
#include "apps/output/factors_file.hpp"
#include "apps/output/joint_report.hpp"
#include "apps/process/interrupt.hpp"

namespace apps {
namespace {

struct MergeArguments {
  std::vector<std::filesystem::path> files;
  std::string range;
  std::filesystem::path save;
  MethodArguments methods;
};

std::vector<ident::RecordFactors> read_all(const MergeArguments& arguments) {
  std::vector<std::vector<ident::RecordFactors>> of_files;
  for (const std::filesystem::path& file : arguments.files) {
    refuse_bodies_run(file, "merge");
    of_files.push_back(read_factors(file));
    check_interrupted();
  }
  std::vector<ident::RecordFactors> records = name_apart(std::move(of_files), arguments.files);
  std::set<std::string> known;
  for (const ident::RecordFactors& record : records) known.insert(record.range);
  if (!arguments.range.empty())
    std::erase_if(records, [&](const ident::RecordFactors& record) { return record.range != arguments.range; });
  if (records.empty())
    throw dsp::Fault(
        dsp::FaultKind::usage, "usage",
        fmt::format("--range: no file has a range '{}', want one of {}", arguments.range, fmt::join(known, ", ")));
  return records;
}

/// Joint fits of every range. 4 where no method found terms in one of them.
int merge(const MergeArguments& arguments, const GlobalOptions& global, Console& console) {
  const std::vector<ident::RecordFactors> records = read_all(arguments);
  for (const std::string& difference : differences(records)) console.warning("factors.differ", difference);
  const auto results = joint_fits(records, options_of(arguments.methods), check_interrupted);
  refuse_warnings(global.strict, console);
  save_factors(arguments.save, records, arguments.files, global.force);
  console.result(console.json() ? joint_json(results) : joint_text(results));
  int code = 0;
  for (const ident::JointResult& result : results)
    if (std::all_of(result.fits.begin(), result.fits.end(),
                    [](const ident::JointFit& fit) { return fit.model.terms.empty(); })) {
      console.error("fit.nothing_selected", fmt::format("range '{}': no method selected a term.", result.range));
      code = 4;
    }
  return code;
}

}  // namespace

Command merge_command() {
  const auto typed = std::make_shared<MergeArguments>();
  return {
      .name = "merge",
      .help = "Several records as one: fitted together, and without each",
      .group = use_group,
      .unused = {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}, {"--threads"}},
      .options = joined({{"FILES",
                          &typed->files,
                          "Run folders, or files that fit --save and merge --save wrote.",
                          {.required = true}},
                         {"--range", &typed->range, "This range only. Left out: each one.", {.name = "NAME"}},
                         {"--save", &typed->save, "Write all of them into one such file.", {.name = "FILE"}}},
                        method_options(typed->methods)),
      .run = [typed](const GlobalOptions& global, Console& console) { return merge(*typed, global, console); },
      .more = methods_help(),
      .examples = {"ardent merge monday-run tuesday-run wednesday-run",
                   "ardent merge fleet/runs/* --methods fast_rvm --json"},
      .details =
          "Recordings are not read again: R factors hold all that a fit needs of their training rows. Candidates that "
          "some record cannot tell apart are left out and named. Beside each standard deviation, which is that of one "
          "regression on all rows with every record's sensors on their own, stands the one over the records: how much "
          "the coefficient changes when one record after the other is left out. The second is the larger one where "
          "records differ by more than their noise."};
}

}  // namespace apps
