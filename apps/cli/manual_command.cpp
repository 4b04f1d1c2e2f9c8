#include "apps/cli/command.hpp"
#include "apps/cli/reference_pages.hpp"
#include "apps/output/output_folder.hpp"

namespace apps {

/// Of the build: man/man1, man/man5 and completion scripts, for `cmake --install`. Not shown to users.
Command manual_command() {
  return {.name = "manual",
          .help = "Writes manual pages and completion scripts",
          .unused = {{"--seed"}, {"--dry-run"}, {"--set"}, {"--threads"}},
          .run = [](const GlobalOptions& global, Console&) {
            const Program program = make_program();
            OutputFolder folder(required_output(global, "manual"), global.force);
            for (const auto& [name, text] : manual_pages(program))
              folder.write("man/man" + name.substr(name.size() - 1) + "/" + name, text);
            folder.write("bash-completion/completions/ardent", bash_completion(program));
            folder.write("zsh/vendor-completions/_ardent", zsh_completion(program));
            folder.commit(begin_manifest("manual", global.command_line, global.seed, folder.destination()));
            return 0;
          }};
}

}  // namespace apps
