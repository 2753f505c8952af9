#include "compiler/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "compiler/cli/console/console.h"
#include "compiler/cli/file_kind.h"
#include "compiler/cli/help_text.h"
#include "compiler/cli/quoted_place.h"
#include "compiler/cli/verb.h"
#include "passes/pass/options.h"

// The one file that talks to CLI11, which splits the words into flags, values and positionals. What
// they mean and every message is ours.

namespace sightline {
namespace {

Error bad_argument(const std::string& message) { return {ErrorCode::kBadArgument, message}; }

// bad-argument: "WHAT; did you mean 'NEAR'?" or, where no known name is near, where to read on.
Error unknown(const std::string& what, const std::string& name,
              const std::vector<std::string>& known, const std::string& command) {
  const std::string near = nearest_name(name, known);
  return bad_argument(concat(
      what, "; ",
      (near.empty() ? "`" + command + " --help` lists them" : "did you mean '" + near + "'?")));
}

const Flag* find_flag(const Verb& verb, const std::string& name) {
  const auto flag = std::ranges::find_if(verb.flags, [&](const Flag& candidate) {
    const std::vector<std::string> names = names_of(candidate);
    return std::ranges::find(names, name) != names.end();
  });
  return flag == verb.flags.end() ? nullptr : &*flag;
}

CLI::Option* add_flag(CLI::App& app, const Flag& flag) {
  if (!takes_value(flag)) return app.add_flag(flag.names)->disable_flag_override();
  if (!flag.bare_value.empty()) return app.add_flag(concat(flag.names, "{", flag.bare_value, "}"));
  CLI::Option* const option = app.add_option(flag.names);
  option->type_size(static_cast<int>(values_each(flag)))->expected(1);
  return option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

CLI::Option* add_positional(CLI::App& app, const Positional& positional) {
  CLI::Option* const option = app.add_option(positional.name);
  // A list continues after flags between its words.
  option->allow_extra_args(is_list(positional.target));
  return option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

// What people mean by flags of other programs; empty: not known.
std::string meaning_of(const std::string& command, const Verb& verb, const std::string& name) {
  if (name == "--json") {
    const Flag* const format = find_flag(verb, "--format");
    const bool has_json =
        format != nullptr && std::ranges::find(format->choices, "json") != format->choices.end();
    return has_json ? "write --format json" : "";
  }
  if (name == "-j" || name == "--jobs" || name == "--threads") {
    return find_flag(verb, "--threads") != nullptr
               ? "write -j or --threads"
               : concat("`", command, "` uses one thread: leave the flag out");
  }
  if (name == "-c" || name == "--config") {
    const auto takes_config = [](const Positional& positional) {
      return positional.name == "CONFIG" || positional.name == "TARGET";
    };
    const auto positional = std::ranges::find_if(verb.positionals, takes_config);
    return positional == verb.positionals.end()
               ? "this verb takes no configuration"
               : concat("the configuration has no flag before it: `", command, " FILE.yaml`");
  }
  if (name == "--version") return "`sightline --version` prints it";
  return "";
}

// A second configuration, or what else a word too many may be.
std::string meaning_of_word(const std::string& command, const Verb& verb) {
  const bool takes_one =
      std::ranges::find(verb.positionals, "CONFIG", &Positional::name) != verb.positionals.end();
  if (takes_one) {
    return "one configuration is read; several drives are a list under mapping: in it";
  }
  return concat("`", command, " --help` shows the usage");
}

// The first word too many: a flag that does not exist, or a positional.
Error unexpected(const std::string& command, const Verb& verb, const std::string& word) {
  if (!word.starts_with('-') || word == "-") {
    return bad_argument(concat("unexpected word '", word, "'; ", meaning_of_word(command, verb)));
  }
  const std::string name =
      word.starts_with("--") ? word.substr(0, word.find('=')) : word.substr(0, 2);
  const std::string meaning = meaning_of(command, verb, name);
  if (!meaning.empty()) return bad_argument(concat("unknown flag ", name, "; ", meaning));
  std::vector<std::string> known;
  for (const Flag& flag : shown_flags(verb)) known.push_back(long_name(flag));
  return unknown("unknown flag " + name, name, known, command);
}

// A map in place of the configuration, of a verb that takes the map by --map.
Result<void> check_swapped(const std::string& command, const Verb& verb,
                           const std::vector<CLI::Option*>& options) {
  const Flag* const map = find_flag(verb, "--map");
  if (map == nullptr || !map->is_required) return {};
  for (std::size_t i = 0; i < verb.positionals.size(); ++i) {
    if (verb.positionals[i].name != "CONFIG") continue;
    for (const std::string& word : options[verb.flags.size() + i]->results()) {
      if (!word.ends_with(".slmap") && kind_of_file(word) != FileKind::kMap) continue;
      return bad_argument(
          concat(word, " is the map: write `", command, " CONFIG --map ", word, "`"));
    }
  }
  return {};
}

// A flag whose value is missing must be the last word, since it takes whatever follows.
Error without_value(const Verb& verb, const std::vector<std::string>& words) {
  for (auto word = words.rbegin(); word != words.rend(); ++word) {
    const bool is_short = word->size() > 1 && word->front() == '-' && (*word)[1] != '-';
    const std::string name = is_short ? std::string("-") + word->back() : *word;
    const Flag* const flag = find_flag(verb, name);
    if (flag == nullptr || !takes_value(*flag)) continue;
    return bad_argument(concat(long_name(*flag), " needs a value: ", flag->value));
  }
  return bad_argument("the last flag needs a value");
}

// "--force=yes"; null where there is no such word.
const Flag* switch_with_value(const Verb& verb, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (!word.starts_with("--") || equals == std::string::npos) continue;
    const Flag* const flag = find_flag(verb, word.substr(0, equals));
    if (flag != nullptr && !takes_value(*flag)) return flag;
  }
  return nullptr;
}

Result<void> split(CLI::App& app, const std::string& command, const Verb& verb,
                   const std::vector<std::string>& words) {
  if (const Flag* const flag = switch_with_value(verb, words)) {
    return bad_argument(long_name(*flag) + " takes no value");
  }
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::ExtrasError&) {
    return unexpected(command, verb, app.remaining().front());
  } catch (const CLI::ArgumentMismatch&) {
    return without_value(verb, words);
  } catch (const CLI::ParseError&) {
    return bad_argument(concat("the arguments of `", command, "` cannot be read; `", command,
                               " --help` shows the usage"));
  }
  return {};
}

// A value that is itself a flag of the verb: the value in between was forgotten.
Result<void> check_values(const Verb& verb, const Flag& flag,
                          const std::vector<std::string>& values) {
  for (const std::string& value : values) {
    if (find_flag(verb, value) == nullptr) continue;
    return bad_argument(
        concat(long_name(flag), " needs a value: ", flag.value, "; found the flag ", value));
  }
  return {};
}

// Those whose target is a setter, or all others.
Result<void> set_flags(const Verb& verb, const std::vector<CLI::Option*>& options,
                       bool with_setter) {
  for (std::size_t i = 0; i < verb.flags.size(); ++i) {
    const Flag& flag = verb.flags[i];
    if (std::holds_alternative<Setter>(flag.target) != with_setter) continue;
    Result<void> set = check_values(verb, flag, options[i]->results());
    if (set) set = set_flag(flag, long_name(flag), options[i]->results());
    if (!set) return set;
  }
  return {};
}

Result<void> check_exclusions(const Verb& verb, const std::vector<CLI::Option*>& options) {
  for (std::size_t i = 0; i < verb.flags.size(); ++i) {
    const Flag& flag = verb.flags[i];
    if (flag.excludes.empty() || options[i]->count() == 0) continue;
    const auto other = static_cast<std::size_t>(find_flag(verb, flag.excludes) - &verb.flags[0]);
    if (options[other]->count() == 0) continue;
    return bad_argument(
        concat(long_name(flag), " and ", flag.excludes, " cannot be used together"));
  }
  return {};
}

// What follows --version: its format.
Result<int> print_version(const Program& program, std::vector<std::string> words) {
  if (words.size() == 2 && words[0] == "--format") words = {concat("--format=", words[1])};
  const bool is_json = words == std::vector<std::string>{"--format=json"};
  if (!words.empty() && !is_json && words != std::vector<std::string>{"--format=text"}) {
    return bad_argument(concat("--version: found '", words[0],
                               "', expected nothing, --format text or --format json"));
  }
  std::fputs(is_json ? program.version_json.c_str()
                     : concat(program.name, " ", program.version, "\n", program.build).c_str(),
             stdout);
  return 0;
}

// --help, --version, or a flag that needs a verb before it.
Result<int> run_without_verb(const Program& program, const std::vector<std::string>& words) {
  const std::string& flag = words.front();
  if (asks_for_help({flag})) {
    std::fputs(help_text(program).c_str(), stdout);
    return 0;
  }
  if (flag == "--version") return print_version(program, {words.begin() + 1, words.end()});
  return unknown(concat("unknown flag ", flag, " before the verb"), flag, {"--help", "--version"},
                 program.name);
}

// Every word that a verb may be called by; a second word ("status") names its verb.
Error unknown_verb(const Program& program, const std::string& name) {
  if (name == "version") {
    return bad_argument(concat("unknown verb 'version'; write `", program.name, " --version`"));
  }
  std::vector<std::string> known = top_names(program);
  for (const auto& [alias, verb] : program.aliases) known.push_back(alias);
  const std::string near = nearest_name(name, known);
  const Verb* const verb = find_verb(program, near);
  const std::string what = concat("unknown verb '", name, "'; ");
  if (near.empty()) return bad_argument(concat(what, "`", program.name, " --help` lists them"));
  return bad_argument(concat(what, "did you mean '", verb == nullptr ? near : verb->name, "'?"));
}

// A family without one of its verbs.
Result<int> run_family(const Program& program, const Family& family,
                       const std::vector<std::string>& words) {
  if (words.size() > 1 && !asks_for_help(words)) {
    return unknown(concat("unknown verb '", family.name, " ", words[1], "'"), words[1],
                   names_in(program, family.name), concat(program.name, " ", family.name));
  }
  const bool has_help = words.size() > 1;
  std::fputs(help_text(program, family).c_str(), has_help ? stdout : stderr);
  return has_help ? 0 : exit_status(ErrorCode::kBadArgument);
}

bool is_set(const Verb& verb, const std::string& name) {
  const Flag* const flag = find_flag(verb, name);
  const auto* const target = flag == nullptr ? nullptr : std::get_if<bool*>(&flag->target);
  return target != nullptr && *target != nullptr && **target;
}

Result<int> run_words(const Program& program, const std::vector<std::string>& words) {
  if (words.front().starts_with('-')) return run_without_verb(program, words);
  const Called called = find_called(program, words);
  if (called.verb == nullptr && called.family != nullptr) {
    return run_family(program, *called.family, words);
  }
  if (called.verb == nullptr) return unknown_verb(program, words.front());
  const Verb& verb = *called.verb;
  const std::string command = concat(program.name, " ", verb.name);
  const std::vector<std::string> rest(
      words.begin() + static_cast<std::ptrdiff_t>(called.word_count), words.end());
  if (asks_for_help(rest)) {
    std::fputs(help_text(command, verb).c_str(), stdout);
    return 0;
  }
  SIGHTLINE_TRY(parse_words(command, verb, rest));
  set_verbosity(is_set(verb, "--quiet")     ? Verbosity::kQuiet
                : is_set(verb, "--verbose") ? Verbosity::kVerbose
                                            : Verbosity::kNormal);
  return verb.run();
}

}  // namespace

Result<void> parse_words(const std::string& command, const Verb& verb,
                         const std::vector<std::string>& words) {
  CLI::App app;
  app.set_help_flag();
  std::vector<CLI::Option*> options;
  for (const Flag& flag : verb.flags) options.push_back(add_flag(app, flag));
  for (const Positional& positional : verb.positionals) {
    options.push_back(add_positional(app, positional));
  }
  SIGHTLINE_TRY(split(app, command, verb, words));
  SIGHTLINE_TRY(check_swapped(command, verb, options));
  // Setters come last: they may add to what another flag has set.
  for (const bool sets : {false, true}) {
    SIGHTLINE_TRY(set_flags(verb, options, sets));
  }
  for (std::size_t i = 0; i < verb.positionals.size(); ++i) {
    const CLI::Option& option = *options[verb.flags.size() + i];
    SIGHTLINE_TRY(
        set_flag(as_flag(verb.positionals[i]), verb.positionals[i].name, option.results()));
  }
  return check_exclusions(verb, options);
}

bool asks_for_help(const std::vector<std::string>& words) {
  const auto end = std::ranges::find(words, "--");
  return std::any_of(words.begin(), end,
                     [](const std::string& word) { return word == "--help" || word == "-h"; });
}

int run_command_line(const Program& program, const std::vector<std::string>& words) {
  if (words.empty()) {
    std::fputs(help_text(program).c_str(), stderr);
    return exit_status(ErrorCode::kBadArgument);
  }
  const Result<int> status = run_words(program, words);
  if (status) return *status;
  const Error error = explain_wrong_file(status.error());
  const int exit = report_error(error);
  std::fputs(quoted_place(error).c_str(), stderr);
  return exit;
}

}  // namespace sightline
