#include "apps/cli/fit_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <sstream>
#include <utility>

#include "apps/output/fit_outcome.hpp"
#include "apps/output/report_text.hpp"
#include "apps/output/results_json.hpp"
#include "apps/process/interrupt.hpp"
#include "dsp/io/sample_source.hpp"
#include "dsp/io/small_file.hpp"
#include "ident/columns.hpp"
#include "ident/identify.hpp"
#include "ident/validate/judge.hpp"

namespace apps {
namespace {

using Eigen::Index;

dsp::Fault usage(std::string name, const std::string& message) {
  return {dsp::FaultKind::usage, std::move(name), message};
}

/// The column's name as one that an expression can hold, short enough to read.
std::string identifier(const std::string& column, std::size_t index) {
  constexpr std::size_t most_characters = 60;
  std::string name;
  for (const char c : column.substr(0, most_characters)) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      name += c;
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  if (name.empty()) return fmt::format("column_{}", index + 1);
  return std::isdigit(static_cast<unsigned char>(name.front())) != 0 ? "_" + name : name;
}

/// A table as signals; its rows are its clock.
dsp::Motion read_table(const std::filesystem::path& file, Console& console) {
  const auto source = dsp::open_source(file);
  const dsp::SourceInfo& info = source->info();
  dsp::Motion table;
  table.sample_rate_hz = 1.0;
  for (std::size_t i = 0; i < info.columns.size(); ++i) {
    const std::string name = identifier(info.columns[i], i);
    if (table.find(name) != nullptr)
      throw dsp::Fault(dsp::FaultKind::input, "channel.name",
                       fmt::format("{}: two columns are called '{}'. Rename one.", file.string(), name));
    if (name != info.columns[i]) console.note(fmt::format("column '{}' is called {} here", info.columns[i], name));
    table.signals.push_back({name, info.units[i], Eigen::VectorXd(info.num_frames)});
  }
  dsp::FrameBlock block;
  Index done = 0;
  constexpr Index rows_at_once = 4096;
  while (const Index count = source->read(block, rows_at_once)) {
    for (Index j = 0; j < block.cols(); ++j)
      table.signals[static_cast<std::size_t>(j)].values.segment(done, count) = block.col(j).head(count);
    done += count;
  }
  return table;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n";
  const std::size_t from = std::min(text.find_first_not_of(blanks), text.size());
  return text.substr(from, text.find_last_not_of(blanks) + 1 - from);
}

/// A dot before letters begins no number: such a text is the name of a file.
bool looks_like_a_file(const std::string& argument) {
  const std::size_t dot = argument.rfind('.');
  return argument.find_first_of(",(") == std::string::npos && dot + 1 < argument.size() && dot != std::string::npos &&
         std::isalpha(static_cast<unsigned char>(argument[dot + 1])) != 0;
}

std::vector<std::string> read_terms(const std::string& argument) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(argument, ignored) && !looks_like_a_file(argument))
    return split_terms(argument);
  std::vector<std::string> terms;
  std::istringstream file(dsp::read_small_file(
      argument, {.kind = dsp::FaultKind::usage, .fault = "config.file", .wanted = "a file of --terms"}));
  for (std::string line; std::getline(file, line);) {
    line.erase(std::min(line.find('#'), line.size()));
    if (!trimmed(line).empty()) terms.emplace_back(trimmed(line));
  }
  return terms;
}

std::vector<ident::Method> methods_of(const std::vector<std::string>& names) {
  if (names.empty()) return ident::default_methods();
  std::vector<ident::Method> methods;
  for (const std::string& name : names) {
    try {
      methods.push_back(ident::method_named(name).method);
    } catch (const std::invalid_argument& error) {
      throw usage("fit.method", fmt::format("--methods: {}.", error.what()));
    }
  }
  return methods;
}

}  // namespace

std::vector<std::string> split_terms(const std::string& list) {
  std::vector<std::string> terms(1);
  int depth = 0;
  for (const char c : list) {
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (c == ',' && depth == 0)
      terms.emplace_back();
    else
      terms.back() += c;
  }
  for (std::size_t i = 0; i < terms.size(); ++i) {
    terms[i] = trimmed(terms[i]);
    if (terms[i].empty())
      throw usage("term.syntax", fmt::format("--terms: term {} of {} is empty.", i + 1, terms.size()));
  }
  return terms;
}

int run_fit(const FitArguments& arguments, Console& console) {
  const dsp::Motion table = read_table(arguments.table, console);
  if (table.find(arguments.target) == nullptr) {
    std::string known;
    for (const dsp::Signal& signal : table.signals) known += (known.empty() ? "" : ", ") + signal.name;
    throw usage("target.unknown", fmt::format("--target: {} has no column '{}', want one of {}.",
                                              arguments.table.string(), arguments.target, known));
  }
  const std::vector<std::string> terms = read_terms(arguments.terms);
  const ident::CandidateLibrary library =
      ident::make_library({.order = 0, .variables = {}, .terms = terms}, arguments.target, table);
  std::vector<ident::Columns> columns{
      ident::form_columns(library, arguments.target, table, arguments.table.filename().string(), check_interrupted)};
  dsp::RangeSpec all;
  all.name = "all";
  all.to_s = all.train_to_s.emplace(static_cast<double>(table.num_samples()));
  all.where = arguments.where;
  all.place = "--where";
  const ident::IdentifyOptions options{.target = arguments.target,
                                       .target_unit = table.find(arguments.target)->unit,
                                       .methods = arguments.settings.options_of(methods_of(arguments.methods)),
                                       .num_threads = arguments.num_threads,
                                       .free_run = false,
                                       .poll = check_interrupted};
  std::vector<ident::RangeResult> ranges{ident::identify({all, 1, {}}, columns, library, options)};
  ident::judge(ranges);
  for (const ident::DroppedTerm& term : ranges.front().dropped)
    console.warning("term.left_out", fmt::format("{} is left out: {}", term.name, term.reason));
  refuse_warnings(arguments.strict, console);
  console.result(console.json() ? metrics_json(ranges, options) : report_text(ranges));
  return outcome_of(ranges.front().fits, arguments.table.string(), console);
}

}  // namespace apps
