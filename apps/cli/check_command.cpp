#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "apps/cli/run_arguments.hpp"
#include "apps/cli/run_bodies.hpp"
#include "apps/config/identification.hpp"
#include "apps/output/results_json.hpp"
#include "apps/process/printable.hpp"
#include "ident/ranges/ranges.hpp"

namespace apps {
namespace {

/// Of a band B in Hz, T seconds hold 2 B T values, however many rows there are.
double independent_values(const std::vector<ident::Row>& rows, const std::vector<ident::Columns>& columns) {
  double values = 0.0;
  for (const ident::Row& row : rows) {
    const ident::Columns& own = columns[row.recording];
    values += std::min(1.0, 2.0 * own.band_hz / own.signals->sample_rate_hz);
  }
  return values;
}

/// What is to be said of so many candidates on these rows; empty: nothing. An estimate from ten values is known to a
/// third of their scatter.
std::string too_many_candidates(Eigen::Index num_candidates, double values) {
  constexpr double values_for_each = 10.0;
  if (static_cast<double>(num_candidates) * values_for_each <= values) return {};
  return fmt::format(
      "{} candidates for {:.0f} independent values: more than one for ten, so that some may explain noise. Lower "
      "library.order, name fewer library.terms, or record for longer",
      num_candidates, values);
}

int check_one_body(const Config& config, const RunArguments& arguments, Console& console) {
  const Work work = prepare_work(config, arguments, console);
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
    const std::string many = too_many_candidates(columns.front().phi.cols(), independent_values(rows.train, columns));
    if (many.empty()) continue;
    text += fmt::format("{:<8} range {}: library.many: {}\n", "warning", range.spec.name, many);
    console.warning("library.many", fmt::format("range {}: {}", range.spec.name, many));
  }
  console.result(console.json() ? checks_json(work.inputs) : text);
  return 0;
}

int check(const RunArguments& arguments, Console& console) {
  const Config config = config_of(arguments);
  try {
    if (config.inner == ident::Inner::none) return check_one_body(config, arguments, console);
  } catch (const dsp::Fault& fault) {
    if (!is_of_bodies(fault)) throw;
  }
  console.result(check_bodies(config, arguments, console));
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
