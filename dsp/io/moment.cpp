#include "dsp/io/moment.hpp"

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>

#include "dsp/values/constants.hpp"

namespace dsp {
namespace {

constexpr double minute_s = 60.0, hour_s = 3600.0;

/// What is not yet read of a text; each call reads one thing, or nothing and says so.
class Rest {
 public:
  explicit Rest(std::string_view text) : text_(text) {}
  [[nodiscard]] bool empty() const { return text_.empty(); }

  bool mark(std::string_view one_of) {
    if (text_.empty() || one_of.find(text_.front()) == std::string_view::npos) return false;
    last_mark_ = text_.front();
    text_.remove_prefix(1);
    return true;
  }
  [[nodiscard]] char last_mark() const { return last_mark_; }

  void blanks() {
    while (mark(" \t")) continue;
  }

  /// `least` to `most` digits.
  bool digits(int least, int most, int& value) {
    int count = 0, read = 0;
    while (count < most && count < static_cast<int>(text_.size()) && text_[count] >= '0' && text_[count] <= '9')
      read = 10 * read + (text_[count++] - '0');
    if (count < least) return false;
    value = read;
    text_.remove_prefix(static_cast<std::size_t>(count));
    return true;
  }

  /// One of `marks` and digits behind it, where there is one. `digit` becomes what the last one means.
  bool fraction(double& value, double& digit, std::string_view marks) {
    value = 0.0;
    digit = 1.0;
    if (!mark(marks)) return true;
    std::size_t count = 0;
    while (count < text_.size() && text_[count] >= '0' && text_[count] <= '9') ++count;
    constexpr std::size_t most = 15;
    if (count == 0 || count > most) return false;
    double whole = 0.0;
    (void)std::from_chars(text_.data(), text_.data() + count, whole);
    digit = std::pow(10.0, -static_cast<double>(count));
    value = whole / std::pow(10.0, static_cast<double>(count));
    text_.remove_prefix(count);
    return true;
  }

  void letters() {
    while (!text_.empty() && ((text_[0] >= 'a' && text_[0] <= 'z') || (text_[0] >= 'A' && text_[0] <= 'Z')))
      text_.remove_prefix(1);
  }

  bool word(std::string_view upper) {
    if (text_.size() < upper.size()) return false;
    for (std::size_t i = 0; i < upper.size(); ++i)
      if ((text_[i] >= 'a' ? text_[i] - 'a' + 'A' : text_[i]) != upper[i]) return false;
    text_.remove_prefix(upper.size());
    return true;
  }

