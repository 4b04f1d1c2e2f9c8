#include "dsp/io/table_header.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "dsp/io/table_layout.hpp"
#include "dsp/io/units.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

/// What headers call the rate or the step: words without capitals.
struct RateKey {
  std::string_view text;
  bool is_step;
};
constexpr std::array rate_keys{
    RateKey{"sample rate", false},
    RateKey{"sampling rate", false},
    RateKey{"samplerate", false},
    RateKey{"samplingrate", false},
    RateKey{"samples per second", false},
    RateKey{"sampling frequency", false},
    RateKey{"sample frequency", false},
    RateKey{"samplefrequency", false},
    RateKey{"sampling freq", false},
    RateKey{"sample freq", false},
    RateKey{"scan rate", false},
    RateKey{"acquisition rate", false},
    RateKey{"logging rate", false},
    RateKey{"data rate", false},
    RateKey{"rate", false},
    RateKey{"fs", false},
    RateKey{"sr", false},
    RateKey{"srate", false},
    RateKey{"abtastrate", false},
    RateKey{"abtastfrequenz", false},
    RateKey{"fr\xc3\xa9quence d'\xc3\xa9"
            "chantillonnage",
            false},
    RateKey{"frecuencia de muestreo", false},
    RateKey{"taxa de amostragem", false},
    RateKey{"frequenza di campionamento", false},
    RateKey{"sample interval", true},
    RateKey{"sampling interval", true},
    RateKey{"sample period", true},
    RateKey{"sampling period", true},
    RateKey{"sample time", true},
    RateKey{"time step", true},
    RateKey{"time increment", true},
    RateKey{"increment", true},
    RateKey{"x increment", true},
    RateKey{"xincrement", true},
    RateKey{"delta x", true},
    RateKey{"delta t", true},
    RateKey{"dt", true},
    RateKey{"wf increment", true},
    RateKey{"abtastintervall", true},
};

const RateKey* find_rate_key(const std::string& text) {
  const auto* known =
      std::find_if(rate_keys.begin(), rate_keys.end(), [&](const RateKey& key) { return key.text == text; });
  return known == rate_keys.end() ? nullptr : known;
}

// Words in a line of units over a column that counts.
constexpr std::array counting{"sequence", "sample", "samples", "index", "count", "#", "-"};

std::string_view without_brackets(std::string_view text) {
  const bool has = text.size() > 2 && (text.front() == '(' || text.front() == '[');
  return has && (text.back() == ')' || text.back() == ']') ? trimmed(text.substr(1, text.size() - 2)) : text;
}

std::string_view without_mark(std::string_view line) {
  auto text = trimmed(line);
  while (text.starts_with('#') || text.starts_with('%')) text = trimmed(text.substr(1));
  return text;
}

// "200", "200 Hz", "5,0 ms": in Hz as a rate or a step says it.
std::optional<double> rate_of(std::string_view value, std::string_view unit_of_key, const RateName& name,
                              bool decimal_comma) {
  const bool is_step = name.is_step;
  const auto text = unquoted(value);
  const auto end = std::min(text.find_first_not_of("0123456789+-.,eE"), text.size());
  double number = 0.0;
  if (parse_cell(text.substr(0, end), decimal_comma, number) != Cell::number || !(number > 0.0)) return std::nullopt;
  const auto behind = trimmed(text.substr(end)), unit = behind.empty() ? unit_of_key : behind;
  if (!unit.empty() && (!is_unit(unit) || find_unit(unit).si != (is_step ? "s" : "Hz"))) return std::nullopt;
  const double si = number * (unit.empty() ? name.factor : find_unit(unit).factor);
  constexpr double highest_hz = 1e9;
  const double rate_hz = is_step ? 1.0 / si : si;
  if (!(rate_hz <= highest_hz)) return std::nullopt;
  constexpr double exact = 1e-9;
  for (int k = 1; k <= 8; ++k)  // 1/0.016 is 62.5 and not a whole number within the digits printed
    if (std::abs(k * rate_hz - std::round(k * rate_hz)) < exact * rate_hz) return rate_hz;
  return roundest_rate(rate_hz, is_step ? 0.5 * last_digit(text.substr(0, end)) / number : 0.0);
}

std::optional<double> rate_in(std::string_view key, std::string_view value, bool decimal_comma) {
  constexpr std::size_t longest_key = 80;
  auto text = unquoted(key);
  if (text.size() > longest_key) return std::nullopt;
  while (text.ends_with(':') || text.ends_with('=')) text = trimmed(text.substr(0, text.size() - 1));
  const NamedUnit split = split_unit(text);
  const auto name = rate_name(split.base);
  return name ? rate_of(value, split.unit, *name, decimal_comma) : std::nullopt;
}

// A key and its value in two cells, or in one on either side of a colon or an equals sign.
std::optional<double> rate_in(const TableLine& line, const TableStyle& style) {
  const auto text = without_mark(line.text);
  const auto cells = style.cells(text);
  for (std::size_t i = 0; i + 1 < cells.size(); ++i)
    if (const auto rate = rate_in(cells[i], cells[i + 1], style.decimal_comma)) return rate;
  const auto mark = text.find_first_of(":=");
  return mark == text.npos ? std::nullopt : rate_in(text.substr(0, mark), text.substr(mark + 1), style.decimal_comma);
}

