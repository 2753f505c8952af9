#include "passes/factors/compute_factors.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "formats/base/random.h"
#include "passes/map/build_ndt.h"
#include "passes/pass/default_looks.h"
#include "tests/passes/factors/plain_factors.h"
#include "tests/support/test_context.h"
#include "tests/support/toy_world.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

struct FactorInputs {
  NdtMap map;
  Sites sites;
  DepthImages depth;
  VirtualScans scans;
};

// Depths and virtual points need not fit the map: factors do not ask where they came from.
void look_around(std::uint64_t seed, FactorInputs& inputs) {
  Random random(seed);
  inputs.depth.azimuth_count = 36;
  inputs.depth.elevation_count = 5;
  inputs.depth.site_count = static_cast<std::uint32_t>(inputs.sites.sites.size());
  for (std::size_t i = 0; i < inputs.sites.sites.size() * inputs.depth.cells_per_site(); ++i) {
    const double distance_m = random.uniform(1.0, 80.0);
    inputs.depth.distance_m.push_back(static_cast<float>(
        distance_m > 50.0 ? std::numeric_limits<double>::infinity() : distance_m));
  }
  for (std::size_t site = 0; site < inputs.sites.sites.size(); ++site) {
    for (int i = 0; i < 300; ++i) {
      inputs.scans.points_m.emplace_back(random.uniform(-40.0, 40.0), random.uniform(-40.0, 40.0),
                                         random.uniform(-4.0, 4.0));
    }
    inputs.scans.end.push_back(inputs.scans.points_m.size());
  }
}

FactorInputs random_inputs(std::uint64_t seed, std::size_t site_count, double tile_m = 64.0) {
  FactorInputs inputs;
  inputs.map = random_ndt_map(seed, 2500, 60.0, 2.0, tile_m);
  Random random(mix(seed, 1));
  for (std::size_t i = 0; i < site_count; ++i) {
    Site site;
    site.s_m = static_cast<double>(i);
    site.p_map_m = {random.uniform(-20.0, 20.0), random.uniform(-20.0, 20.0),
                    random.uniform(0.0, 2.0)};
    inputs.sites.sites.push_back(site);
  }
  look_around(mix(seed, 2), inputs);
  return inputs;
}

Result<SeenFactors> compute(const PassContext& ctx, const FactorInputs& inputs,
                            const std::vector<double>& ranges_m) {
  SIGHTLINE_ASSIGN(const FactorWorld world, make_factor_world(inputs.map, ranges_m));
  return compute_factors(ctx, world, inputs.sites, inputs.depth, inputs.scans);
}

FactorTable must_compute(const FactorInputs& inputs, int threads = 1,
                         const std::vector<double>& ranges_m = default_ranges_m()) {
  const SeenFactors seen = value_of(compute(TestContext(threads), inputs, ranges_m));
  EXPECT_TRUE(validate(seen.table).has_value());
  return seen.table;
}

double value(const FactorTable& table, std::size_t site, std::size_t range,
             const std::string& factor) {
  const auto column = std::find(table.factors.begin(), table.factors.end(), factor);
  EXPECT_NE(column, table.factors.end()) << factor;
  return table.at(site, range, static_cast<std::size_t>(column - table.factors.begin()));
}

void expect_near_relative(double found, double expected, const std::string& factor) {
  EXPECT_NEAR(found, expected, 1e-9 * std::abs(expected) + 1e-12) << factor;
}

double share_within(const DepthImages& depth, std::size_t site, double range_m) {
  double occupied = 0.0;
  for (const float distance_m : depth.image_of(site)) occupied += distance_m <= range_m ? 1 : 0;
  return occupied / static_cast<double>(depth.cells_per_site());
}

void expect_plain_counts(const FactorInputs& inputs, const FactorTable& table, std::size_t site,
                         std::size_t range) {
  const Eigen::Vector3d& p = inputs.sites.sites[site].p_map_m;
  const double range_m = table.looks[range].range_m;
  const std::vector<const Nd*> nds = plain::within(inputs.map, p, range_m);
  const auto found = [&](const std::string& factor) { return value(table, site, range, factor); };
  const auto size = static_cast<double>(nds.size());
  EXPECT_EQ(found("feature_count"), size);
  for (int which = 1; which <= 3; ++which) {
    const std::string name =
        std::array<const char*, 3>{"d1", "d2", "d3"}.at(static_cast<std::size_t>(which - 1));
    const double count = plain::dimension_count(nds, which);
    EXPECT_EQ(found(name + "_count"), count);
    expect_near_relative(found(name + "_ratio"), nds.empty() ? 0.0 : count / size, name);
  }
  expect_near_relative(found("occupancy_ratio"), share_within(inputs.depth, site, range_m),
                       "occupancy_ratio");
  expect_near_relative(found("normal_entropy"), plain::normal_entropy(nds), "normal_entropy");
  expect_near_relative(found("r_average"), plain::r_average(nds, p, range_m), "r_average");
}

