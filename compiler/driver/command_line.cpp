#include "compiler/driver/command_line.h"

#include <algorithm>
#include <cstdio>

#include "compiler/driver/command_tree.h"
#include "compiler/driver/console.h"
#include "compiler/pipeline/options.h"

namespace sightline {
namespace {

constexpr const char* kWhereToBegin =
    "sightline compiles recorded drives into a map that tells a vehicle how far it must look at "
    "each place.\n\n"
    "Begin with a folder of recordings:\n"
    "  sightline init recordings/ -o drive.yaml       look at them, write a configuration\n"
    "  sightline compile drive.yaml -o drive.slmap    make the map\n"
    "  sightline inspect drive.slmap                  what the map says of itself\n\n";

int show_where_to_begin(const CommandTree& tree) {
  std::fputs(kWhereToBegin, stderr);
  std::fputs("Verbs:\n", stderr);
  for (const CommandVerb& verb : tree.verbs) {
    std::fprintf(stderr, "  %-12s %s\n", verb.name.c_str(), verb.summary.c_str());
  }
  std::fputs("\n`sightline VERB --help` explains a verb with examples, `sightline man | man -l -` "
             "all of them.\n", stderr);
  return exit_status(ErrorCode::kBadArgument);
}

int refuse(const std::string& what, const std::string& nearest, const std::string& help) {
  const std::string hint =
      nearest.empty() ? "`" + help + " --help` lists them" : "did you mean '" + nearest + "'?";
  return report_error({ErrorCode::kBadArgument, what + "; " + hint, "", ""});
}

std::vector<std::string> long_names(const CommandVerb& verb) {
  std::vector<std::string> names;
  for (const CommandFlag& flag : verb.flags) {
    std::ranges::copy_if(flag.names, std::back_inserter(names),
                         [](const std::string& name) { return name.starts_with("--"); });
  }
  return names;
}

// The first word that begins like a flag and is none; empty where there is no such.
std::string unknown_flag(const std::vector<std::string>& words, const CommandVerb& verb) {
  const std::vector<std::string> known = long_names(verb);
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    if (name == "--") break;
    if (name.starts_with("--") && std::ranges::find(known, name) == known.end()) return name;
  }
  return "";
}

}  // namespace

int run_command_line(CLI::App& app, int argc, char** argv, const int& status) {
  const CommandTree tree = command_tree(app);
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.empty()) return show_where_to_begin(tree);
  const auto verb = std::ranges::find(tree.verbs, words.front(), &CommandVerb::name);
  if (verb == tree.verbs.end() && !words.front().starts_with('-')) {
    std::vector<std::string> names;
    for (const CommandVerb& known : tree.verbs) names.push_back(known.name);
    return refuse("unknown verb '" + words.front() + "'", nearest_name(words.front(), names),
                  "sightline");
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ExtrasError& error) {
    const std::string flag = verb == tree.verbs.end() ? "" : unknown_flag(words, *verb);
    if (flag.empty()) {
      app.exit(error);
      return exit_status(ErrorCode::kBadArgument);
    }
    return refuse("unknown flag " + flag, nearest_name(flag, long_names(*verb)),
                  "sightline " + verb->name);
  } catch (const CLI::ParseError& error) {
    // Asking for help is no failure; all else the parser finds is usage.
    const int parsed = app.exit(error);
    return parsed == 0 ? 0 : exit_status(ErrorCode::kBadArgument);
  }
  return status;
}

}  // namespace sightline
