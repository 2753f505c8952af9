#include "passes/localize/add_mapping_error.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/synthetic_drive.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

// A synthetic drive whose last factor is called as the one that stands in; site 2 was not measured.
// Its scans end twice as far from the poses that they came with as from the reference.
SyntheticDrive small_drive() {
  SyntheticDrive drive =
      synthetic_drive(4, {.site_count = 5, .ranges_m = {10.0, 20.0}, .has_paper_factors = false});
  drive.factors.factors.back() = "virtual_error";
  drive.measured.scan_of_site[2] = -1;
  for (ErrorRow& row : drive.measured.rows) row.from_given_m = 2.0 * row.mean_m;
  return drive;
}

struct Added {
  Result<FactorTable> table;
  std::vector<std::string> warnings;
};

Added added(const SyntheticDrive& drive, const std::string& localizing_sensor = "vlp-16") {
  PassContext ctx;
  std::vector<std::string> warnings;
  ctx.warning_sink = [&](const std::string& message) { warnings.push_back(message); };
  const SensorProfile mapping_sensor = *sensor_profile("vlp-16");
  Result<FactorTable> table =
      of_ranges(whole_rows(add_mapping_error(ctx, {}, drive.factors, drive.measured,
                                             &mapping_sensor, *sensor_profile(localizing_sensor))));
  return {std::move(table), std::move(warnings)};
}

// Calls back with (site, range, own_error, mapping_error), and expects that nothing else changed.
template <class Expect>
void for_each_row(const FactorTable& table, const FactorTable& before, const Expect& expect) {
  ASSERT_EQ(table.factors.size(), before.factors.size() + 2);
  EXPECT_EQ(table.factors[before.factors.size()], "own_error");
  EXPECT_EQ(table.factors.back(), "mapping_error");
  EXPECT_EQ(table.looks, before.looks);
  ASSERT_EQ(table.site_count, before.site_count);
  ASSERT_TRUE(validate(table).has_value());
  for (std::size_t site = 0; site < before.site_count; ++site) {
    for (std::size_t range = 0; range < before.looks.size(); ++range) {
      for (std::size_t f = 0; f < before.factors.size(); ++f) {
        EXPECT_EQ(table.factors[f], before.factors[f]);
        EXPECT_EQ(table.at(site, range, f), before.at(site, range, f));
      }
      const std::size_t own = before.factors.size();
      expect(site, range, table.at(site, range, own), table.at(site, range, own + 1));
    }
  }
}

TEST(AddMappingError, TellsWhatWasMeasuredAndElsewhereWhatTheVirtualScanSays) {
  const SyntheticDrive drive = small_drive();
  const auto [table, warnings] = added(drive);
  ASSERT_TRUE(table.has_value());
  EXPECT_TRUE(warnings.empty());
  for_each_row(*table, drive.factors,
               [&](std::size_t site, std::size_t range, double own_m, double mapping_m) {
                 EXPECT_EQ(mapping_m, site == 2 ? drive.factors.at(site, range, 2)
                                                : drive.measured.row(site, range).from_given_m);
                 EXPECT_EQ(own_m, site == 2 ? mapping_m : 0.5 * mapping_m);
               });
}

TEST(AddMappingError, BelievesNoOtherSensorThanTheOneThatLocalizes) {
  const SyntheticDrive drive = small_drive();
  const auto [table, warnings] = added(drive, "hdl-64e");
  ASSERT_TRUE(table.has_value());
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0],
            "sensor vlp-16 made the map, but hdl-64e localizes in it: mapping_error is computed "
            "from virtual scans");
  for_each_row(*table, drive.factors,
               [&](std::size_t site, std::size_t range, double own_m, double mapping_m) {
                 EXPECT_EQ(mapping_m, drive.factors.at(site, range, 2));
                 EXPECT_EQ(own_m, mapping_m);
               });
}

TEST(AddMappingError, OfADriveThatIsAlsoLocalizedIsEvidenceAndNothingToLearnFrom) {
  const SyntheticDrive drive = small_drive();
  PassContext ctx;
  const FactorTable table = value_of(of_ranges(whole_rows(add_mapping_error(
      ctx, {}, drive.factors, drive.measured, nullptr, *sensor_profile("vlp-16")))));
  for_each_row(table, drive.factors,
               [&](std::size_t site, std::size_t range, double own_m, double mapping_m) {
                 EXPECT_EQ(mapping_m, drive.factors.at(site, range, 2));
                 EXPECT_EQ(own_m, site == 2 ? drive.factors.at(site, range, 2)
                                            : drive.measured.row(site, range).mean_m);
               });
}

