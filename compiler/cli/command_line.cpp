#include "compiler/cli/command_line.h"

#include <cstdio>

#include "compiler/cli/console/console.h"
#include "compiler/cli/file_kind.h"
#include "compiler/cli/help_text.h"
#include "compiler/cli/parse_command_line.h"

namespace sightline {
namespace {

// --help, --version, or a flag that needs a verb before it.
Result<int> run_without_verb(const Program& program, const std::string& flag) {
  if (asks_for_help({flag})) {
    std::fputs(help_text(program).c_str(), stdout);
    return 0;
  }
  if (flag == "--version") {
    std::printf("%s %s\n%s", program.name.c_str(), program.version.c_str(), program.build.c_str());
    return 0;
  }
  return unknown("flag " + flag + " stands before the verb", flag, {"--help", "--version"},
                 program.name);
}

Result<int> run_words(const Program& program, const std::vector<std::string>& words) {
  const std::string& name = words.front();
  if (name.starts_with('-')) return run_without_verb(program, name);
  const Verb* const verb = find_verb(program, name);
  if (verb == nullptr) {
    return unknown("unknown verb '" + name + "'", name, verb_names(program), program.name);
  }
  const std::string command = program.name + " " + name;
  const std::vector<std::string> rest(words.begin() + 1, words.end());
  if (asks_for_help(rest)) {
    std::fputs(help_text(command, *verb).c_str(), stdout);
    return 0;
  }
  SIGHTLINE_TRY(parse_words(command, *verb, rest));
  return verb->run();
}

}  // namespace

int run_command_line(const Program& program, const std::vector<std::string>& words) {
  if (words.empty()) {
    std::fputs(help_text(program).c_str(), stderr);
    return exit_status(ErrorCode::kBadArgument);
  }
  const Result<int> status = run_words(program, words);
  return status ? *status : report_error(explain_wrong_file(status.error()));
}

}  // namespace sightline
