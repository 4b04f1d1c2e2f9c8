#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace dsp {

/// A reading of a calendar and a clock, as loggers print them.
struct Moment {
  std::optional<std::int64_t> day{};  ///< since 1970-01-01; nothing where no date is printed, or one of unclear order
  double second = 0.0;                ///< since midnight; in UTC where a time zone is printed, then of any sign
  double digit_s = 0.0;               ///< what the last digit printed means; 0: a date alone
  double period_s = 86400.0;          ///< after which `second` begins anew
  [[nodiscard]] bool has_time() const { return digit_s > 0.0; }
};

/// Reads "2026-11-20T10:00:00.123+01:00", "20261120T100000.123Z", "20.11.2026 10:00:00,123", "20-Nov-2026
/// 10:00:00.123" (months in five languages), "2026/11/20 10:00:00", "2026-11-20 10.00.00,123", "11/20/2026 10:00:00 AM"
/// (a date of this kind has no clear order of day and month), "10:00:00.123" (hours may go beyond 24), "10:00:00:123",
/// "1.10:00:00.123" (days before hours), "00:12.3" (minutes and seconds, as spreadsheets print them) and dates alone.
/// Blanks and quotes around it are dropped. Nothing where it is none of these.
[[nodiscard]] std::optional<Moment> parse_moment(std::string_view text);

/// Makes moments of one record, in their order, seconds since the midnight before the first. Where no date is printed a
/// step back by more than half a period is the beginning of the next.
class MomentClock {
 public:
  double seconds(const Moment& moment);
  /// Of the first moment, where it has a date: the midnight that seconds are counted from.
  [[nodiscard]] const std::optional<std::int64_t>& first_day() const& { return first_day_; }
  void first_day() const&& = delete;

 private:
  std::optional<Moment> last_;
  std::optional<std::int64_t> first_day_{};
  double begun_s_ = 0.0;  // of the present period
};

}  // namespace dsp
