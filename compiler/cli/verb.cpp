#include "compiler/cli/verb.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <type_traits>

#include "passes/pass/options.h"

namespace sightline {
namespace {

Flag help_flag() { return {.names = "-h,--help", .help = "Print this help"}; }

// The shortest text that reads back as the same number, without an exponent below 1e15.
template <class Number>
std::string number_text(Number number) {
  char text[32];
  std::to_chars_result end = std::to_chars(text, text + sizeof text, number);
  if constexpr (std::is_floating_point_v<Number>) {
    const bool is_short = std::abs(number) < 1e15 && number == std::floor(number);
    if (is_short) end = std::to_chars(text, text + sizeof text, number, std::chars_format::fixed);
  }
  return {text, end.ptr};
}

bool is_within_limits(const Flag& flag, double number) {
  return (!flag.minimum || number >= *flag.minimum) && (!flag.maximum || number <= *flag.maximum);
}

template <class Number>
Result<void> set_number(const Flag& flag, const std::string& called, const std::string& word,
                        Number& target) {
  Number number{};
  const char* const end = word.data() + word.size();
  const std::from_chars_result read = std::from_chars(word.data(), end, number);
  const bool is_read = read.ec == std::errc() && read.ptr == end;
  if (!is_read || !std::isfinite(static_cast<double>(number)) ||
      !is_within_limits(flag, static_cast<double>(number))) {
    return Error{ErrorCode::kBadValue,
                 concat(called, ": found '", word, "', expected ", expected_text(flag))};
  }
  target = number;
  return {};
}

const std::string* remedy_of(const Flag& flag, const std::string& value) {
  const auto found =
      std::ranges::find(flag.remedies, value, &std::pair<std::string, std::string>::first);
  return found == flag.remedies.end() ? nullptr : &found->second;
}

Result<void> check_ending(const Flag& flag, const std::string& called, const std::string& word) {
  const std::string ending = std::filesystem::path(word).extension().string();
  const bool is_allowed = flag.endings.empty() || ending.empty() || word.starts_with("/dev/") ||
                          std::ranges::find(flag.endings, ending) != flag.endings.end();
  if (is_allowed) return {};
  const std::string* const remedy = remedy_of(flag, ending);
  return Error{ErrorCode::kBadArgument,
               concat(called, ": found '", word, "', expected a path that ends in ",
                      joined(flag.endings, " or "), remedy ? concat("; ", *remedy) : "")};
}

Result<void> check_choice(const Flag& flag, const std::string& called, const std::string& word) {
  if (flag.choices.empty() || std::ranges::find(flag.choices, word) != flag.choices.end()) {
    return {};
  }
  if (const std::string* const remedy = remedy_of(flag, word)) {
    return Error{ErrorCode::kUnknownName, concat(called, ": '", word, "' ", *remedy)};
  }
  const std::string near = nearest_name(word, flag.choices);
  const std::string hint =
      near.empty() ? "it is one of " + joined(flag.choices) : concat("did you mean '", near, "'?");
  return Error{ErrorCode::kUnknownName, concat(called, ": '", word, "' is not known; ", hint)};
}

struct SetTarget {
  const Flag& flag;
  const std::string& called;
  const std::string& word;

  Result<void> operator()(bool* target) const {
    if (target != nullptr) *target = true;
    return {};
  }
  Result<void> operator()(std::string* target) const {
    *target = word;
    return {};
  }
  Result<void> operator()(std::vector<std::string>* target) const {
    target->push_back(word);
    return {};
  }
  Result<void> operator()(const Setter& setter) const {
    const Result<void> set = setter(word);
    if (set) return {};
    Error error = set.error();
    error.message = concat(called, ": ", error.message);
    return error;
  }
  template <class Number>
  Result<void> operator()(Number* target) const {
    return set_number(flag, called, word, *target);
  }
};

struct DefaultText {
  const Flag& flag;

