#include "tests/system/evaluation_schema.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "formats/base/files/atomic_file.h"
#include "tests/support/json_schema.h"

namespace sightline {

std::string fault_of_evaluation(const std::string& json_text) {
  const nlohmann::json document = nlohmann::json::parse(json_text, nullptr, false);
  if (document.is_discarded()) return "no JSON";
  const std::filesystem::path file =
      std::filesystem::path(SIGHTLINE_ROOT) / "schemas/evaluation.schema.json";
  const nlohmann::json published = nlohmann::json::parse(*read_text_file(file));
  return schema_faults(published, document);
}

// A schema that takes anything would prove nothing.
TEST(Evaluate, TheSchemaRefusesATableThatIsNoneAndAColumnTooMany) {
  EXPECT_NE(fault_of_evaluation("[]"), "");
  EXPECT_NE(
      fault_of_evaluation("[{\"name\": \"x\", \"facts\": {}, \"columns\": [], \"rows\": []}]"), "");
  EXPECT_NE(fault_of_evaluation("{"), "");
}

}  // namespace sightline
