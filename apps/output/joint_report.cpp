#include "apps/output/joint_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/output/report_text.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/json_number.hpp"
#include "apps/text/json_parts.hpp"
#include "apps/text/number_text.hpp"
#include "dsp/values/fault.hpp"
#include "ident/regression/methods.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

std::string terms_table(const ident::JointFit& fit) {
  std::size_t width = 4;
  for (const ident::ModelTerm& term : fit.model.terms) width = std::max(width, label(term).size());
  std::string text =
      fmt::format("      {:<{}}  {:>13}    {:<10} {:<13} unit\n", "term", width, "mean", "std", "over records");
  for (std::size_t i = 0; i < fit.model.terms.size(); ++i) {
    const ident::ModelTerm& term = fit.model.terms[i];
    text += fmt::format("      {:<{}}  {:>13} +- {:<10} {:<13} {}\n", label(term), width, ident::number(term.mean),
                        three_digits(term.std), three_digits(fit.std_over_records(static_cast<Index>(i))), term.unit);
  }
  return text;
}

std::string records_table(const ident::JointFit& fit, std::size_t most_records) {
  if (fit.records.size() < 2) return "      one record: nothing to leave out\n";
  std::size_t width = 6;
  for (const ident::RecordCheck& check : fit.records) width = std::max(width, printable(check.record, 40).size());
  std::string text = fmt::format("      {:<{}}  NMSE joint  left out  the others' equation\n", "record", width);
  const auto order = worst_first(fit);
  for (std::size_t i = 0; i < std::min(most_records, order.size()); ++i)
    text += fmt::format("      {:<{}}  {:<10}  {:<8}  {}\n", printable(order[i]->record, 40), width,
                        three_digits(order[i]->nmse), three_digits(order[i]->nmse_left_out),
                        ident::to_text(order[i]->left_out));
  if (order.size() > most_records)
    text += fmt::format("      and {} more with smaller errors\n", order.size() - most_records);
  return text;
}

Json fit_json(const ident::JointFit& fit) {
  Json json{{"method", to_string(fit.fit.method)},
            {"status", to_string(fit.fit.status)},
            {"text", ident::to_text(fit.model)},
            {"coordinates", coordinates_json(fit.model.coordinates)}};
  json["terms"] = Json::array();
  for (std::size_t i = 0; i < fit.model.terms.size(); ++i) {
    const ident::ModelTerm& term = fit.model.terms[i];
    Json one{{"name", term.name}};
    if (term.recording > 0) one["recording"] = printable(term.recording_name);
    one.update({{"mean", term.mean},
                {"std", number_or_null(term.std)},
                {"std_over_records", number_or_null(fit.std_over_records(static_cast<Index>(i)))},
                {"unit", term.unit}});
    json["terms"].push_back(std::move(one));
  }
  json["covariance"] = Json::array();
  for (Index i = 0; i < fit.model.covariance.rows(); ++i) {
    Json row = Json::array();
    for (Index j = 0; j < fit.model.covariance.cols(); ++j) row.push_back(number_or_null(fit.model.covariance(i, j)));
    json["covariance"].push_back(std::move(row));
  }
  json["records"] = Json::array();
  for (const ident::RecordCheck& check : fit.records)
    json["records"].push_back(
        {{"record", printable(check.record)},
         {"nmse", number_or_null(check.nmse)},
         {"nmse_left_out", number_or_null(check.nmse_left_out)},
         {"left_out_text", fit.records.size() > 1 ? Json(ident::to_text(check.left_out)) : Json()}});
  return json;
}

/// A recording by its bytes and its name.
void refuse_twice(const std::vector<const ident::RecordFactors*>& records) {
  std::map<std::string, const ident::RecordFactors*> seen;
  for (const ident::RecordFactors* record : records) {
    const auto [first, is_new] = seen.emplace(record->sources.front().sha256 + record->where, record);
    if (!is_new)
      throw dsp::Fault(
          dsp::FaultKind::input, "factors.twice",
          fmt::format("range '{}': {} and {} are the same recording, which would count twice. Leave one out",
                      printable(record->range), printable(first->second->record), printable(record->record)));
  }
}

}  // namespace

const ident::JointFit* shown_fit(const ident::JointResult& result) {
  const auto found = std::find_if(result.fits.begin(), result.fits.end(),
                                  [](const ident::JointFit& fit) { return !fit.model.terms.empty(); });
  return found == result.fits.end() ? nullptr : &*found;
}

std::vector<const ident::RecordCheck*> worst_first(const ident::JointFit& fit) {
  std::vector<const ident::RecordCheck*> order;
  for (const ident::RecordCheck& check : fit.records) order.push_back(&check);
  const auto error = [](const ident::RecordCheck* check) {
    return std::isfinite(check->nmse_left_out) ? check->nmse_left_out : -1.0;
  };
  std::stable_sort(order.begin(), order.end(), [&](const auto* a, const auto* b) { return error(a) > error(b); });
  return order;
}

