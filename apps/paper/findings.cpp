#include "apps/paper/findings.hpp"

#include <algorithm>
#include <cmath>

#include "apps/paper/paper_data.hpp"

namespace apps {

double number_in(const Json& value) {
  return value.is_number() ? value.get<double>() : missing;
}

JsonRows matching(const Json& rows, const Json& values) {
  JsonRows found;
  for (const Json& row : rows)
    if (std::all_of(values.items().begin(), values.items().end(),
                    [&](const auto& wanted) { return row.at(wanted.key()) == wanted.value(); }))
      found.push_back(&row);
  return found;
}

std::vector<std::pair<Json, JsonRows>> grouped(const JsonRows& rows, const std::vector<std::string>& keys) {
  std::vector<std::pair<Json, JsonRows>> groups;
  for (const Json* row : rows) {
    Json values;
    for (const std::string& key : keys) values.push_back(row->at(key));
    auto at = std::find_if(groups.begin(), groups.end(), [&](const auto& group) { return group.first == values; });
    if (at == groups.end()) at = groups.emplace(at, std::move(values), JsonRows());
    at->second.push_back(row);
  }
  return groups;
}

double mean_of(const JsonRows& rows, const std::string& path) {
  double sum = 0.0;
  for (const Json* row : rows) sum += number_in(row->at(Json::json_pointer(path)));
  return sum / static_cast<double>(rows.size());
}

FoundTerm found_term(const JsonRows& fits, const std::string& name) {
  FoundTerm found;
  for (const Json* fit : fits)
    for (const Json& term : fit->at("terms")) {
      if (term["name"] != name) continue;
      const double mean = number_in(term["mean"]),
                   std = number_in(term[term.contains("std_noise") ? "std_noise" : "std"]);
      const double scale = number_in(term.value("scale", Json()));
      found.mean += mean;
      found.std += std;
      found.mean_scaled += mean * scale;
      found.std_scaled += std * scale;
      found.cov += std / std::abs(mean);
      found.t += mean / std;
      found.unit = term.value("unit", "");
      ++found.kept;
    }
  for (double FoundTerm::*value : {&FoundTerm::mean, &FoundTerm::std, &FoundTerm::mean_scaled, &FoundTerm::std_scaled,
                                   &FoundTerm::cov, &FoundTerm::t})
    found.*value /= found.kept;  // NaN for none
  return found;
}

}  // namespace apps
