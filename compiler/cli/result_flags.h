#pragma once

#include <string>
#include <vector>

#include "compiler/cli/verb.h"
#include "formats/base/result.h"

namespace sightline {

// How a verb that prints results prints them, and where.
struct ResultFlags {
  std::string format = "text";
  std::string output;  // empty: stdout
  bool is_forced = false;

  // "text" with an output that ends in .json or .csv is that format, if the verb has it.
  [[nodiscard]] std::string chosen_format(const std::vector<std::string>& formats) const;
  // Of a verb whose formats are text and json.
  [[nodiscard]] bool is_json() const { return chosen_format({"text", "json"}) == "json"; }
};

// --format with these choices, -o and --force. `json_help` names the schema: "json as
// schemas/inspect.schema.json describes it".
void add_result_flags(Verb& verb, ResultFlags& flags, const std::vector<std::string>& formats,
                      const std::string& json_help);

// Before hours of work. Errors: those of try_output().
Result<void> try_result(const ResultFlags& flags);

// Writes the result to the file and prints that it did; without a file prints it. Errors: those of
// write_file_atomically().
Result<void> put_result(const ResultFlags& flags, const std::string& result);

}  // namespace sightline
