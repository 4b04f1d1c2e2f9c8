#include "apps/output/factors_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/output/output_folder.hpp"
#include "apps/output/run_json.hpp"
#include "apps/output/staging_folder.hpp"
#include "apps/process/output_file.hpp"
#include "apps/process/path.hpp"
#include "apps/process/printable.hpp"
#include "apps/process/system_fault.hpp"
#include "apps/process/version.hpp"
#include "apps/text/json_parts.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"
#include "ident/judgement/judge.hpp"
#include "ident/library/expression.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

constexpr int factors_schema = 1;
constexpr const char* factors_kind = "ardent factors";

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
  json["coordinates"] = coordinates_json(record.coordinates);
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

/// A value of the file and where it is: "records[2].white.R".
class Field {
 public:
  Field(const std::string& file, std::string place, const Json& json)
      : file_(file), place_(std::move(place)), json_(json) {}
  [[nodiscard]] Field at(const char* key) const {
    if (!json_.is_object()) fail("an object");
    const auto member = json_.find(key);
    const std::string place = place_.empty() ? key : place_ + "." + key;
    if (member == json_.end())
      throw dsp::Fault(dsp::FaultKind::input, "factors.damaged", fmt::format("{}: {} is missing", file_, place));
    return {file_, place, *member};
  }
  [[nodiscard]] bool has(const char* key) const { return json_.is_object() && json_.contains(key); }
  [[nodiscard]] std::vector<Field> items() const {
    if (!json_.is_array()) fail("a list");
    std::vector<Field> all;
    for (std::size_t i = 0; i < json_.size(); ++i) all.emplace_back(file_, fmt::format("{}[{}]", place_, i), json_[i]);
    return all;
  }
  [[nodiscard]] std::string text() const {
    if (!json_.is_string()) fail("a text");
    return json_.get<std::string>();
  }
  [[nodiscard]] bool flag() const {
    if (!json_.is_boolean()) fail("true or false");
    return json_.get<bool>();
  }
  /// Finite.
  [[nodiscard]] double number() const {
    const double value = json_.is_number() ? json_.get<double>() : std::nan("");
    if (!std::isfinite(value)) fail("a number");
    return value;
  }
  [[nodiscard]] double number_from(double least) const {
    const double value = number();
    if (value < least) fail(fmt::format("{} or more", least));
    return value;
  }
  [[nodiscard]] Index count() const {
    if (!json_.is_number_integer() || json_.get<double>() < 0.0 || json_.get<double>() > 1e15)
      fail("a whole number, 0 or more");
    return json_.get<Index>();
  }
  /// The numbers of a list of this length.
  [[nodiscard]] Eigen::VectorXd numbers(Index length) const {
    if (!json_.is_array() || std::ssize(json_) != length) fail(fmt::format("a list of {} numbers", length));
    Eigen::VectorXd values(length);
    for (Index i = 0; i < length; ++i) {
      const Json& one = json_[static_cast<std::size_t>(i)];
      if (!one.is_number() || !std::isfinite(one.get<double>()))
        Field(file_, fmt::format("{}[{}]", place_, i), one).fail("a number");
      values(i) = one.get<double>();
    }
    return values;
  }
  [[noreturn]] void fail(const std::string& wanted) const {
    constexpr std::size_t most = 40;
    std::string got = json_.is_array()    ? fmt::format("a list of {}", json_.size())
                      : json_.is_object() ? "an object"
                                          : json_.dump(-1, ' ', true, Json::error_handler_t::replace);
    if (got.size() > most) got = got.substr(0, most) + "...";
    throw dsp::Fault(dsp::FaultKind::input, "factors.damaged",
                     fmt::format("{}: {}: got {}, want {}", file_, place_, got, wanted));
  }

 private:
  const std::string& file_;
  std::string place_;
  const Json& json_;
};

