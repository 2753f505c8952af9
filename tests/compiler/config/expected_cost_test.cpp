#include "compiler/config/expected_cost.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/base/files/atomic_file.h"
#include "tests/support/json_schema.h"

namespace sightline {
namespace {

TEST(ExpectedCost, KeepsToItsSchemaAsJson) {
  using Json = nlohmann::json;
  const Json schema =
      Json::parse(*read_text_file(std::string(SIGHTLINE_ROOT) + "/schemas/cost.schema.json"));
  ExpectedCost cost;
  cost.drives = {{"mapping", 301, 28'000.0}};
  cost.steps = {{"ingest", true, 0.0}, {"build-ndt", false, 2.5}};
  cost.memory_mib = 240.0;
  Json json = Json::parse(to_json(cost));
  EXPECT_EQ(schema_faults(schema, json), "");
  EXPECT_EQ(json["steps"][1]["wall_s"], 2.5);
  EXPECT_FALSE(json.contains("places"));
  cost.places = {{600, 12, 40.0}};
  EXPECT_EQ(schema_faults(schema, Json::parse(to_json(cost))), "");
  json["threads"] = 0;
  EXPECT_NE(schema_faults(schema, json), "");
}

}  // namespace
}  // namespace sightline
