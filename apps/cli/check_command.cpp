#include <fmt/format.h>

#include <memory>

#include "apps/cli/run_arguments.hpp"
#include "apps/config/identification.hpp"
#include "apps/output/results_json.hpp"
#include "apps/process/printable.hpp"
#include "ident/ranges.hpp"

namespace apps {
namespace {

int check(const RunArguments& arguments, Console& console) {
  const Work work = prepare_work(config_of(arguments), arguments, console);
  const std::vector<ident::Columns> columns =
      all_columns(work.config, work.inputs, compile_libraries(work.config, work.inputs), arguments.max_memory_bytes,
                  arguments.num_threads, console);
  std::string text;
  for (const Input& input : work.inputs)
    for (const dsp::Check& found : input.prepared.checks)
      text += fmt::format("{:<8} {}: {}: {}{}\n", to_string(found.status), input.prepared.name, found.name,
                          printable(channel_prefix(found)), printable(found.message));
  for (const ident::Range& range : work.config.ranges) {
    const ident::RangeRows rows = ident::range_rows(range, columns);
    text += fmt::format("{:<8} range {}: {} training rows, {} test rows\n", "ok", range.spec.name, rows.train.size(),
                        rows.test.size());
  }
  console.result(console.json() ? checks_json(work.inputs) : text);
  return 0;
}

}  // namespace

Command check_command() {
  const auto typed = std::make_shared<RunArguments>();
  return {.name = "check",
          .help = "Checks a recording or config as a run would; writes no files",
          .group = look_group,
          .unused = {{"--output"}, {"--seed"}, {"--dry-run"}, {"--force"}},
          .options = run_options(*typed),
          .run = [typed](const GlobalOptions& global,
                         Console& console) { return check(with_global(*typed, global), console); },
          .examples = {"ardent check drive.wav", "ardent check drive.toml --set prepare.cutoff_hz=10.24"}};
}

}  // namespace apps
