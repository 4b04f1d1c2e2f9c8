#include "dsp/io/clock_start.hpp"

#include <fmt/chrono.h>

#include <chrono>
#include <cmath>

#include "dsp/values/constants.hpp"

namespace dsp {
double ClockStart::until(const ClockStart& other) const {
  const double days = day && other.day ? static_cast<double>(*other.day - *day) : 0.0;
  return days * day_s + (other.s - s);
}

std::string to_string(const ClockStart& start) {
  if (!start.day) return fmt::format("{} s", start.s);
  const double microseconds = std::round(1e6 * start.s);  // a time zone may have put them before midnight
  const std::chrono::sys_time<std::chrono::microseconds> moment =
      std::chrono::sys_days(std::chrono::days(*start.day)) +
      std::chrono::microseconds(static_cast<std::int64_t>(microseconds));
  const auto seconds = std::chrono::floor<std::chrono::seconds>(moment);
  std::string text = fmt::format("{:%Y-%m-%d %H:%M:%S}", fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)));
  if (const auto rest = (moment - seconds).count(); rest > 0) {
    text += fmt::format(".{:06}", rest);
    text.erase(text.find_last_not_of('0') + 1);
  }
  return text;
}

}  // namespace dsp
