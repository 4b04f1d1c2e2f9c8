#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace support {

/// A function of time as a data set 58 of the universal file format, laid out column by column as its description has
/// it [SDRC]: 6E13.5 and 4E20.12 for even steps, pairs for uneven ones, and the same numbers as bytes in 58b.
struct Uff {
  std::vector<double> values;
  double step_s = 0.01;
  bool is_even = true, is_double = false, is_binary = false, is_big = false;
  std::string name = "NONE", unit = "mm";
  int node = 3, direction = -2, kind = 8, function = 1, over = 17, type = 0;  ///< type 0: real, by is_double

  [[nodiscard]] std::string text() const {
    const std::string numbers = is_binary ? bytes() : lines();
    std::string all = fmt::format("{:6}\n{:6}", -1, 58);
    if (is_binary)
      all += fmt::format("b{:6}{:6}{:12}{:12}{:6}{:6}{:12}{:12}", is_big ? 2 : 1, 2, 11, numbers.size(), 0, 0, 0, 0);
    all += "\nan identity\nNONE\n01-Jan-20 00:00:00\nNONE\nNONE\n";
    all += fmt::format("{:5}{:10}{:5}{:10} {:10}{:10}{:4} {:10}{:10}{:4}\n", function, 0, 0, 0, name, node, direction,
                       "NONE", 0, 0);
    all += fmt::format("{:10}{:10}{:10}{:13.5E}{:13.5E}{:13.5E}\n",
                       type != 0   ? type
                       : is_double ? 4
                                   : 2,
                       values.size(), is_even ? 1 : 0, 0.0, is_even ? step_s : 0.0, 0.0);
    all += axis(over, "time", "s") + axis(kind, "motion", unit) + axis(0, "NONE", "NONE") + axis(0, "NONE", "NONE");
    return all + numbers + fmt::format("{:6}\n", -1);
  }

 private:
  static std::string axis(int code, const std::string& label, const std::string& its_unit) {
    return fmt::format("{:10}{:5}{:5}{:5} {:20} {:20}\n", code, 0, 0, 0, label, its_unit);
  }
  [[nodiscard]] double x(std::size_t i) const { return step_s * static_cast<double>(i); }

  [[nodiscard]] std::string lines() const {
    std::string all;
    const std::size_t in_line = is_double ? (is_even ? 4 : 2) : (is_even ? 6 : 3);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!is_even) all += fmt::format("{:13.5E}", x(i));
      all += is_double ? fmt::format("{:20.12E}", values[i]) : fmt::format("{:13.5E}", values[i]);
      if ((i + 1) % in_line == 0 || i + 1 == values.size()) all += "\n";
    }
    return all;
  }

  template <class Number>
  void append(std::string& all, Number value) const {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (is_big == (std::endian::native == std::endian::little)) std::reverse(raw, raw + sizeof value);
    all.append(raw, sizeof value);
  }
  [[nodiscard]] std::string bytes() const {
    std::string all;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!is_even) append(all, static_cast<float>(x(i)));
      if (is_double)
        append(all, values[i]);
      else
        append(all, static_cast<float>(values[i]));
    }
    return all;
  }
};

/// A data set 164: so many of its units of length make a metre.
inline std::string uff_units(double per_metre) {
  return fmt::format("{:6}\n{:6}\n{:10}{:20}{:10}\n{:25.17E}{:25.17E}{:25.17E}\n{:25.17E}\n{:6}\n", -1, 164, 1,
                     "some units", 2, per_metre, 1.0, 1.0, 273.15, -1);
}

}  // namespace support
