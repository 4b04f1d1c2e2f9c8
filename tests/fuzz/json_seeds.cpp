#include <fmt/format.h>

#include "fuzz/harness.hpp"

std::vector<std::string> fuzz::seeds() {
  std::string times, values, records, rows, lines;
  for (int i = 0; i < 12; ++i) {
    const std::string comma = i > 0 ? "," : "", time = fmt::format("{}", 0.004 * i),
                      value = fmt::format("{}", i * i % 7);
    times += comma + time;
    values += comma + value;
    records += fmt::format("{}{{\"t\": {}, \"x_mm\": {}}}", comma, time, value);
    rows += fmt::format("{}[{}, {}]", comma, time, value);
    lines += fmt::format("{{\"t\": {}, \"x_mm\": {}}}\n", time, value);
  }
  return {fmt::format("{{\"t\": [{}], \"x_mm\": [{}], \"note\": \"a\\u00e9b\"}}", times, values), "[" + records + "]",
          fmt::format("{{\"columns\": [\"t\", \"x_mm\"], \"data\": [{}]}}", rows), lines,
          fmt::format("{{\"dt\": 4e-3, \"run\": {{\"x_mm\": [{}], \"y\": [NaN, null]}}}}", values)};
}
