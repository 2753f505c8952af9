#include <cstdio>
#include <memory>
#include <string>

#include "compiler/cli/help_text.h"
#include "compiler/cli/man_page.h"
#include "compiler/cli/shell_completion.h"
#include "compiler/commands/commands.h"

// The verbs that speak of the command line itself.

namespace sightline {
namespace {

void print_help(const std::string& name) {
  const Program program = sightline_program();
  const Verb* const verb = find_verb(program, name);
  const std::string text =
      verb == nullptr ? help_text(program) : help_text(program.name + " " + name, *verb);
  std::fputs(text.c_str(), stdout);
}

}  // namespace

Verb completion_verb() {
  const auto shell = std::make_shared<std::string>();
  Verb verb;
  verb.name = "completion";
  verb.summary = "Print a script that completes verbs, flags and values in a shell";
  verb.examples = {
      "source <(sightline completion bash)",
      "sightline completion bash > ~/.local/share/bash-completion/completions/sightline",
      "sightline completion zsh > ~/.zfunc/_sightline"};
  verb.positionals = {{.name = "SHELL",
                       .help = "Which shell reads the script",
                       .target = shell.get(),
                       .choices = {"bash", "zsh"}}};
  verb.run = [shell]() -> Result<int> {
    const Program program = sightline_program();
    const std::string script =
        *shell == "bash" ? bash_completion(program) : zsh_completion(program);
    std::fputs(script.c_str(), stdout);
    return 0;
  };
  return verb;
}

Verb man_verb() {
  Verb verb;
  verb.name = "man";
  verb.summary = "Print the manual page";
  verb.examples = {"sightline man | man -l -",
                   "sightline man > ~/.local/share/man/man1/sightline.1"};
  verb.run = []() -> Result<int> {
    std::fputs(man_page(sightline_program()).c_str(), stdout);
    return 0;
  };
  return verb;
}

Verb help_verb(std::vector<std::string> verbs) {
  verbs.emplace_back("help");
  const auto name = std::make_shared<std::string>();
  Verb verb;
  verb.name = "help";
  verb.summary = "Explain a verb with examples, or list all verbs";
  verb.details = "`sightline help VERB` prints the same as `sightline VERB --help`.";
  verb.examples = {"sightline help", "sightline help compile"};
  verb.positionals = {{.name = "VERB",
                       .help = "The verb to explain",
                       .target = name.get(),
                       .choices = verbs,
                       .is_required = false}};
  verb.run = [name]() -> Result<int> {
    print_help(*name);
    return 0;
  };
  return verb;
}

}  // namespace sightline