void expect_plain_bounds(const FactorInputs& inputs, const FactorTable& table, std::size_t site,
                         std::size_t range) {
  const plain::Bound bound =
      plain::bound(plain::by_cell(inputs.map), inputs.map.cell_m, inputs.sites.sites[site].p_map_m,
                   inputs.scans.points_of(site), table.looks[range].range_m);
  const auto found = [&](const std::string& factor) { return value(table, site, range, factor); };
  expect_near_relative(found("crlb_max"), bound.max_m, "crlb_max");
  expect_near_relative(found("crlb_min"), bound.min_m, "crlb_min");
  expect_near_relative(found("crlb_yaw"), bound.yaw_rad, "crlb_yaw");
  expect_near_relative(found("hz_lmin"), bound.hz_lmin, "hz_lmin");
  EXPECT_EQ(found("virtual_points"), bound.points);
  // A direction: 179.9 and 0.1 degrees are neighbours; round uncertainty has none.
  if (bound.max_m < 1.0001 * bound.min_m) return;
  const double apart_deg = std::abs(found("crlb_heading") - bound.heading_deg);
  EXPECT_LT(std::min(apart_deg, 180.0 - apart_deg), 1e-5);
}

void expect_plain_scores(const FactorInputs& inputs, const FactorTable& table, std::size_t site) {
  const plain::NdByCell cells = plain::by_cell(inputs.map);
  const Eigen::Vector3d& p = inputs.sites.sites[site].p_map_m;
  std::vector<std::vector<double>> score(table.looks.size(), std::vector<double>(289, 0.0));
  for (const Nd& nd : inputs.map.nds) {
    const double distance_m = (nd.mean_m - p).norm();
    if (distance_m > table.looks.back().range_m) continue;
    const std::vector<double> sent = plain::self_score(nd, cells, inputs.map.cell_m);
    for (std::size_t range = 0; range < score.size(); ++range) {
      if (distance_m > table.looks[range].range_m) continue;
      for (std::size_t v = 0; v < sent.size(); ++v) score[range][v] += sent[v];
    }
  }
  for (std::size_t range = 0; range < score.size(); ++range) {
    expect_near_relative(value(table, site, range, "score_entropy"),
                         plain::score_entropy(score[range]), "score_entropy");
    expect_near_relative(value(table, site, range, "flat_050"), plain::flat_050(score[range]),
                         "flat_050");
  }
}

TEST(ComputeFactors, EqualsAPlainImplementationAtAllNineRanges) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const FactorInputs inputs = random_inputs(seed, 6);
    const FactorTable table = must_compute(inputs);
    ASSERT_EQ(table.looks.size(), 9U);
    for (std::size_t site = 0; site < 6; ++site) {
      for (std::size_t range = 0; range < 9; ++range) {
        expect_plain_counts(inputs, table, site, range);
        expect_plain_bounds(inputs, table, site, range);
      }
    }
  }
}

TEST(ComputeFactors, EqualsAPlainSelfScoreAtAllNineRanges) {
  for (std::uint64_t seed = 4; seed <= 5; ++seed) {
    const FactorInputs inputs = random_inputs(seed, 1);
    expect_plain_scores(inputs, must_compute(inputs), 0);
  }
}

TEST(ComputeFactors, EqualsAPlainImplementationOnADrawnTown) {
  const ToyWorld world = draw_world(R"(
####################
....................
..o......@.......o..
....................
########...#########
       #...#
       #.@.#
)");
  const NdtMap map = value_of(whole_rows(build_ndt(TestContext(), {}, world.points)));
  FactorInputs inputs{map, world.sites, {}, {}};
  look_around(7, inputs);
  const FactorTable table = must_compute(inputs);
  for (std::size_t site = 0; site < world.sites.sites.size(); ++site) {
    expect_plain_scores(inputs, table, site);
    for (std::size_t range = 0; range < 9; ++range) {
      expect_plain_counts(inputs, table, site, range);
      expect_plain_bounds(inputs, table, site, range);
    }
  }
}

