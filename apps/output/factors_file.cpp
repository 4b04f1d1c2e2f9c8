#include "apps/output/factors_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/process/path.hpp"
#include "apps/process/printable.hpp"
#include "apps/process/version.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

constexpr int factors_schema = 1;

/// The upper triangle, row by row; numbers read back as the same doubles.
Json triangle_json(const ident::RFactor& data) {
  Json values = Json::array();
  for (Index i = 0; i < data.R.rows(); ++i)
    for (Index j = i; j < data.R.cols(); ++j) values.push_back(data.R(i, j));
  return {{"num_rows", data.num_samples}, {"R", std::move(values)}};
}

Json record_json(const ident::RecordFactors& record) {
  Json json{{"record", printable(record.record)},
            {"range", printable(record.range)},
            {"where", record.where},
            {"files", Json::array()},
            {"calibrated", record.calibrated},
            {"rate_hz", record.rate_hz},
            {"band_hz", record.band_hz},
            {"target", record.target},
            {"target_unit", record.target_unit},
            {"terms", Json::array()}};
  if (record.stated_zero_m) json["stated_zero_m"] = *record.stated_zero_m;
  for (const ident::FactorSource& source : record.sources)
    json["files"].push_back({{"path", printable(source.path)}, {"sha256", source.sha256}});
  for (const ident::FactorTerm& term : record.terms)
    json["terms"].push_back({{"name", term.name}, {"unit", term.unit}, {"scale", term.scale}});
  json["white"] = triangle_json(record.white);
  if (record.evidence.num_terms > 0) json["evidence"] = triangle_json(record.evidence);
  if (const ident::EffectiveSize& size = record.size; record.evidence.num_terms > 0)
    json["size"] = {{"num_rows", size.num_rows},
                    {"num_uncorrelated", size.num_uncorrelated},
                    {"num_noise", size.num_noise},
                    {"num_states", size.num_states},
                    {"structural_fraction", size.structural_fraction}};
  json["blocks"] = Json::array();
  for (const ident::FactorBlock& block : record.blocks) {
    Json one{{"from_s", block.from_s}, {"to_s", block.to_s}, {"target_sum", block.target_sum}};
    one.update(triangle_json(block.data));
    json["blocks"].push_back(std::move(one));
  }
  return json;
}

}  // namespace

std::vector<ident::RecordFactors> record_factors(const std::vector<ident::RangeResult>& ranges,
                                                 const std::vector<ident::Columns>& recordings,
                                                 const std::vector<std::vector<ident::FactorSource>>& sources,
                                                 const ident::CandidateLibrary& library,
                                                 const ident::IdentifyOptions& options) {
  std::vector<ident::RecordFactors> records;
  for (const ident::RangeResult& range : ranges) {
    ident::RecordFactors record{.range = range.spec.name,
                                .where = range.spec.where,
                                .target = options.target,
                                .target_unit = options.target_unit,
                                .calibrated = range.uncalibrated.empty(),
                                .white = range.factors.white,
                                .evidence = range.factors.evidence,
                                .size = range.factors.size,
                                .blocks = range.factors.blocks};
    for (std::size_t r = 0; r < recordings.size(); ++r) {
      if (range.recording != 0 && static_cast<std::size_t>(range.recording) != r + 1) continue;
      record.record += (record.record.empty() ? "" : ", ") + recordings[r].name;
      record.sources.insert(record.sources.end(), sources[r].begin(), sources[r].end());
      record.rate_hz = recordings[r].signals->sample_rate_hz;
      record.band_hz = recordings[r].band_hz;
    }
    for (std::size_t i = 0; i < range.factors.terms.size(); ++i) {
      const ident::Term& term = library.terms[static_cast<std::size_t>(range.factors.terms[i])];
      record.terms.push_back({term.name, term.unit, range.factors.scale(static_cast<Index>(i))});
    }
    records.push_back(std::move(record));
  }
  return records;
}

void name_apart(std::vector<std::vector<ident::RecordFactors>>& of_files, const std::vector<fs::path>& files) {
  std::map<std::string, std::set<std::size_t>> found_in;  // of each name
  for (std::size_t i = 0; i < of_files.size(); ++i)
    for (const ident::RecordFactors& record : of_files[i]) found_in[record.record].insert(i);
  const std::vector<std::string> names = distinct_names(files);
  for (std::size_t i = 0; i < of_files.size(); ++i)
    for (ident::RecordFactors& record : of_files[i])
      if (found_in.at(record.record).size() > 1) record.record = fmt::format("{}: {}", names[i], record.record);
}

double factors_bytes(const std::vector<ident::RecordFactors>& records) {
  constexpr double longest_number = 25.0, rest = 2000.0;
  double bytes = 0.0;
  for (const ident::RecordFactors& record : records) {
    const auto width = static_cast<double>(record.white.R.cols());
    bytes += rest + 0.5 * width * (width + 1.0) * longest_number * static_cast<double>(2 + record.blocks.size());
  }
  return bytes;
}

std::string factors_json(const std::vector<ident::RecordFactors>& records) {
  Json document{
      {"kind", "ardent factors"}, {"schema", factors_schema}, {"version", version()}, {"records", Json::array()}};
  for (const ident::RecordFactors& record : records) document["records"].push_back(record_json(record));
  return document.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace apps
