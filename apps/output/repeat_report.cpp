#include "apps/output/repeat_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/process/printable.hpp"
#include "apps/text/json_parts.hpp"

namespace apps {
namespace {

bool all_same(const std::vector<RepeatedFile>& files) {
  return std::all_of(files.begin(), files.end(), [](const RepeatedFile& file) { return file.same || !file.counts; });
}

std::string lines_on(const char* what, const std::vector<RepeatedFile>& files, const char* missing) {
  const auto num_same = std::count_if(files.begin(), files.end(), [](const RepeatedFile& file) { return file.same; });
  std::string text = fmt::format("  {:<8} {} of {} files the same, bit for bit\n", what, num_same, files.size());
  for (const RepeatedFile& file : files)
    if (!file.same)
      text += fmt::format("           {}: {}{}\n", printable(file.path),
                          file.is_new  ? "is new"
                          : file.found ? "differs"
                                       : missing,
                          file.counts ? "" : "; not read again, config.toml has its settings");
  return text;
}

nlohmann::ordered_json json_of(const std::vector<RepeatedFile>& files) {
  auto list = nlohmann::ordered_json::array();
  for (const RepeatedFile& file : files)
    list.push_back({{"path", printable(file.path)},
                    {"found", file.found},
                    {"same", file.same},
                    {"counts", file.counts},
                    {"new", file.is_new}});
  return list;
}

}  // namespace

bool RepeatReport::inputs_same() const {
  return all_same(inputs);
}

bool RepeatReport::results_same() const {
  return all_same(results);
}

std::string repeat_text(const RepeatReport& report) {
  const bool same_program = report.program_then == report.program_now;
  std::string text = fmt::format("{} again\n  {:<8} {}\n", printable(report.run), "program",
                                 same_program ? "the same: ardent " + report.program_now : "differs");
  if (!same_program)
    text += fmt::format("           then ardent {}\n           now  ardent {}\n", printable(report.program_then),
                        report.program_now);
  text += lines_on("inputs", report.inputs, "is missing");
  text += lines_on("results", report.results, "is no longer written");
  if (!report.folder.empty()) text += fmt::format("  the repeat is in {}\n", report.folder.string());
  return text;
}

std::string repeat_json(const RepeatReport& report) {
  nlohmann::ordered_json document{{"run", printable(report.run)},
                                  {"same", report.inputs_same() && report.results_same()},
                                  {"program",
                                   {{"same", report.program_then == report.program_now},
                                    {"then", printable(report.program_then)},
                                    {"now", report.program_now}}},
                                  {"inputs", json_of(report.inputs)},
                                  {"results", json_of(report.results)}};
  return text_of(document);
}

}  // namespace apps