TEST(ComputeFactors, GivesTheSameBytesForTilesOf32And64AndAnyNumberOfThreads) {
  const FactorInputs large = random_inputs(8, 70, 64.0);  // more than one group
  const FactorInputs small = random_inputs(8, 70, 32.0);
  const std::vector<double> ranges_m = {15.0, 50.0};
  const std::vector<std::byte> bytes = to_bytes(must_compute(large, 1, ranges_m));
  EXPECT_EQ(bytes, to_bytes(must_compute(large, 3, ranges_m)));
  EXPECT_EQ(bytes, to_bytes(must_compute(small, 1, ranges_m)));
}

TEST(ComputeFactors, GivesASiteTheSameValuesWhoeverItsNeighboursAre) {
  const FactorInputs many = random_inputs(9, 3);
  const FactorTable table = must_compute(many);
  FactorInputs alone = many;
  alone.sites.sites = {many.sites.sites[2]};
  alone.depth.site_count = 1;
  alone.depth.distance_m.assign(many.depth.image_of(2).begin(), many.depth.image_of(2).end());
  alone.scans.points_m.assign(many.scans.points_of(2).begin(), many.scans.points_of(2).end());
  alone.scans.end = {alone.scans.points_m.size()};
  const FactorTable lonely = must_compute(alone);
  const std::size_t row = table.looks.size() * table.factors.size();
  EXPECT_TRUE(std::equal(lonely.values.begin(), lonely.values.end(),
                         table.values.begin() + static_cast<long>(2 * row)));
}

TEST(ComputeFactors, SeesNothingBeyondItsHalo) {
  const FactorInputs inputs = random_inputs(10, 1);
  const std::vector<double> near = {5.0, 10.0, 20.0};
  FactorInputs cut = inputs;
  const double halo_m = 20.0 + 2.0 * std::sqrt(2.0) + 2.0 * inputs.map.cell_m;
  std::erase_if(cut.map.nds, [&](const Nd& nd) {
    return (nd.mean_m - inputs.sites.sites[0].p_map_m).norm() > halo_m;
  });
  ASSERT_LT(cut.map.nds.size(), inputs.map.nds.size());
  FactorInputs near_only = cut;
  // Virtual points reach further than the ranges asked for; they must not matter either.
  EXPECT_EQ(must_compute(inputs, 1, near).values, must_compute(near_only, 1, near).values);
}

TEST(ComputeFactors, KeepsThePropertiesThatDefinitionsImply) {
  const FactorTable table = must_compute(random_inputs(11, 20));
  for (std::size_t site = 0; site < 20; ++site) {
    for (std::size_t range = 0; range < 9; ++range) {
      const auto at = [&](const std::string& factor) { return value(table, site, range, factor); };
      const double count = at("feature_count");
      EXPECT_EQ(at("d1_count") + at("d2_count") + at("d3_count"), count);
      EXPECT_NEAR(at("d1_ratio") + at("d2_ratio") + at("d3_ratio"), count > 0 ? 1.0 : 0.0, 1e-12);
      EXPECT_GE(at("normal_entropy"), 0.0);
      EXPECT_LE(at("normal_entropy"), std::log2(73.0));
      EXPECT_GE(at("score_entropy"), 0.0);
      EXPECT_LE(at("score_entropy"), std::log2(289.0) + 1e-12);
      EXPECT_LE(at("r_average"), table.looks[range].range_m);
      EXPECT_GE(at("crlb_max"), at("crlb_min"));
      EXPECT_LE(at("crlb_max"), 10.0 + 1e-9);  // the prior's
      EXPECT_GE(at("crlb_heading"), 0.0);
      EXPECT_LT(at("crlb_heading"), 180.0);
      if (range == 0) continue;
      for (const char* factor : {"feature_count", "d1_count", "d2_count", "d3_count",
                                 "occupancy_ratio", "virtual_points"}) {
        EXPECT_GE(at(factor), value(table, site, range - 1, factor)) << factor;
      }
      EXPECT_LE(at("crlb_max"), value(table, site, range - 1, "crlb_max") + 1e-12);
      EXPECT_GE(at("hz_lmin"), value(table, site, range - 1, "hz_lmin") - 1e-12);
    }
  }
}

