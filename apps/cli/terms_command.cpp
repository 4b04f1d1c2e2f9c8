#include "apps/cli/command.hpp"
#include "apps/output/results_json.hpp"
#include "apps/reference/topics.hpp"

namespace apps {

Command terms_command() {
  return {.name = "terms",
          .help = "Names and functions allowed in candidate terms",
          .group = help_group,
          .unused = {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}, {"--force"}, {"--threads"}},
          .run =
              [](const GlobalOptions&, Console& console) {
                console.result(console.json() ? terms_json(signal_help(), ident::expression_functions())
                                              : to_text(terms_page()));
                return 0;
              },
          .examples = {"ardent terms", "ardent terms --json"}};
}

}  // namespace apps
