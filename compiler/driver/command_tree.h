#pragma once

#include <string>
#include <vector>

#include "compiler/driver/commands.h"

// The command line as plain data, read off CLI11: completions and the manual page are made of it, so
// they cannot miss a flag.

namespace sightline {

struct CommandFlag {
  std::vector<std::string> names;  // "-o", "--output"
  std::string help;
  std::string value;                 // what it takes, "TEXT"; empty: nothing
  std::vector<std::string> choices;  // empty: anything
};

struct CommandArgument {
  std::string name;
  std::string help;
  std::vector<std::string> choices;
  bool is_required = false;
  bool is_list = false;
};

struct CommandVerb {
  std::string name;
  std::string summary;
  std::string footer;  // what --help says below the flags, examples last
  std::vector<CommandFlag> flags;
  std::vector<CommandArgument> arguments;
};

struct CommandTree {
  std::string name;
  std::string summary;
  std::vector<CommandFlag> flags;
  std::vector<CommandVerb> verbs;  // in the order in which they were added
};

// Without what is hidden.
CommandTree command_tree(const CLI::App& app);

}  // namespace sightline