TEST(ComputeFactors, DoesNotMoveWhenTheWorldIsShiftedByWholeCells) {
  const FactorInputs inputs = random_inputs(12, 5);
  FactorInputs moved = inputs;
  const CellKey by{64, -96, 3};
  const Eigen::Vector3d by_m = 2.0 * Eigen::Vector3d(by.x, by.y, by.z);
  for (Nd& nd : moved.map.nds) {
    nd.key = {nd.key.x + by.x, nd.key.y + by.y, nd.key.z + by.z};
    nd.mean_m += by_m;
  }
  for (Site& site : moved.sites.sites) site.p_map_m += by_m;
  const FactorTable before = must_compute(inputs);
  const FactorTable after = must_compute(moved);
  for (std::size_t i = 0; i < before.values.size(); ++i) {
    const std::string& factor = before.factors[i % before.factors.size()];
    // Positions round to other doubles; directions of nearly round bounds turn more than that.
    const double tolerance = factor == "crlb_heading" ? 1e-4 : 1e-9;
    EXPECT_NEAR(before.values[i], after.values[i], tolerance) << factor;
  }
}

TEST(ComputeFactors, GivesAnEmptyPlaceTheValuesThatDefinitionsNameForIt) {
  FactorInputs inputs;
  inputs.map = random_ndt_map(13, 100, 20.0);
  Site site;
  site.p_map_m = {500.0, 500.0, 0.0};
  inputs.sites.sites = {site};
  inputs.depth.site_count = 1;
  inputs.depth.distance_m.assign(inputs.depth.cells_per_site(),
                                 std::numeric_limits<float>::infinity());
  inputs.scans.end = {0};
  const FactorTable table = must_compute(inputs);
  for (std::size_t range = 0; range < 9; ++range) {
    EXPECT_EQ(value(table, 0, range, "feature_count"), 0.0);
    EXPECT_EQ(value(table, 0, range, "d2_ratio"), 0.0);
    EXPECT_EQ(value(table, 0, range, "occupancy_ratio"), 0.0);
    EXPECT_EQ(value(table, 0, range, "normal_entropy"), 0.0);
    EXPECT_EQ(value(table, 0, range, "r_average"), table.looks[range].range_m);
    EXPECT_EQ(value(table, 0, range, "score_entropy"), std::log2(289.0));
    EXPECT_EQ(value(table, 0, range, "flat_050"), 1.0);
    EXPECT_NEAR(value(table, 0, range, "crlb_max"), 10.0, 1e-12);
  }
}

TEST(ComputeFactors, CountsVirtualPointsThatLieInNoValidNd) {
  const FactorInputs inputs = random_inputs(14, 1);
  const SeenFactors seen = value_of(compute(PassContext{}, inputs, default_ranges_m()));
  EXPECT_EQ(seen.point_count, 300U);
  EXPECT_GT(seen.unmatched_count, 0U);
  EXPECT_LT(seen.unmatched_count, 300U);
}

ErrorCode code_of_failure(const FactorInputs& inputs,
                          const std::vector<double>& ranges_m = default_ranges_m()) {
  const Result<SeenFactors> seen = compute(PassContext{}, inputs, ranges_m);
  EXPECT_FALSE(seen.has_value());
  return seen.has_value() ? ErrorCode{} : seen.error().code;
}

TEST(ComputeFactors, RefusesInputsThatDoNotBelongTogether) {
  FactorInputs other_frame = random_inputs(15, 2);
  other_frame.map.frame.origin_world_m.x() = 64.0;
  EXPECT_EQ(code_of_failure(other_frame), ErrorCode::kMismatchedInputs);
  FactorInputs fewer_scans = random_inputs(15, 2);
  fewer_scans.scans.end.pop_back();
  EXPECT_EQ(code_of_failure(fewer_scans), ErrorCode::kMismatchedInputs);
  FactorInputs short_rays = random_inputs(15, 2);
  short_rays.depth.longest_range_m = 30.0;
  EXPECT_EQ(code_of_failure(short_rays), ErrorCode::kMismatchedInputs);
}

TEST(ComputeFactors, RefusesRangesThatDoNotAscend) {
  const FactorInputs inputs = random_inputs(16, 1);
  EXPECT_EQ(code_of_failure(inputs, {20.0, 10.0}), ErrorCode::kBadValue);
  EXPECT_EQ(code_of_failure(inputs, {10.0, 10.0}), ErrorCode::kBadValue);
  EXPECT_EQ(code_of_failure(inputs, {}), ErrorCode::kBadValue);
  EXPECT_EQ(code_of_failure(inputs, {0.0, 10.0}), ErrorCode::kBadValue);
}

}  // namespace
}  // namespace sightline
