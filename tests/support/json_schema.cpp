#include "tests/support/json_schema.h"

#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

namespace sightline {

std::string schema_faults(const nlohmann::json& schema, const nlohmann::json& document) {
  using valijson::adapters::NlohmannJsonAdapter;
  valijson::SchemaParser parser(schema.contains("id") ? valijson::SchemaParser::kDraft4
                                                      : valijson::SchemaParser::kDraft7);
  valijson::Schema rules;
  parser.populateSchema(NlohmannJsonAdapter(schema), rules);
  valijson::ValidationResults results;
  if (valijson::Validator().validate(rules, NlohmannJsonAdapter(document), &results)) return "";
  std::string text;
  for (const auto& result : results) {
    for (const std::string& part : result.context) text += part;
    text += ": " + result.description + "\n";
  }
  return text.empty() ? "invalid\n" : text;
}

}  // namespace sightline
