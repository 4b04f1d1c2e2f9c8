#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/table_style.hpp"

namespace dsp {

/// What lines above the rows of a table say.
struct TableHeader {
  std::vector<std::string_view> names{};  ///< cells, as many as columns; empty: none
  std::vector<std::string> units{};       ///< likewise, empty where there is no line of them
  std::optional<double> rate_hz{};
  std::vector<const TableLine*> skipped{};  ///< lines of which nothing was taken
  const TableLine* misfit = nullptr;  ///< the line above the rows, where it has several words and not as many as they
};

/// What files call the step between samples or their rate: "Sampling rate", "fs", "sampleRateHz", "dt_ms".
struct RateName {
  bool is_step = false;
  double factor = 1.0;  ///< of the unit at its end, to s or Hz
  /// Of a number so called; 0 where it is none: not positive, or not finite either way.
  [[nodiscard]] double rate_hz(double number) const;
};
/// Nothing where a text is neither.
[[nodiscard]] std::optional<RateName> rate_name(std::string_view text);

/// Of a key, without capitals: "sampleRate_Hz" is sample, rate, hz.
[[nodiscard]] std::vector<std::string> words_of_key(std::string_view key);

/// `above`: the lines before the first row; the names are in line number `header_row` where that is not 0.
[[nodiscard]] TableHeader table_header(const std::vector<TableLine>& above, const TableStyle& style,
                                       std::int64_t header_row);

}  // namespace dsp
