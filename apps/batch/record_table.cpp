#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/batch/record_results.hpp"
#include "apps/output/tables.hpp"

namespace apps {
namespace {

/// With as few digits as give it back when read; nothing where there is none.
std::string number_cell(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string();
}

std::string coefficient_cells(const RangeRow& range, const std::vector<std::string>& terms) {
  std::string cells;
  for (const std::string& name : terms) {
    const auto term = std::find_if(range.terms.begin(), range.terms.end(),
                                   [&](const CoefficientResult& one) { return one.name == name; });
    cells += term == range.terms.end() ? std::string(",,")
                                       : fmt::format(",{},{}", number_cell(term->mean), number_cell(term->std));
  }
  return cells;
}

}  // namespace

std::string table_csv(const std::vector<RecordResult>& records) {
  const std::vector<std::string> terms = all_terms(records);
  std::string text =
      "recording,run,exit_code,error,range,chosen,verdict,cause,method,num_train,num_effective,nmse_train,nmse_test,"
      "nmse_free_run";
  for (const std::string& term : terms) text += fmt::format(",{},{}", text_cell(term), text_cell("std " + term));
  text += '\n';
  for (const RecordResult& record : records) {
    const std::vector<RangeRow> none(1, RangeRow{.num_train = std::nan(""),
                                                 .num_effective = std::nan(""),
                                                 .nmse_train = std::nan(""),
                                                 .nmse_test = std::nan(""),
                                                 .nmse_free_run = std::nan("")});
    for (const RangeRow& range : record.ranges.empty() ? none : record.ranges)
      text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}{}\n", text_cell(record.recording),
                          text_cell(record.run), record.exit_code, text_cell(record.error), text_cell(range.name),
                          range.name.empty() ? ""
                          : range.chosen     ? "1"
                                             : "0",
                          range.verdict, range.cause, range.method, number_cell(range.num_train),
                          number_cell(range.num_effective), number_cell(range.nmse_train), number_cell(range.nmse_test),
                          number_cell(range.nmse_free_run), coefficient_cells(range, terms));
  }
  return text;
}

}  // namespace apps