// "time [s]   displacement [mm]": names with blanks within, two or a tab between them.
std::vector<std::string_view> between_wide_blanks(std::string_view text) {
  std::vector<std::string_view> cells;
  for (text = trimmed(text); !text.empty();) {
    const auto end = std::min({text.find("  "), text.find('\t'), text.size()});
    cells.push_back(text.substr(0, end));
    text = trimmed(text.substr(end));
  }
  return cells;
}

// "time", "[s]", "x", "(mm)" as "time [s]", "x (mm)". The cells lie in one text.
std::vector<std::string_view> with_brackets_joined(const std::vector<std::string_view>& cells) {
  std::vector<std::string_view> joined;
  for (const std::string_view cell : cells) {
    const bool is_bracket = !joined.empty() && !cell.empty() && (cell.front() == '[' || cell.front() == '(');
    if (is_bracket)
      joined.back() = {joined.back().data(),
                       static_cast<std::size_t>(cell.data() + cell.size() - joined.back().data())};
    else
      joined.push_back(cell);
  }
  return joined;
}

/// A header above the rows, line by line from the last.
class HeaderSearch {
 public:
  HeaderSearch(const std::vector<TableLine>& above, const TableStyle& style) : style_(style) {
    for (const TableLine& line : above) {
      if (line.is_blank()) continue;
      lines_.push_back(&line);
      const std::string_view text = line.is_comment() ? without_mark(line.text) : std::string_view(line.text);
      cells_.push_back(style.cells(text));
      if (style.separator != ' ' || cells_.back().size() == width()) continue;
      for (auto cells : {between_wide_blanks(text), with_brackets_joined(cells_.back())})
        if (cells.size() == width()) cells_.back() = std::move(cells);
    }
  }

  TableHeader read(std::int64_t header_row) {
    int names = -1;
    if (header_row > 0) {
      for (int i = 0; i < size(); ++i)
        if (lines_[at(i)]->number == header_row) names = i;
    } else {
      names = find_names();
    }
    const int units = names >= 0 ? find_units(names) : -1;
    if (names >= 0) {
      if (cells_[at(names)].size() != width() && !is_over_values(names)) {
        found_.misfit = lines_[at(names)];
        return found_;
      }
      found_.names = first_cells(names);
    }
    if (units >= 0) set_units(units);
    for (int i = 0; i < size(); ++i) {
      const auto rate = i == names && !is_over_values(i) ? std::nullopt : rate_at(i);
      if (rate && !found_.rate_hz) found_.rate_hz = rate;
      const bool used = i == names || i == units || rate || lines_[at(i)]->is_comment() || is_over_values(i - 1);
      if (!used && header_row == 0) found_.skipped.push_back(lines_[at(i)]);
    }
    return found_;
  }

