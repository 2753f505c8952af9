#include "tests/system/evaluation_schema.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "compiler/base/atomic_file.h"

namespace sightline {

std::string fault_of_evaluation(const std::string& json_text) {
  const nlohmann::json document = nlohmann::json::parse(json_text, nullptr, false);
  if (document.is_discarded()) return "no JSON";
  const std::filesystem::path file =
      std::filesystem::path(SIGHTLINE_ROOT) / "schemas/evaluation.schema.json";
  const nlohmann::json published = nlohmann::json::parse(*read_text_file(file));
  valijson::Schema schema;
  valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(published),
                                          schema);
  valijson::ValidationResults faults;
  if (valijson::Validator().validate(schema, valijson::adapters::NlohmannJsonAdapter(document),
                                     &faults)) {
    return "";
  }
  valijson::ValidationResults::Error first;
  return faults.popError(first) ? first.description : "invalid";
}

// A schema that takes anything would prove nothing.
TEST(Evaluate, TheSchemaRefusesATableThatIsNoneAndAColumnTooMany) {
  EXPECT_NE(fault_of_evaluation("[]"), "");
  EXPECT_NE(fault_of_evaluation("[{\"name\": \"x\", \"facts\": {}, \"columns\": [], \"rows\": []}]"),
            "");
  EXPECT_NE(fault_of_evaluation("{"), "");
}

}  // namespace sightline
