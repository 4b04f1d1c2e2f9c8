#pragma once
#include <fmt/format.h>

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/settings.hpp"

// The printed numbers of [QZS23] and what is said of them: the files of data/paper, which are part of the program.

namespace apps {

inline constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// The three methods of the paper, in its order.
inline constexpr const char* paper_methods[] = {"fast_rvm", "slow_rvm", "sindy"};

/// A line of one of its tables; data/paper/README.md says what the columns mean.
struct Printed {
  int table = 0;
  std::string row, term, method, quantity;
  double value = missing, tolerance = missing, should_be = missing;  ///< NaN: not there
  std::string remark = {};
};
/// In the order of tables and lines.
[[nodiscard]] const std::vector<Printed>& printed_numbers();
/// NaN: not printed. `row` may be left out where a table has one.
[[nodiscard]] double printed_value(int table, std::string_view term, std::string_view method, std::string_view quantity,
                                   std::string_view row = "a");

[[nodiscard]] const dsp::Settings& paper_cases();      ///< cases.toml
[[nodiscard]] const dsp::Settings& paper_sentences();  ///< sentences.toml
/// An array of texts in them; empty where it is left out.
[[nodiscard]] std::vector<std::string> words_in(const dsp::Settings& settings, std::string_view key);

// The files as they were when the program was built.
[[nodiscard]] std::string_view paper_tables_text();  ///< all tables, one after the other
[[nodiscard]] std::string_view paper_cases_text();
[[nodiscard]] std::string_view paper_sentences_text();
[[nodiscard]] std::string_view paper_rig_text();

/// A sentence of [reason] with these numbers and words, fmt::arg("name", value).
template <class... Arguments>
[[nodiscard]] std::string reason(std::string_view name, const Arguments&... arguments) {
  return fmt::format(fmt::runtime(paper_sentences().table("reason").text(name).value()), arguments...);
}

}  // namespace apps
