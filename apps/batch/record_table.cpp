#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/batch/record_results.hpp"
#include "apps/output/tables.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/json_parts.hpp"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;

/// Numbers with as few digits as give them back when read; nothing where there is none.
std::string cell(const Json& value) {
  if (value.is_string()) return text_cell(value.get<std::string>());
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  return value.is_number() ? fmt::format("{}", value.get<double>()) : "";
}

std::string range_cells(const Json& range, const std::vector<std::string>& terms) {
  std::string cells;
  for (const char* key : {"/name", "/chosen", "/verdict", "/cause", "/method", "/num_train", "/num_effective",
                          "/nmse/train", "/nmse/test", "/nmse/free_run"})
    cells += "," + cell(range.value(Json::json_pointer(key), Json()));
  for (const std::string& name : terms) {
    Json found;
    for (const Json& term : range.value("terms", Json::array()))
      if (found.is_null() && term.at("name") == name) found = term;
    cells += found.is_null() ? "," : "," + cell(found.at("mean"));
    cells += found.is_null() ? "," : "," + cell(found.at("std"));
  }
  return cells;
}

Json text_or_null(const std::string& text) {
  return text.empty() ? Json() : Json(printable(text));
}

}  // namespace

std::vector<std::string> all_terms(const std::vector<RecordResult>& records) {
  std::vector<std::string> names;
  for (const RecordResult& record : records)
    for (const Json& range : record.ranges)
      for (const Json& term : range.at("terms"))
        if (const std::string name = term.at("name"); std::find(names.begin(), names.end(), name) == names.end())
          names.push_back(name);
  return names;
}

std::string table_csv(const std::vector<RecordResult>& records) {
  const std::vector<std::string> terms = all_terms(records);
  std::string text =
      "recording,run,exit_code,error,range,chosen,verdict,cause,method,num_train,num_effective,nmse_train,nmse_test,"
      "nmse_free_run";
  for (const std::string& term : terms) text += fmt::format(",{},{}", text_cell(term), text_cell("std " + term));
  text += '\n';
  for (const RecordResult& record : records) {
    const std::vector<Json> none(1, Json::object());
    for (const Json& range : record.ranges.empty() ? none : record.ranges)
      text += fmt::format("{},{},{},{}{}\n", text_cell(record.recording), text_cell(record.run), record.exit_code,
                          text_cell(record.error), range_cells(range, terms));
  }
  return text;
}

std::string table_json(const std::vector<RecordResult>& records, const std::string& joint, const std::string& reason) {
  Json document{{"schema", 1}, {"num_records", records.size()}};
  document["num_failed"] =
      std::count_if(records.begin(), records.end(), [](const RecordResult& record) { return record.run.empty(); });
  document["records"] = Json::array();
  for (const RecordResult& record : records)
    document["records"].push_back({{"recording", record.recording},
                                   {"run", text_or_null(record.run)},
                                   {"exit_code", record.exit_code},
                                   {"error", text_or_null(record.error)},
                                   {"ranges", record.ranges}});
  document["joint"] = joint.empty() ? Json() : parsed_json(joint);
  if (joint.empty()) document["joint_reason"] = text_or_null(reason);
  return text_of(document);
}

}  // namespace apps
