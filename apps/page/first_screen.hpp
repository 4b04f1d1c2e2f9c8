#pragma once
#include <optional>
#include <string>
#include <vector>

#include "apps/page/run_results.hpp"

namespace apps {

/// What a reader wants first, in words that terminal and page share.
struct FirstScreen {
  struct Line {
    std::string text;
    bool to_paste = false;   ///< of a file, as it is
    bool is_needed = false;  ///< lines to paste that are of no use cut
  };
  struct Entry {
    std::string label;  ///< none: it is about everything below
    std::vector<Line> lines;
    std::size_t most = 4;  ///< lines of a terminal; what is beyond is in report.html
  };
  std::vector<Entry> entries;

  /// What a page shows before any words.
  struct Answer {
    struct Quantity {
      std::string name, value, unit;  ///< "natural frequency", "1.1254(3)", "Hz"
    };
    std::optional<ident::Verdict> verdict = {};  ///< none: there is no equation
    std::string sentence = {};                   ///< the first of what it rests on
    std::vector<std::string> equations = {};     ///< MathML
    std::string symbols = {};                    ///< what they are: "x in m, f in N"
    std::vector<Quantity> quantities = {};
    std::string accuracy = {};  ///< what all of them share beside their standard deviations
  };
  Answer answer = {};
};

/// The chosen equation, which one that is and whether the other methods agree, the zero of x, its physical terms;
/// whether to trust it; what to mend; which data were used; which recorded inputs are in the equation.
[[nodiscard]] FirstScreen first_screen(const RunResults& results);

/// Columns of a terminal that labels take.
inline constexpr std::size_t label_width = 13;

/// For a terminal: at most 24 lines of at most 100 columns.
[[nodiscard]] std::string to_text(const FirstScreen& screen);

}  // namespace apps
