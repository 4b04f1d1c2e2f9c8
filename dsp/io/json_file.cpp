#include "dsp/io/json_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "dsp/io/array_file.hpp"
#include "dsp/io/moment.hpp"
#include "dsp/io/table_cells.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/memory_limit.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

constexpr double json_missing = std::numeric_limits<double>::quiet_NaN();
constexpr char key_mark = '\x1f';

/// What stands under one path of keys: a number, a list of them, or one of lists.
struct JsonColumn {
  std::vector<double> values;
  std::shared_ptr<std::size_t> num_records;  // of the list in whose records it stands
  std::size_t width = 0, in_list = 0;        // of the inner lists; of the one that is open
  bool is_listed = false, is_uneven = false, has_text = false, is_time = false;
  std::vector<std::string> texts;  // the first ones
  MomentClock moments;
};

/// Puts numbers under the keys that lead to them, as the parser finds them. Lists have no part in a path: the outermost
/// is that of the rows, one within it that of what a row holds side by side.
class JsonColumns {
 public:
  explicit JsonColumns(std::string name) : name_(std::move(name)) {}

  // What the parser calls; false ends it.
  bool null() { return put(json_missing); }
  bool boolean(bool value) { return put(value ? 1.0 : 0.0); }
  bool number_integer(std::int64_t value) { return put(static_cast<double>(value)); }
  bool number_unsigned(std::uint64_t value) { return put(static_cast<double>(value)); }
  bool number_float(double value, const std::string& /*text*/) { return put(value); }
  bool string(std::string& text) {
    constexpr std::size_t most_texts = 10'000;
    JsonColumn& column = current();
    if (column.texts.size() < most_texts) column.texts.push_back(text);
    double value = json_missing;
    if (parse_cell(text, false, value) != Cell::bad) return put(value);
    if (const auto moment = parse_moment(text); moment && moment->has_time()) {
      column.is_time = true;
      return put(column.moments.seconds(*moment));
    }
    column.has_text = true;
    return put(json_missing);
  }
  bool binary(nlohmann::json::binary_t& /*bytes*/) { return false; }
  bool start_object(std::size_t /*size*/) {
    if (num_lists_ == 1 && frames_.back().is_list) ++*frames_.back().num_records;
    return open(false);
  }
  bool end_object() { return close(); }
  bool start_array(std::size_t /*size*/) {
    if (num_lists_ == 1) current().in_list = 0;
    return open(true);
  }
  bool end_array() {
    if (num_lists_ == 2) {
      JsonColumn& column = current();
      if (column.width == 0) column.width = column.in_list;
      column.is_uneven = column.is_uneven || column.in_list != column.width;
    }
    return close();
  }
  bool key(std::string& text) {
    Frame& frame = frames_.back();
    path_.resize(frame.path_bytes);
    if (!frame.is_list && frame.num_keys++ == 0 && text == "0") {  // {"0": 1, "1": 2}: a list
      frame.is_list = true;
      ++num_lists_;
    }
    if (!frame.is_list) path_.append(1, key_mark).append(text);
    return path_.size() < most_path_bytes;
  }
  bool parse_error(std::size_t at, const std::string& /*token*/, const nlohmann::json::exception& error) {
    const std::string_view what = error.what(), mark = ": ";
    const auto colon = what.find(mark, what.find("column"));
    throw Fault(
        FaultKind::input, "json.syntax",
        fmt::format("{}: no JSON at byte {} ({}). Copy the file from its source again, or correct it there", name_,
                    offset_ + at, clean_name(colon == what.npos ? what : what.substr(colon + mark.size()))));
  }

  /// From here on values follow each other as if in a list.
  void begin_lines() { (void)open(true); }
  void begin_line(std::size_t offset) {
    offset_ = offset;
    path_.clear();
  }
  [[nodiscard]] std::map<std::string, JsonColumn>& columns() { return columns_; }
  [[nodiscard]] const std::vector<std::string>& order() const { return order_; }

 private:
  static constexpr std::size_t deepest = 64, most_columns = 100'000, most_path_bytes = 100'000;
  struct Frame {
    std::size_t path_bytes = 0, num_keys = 0;
    bool is_list = false;  // or an object whose keys count
    std::shared_ptr<std::size_t> num_records = std::make_shared<std::size_t>(0);
  };

  bool open(bool is_list) {
    frames_.push_back({.path_bytes = path_.size(), .is_list = is_list});
    num_lists_ += is_list ? 1 : 0;
    return frames_.size() <= deepest && columns_.size() < most_columns;
  }
  bool close() {
    path_.resize(frames_.back().path_bytes);
    num_lists_ -= frames_.back().is_list ? 1 : 0;
    frames_.pop_back();
    return true;
  }
  JsonColumn& current() {
    const auto [at, is_new] = columns_.try_emplace(path_);
    if (is_new) order_.push_back(path_);
    return at->second;
  }
  bool put(double value) {
    JsonColumn& column = current();
    column.is_listed = column.is_listed || num_lists_ > 0;
    column.is_uneven = column.is_uneven || num_lists_ > 2 || (num_lists_ == 0 && !column.values.empty());
    if (num_lists_ == 1 && !frames_.back().is_list) {  // a record
      const auto rows = std::find_if(frames_.begin(), frames_.end(), [](const Frame& one) { return one.is_list; });
      column.num_records = rows->num_records;
      if (column.values.size() + 1 < *column.num_records) column.values.resize(*column.num_records - 1, json_missing);
    }
    ++column.in_list;
    column.values.push_back(value);
    return columns_.size() < most_columns;
  }

