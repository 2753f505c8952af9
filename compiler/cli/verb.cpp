#include "compiler/cli/verb.h"

#include <algorithm>
#include <iterator>
#include <sstream>

namespace sightline {
namespace {

Flag help_flag() { return {.names = "-h,--help", .help = "Print this help"}; }

}  // namespace

Result<int> exit_status_of(const Result<void>& done) {
  if (!done) return done.error();
  return 0;
}

std::vector<std::string> names_of(const Flag& flag) {
  std::vector<std::string> names;
  std::istringstream list(flag.names);
  for (std::string name; std::getline(list, name, ',');) names.push_back(name);
  return names;
}

std::string long_name(const Flag& flag) { return names_of(flag).back(); }

bool takes_value(const Flag& flag) { return !flag.value.empty(); }

std::size_t values_each(const Flag& flag) {
  if (flag.value.empty()) return 0;
  return 1 + static_cast<std::size_t>(std::ranges::count(flag.value, ' '));
}

bool is_list(const FlagTarget& target) {
  return std::holds_alternative<std::vector<std::string>*>(target);
}

std::vector<Flag> shown_flags(const Verb& verb) {
  std::vector<Flag> shown;
  std::ranges::copy_if(verb.flags, std::back_inserter(shown),
                       [](const Flag& flag) { return !flag.is_hidden; });
  shown.push_back(help_flag());
  return shown;
}

std::vector<Flag> flags_without_verb() {
  return {help_flag(), {.names = "--version", .help = "Print the version of the program"}};
}

std::vector<std::string> verb_names(const Program& program) {
  std::vector<std::string> names;
  for (const Verb& verb : program.verbs) names.push_back(verb.name);
  return names;
}

const Verb* find_verb(const Program& program, const std::string& name) {
  const auto verb = std::ranges::find(program.verbs, name, &Verb::name);
  return verb == program.verbs.end() ? nullptr : &*verb;
}

}  // namespace sightline
