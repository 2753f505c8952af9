#include "compiler/views/report/page/report_sources.h"

#include <nlohmann/json.hpp>

#include "formats/base/files/atomic_file.h"

namespace sightline {
namespace {

using Json = nlohmann::json;

GateResult::Violation violation_of(const Json& check) {
  GateResult::Violation violation = {check.at("rule").get<std::string>(),
                                     check.at("severity").get<std::string>(),
                                     check.at("message").get<std::string>(),
                                     {}};
  const Json& place = check.at("place");
  if (!place.is_null() && !place.at("of_old_map").get<bool>()) {
    violation.first_site = place.at("first_site").get<std::uint32_t>();
  }
  return violation;
}

GateResult result_of(const Json& json) {
  GateResult result;
  result.root_digest = json.at("map").at("root_digest").get<std::string>();
  result.passed = json.at("passed").get<bool>();
  result.errors = json.at("errors").get<std::uint32_t>();
  result.warnings = json.at("warnings").get<std::uint32_t>();
  result.notes = json.at("notes").get<std::uint32_t>();
  result.excepted = json.at("excepted").get<std::uint32_t>();
  for (const Json& check : json.at("checks")) {
    if (check.at("verdict") == "violated") result.violations.push_back(violation_of(check));
  }
  return result;
}

}  // namespace

Result<GateResult> read_gate_result(const std::filesystem::path& file) {
  SIGHTLINE_ASSIGN(const std::string text, read_text_file(file));
  try {
    return result_of(Json::parse(text));
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kMalformedText,
                 std::string("expected what gate --json writes: ") + exception.what(),
                 file.string()};
  }
}

}  // namespace sightline
