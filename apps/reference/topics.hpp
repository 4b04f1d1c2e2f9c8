#pragma once
#include <string>
#include <vector>

#include "apps/reference/page.hpp"
#include "ident/library/expression.hpp"

// What `ardent help TOPIC` explains beside commands.

namespace apps {

/// Signals that may stand in terms and conditions: those of a body in one row, further channels last.
[[nodiscard]] std::vector<ident::FunctionHelp> signal_help();

[[nodiscard]] Page terms_page();
[[nodiscard]] Page methods_page();
[[nodiscard]] Page files_page();
[[nodiscard]] Page verdict_page();
[[nodiscard]] Page exit_codes_page();

/// All topics: config, sidecar, terms, methods, verdict, files, exit-codes.
[[nodiscard]] std::vector<Page> topic_pages();

}  // namespace apps
