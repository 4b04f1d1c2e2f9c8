#pragma once
#include <string_view>

// Files of data/paper as they were when the program was built.

namespace apps {

[[nodiscard]] std::string_view paper_tables_text();  ///< all tables, one after the other
[[nodiscard]] std::string_view paper_cases_text();
[[nodiscard]] std::string_view paper_sentences_text();
[[nodiscard]] std::string_view paper_rig_text();

}  // namespace apps