  std::string name_, path_;
  std::map<std::string, JsonColumn> columns_;
  std::vector<std::string> order_;
  std::vector<Frame> frames_;
  int num_lists_ = 0;
  std::size_t offset_ = 0;
};

// NaN and Infinity, which some writers leave outside of texts, as null.
std::string without_words_for_missing(std::string text) {
  if (text.find("NaN") == text.npos && text.find("Infinity") == text.npos) return text;
  std::string mended;
  bool is_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view rest = std::string_view(text).substr(i);
    const std::size_t length = is_text                         ? 0
                               : rest.starts_with("NaN")       ? 3
                               : rest.starts_with("Infinity")  ? 8
                               : rest.starts_with("-Infinity") ? 9
                                                               : 0;
    if (length > 0) {
      mended += "null";
      i += length - 1;
      continue;
    }
    if (text[i] == '\\' && is_text && i + 1 < text.size())
      mended += text[i++];
    else if (text[i] == '"')
      is_text = !is_text;
    mended += text[i];
  }
  return mended;
}

// A record a line: another begins in the line behind the first.
bool is_in_lines(std::string_view text) {
  const auto end = text.find('\n');
  if (end == text.npos) return false;
  const auto first = trimmed(text.substr(0, end));
  const auto next = text.find_first_not_of(" \t\r\n", end);
  return next != text.npos && !first.empty() &&
         ((first.back() == '}' && text[next] == '{') || (first.back() == ']' && text[next] == '['));
}

void parse(const std::string& text, JsonColumns& columns, const std::string& name) {
  const auto parse_one = [&](std::string_view piece) {
    if (!nlohmann::json::sax_parse(piece.begin(), piece.end(), &columns))
      throw Fault(FaultKind::input, "json.depth",
                  fmt::format("{}: is nested too deeply or has too many keys for a table", name));
  };
  if (!is_in_lines(text)) return parse_one(text);
  columns.begin_lines();
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    const std::string_view line = std::string_view(text).substr(at, end - at);
    columns.begin_line(at);
    if (!trimmed(line).empty()) parse_one(line);
    at = end + 1;
  }
}

std::string joined_path(std::string path) {
  std::replace(path.begin(), path.end(), key_mark, '.');
  return path.empty() ? "" : path.substr(1);
}

void add_column(const std::string& path, JsonColumn& column, ArrayContents& contents) {
  if (column.num_records && column.values.size() < *column.num_records)
    column.values.resize(*column.num_records, json_missing);
  const std::string whole = joined_path(path);
  const auto mark = path.rfind(key_mark);
  const std::string group = mark == path.npos || mark == 0 ? "" : whole.substr(0, mark);
  FileArray array{.group = group, .name = whole.substr(group.size()), .kind = "numbers", .values = ValueKind::doubles};
  if (column.is_time) array.unit = "s";
  const std::size_t size = column.values.size();
  if (column.has_text || column.is_uneven) {
    array.values = ValueKind::none;
    array.kind = column.has_text ? "text" : "lists of several lengths";
  }
  if (column.is_listed) array.shape = {static_cast<std::int64_t>(column.width > 0 ? size / column.width : size)};
  if (column.width > 0) array.shape.push_back(static_cast<std::int64_t>(column.width));
  const auto values = std::make_shared<const std::vector<double>>(std::move(column.values));
  const auto bytes = [values](std::uint64_t offset, std::size_t) {
    return reinterpret_cast<const char*>(values->data()) + offset;
  };
  constexpr std::uint64_t each = sizeof(double);
  std::vector<std::uint64_t> shape, steps;
  for (std::size_t i = 0; i < array.shape.size(); ++i) {
    if (array.shape[i] == 1) continue;
    shape.push_back(static_cast<std::uint64_t>(array.shape[i]));
    steps.push_back(i == 0 ? each * std::max<std::size_t>(column.width, 1) : each);
  }
  if (array.values != ValueKind::none) array.read = strided({}, shape, steps, 0, bytes);
  if (column.has_text) array.texts = std::move(column.texts);
  contents.arrays.push_back(std::move(array));
}

}  // namespace

std::unique_ptr<SampleSource> open_json_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  const auto size = static_cast<double>(file->size());
  require_memory(file->name(), 2.0 * size, options.max_memory_bytes);
  const std::string text = without_words_for_missing(file->text(0, static_cast<std::size_t>(file->size())));
  constexpr double bytes_each = 16.0;  // of a number, in a list that grows
  const auto commas = static_cast<double>(std::count(text.begin(), text.end(), ','));
  require_memory(file->name(), 2.0 * size + bytes_each * commas, options.max_memory_bytes);
  JsonColumns columns(file->name());
  parse(text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text, columns, file->name());
  ArrayContents contents{.container = "JSON", .prefix = "json"};
  for (const std::string& path : columns.order()) add_column(path, columns.columns()[path], contents);
  return open_arrays(std::move(file), std::move(contents), options);
}

}  // namespace dsp
