#include "apps/text/rounded.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace apps {
namespace {

/// Power of ten of the last digit that a standard deviation earns, and how many of those it is.
struct LastDigit {
  int power = 0, units = 0;
};

LastDigit last_digit(double std) {
  constexpr double two_digits_to = 35.5;
  int power = static_cast<int>(std::floor(std::log10(std))) - 1;
  double units = std / std::pow(10.0, power);  // two digits
  if (units < two_digits_to && std::round(units) < two_digits_to) return {power, static_cast<int>(std::round(units))};
  units = std / std::pow(10.0, ++power);
  if (const double one = std::round(units); one < 10.0) return {power, static_cast<int>(one)};
  return {power, 10};
}

/// The value without the power of ten, if that is written apart.
std::string digits_of(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.find_first_not_of("-0.") == std::string::npos && text.front() == '-') text.erase(0, 1);
  return text;
}

/// Of a number without a standard deviation, as fmt writes it.
Rounded split(const std::string& text) {
  const std::size_t e = text.find('e');
  return e == std::string::npos ? Rounded{text, 0} : Rounded{text.substr(0, e), std::stoi(text.substr(e + 1))};
}

}  // namespace

Rounded rounded(double value, double std) {
  constexpr int most_zeros = 3;  // behind the point
  if (!std::isfinite(value)) return {"not known", 0};
  if (!std::isfinite(std)) return split(fmt::format("{:.3g}", value));
  if (!(std > 0.0)) return split(fmt::format("{:.6g}", value));
  const LastDigit last = last_digit(std);
  const double size = std::max(std::abs(value), std::pow(10.0, last.power));
  const int leading = static_cast<int>(std::floor(std::log10(size)));
  if (last.power <= 0 && leading >= -most_zeros)
    return {fmt::format("{}({})", digits_of(value, -last.power), last.units), 0};
  const int decimals = std::max(0, leading - last.power), power = last.power + decimals;
  return {fmt::format("{}({})", digits_of(value / std::pow(10.0, power), decimals), last.units), power};
}

std::string with_uncertainty(double value, double std) {
  const Rounded shown = rounded(value, std);
  return shown.power_of_ten == 0 ? shown.digits : fmt::format("{}e{:+03d}", shown.digits, shown.power_of_ten);
}

}  // namespace apps