  std::string operator()(const bool* /*target*/) const { return ""; }
  std::string operator()(const std::string* target) const { return *target; }
  std::string operator()(const std::vector<std::string>* target) const { return joined(*target); }
  std::string operator()(const Setter& /*setter*/) const { return ""; }
  template <class Number>
  std::string operator()(const Number* target) const {
    return is_within_limits(flag, static_cast<double>(*target)) ? number_text(*target) : "";
  }
};

}  // namespace

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

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
  return {
      help_flag(),
      {.names = "--version", .help = "Print the version of the program (--format json: as JSON)"}};
}

std::vector<std::string> top_names(const Program& program) {
  std::vector<std::string> names;
  for (const Verb& verb : program.verbs) {
    const std::string name = verb.name.substr(0, verb.name.find(' '));
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return names;
}

std::vector<std::string> names_in(const Program& program, const std::string& family) {
  std::vector<std::string> names;
  for (const Verb& verb : program.verbs) {
    if (family_of(verb) == family) names.push_back(verb.name.substr(family.size() + 1));
  }
  return names;
}

std::string family_of(const Verb& verb) {
  const std::size_t blank = verb.name.find(' ');
  return blank == std::string::npos ? "" : verb.name.substr(0, blank);
}

const Verb* find_verb(const Program& program, const std::string& name) {
  const auto alias =
      std::ranges::find(program.aliases, name, &std::pair<std::string, std::string>::first);
  const std::string& full = alias == program.aliases.end() ? name : alias->second;
  const auto verb = std::ranges::find(program.verbs, full, &Verb::name);
  return verb == program.verbs.end() ? nullptr : &*verb;
}

Called find_called(const Program& program, const std::vector<std::string>& words) {
  if (words.empty()) return {};
  const auto family = std::ranges::find(program.families, words[0], &Family::name);
  const bool is_family = family != program.families.end();
  const Family* const found = is_family ? &*family : nullptr;
  if (is_family && words.size() > 1) {
    const Verb* const verb = find_verb(program, concat(words[0], " ", words[1]));
    if (verb != nullptr) return {verb, found, 2};
  }
  const bool is_alone = words.size() == 1 || words[1] == "--help" || words[1] == "-h";
  if (is_family && is_alone) return {nullptr, found, 1};
  const Verb* const verb = find_verb(program, words[0]);
  return {verb, found, static_cast<std::size_t>(verb != nullptr || is_family ? 1 : 0)};
}

Result<void> set_flag(const Flag& flag, const std::string& called,
                      const std::vector<std::string>& words) {
  if (words.empty()) {
    if (!flag.is_required) return {};
    return Error{ErrorCode::kBadArgument, concat(called, " is required: ", flag.help)};
  }
  if (takes_value(flag) && !is_list(flag.target) && words.size() > 1) {
    return Error{ErrorCode::kBadArgument,
                 concat(called, " is given ", words.size(), " times, as '", words[0], "' and '",
                        words[1], "'; it takes one value")};
  }
  if (is_list(flag.target)) std::get<std::vector<std::string>*>(flag.target)->clear();
  for (const std::string& word : words) {
    SIGHTLINE_TRY(check_choice(flag, called, word));
    SIGHTLINE_TRY(check_ending(flag, called, word));
    SIGHTLINE_TRY(std::visit(SetTarget{flag, called, word}, flag.target));
  }
  return {};
}

Flag as_flag(const Positional& positional) {
  return {.value = positional.name,
          .help = positional.help,
          .target = positional.target,
          .choices = positional.choices,
          .is_required = positional.is_required};
}

std::string default_text(const Flag& flag) {
  if (flag.is_required) return "";
  return std::visit(DefaultText{flag}, flag.target);
}

std::string expected_text(const Flag& flag) {
  if (!flag.choices.empty()) return "one of " + joined(flag.choices);
  const bool is_number = std::holds_alternative<double*>(flag.target);
  std::string text = is_number ? "a number" : "a whole number";
  if (flag.minimum && flag.maximum) {
    text += concat(" from ", number_text(*flag.minimum), " to ", number_text(*flag.maximum));
  } else if (flag.minimum) {
    text += " of at least " + number_text(*flag.minimum);
  }
  return text;
}

}  // namespace sightline
