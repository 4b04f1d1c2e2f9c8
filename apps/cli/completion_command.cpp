#include <memory>

#include "apps/cli/command.hpp"
#include "apps/cli/reference_pages.hpp"

namespace apps {

Command completion_command() {
  const auto shell = std::make_shared<std::string>();
  return {.name = "completion",
          .help = "Prints what a shell needs to complete command lines",
          .group = help_group,
          .unused = {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}, {"--force"}, {"--threads"}},
          .options = {{"SHELL", shell.get(), "bash or zsh.", {.words = {"bash", "zsh"}, .required = true}}},
          .run =
              [shell](const GlobalOptions&, Console& console) {
                console.result(*shell == "bash" ? bash_completion(make_program()) : zsh_completion(make_program()));
                return 0;
              },
          .examples = {"eval \"$(ardent completion bash)\"                # in ~/.bashrc",
                       "ardent completion zsh > ~/.zfunc/_ardent         # in a folder of $fpath"}};
}

}  // namespace apps