 private:
  std::string_view text_;
  char last_mark_ = 0;
};

std::string_view bare(std::string_view text) {
  constexpr std::string_view dropped = " \t\r\"";
  const auto from = text.find_first_not_of(dropped);
  return from == text.npos ? "" : text.substr(from, text.find_last_not_of(dropped) + 1 - from);
}

bool set_day(Moment& moment, int year, int month, int day) {
  const std::chrono::year_month_day date{std::chrono::year{year}, std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return false;
  moment.day = std::chrono::sys_days(date).time_since_epoch().count();
  return true;
}

struct MonthName {
  std::string_view beginning;  // without accents and in capitals: English, German, French, Spanish, Portuguese
  int month;
};
constexpr std::array month_names{MonthName{"JAN", 1},  MonthName{"ENE", 1},  MonthName{"FEB", 2},  MonthName{"FEV", 2},
                                 MonthName{"MAR", 3},  MonthName{"MRZ", 3},  MonthName{"APR", 4},  MonthName{"AVR", 4},
                                 MonthName{"ABR", 4},  MonthName{"MAY", 5},  MonthName{"MAI", 5},  MonthName{"JUN", 6},
                                 MonthName{"JUIN", 6}, MonthName{"JUIL", 7}, MonthName{"JUL", 7},  MonthName{"AUG", 8},
                                 MonthName{"AGO", 8},  MonthName{"SEP", 9},  MonthName{"SET", 9},  MonthName{"OCT", 10},
                                 MonthName{"OKT", 10}, MonthName{"OUT", 10}, MonthName{"NOV", 11}, MonthName{"DEC", 12},
                                 MonthName{"DEZ", 12}, MonthName{"DIC", 12}};

/// "03-Nov-2022", "3 November 2022".
bool read_named_date(Rest& rest, Moment& moment) {
  int day = 0, month = 0, year = 0;
  if (!rest.digits(1, 2, day) || !rest.mark("-. /")) return false;
  rest.blanks();
  for (const MonthName& name : month_names)
    if (month == 0 && rest.word(name.beginning)) month = name.month;
  rest.letters();
  if (month == 0 || !rest.mark("-. /")) return false;
  rest.blanks();
  return rest.digits(4, 4, year) && set_day(moment, year, month, day);
}

/// 20261120T with what is behind it, 2026-11-20, 2026/11/20, 20.11.2026, 11/20/2026, 20-Nov-2026.
bool read_date(Rest& rest, Moment& moment) {
  int first = 0, second = 0, third = 0;
  Rest from_year = rest, joined = rest;
  if (joined.digits(4, 4, first) && joined.digits(2, 2, second) && joined.digits(2, 2, third) && joined.mark("T")) {
    rest = joined;
    return set_day(moment, first, second, third);
  }
  if (from_year.digits(4, 4, first) && from_year.mark("-/.")) {
    const char mark = from_year.last_mark();
    if (!from_year.digits(1, 2, second) || !from_year.mark({&mark, 1}) || !from_year.digits(1, 2, third)) return false;
    rest = from_year;
    return set_day(moment, first, second, third);
  }
  if (Rest named = rest; read_named_date(named, moment)) {
    rest = named;
    return true;
  }
  if (!rest.digits(1, 2, first) || !rest.mark("./-")) return false;
  const char mark = rest.last_mark();
  if (!rest.digits(1, 2, second) || !rest.mark({&mark, 1}) || !rest.digits(4, 4, third)) return false;
  if (mark == '.') return set_day(moment, third, second, first);
  return first >= 1 && second >= 1 && first <= 31 && second <= 31;  // of day and month, which is which?
}

/// 10:00:00.123, 10:00:00:123, 12.3 behind minutes; behind a date 10.00.00,123 and 100000.123, too.
bool read_time(Rest& rest, Moment& moment, bool has_date) {
  int first = 0, second = 0, third = 0;
  double fraction = 0.0;
  Rest joined = rest, dotted = rest;
  const bool is_joined = has_date && joined.digits(2, 2, first) && joined.digits(2, 2, second) && second < 60 &&
                         joined.digits(2, 2, third);
  const bool is_dotted = !is_joined && has_date && dotted.digits(2, 2, first) && dotted.mark(".") &&
                         dotted.digits(2, 2, second) && second < 60 && dotted.mark(".") && dotted.digits(2, 2, third);
  bool with_hours = is_joined || is_dotted;
  if (with_hours) {
    rest = is_joined ? joined : dotted;
  } else {
    third = 0;
    if (!rest.digits(1, 3, first) || !rest.mark(":") || !rest.digits(2, 2, second) || second >= 60) return false;
    with_hours = rest.mark(":");
    if (with_hours && !rest.digits(2, 2, third)) return false;
  }
  if (!rest.fraction(fraction, moment.digit_s, with_hours ? ".,:" : ".,") || third > 60) return false;
  if (!with_hours && moment.digit_s == 1.0) return false;  // hours and minutes are no time of a sample
  moment.second =
      with_hours ? first * hour_s + second * minute_s + (third + fraction) : first * minute_s + (second + fraction);
  if (!with_hours) moment.period_s = hour_s;
  Rest half = rest;
  half.blanks();
  for (const auto& [word, noon_s] : {std::pair{"AM", 0.0}, std::pair{"PM", 0.5 * day_s}})
    if (half.word(word)) {
      if (!with_hours || first < 1 || first > 12) return false;
      moment.second = std::fmod(moment.second, 0.5 * day_s) + noon_s;
      rest = half;
      return true;
    }
  return true;
}

/// Z, +01:00, -0530, +01.
bool read_zone(Rest& rest, Moment& moment) {
  rest.blanks();
  if (rest.empty() || rest.word("Z") || rest.word("UTC")) return true;
  if (!rest.mark("+-")) return false;
  const double sign = rest.last_mark() == '+' ? 1.0 : -1.0;
  int hours = 0, minutes = 0;
  if (!rest.digits(2, 2, hours)) return false;
  (void)rest.mark(":");
  if (!rest.empty() && !rest.digits(2, 2, minutes)) return false;
  moment.second -= sign * (hours * hour_s + minutes * minute_s);
  return true;
}

}  // namespace

std::optional<Moment> parse_moment(std::string_view text) {
  Rest rest(bare(text));
  Moment moment;
  Rest date = rest;
  const bool has_date = read_date(date, moment);
  if (has_date) {
    rest = date;
    if (rest.empty()) return moment;
    if (rest.last_mark() != 'T' && !rest.mark("Tt_") && !rest.mark(" ")) return std::nullopt;
    rest.blanks();
  }
  int days = 0;
  if (Rest span = rest; !has_date && span.digits(1, 4, days) && span.mark(".")) {
    if (!read_time(span, moment, false) || !span.empty()) return std::nullopt;
    moment.second += days * day_s;
    return moment;
  }
  if (!read_time(rest, moment, has_date) || !read_zone(rest, moment) || !rest.empty()) return std::nullopt;
  return moment;
}

double MomentClock::seconds(const Moment& moment) {
  if (!last_) first_day_ = moment.day;
  if (moment.day) {
    begun_s_ = static_cast<double>(*moment.day - first_day_.value_or(0)) * day_s;
  } else if (last_ && moment.second < last_->second - 0.5 * moment.period_s) {
    begun_s_ += moment.period_s;
  }
  last_ = moment;
  return begun_s_ + moment.second;
}

}  // namespace dsp
