#include <memory>

#include "apps/cli/command.hpp"
#include "apps/cli/reference_pages.hpp"

namespace apps {

Command completion_command() {
  return {"completion",
          "Prints what a shell needs to complete command lines",
          {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}, {"--force"}, {"--threads"}},
          [](CLI::App& command) -> CommandBody {
            auto shell = std::make_shared<std::string>();
            command.add_option("SHELL", *shell, "bash or zsh.")->required()->check(CLI::IsMember({"bash", "zsh"}));
            const CLI::App* root = command.get_parent();
            return [=](const GlobalOptions&, Console& console) {
              console.result(*shell == "bash" ? bash_completion(*root) : zsh_completion(*root));
              return 0;
            };
          },
          help_group,
          {"eval \"$(ardent completion bash)\"                # in ~/.bashrc",
           "ardent completion zsh > ~/.zfunc/_ardent         # in a folder of $fpath"}};
}

}  // namespace apps