ident::RFactor read_triangle(const Field& field, Index num_terms) {
  const Index width = num_terms + 1;
  const Eigen::VectorXd values = field.at("R").numbers(width * (width + 1) / 2);
  ident::RFactor data{Eigen::MatrixXd::Zero(width, width), num_terms, field.at("num_rows").count()};
  if (data.num_samples < 1) field.at("num_rows").fail("1 or more");
  Index next = 0;
  for (Index i = 0; i < width; ++i)
    for (Index j = i; j < width; ++j) data.R(i, j) = values(next++);
  return data;
}

std::vector<ident::FactorTerm> factor_terms_in(const Field& field) {
  std::vector<ident::FactorTerm> terms;
  std::set<std::string> names;
  for (const Field& term : field.items()) {
    terms.push_back({term.at("name").text(), term.at("unit").text(), term.at("scale").number_from(0.0)});
    if (!names.insert(terms.back().name).second) term.at("name").fail("a term that is not there yet");
    try {
      const ident::Expression expression(terms.back().name);
    } catch (const dsp::Fault& fault) {
      term.at("name").fail(fmt::format("a term ({})", fault.what()));
    }
  }
  if (terms.empty()) field.fail("at least one term");
  return terms;
}

std::vector<ident::FactorBlock> read_blocks(const Field& field, Index num_terms, Index num_rows) {
  std::vector<ident::FactorBlock> blocks;
  Index rows = 0;
  for (const Field& block : field.items()) {
    blocks.push_back({block.at("from_s").number_from(0.0), block.at("to_s").number(), block.at("target_sum").number(),
                      read_triangle(block, num_terms)});
    if (!(blocks.back().to_s > blocks.back().from_s)) block.at("to_s").fail("more than from_s");
    rows += blocks.back().data.num_samples;
  }
  if (rows != num_rows)
    field.fail(fmt::format("blocks of {} rows together, as white has; these have {}", num_rows, rows));
  return blocks;
}

std::string read_hash(const Field& field) {
  const std::string hash = field.text();
  if (hash.size() != 64 || hash.find_first_not_of("0123456789abcdef") != std::string::npos)
    field.fail("a SHA-256 of 64 digits");
  return hash;
}

ident::EffectiveSize read_size(const Field& field) {
  ident::EffectiveSize size{field.at("num_rows").number_from(1.0), field.at("num_uncorrelated").number_from(0.0),
                            field.at("num_noise").number_from(0.0), field.at("num_states").number_from(0.0),
                            field.at("structural_fraction").number_from(0.0)};
  if (size.structural_fraction > 1.0) field.at("structural_fraction").fail("a number from 0 to 1");
  if (size.num_uncorrelated > size.num_rows) field.at("num_uncorrelated").fail("no more than num_rows");
  return size;
}

