#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "formats/base/result.h"

// The command line as plain data. Each verb is described once; parsing, --help, the manual page and
// the completion of shells are made from that description, so they cannot contradict each other.

namespace sightline {

// Takes a value, "true" of a switch. It may refuse: its message then gives the reason, without the
// name of the flag. Setters are called after all other targets are set.
using Setter = std::function<Result<void>(const std::string&)>;

// Where a value from the command line goes. Pointers must live as long as the verb: point into what
// `run` captures.
using FlagTarget = std::variant<bool*, int*, std::uint32_t*, std::uint64_t*, double*, std::string*,
                                std::vector<std::string>*, Setter>;

// Help shows the value of the target as the default, unless the flag is required, the text is empty
// or the number is outside minimum and maximum (-1 for "no site").
struct Flag {
  std::string names = {};  // "-o,--output": at most one letter, then the long name
  std::string value = {};  // what it takes, "FILE", or "FILE FILE" for two words; empty: a switch
  std::string help = {};   // without a full stop at the end; parsing and help add what follows
  FlagTarget target = {};  // a list: the flag may be repeated
  std::vector<std::string> choices = {};  // the only values allowed; empty: any
  // Of values that are none of the choices: "is not written; convert another with ogr2ogr".
  std::vector<std::pair<std::string, std::string>> remedies = {};
  // Of a path that is written: ".slmap". A path without an ending is taken too. `remedies` are of
  // other endings.
  std::vector<std::string> endings = {};
  std::optional<double> minimum = {};  // of a number; both limits are allowed values
  std::optional<double> maximum = {};
  bool is_required = false;
  std::string excludes = {};    // the long name of a flag that cannot be used with this one
  std::string bare_value = {};  // what the flag means without a value; with one: --name=VALUE
  bool is_hidden = false;       // from help, the manual page and completion
};

struct Positional {
  std::string name = {};  // "MAP"
  std::string help = {};
  FlagTarget target = {};  // a list, of the last positional only: one or more words
  std::vector<std::string> choices = {};
  bool is_required = true;
};

struct Verb {
  std::string name;                   // one word, or two: "cluster plan"
  std::string summary;                // one line
  std::string details;                // paragraphs, separated by empty lines; empty: nothing to add
  std::vector<std::string> examples;  // commands, each with a comment if need be
  std::vector<Positional> positionals;
  std::vector<Flag> flags;
  std::function<Result<int>()> run;  // the exit status of the process
  std::string group;                 // heading in the list of verbs
};

// Verbs of two words that share the first one: "cluster" of "cluster plan" and "cluster work".
struct Family {
  std::string name;
  std::string summary;  // one line
};

struct Program {
  std::string name;
  std::string version;
  std::string build;         // what --version adds: lines, each with its end
  std::string version_json;  // what --version --format json prints (schemas/version.schema.json)
  std::string summary;
  std::vector<std::string> first_steps;  // commands for somebody who is new here
  std::string details;                   // paragraphs
  std::vector<Verb> verbs;
  std::vector<Family> families;
  // Names of before that still call a verb, in no help: {"plan", "cluster plan"}.
  std::vector<std::pair<std::string, std::string>> aliases;
};

// What the first words of a command line call: a verb; a family alone; or neither.
struct Called {
  const Verb* verb = nullptr;
  const Family* family = nullptr;
  std::size_t word_count = 0;  // that name it
};

// The words with `between` between them.
std::string joined(const std::vector<std::string>& words, const std::string& between = ", ");

// Exit status 0 of what succeeded.
Result<int> exit_status_of(const Result<void>& done);

// {"-o", "--output"}
std::vector<std::string> names_of(const Flag& flag);
// "--output", as messages call the flag.
std::string long_name(const Flag& flag);
bool takes_value(const Flag& flag);
// How many words follow the flag each time: 2 for the value "FILE FILE".
std::size_t values_each(const Flag& flag);
bool is_list(const FlagTarget& target);

// The flags that people are shown: all that are not hidden, and --help.
std::vector<Flag> shown_flags(const Verb& verb);
// --help and --version, which need no verb.
std::vector<Flag> flags_without_verb();

// First words of all verbs in the order of the program, each once: "init", "cluster", ...
std::vector<std::string> top_names(const Program& program);
// Second words of a family's verbs: "plan", "work", ...
std::vector<std::string> names_in(const Program& program, const std::string& family);
// "cluster" of "cluster plan"; empty for a verb of one word.
std::string family_of(const Verb& verb);
// By its full name or an alias; null where there is no such verb.
const Verb* find_verb(const Program& program, const std::string& name);
// Two words of a verb come before an alias of one: `delta make` is no map called "make".
Called find_called(const Program& program, const std::vector<std::string>& words);

// Sets the target of a flag from the words that the command line has for it, which may be none.
// `called` is the flag's name in messages: "--threads" or "MAP".
// Errors: unknown-name for a value that is none of the choices, with the nearest one; bad-value for
// what is no number or is outside the limits; bad-argument for a flag that is missing or
// repeated.
Result<void> set_flag(const Flag& flag, const std::string& called,
                      const std::vector<std::string>& words);

// The same value in the words of a flag, so that both are read by one function.
Flag as_flag(const Positional& positional);

// What holds without the flag, as help shows it; empty: nothing to show.
std::string default_text(const Flag& flag);

// "a whole number from 0 to 1024", "a number of at least 0", "one of csv, json".
std::string expected_text(const Flag& flag);

}  // namespace sightline