TEST(AddMappingError, GivesLooksThatTakeASampleATableOfTheirOwn) {
  const SyntheticDrive drive = small_drive();
  const std::vector<Look> looks = {{.range_m = 100.0, .return_count = 650, .point_count = 40},
                                   {.range_m = 100.0, .return_count = 1944, .point_count = 80}};
  MeasuredError measured = drive.measured;
  measured.looks = looks;
  for (ErrorRow& row : measured.rows) row.from_given_m *= 0.1;
  const SensorProfile sensor = *sensor_profile("vlp-16");
  const ByFamily<StoredTable<MeasuredError>> own(drive.measured, measured);
  const ByFamily<FactorTable> table = value_of(
      whole_rows(add_mapping_error(TestContext(), {}, drive.factors, own, &sensor, sensor)));
  ASSERT_TRUE(validate(table).has_value());
  ASSERT_TRUE(table.samples.has_value());
  const FactorTable& samples = *table.samples;
  EXPECT_EQ(samples.looks, looks);
  EXPECT_EQ(samples.shared_count, drive.factors.factors.size()) << "not once for each look";
  const auto at = [&](std::size_t site, std::size_t look, const std::string& name) {
    const auto found = std::ranges::find(samples.factors, name);
    return samples.at(site, look, static_cast<std::size_t>(found - samples.factors.begin()));
  };
  for (std::size_t site = 0; site < samples.site_count; ++site) {
    const double errors_m[] = {measured.row(site, 0).from_given_m,
                               measured.row(site, 1).from_given_m};
    for (std::size_t look = 0; look < looks.size(); ++look) {
      EXPECT_EQ(at(site, look, "feature_count"), drive.factors.at(site, 1, 0)) << "longest range";
      EXPECT_EQ(at(site, look, "look_number"), static_cast<double>(look));
      if (site == 2) {
        EXPECT_EQ(at(site, look, "mapping_error"), drive.factors.at(site, 1, 2)) << "stand-in";
        continue;
      }
      EXPECT_EQ(at(site, look, "mapping_error"), errors_m[look]);
      EXPECT_DOUBLE_EQ(at(site, look, "mapping_error_mean"), (errors_m[0] + errors_m[1]) / 2.0);
      EXPECT_EQ(at(site, look, "mapping_error_max"), std::max(errors_m[0], errors_m[1]));
    }
    EXPECT_GT(at(site, 1, "match_cost"), at(site, 0, "match_cost"));
  }
}

TEST(AddMappingError, RefusesOtherSitesOtherRangesAndFactorsWithoutAStandIn) {
  SyntheticDrive other_sites = small_drive();
  other_sites.measured.scan_of_site.pop_back();
  other_sites.measured.rows.resize(
      other_sites.measured.shape().size(other_sites.measured.scan_of_site.size()));
  SyntheticDrive other_ranges = small_drive();
  other_ranges.measured.looks.back().range_m = 25.0;
  SyntheticDrive no_stand_in = small_drive();
  no_stand_in.factors.factors.back() = "crlb_max";
  for (const SyntheticDrive& drive : {other_sites, other_ranges, no_stand_in}) {
    const Error error = failure_of(added(drive).table);
    EXPECT_EQ(error.code, ErrorCode::kMismatchedInputs);
    EXPECT_EQ(error.place, "pass add-mapping-error");
  }
}

TEST(AddMappingError, WhatWasSimulatedStandsForBothAndSaysSo) {
  const SyntheticDrive drive = small_drive();
  MeasuredError simulated = drive.measured;
  simulated.reference = ErrorReference::kSimulated;
  simulated.scan_of_site[2] = 2;
  const FactorTable table = value_of(of_ranges(whole_rows(add_mapping_error(
      TestContext(), {}, drive.factors, simulated, nullptr, *sensor_profile("vlp-16")))));
  ASSERT_TRUE(validate(table).has_value());
  EXPECT_TRUE(is_simulated(table));
  EXPECT_FALSE(is_simulated(drive.factors));
  const std::size_t before = drive.factors.factors.size();
  ASSERT_EQ(table.factors.size(), before + 3);
  for (std::size_t site = 0; site < table.site_count; ++site) {
    for (std::size_t range = 0; range < table.looks.size(); ++range) {
      EXPECT_EQ(table.at(site, range, before), 1.0);
      EXPECT_EQ(table.at(site, range, before + 1), 2.0 * simulated.row(site, range).mean_m);
      EXPECT_EQ(table.at(site, range, before + 2), simulated.row(site, range).mean_m);
    }
  }
}

}  // namespace
}  // namespace sightline