std::vector<ident::JointResult> joint_fits(const std::vector<ident::RecordFactors>& records,
                                           const std::vector<ident::MethodOptions>& methods, const ident::Poll& poll) {
  std::vector<std::string> ranges;
  for (const ident::RecordFactors& record : records)
    if (std::find(ranges.begin(), ranges.end(), record.range) == ranges.end()) ranges.push_back(record.range);
  std::vector<ident::JointResult> results;
  for (const std::string& range : ranges) {
    std::vector<const ident::RecordFactors*> own;
    for (const ident::RecordFactors& record : records)
      if (record.range == range) own.push_back(&record);
    refuse_twice(own);
    results.push_back(ident::joint_fit(own, methods, poll));
  }
  return results;
}

namespace {

/// Where some record has a range that another has not; empty elsewhere.
std::string different_ranges(const std::vector<ident::RecordFactors>& records) {
  std::map<std::string, std::set<std::string>> having;
  std::set<std::string> recordings;
  for (const ident::RecordFactors& record : records) {
    having[record.range].insert(record.sources.front().sha256);
    recordings.insert(record.sources.front().sha256);
  }
  if (std::all_of(having.begin(), having.end(), [&](const auto& range) { return range.second == recordings; }))
    return {};
  std::vector<std::string> parts;
  for (const auto& [range, own] : having) parts.push_back(fmt::format("{} in {}", printable(range), own.size()));
  return fmt::format(
      "not all of {} records have the same ranges ({}), and each range is fitted on its own. For one fit "
      "of all records name a [[range]] in the config",
      recordings.size(), fmt::join(parts, ", "));
}

/// Zeros that were found in each record are each its own; those that a person stated may be mistaken. Empty where all
/// are alike.
std::string different_zeros(const std::vector<ident::RecordFactors>& records) {
  const ident::RecordFactors& first = records.front();
  const auto other = std::find_if(records.begin(), records.end(), [&](const ident::RecordFactors& record) {
    return record.stated_zero_m != first.stated_zero_m;
  });
  if (other == records.end()) return {};
  const auto shown_zero = [](const ident::RecordFactors& record) {
    return fmt::format("{} ({})", record.stated_zero_m ? fmt::format("{:.6g} m", *record.stated_zero_m) : "not stated",
                       printable(record.record));
  };
  return fmt::format(
      "the zero of x differs between records: {}, {}. Terms in x are then of different x, unless the "
      "sensor's zero differed. Give all of them one prepare.zero",
      shown_zero(first), shown_zero(*other));
}

}  // namespace

std::vector<std::string> differences(const std::vector<ident::RecordFactors>& records) {
  std::vector<std::string> found;
  const auto compare = [&](const char* what, double ident::RecordFactors::*value) {
    const auto [least, most] = std::minmax_element(records.begin(), records.end(),
                                                   [&](const auto& a, const auto& b) { return a.*value < b.*value; });
    constexpr double alike = 1e-9;  // of a rate
    if ((*most).*value - (*least).*value > alike * (*most).*value)
      found.push_back(
          fmt::format("{} differs between records: {:.9g} Hz ({}) to {:.9g} Hz ({}). Give all of them one, as "
                      "prepare.cutoff_hz in the config",
                      what, (*least).*value, printable(least->record), (*most).*value, printable(most->record)));
  };
  if (records.empty()) return found;
  compare("the band", &ident::RecordFactors::band_hz);
  if (std::string text = different_zeros(records); !text.empty()) found.push_back(std::move(text));
  if (std::string text = different_ranges(records); !text.empty()) found.push_back(std::move(text));
  return found;
}

std::string joint_text(const std::vector<ident::JointResult>& results, std::size_t most_records) {
  std::string text;
  for (const ident::JointResult& result : results) {
    text += fmt::format("range {}: {} records together\n", printable(result.range), result.records.size());
    if (!result.left_out.empty()) text += fmt::format("  left out: {}\n", fmt::join(result.left_out, ", "));
    const ident::JointFit* fit = shown_fit(result);
    if (fit == nullptr) {
      text += "  no equation\n";
      continue;
    }
    text += fmt::format("  {}\n", ident::to_text(fit->model));
    if (!fit->model.coordinates.empty()) text += fmt::format("  {}\n", coordinates_sentence(fit->model.coordinates));
    std::vector<MethodModel> others;
    for (const ident::JointFit& other : result.fits)
      if (&other != fit) others.push_back({other.fit.method, &other.model});
    text += fmt::format("  By {}. {}\n", to_string(fit->fit.method), agreement_sentence(fit->model, others));
    text += terms_table(*fit) + records_table(*fit, most_records);
  }
  return text;
}

std::string joint_json(const std::vector<ident::JointResult>& results) {
  Json document{{"ranges", Json::array()}};
  for (const ident::JointResult& result : results) {
    Json range{{"name", printable(result.range)}, {"target", result.target},     {"target_unit", result.target_unit},
               {"records", Json::array()},        {"left_out", result.left_out}, {"methods", Json::array()}};
    for (const std::string& record : result.records) range["records"].push_back(printable(record));
    for (const ident::JointFit& fit : result.fits) range["methods"].push_back(fit_json(fit));
    document["ranges"].push_back(std::move(range));
  }
  return text_of(document);
}

}  // namespace apps
