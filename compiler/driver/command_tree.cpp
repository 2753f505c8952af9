#include "compiler/driver/command_tree.h"

#include <sstream>

namespace sightline {
namespace {

// CLI11 tells choices only in the name of a type: "TEXT:{csv,json}".
std::vector<std::string> choices_in(const std::string& type) {
  std::vector<std::string> choices;
  const std::size_t open = type.find(":{");
  const std::size_t close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return choices;
  std::istringstream list(type.substr(open + 2, close - open - 2));
  for (std::string choice; std::getline(list, choice, ',');) choices.push_back(choice);
  return choices;
}

std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

void add_option(const CLI::Option& option, std::vector<CommandFlag>& flags,
                std::vector<CommandArgument>* arguments) {
  if (option.get_group().empty()) return;
  const std::string type = option.get_type_name();
  if (option.nonpositional()) {
    CommandFlag flag{names_of(option), option.get_description(), "", choices_in(type)};
    if (option.get_items_expected_max() > 0) flag.value = type.substr(0, type.find(':'));
    flags.push_back(std::move(flag));
  } else if (arguments != nullptr) {
    arguments->push_back({option.get_name(/*positional=*/true), option.get_description(),
                          choices_in(type), option.get_required(),
                          option.get_items_expected_max() > 1});
  }
}

}  // namespace

CommandTree command_tree(const CLI::App& app) {
  CommandTree tree;
  tree.name = app.get_name();
  tree.summary = app.get_description();
  for (const CLI::Option* option : app.get_options()) add_option(*option, tree.flags, nullptr);
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_group().empty()) continue;
    CommandVerb& verb = tree.verbs.emplace_back();
    verb.name = command->get_name();
    verb.summary = command->get_description();
    verb.footer = command->get_footer();
    for (const CLI::Option* option : command->get_options()) {
      add_option(*option, verb.flags, &verb.arguments);
    }
  }
  return tree;
}

}  // namespace sightline