 private:
  [[nodiscard]] static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] int size() const { return static_cast<int>(lines_.size()); }
  [[nodiscard]] std::size_t width() const { return static_cast<std::size_t>(style_.num_columns); }

  [[nodiscard]] bool is_number(std::string_view cell) const {
    double value = 0.0;
    return parse_cell(cell, style_.decimal_comma, value) == Cell::number;
  }
  // Words, and not a number among them.
  [[nodiscard]] bool is_words(int i) const {
    const auto& cells = cells_[at(i)];
    return std::none_of(cells.begin(), cells.end(), [&](std::string_view cell) { return is_number(cell); }) &&
           std::any_of(cells.begin(), cells.end(), [](std::string_view cell) { return !unquoted(cell).empty(); });
  }
  // "Time, 1, 2, 3": channels by their numbers, right above the rows.
  [[nodiscard]] bool is_numbered(int i) const {
    const auto& cells = cells_[at(i)];
    return i == size() - 1 && cells.size() > 1 && speaks_of_time(split_unit(unquoted(cells.front())).base) &&
           std::all_of(cells.begin() + 1, cells.end(), [&](std::string_view cell) { return is_number(cell); });
  }
  // Wider than the rows, and over each further cell a number: "X,CH1,Start,Increment" over "s,Volt,-1.0,5e-3".
  [[nodiscard]] bool is_over_values(int i) const {
    if (i < 0 || i + 1 >= size()) return false;
    const auto &keys = cells_[at(i)], &values = cells_[at(i + 1)];
    return keys.size() == values.size() && keys.size() > width() &&
           std::all_of(values.begin() + static_cast<std::ptrdiff_t>(width()), values.end(),
                       [&](std::string_view cell) { return is_number(cell); });
  }

  // The last that is as wide as the rows, not counting one of units; the last remark where no line is.
  int find_names() {
    int remark = -1;
    for (int i = size() - 1; i >= 0; --i) {
      const bool fits = cells_[at(i)].size() == width() && (is_words(i) || is_numbered(i));
      if (lines_[at(i)]->is_comment()) {
        const bool is_over_units = i == size() - 2 && lines_[at(i + 1)]->is_comment() && is_units(i + 1);
        if (fits && is_over_units && is_words(i)) return i;  // "# t x" over "# s mm"
        if (remark < 0 && fits && i == size() - 1) remark = i;
        continue;
      }
      if (fits && is_units(i) && i > 0 && cells_[at(i - 1)].size() == width() && is_words(i - 1)) continue;
      if (fits || is_over_values(i)) {
        found_.misfit = nullptr;
        return i;
      }
      if (is_over_values(i - 1)) continue;
      if (i == size() - 1 && cells_[at(i)].size() > 1 && is_words(i)) found_.misfit = lines_[at(i)];
    }
    return remark;
  }

  [[nodiscard]] static bool is_counting(std::string_view cell) {
    return std::find(counting.begin(), counting.end(), lower(cell)) != counting.end();
  }
  // Units, nothing and words for a count; at least one unit. Under a line of words half of them are enough, or brackets
  // around all: a unit may be unknown.
  [[nodiscard]] bool is_units(int i) const {
    const auto& cells = cells_[at(i)];
    std::size_t known = 0, unknown = 0, bracketed = 0;
    for (std::size_t c = 0; c < std::min(cells.size(), width()); ++c) {
      const auto whole = unquoted(cells[c]), cell = without_brackets(whole);
      if (cell.empty() || is_counting(cell)) continue;
      ++(is_unit(cell) ? known : unknown);
      bracketed += cell != whole ? 1 : 0;
    }
    const bool is_under_words = i > 0 && is_words(i) && cells_[at(i - 1)].size() == width() && is_words(i - 1);
    const bool are_units =
        unknown == 0 ? known > 0 : is_under_words && (bracketed == known + unknown || known >= unknown);
    return are_units && cells.size() >= width();
  }
  [[nodiscard]] int find_units(int names) const {
    if (names + 1 < size() && is_units(names + 1)) return names + 1;
    return names > 0 && is_units(names - 1) ? names - 1 : -1;
  }
  void set_units(int i) {
    for (const auto cell : first_cells(i)) {
      const auto unit = without_brackets(unquoted(cell));
      found_.units.emplace_back(is_unit(unit) ? std::string(unit) : "");
    }
  }
  [[nodiscard]] std::vector<std::string_view> first_cells(int i) const {
    const auto& cells = cells_[at(i)];
    return {cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(std::min(cells.size(), width()))};
  }
  [[nodiscard]] std::optional<double> rate_at(int i) const {
    if (is_over_values(i))
      for (std::size_t c = width(); c < cells_[at(i)].size(); ++c)
        if (const auto rate = rate_in(cells_[at(i)][c], cells_[at(i + 1)][c], style_.decimal_comma)) return rate;
    return rate_in(*lines_[at(i)], style_);
  }

  const TableStyle& style_;
  std::vector<const TableLine*> lines_;
  std::vector<std::vector<std::string_view>> cells_;
  TableHeader found_;
};

}  // namespace

double RateName::rate_hz(double number) const {
  const double si = number * factor, rate_hz = is_step ? 1.0 / si : si;
  return si > 0.0 && std::isnormal(si) && std::isnormal(rate_hz) ? rate_hz : 0.0;
}

std::vector<std::string> words_of_key(std::string_view key) {
  std::vector<std::string> words{""};
  bool was_lower = false;
  for (const char c : key) {
    const bool upper = c >= 'A' && c <= 'Z';
    const bool is_part = upper || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || static_cast<signed char>(c) < 0;
    if (!is_part || (upper && was_lower)) words.emplace_back();
    if (is_part) words.back() += c;
    was_lower = is_part && !upper;
  }
  std::erase(words, "");
  for (std::string& word : words) word = lower(word);
  return words;
}

std::optional<RateName> rate_name(std::string_view text) {
  constexpr std::size_t longest = 80;
  if (text.size() > longest) return std::nullopt;
  if (text == "Ts") return RateName{.is_step = true};  // MATLAB's; ts may be a time stamp
  if (const RateKey* key = find_rate_key(lower(text))) return RateName{.is_step = key->is_step};
  std::vector<std::string> words = words_of_key(text);
  const auto joined = [&] { return fmt::format("{}", fmt::join(words, " ")); };
  if (const RateKey* key = find_rate_key(joined())) return RateName{.is_step = key->is_step};
  if (words.size() < 2 || !is_unit(words.back())) return std::nullopt;
  const Unit unit = find_unit(words.back());
  words.pop_back();
  const RateKey* key = find_rate_key(joined());
  if (key == nullptr || unit.si != (key->is_step ? "s" : "Hz")) return std::nullopt;
  return RateName{.is_step = key->is_step, .factor = unit.factor};
}

TableHeader table_header(const std::vector<TableLine>& above, const TableStyle& style, std::int64_t header_row) {
  return HeaderSearch(above, style).read(header_row);
}

}  // namespace dsp
