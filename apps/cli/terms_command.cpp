#include "apps/cli/command.hpp"
#include "apps/output/results_json.hpp"
#include "apps/reference/topics.hpp"

namespace apps {
namespace {

void terms(Console& console) {
  console.result(console.json() ? terms_json(signal_help(), ident::expression_functions()) : to_text(terms_page()));
}

}  // namespace

Command terms_command() {
  return {"terms",
          "Names and functions allowed in candidate terms",
          {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}, {"--force"}, {"--threads"}},
          [](CLI::App&) -> CommandBody {
            return [](const GlobalOptions&, Console& console) {
              terms(console);
              return 0;
            };
          },
          help_group,
          {"ardent terms", "ardent terms --json"}};
}

}  // namespace apps
