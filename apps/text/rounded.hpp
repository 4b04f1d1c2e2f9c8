#pragma once
#include <string>

namespace apps {

/// A value as it is printed: "-9.74(11)" times ten to the 4.
struct Rounded {
  std::string digits;
  int power_of_ten = 0;
};

/// The digits that a standard deviation earns, and that in units of the last one: "-50.0(2)" would be right from -50.05
/// to -49.95. The standard deviation has two digits where they are 10 to 35, else one, so that rounding changes it by a
/// seventh at most. Powers of ten are written apart where the last digit would otherwise stand before the point, or
/// behind more than three zeros. Without a standard deviation (NaN) three digits and no bracket, with one of zero six.
[[nodiscard]] Rounded rounded(double value, double std);
/// The same in one word: "-9.74(11)e+04"; "not known" for NaN.
[[nodiscard]] std::string with_uncertainty(double value, double std);

}  // namespace apps
