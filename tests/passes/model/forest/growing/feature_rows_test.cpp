#include "passes/model/forest/growing/feature_rows.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/synthetic_drive.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

FactorTable small_table() {
  FactorTable table;
  table.looks = every_return_at({10.0, 15.0});
  table.factors = {"a", "b"};
  table.site_count = 2;
  table.values = {1, 2, 3, 4, 5, 6, 7, 8};
  return table;
}

TEST(FeatureRows, HoldTheNamedFactorsAndTheRange) {
  const FeatureRows rows = value_of(gather_features(small_table(), {"b"}));
  EXPECT_EQ(rows.names, (std::vector<std::string>{"b", "range_m"}));
  EXPECT_EQ(rows.row_count, 4u);
  EXPECT_EQ(rows.values, (std::vector<float>{2, 10, 4, 15, 6, 10, 8, 15}));
}

TEST(FeatureRows, KnowTheElevenFactorsOfThePaper) {
  EXPECT_EQ(paper_factors().size(), 11u);
  const SyntheticDrive drive = synthetic_drive(1, {.site_count = 3});
  EXPECT_TRUE(gather_features(drive.factors, paper_factors()).has_value());
}

TEST(FeatureRows, GiveASiteItsOwnDigest) {
  FactorTable table = small_table();
  const std::uint64_t before = features_digest(*gather_features(table, {"a", "b"}), 1, 2);
  table.values[0] = 100.0;  // site 0
  EXPECT_EQ(features_digest(*gather_features(table, {"a", "b"}), 1, 2), before);
  table.values[7] = 100.0;  // site 1
  EXPECT_NE(features_digest(*gather_features(table, {"a", "b"}), 1, 2), before);
}

TEST(FeatureRows, RefuseAMissingFactorByName) {
  const Error refused = failure_of(gather_features(small_table(), {"a", "crlb_max"}));
  EXPECT_EQ(refused.code, ErrorCode::kMismatchedInputs);
  EXPECT_NE(refused.message.find("crlb_max"), std::string::npos);
}

TEST(FeatureRows, RefuseWhatIsNotAFiniteFloatAndSayWhere) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    FactorTable table = small_table();
    table.values[7] = bad;
    const Error refused = failure_of(gather_features(table, {"b"}));
    EXPECT_EQ(refused.code, ErrorCode::kInvalidArtifact);
    EXPECT_EQ(refused.place, "site 1, range 15 m");
  }
}

}  // namespace
}  // namespace sightline
