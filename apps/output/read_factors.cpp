#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/output/factors_file.hpp"
#include "apps/output/run_json.hpp"
#include "dsp/fault.hpp"
#include "dsp/names.hpp"
#include "ident/library/expression.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

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

std::vector<ident::FactorTerm> read_terms(const Field& field) {
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
                              .terms = read_terms(field.at("terms"))};
  if (field.has("stated_zero_m")) record.stated_zero_m = field.at("stated_zero_m").number();
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
  if (!whole.has("kind") || whole.at("kind").text() != "ardent factors")
    throw dsp::Fault(
        dsp::FaultKind::input, "factors.file",
        fmt::format("{}: holds no R factors. Want a file that ardent fit --save wrote, or a run folder", name));
  if (const Index schema = whole.at("schema").count(); schema != 1)
    throw dsp::Fault(dsp::FaultKind::input, "factors.schema",
                     fmt::format("{}: schema {}, want 1. Write it again with this program", name, schema));
  std::vector<ident::RecordFactors> records;
  for (const Field& record : whole.at("records").items()) records.push_back(read_record(record));
  if (records.empty()) whole.at("records").fail("at least one record");
  return records;
}

}  // namespace apps
