#include <cstdio>
#include <memory>
#include <string>

#include "compiler/driver/commands.h"
#include "compiler/driver/man_page.h"
#include "compiler/driver/shell_completion.h"

namespace sightline {

void add_completion_command(CLI::App& app, int& status) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "completion", "Print a script that completes verbs, flags and values in a shell");
  command->footer(
      "Examples:\n"
      "  source <(sightline completion bash)\n"
      "  sightline completion bash > ~/.local/share/bash-completion/completions/sightline\n"
      "  sightline completion zsh > ~/.zfunc/_sightline");
  command->add_option("shell", *shell, "bash or zsh")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh"}));
  command->callback([shell, &app, &status] {
    const CommandTree tree = command_tree(app);
    std::fputs((*shell == "bash" ? bash_completion(tree) : zsh_completion(tree)).c_str(), stdout);
    status = 0;
  });
}

void add_man_command(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand("man", "Print the manual page");
  command->footer(
      "Examples:\n"
      "  sightline man | man -l -\n"
      "  sightline man > ~/.local/share/man/man1/sightline.1");
  command->callback([&app, &status] {
    std::fputs(man_page(command_tree(app), SIGHTLINE_VERSION).c_str(), stdout);
    status = 0;
  });
}

}  // namespace sightline