ident::RecordFactors read_record(const Field& field) {
  ident::RecordFactors record{.record = field.at("record").text(),
                              .range = field.at("range").text(),
                              .where = field.at("where").text(),
                              .target = field.at("target").text(),
                              .target_unit = field.at("target_unit").text(),
                              .rate_hz = field.at("rate_hz").number_from(0.0),
                              .band_hz = field.at("band_hz").number_from(0.0),
                              .calibrated = field.at("calibrated").flag(),
                              .terms = factor_terms_in(field.at("terms"))};
  if (field.has("stated_zero_m")) record.stated_zero_m = field.at("stated_zero_m").number();
  if (field.has("coordinates"))
    for (const Field& one : field.at("coordinates").items())
      record.coordinates.push_back({.recording = one.at("recording").text(),
                                    .of = one.at("of").text(),
                                    .unit = one.at("unit").text(),
                                    .zero = one.at("zero").number(),
                                    .zero_std = one.at("zero_std").number_from(0.0),
                                    .prepared_zero = one.at("prepared_zero").number(),
                                    .lead_s = one.at("lead_s").number(),
                                    .lead_std_s = one.at("lead_std_s").number_from(0.0)});
  for (const Field& source : field.at("files").items())
    record.sources.push_back({source.at("path").text(), read_hash(source.at("sha256"))});
  if (record.sources.empty()) field.at("files").fail("at least one file");
  const Index b = std::ssize(record.terms);
  record.white = read_triangle(field.at("white"), b);
  if (field.has("evidence")) {
    record.evidence = read_triangle(field.at("evidence"), b);
    record.size = read_size(field.at("size"));
  }
  record.blocks = read_blocks(field.at("blocks"), b, record.white.num_samples);
  return record;
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
    if (!range.fits.empty()) record.coordinates = range.fits[ident::chosen_method(range)].model.coordinates;
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

std::vector<ident::RecordFactors> name_apart(std::vector<std::vector<ident::RecordFactors>> of_files,
                                             const std::vector<fs::path>& files) {
  std::map<std::string, std::set<std::size_t>> found_in;  // of each name
  for (std::size_t i = 0; i < of_files.size(); ++i)
    for (const ident::RecordFactors& record : of_files[i]) found_in[record.record].insert(i);
  const std::vector<std::string> names = distinct_names(files);
  std::vector<ident::RecordFactors> all;
  for (std::size_t i = 0; i < of_files.size(); ++i)
    for (ident::RecordFactors& record : of_files[i]) {
      if (found_in.at(record.record).size() > 1) record.record = fmt::format("{}: {}", names[i], record.record);
      all.push_back(std::move(record));
    }
  return all;
}

std::string factors_json(const std::vector<ident::RecordFactors>& records) {
  Json document{{"kind", factors_kind}, {"schema", factors_schema}, {"version", version()}, {"records", Json::array()}};
  for (const ident::RecordFactors& record : records) document["records"].push_back(record_json(record));
  return document.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<ident::RecordFactors> read_factors(const fs::path& file_or_folder) {
  std::error_code unknown;
  const fs::path file = fs::is_directory(file_or_folder, unknown) ? file_or_folder / factors_name : file_or_folder;
  const std::string name = dsp::clean_name(file.string());
  Json document;
  try {
    document = read_run_json(file);
  } catch (const dsp::Fault& fault) {
    throw dsp::Fault(dsp::FaultKind::input, "factors.file",
                     fmt::format("{}. Want a file that ardent fit --save wrote, or a run folder with {}", fault.what(),
                                 factors_name));
  }
  const Field whole(name, "", document);
  if (!whole.has("kind") || whole.at("kind").text() != factors_kind)
    throw dsp::Fault(
        dsp::FaultKind::input, "factors.file",
        fmt::format("{}: holds no R factors. Want a file that ardent fit --save wrote, or a run folder", name));
  if (const Index schema = whole.at("schema").count(); schema != factors_schema)
    throw dsp::Fault(
        dsp::FaultKind::input, "factors.schema",
        fmt::format("{}: schema {}, want {}. Write it again with this program", name, schema, factors_schema));
  std::vector<ident::RecordFactors> records;
  for (const Field& record : whole.at("records").items()) records.push_back(read_record(record));
  if (records.empty()) whole.at("records").fail("at least one record");
  return records;
}

void save_factors(const fs::path& file, const std::vector<ident::RecordFactors>& records,
                  const std::vector<fs::path>& read, bool force) {
  if (file.empty()) {
    if (!force) return;
    throw dsp::Fault(dsp::FaultKind::usage, "usage", "--force has no effect without --save. Leave it out");
  }
  const fs::path place = named_path(file);
  require_apart(place, read);
  const auto require_factors = [&](const Folder& folder, const std::string& name) {
    if (!force) throw taken_at(place);
    try {
      if (!folder.entry(name)->is_file()) throw link_at(place);
      static_cast<void>(read_factors(folder.path() / name));
    } catch (const dsp::Fault&) {
      throw output_fault("output.foreign", place, "holds no R factors, so it is not replaced. Choose another name");
    }
  };
  StagingFolder staging(place, require_factors);
  const std::string name = place.filename();
  staging.require_free(name);
  write_file(staging.fresh(), name, place, factors_json(records));
  staging.place({name});
}

}  // namespace apps
