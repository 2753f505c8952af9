#include "tests/formats/reader/c_interface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_writer.h"
#include "formats/reader/reader.h"
#include "tests/formats/map/random_map.h"
#include "tests/formats/map/resealed.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

std::string written_map(const std::vector<std::byte>& file, const char* name) {
  const std::filesystem::path path = scratch_folder() / name;
  EXPECT_TRUE(write_file_atomically(path, file, IfExists::kReplace));
  return path.string();
}

TEST(CInterface, AnswersWhatTheCppInterfaceAnswers) {
  const CompiledMap map = random_map({.seed = 1});
  const std::string path = written_map(encode_map(map), "c_interface.slmap");
  const MapReader reader = value_of(MapReader::open(path, "annealed"));
  const Eigen::Vector3d p_m = map.sites.sites[3].p_map_m + map.sites.frame.origin_world_m;
  sightline_range range;
  ASSERT_EQ(range_from_c(path.c_str(), p_m.data(), 0.1, &range), 0);
  const RangeAnswer expected = value_of(reader.observation_range({p_m[0], p_m[1], p_m[2]}, 0.1));
  EXPECT_EQ(range.range_m, expected.range_m);
  EXPECT_EQ(range.probability, expected.probability);
  EXPECT_EQ(range.mean_error_m, expected.mean_error_m);
  EXPECT_EQ(range.distance_m, expected.distance_m);
  EXPECT_EQ(range.flags, expected.flags);
  EXPECT_EQ(range.site, 3u);
}

TEST(CInterface, NamesTheLookThatTheCppInterfaceNames) {
  const CompiledMap map = random_map({.seed = 5});
  const std::string path = written_map(encode_map(map), "c_look.slmap");
  const MapReader reader = value_of(MapReader::open(path, "annealed"));
  sightline_map* opened = nullptr;
  ASSERT_EQ(sightline_open(path.c_str(), "annealed", &opened, nullptr, 0), 0);
  for (const Site& site : map.sites.sites) {
    const Eigen::Vector3d p_m = site.p_map_m + map.sites.frame.origin_world_m;
    for (const double visible_m : {5.0, 90.0, std::numeric_limits<double>::infinity()}) {
      sightline_look look;
      ASSERT_EQ(sightline_get_look(opened, p_m.data(), 0.25, visible_m, &look), 0);
      const LookAnswer expected = value_of(reader.look({p_m[0], p_m[1], p_m[2]}, 0.25, visible_m));
      EXPECT_EQ(look.range_m, expected.look.range_m);
      EXPECT_EQ(look.return_count, expected.look.return_count);
      EXPECT_EQ(look.even_beyond_m, expected.look.even_beyond_m);
      EXPECT_EQ(look.point_count, expected.look.point_count);
      EXPECT_EQ(look.is_by_normals != 0, expected.look.is_by_normals);
      EXPECT_EQ(look.settles != 0, expected.look.settles);
      EXPECT_EQ(look.probability, expected.probability);
      EXPECT_EQ(look.mean_error_m, expected.mean_error_m);
      EXPECT_EQ(look.flags, expected.flags);
      EXPECT_EQ(look.site, expected.site);
    }
  }
  sightline_look look;
  const double nowhere_m[3] = {NAN, 0.0, 0.0};
  EXPECT_NE(sightline_get_look(opened, nowhere_m, 0.25, 90.0, &look), 0);
  EXPECT_EQ(look.range_m, 50.0);
  EXPECT_EQ(look.flags, SIGHTLINE_FAR);
  sightline_close(opened);
}

TEST(CInterface, NamesTheRulesThatDecided) {
  const CompiledMap map = random_map({.seed = 5});
  const std::string path = written_map(encode_map(map), "c_reasons.slmap");
  const Result<MapReader> reader = MapReader::open(path, "annealed");
  ASSERT_TRUE(reader) << to_string(reader.error());
  sightline_map* opened = nullptr;
  ASSERT_EQ(sightline_open(path.c_str(), "annealed", &opened, nullptr, 0), 0);
  sightline_reasons reasons;
  for (std::size_t site = 0; site < map.sites.sites.size(); ++site) {
    const Eigen::Vector3d p_m = map.sites.sites[site].p_map_m + map.sites.frame.origin_world_m;
    ASSERT_EQ(sightline_get_reasons(opened, p_m.data(), 0.25, &reasons), 0);
    EXPECT_EQ(sightline_reason_name(reasons.range), name_of(map.ranges.reason(site, 1)));
    EXPECT_EQ(sightline_reason_name(reasons.look),
              name_of(reader->look({p_m[0], p_m[1], p_m[2]}, 0.25)->reason));
  }
  const double far_m[3] = {1e6, 0.0, 0.0};
  const double nowhere_m[3] = {NAN, 0.0, 0.0};
  EXPECT_EQ(sightline_get_reasons(opened, far_m, 0.25, &reasons), 0);
  EXPECT_STREQ(sightline_reason_name(reasons.range), "none");
  EXPECT_NE(sightline_get_reasons(opened, nowhere_m, 0.25, &reasons), 0);
  EXPECT_EQ(reasons.look, 0U);
  EXPECT_STREQ(sightline_reason_name(12), "unknown");
  sightline_close(opened);
}

TEST(CInterface, TellsThePlanThatTheCppInterfaceTells) {
  const CompiledMap map = random_map({.seed = 5});
  const std::string path = written_map(encode_map(map), "c_plan.slmap");
  const MapReader reader = value_of(MapReader::open(path, "annealed"));
  sightline_map* opened = nullptr;
  ASSERT_EQ(sightline_open(path.c_str(), "annealed", &opened, nullptr, 0), 0);
  for (const Site& site : map.sites.sites) {
    const Eigen::Vector3d p_m = site.p_map_m + map.sites.frame.origin_world_m;
    for (const int is_tracking : {0, 1}) {
      sightline_look_plan plan;
      ASSERT_EQ(sightline_get_look_plan(opened, p_m.data(), 0.35, is_tracking, 200.0, &plan), 0);
      const LookPlanAnswer expected =
          value_of(reader.look_plan({p_m[0], p_m[1], p_m[2]}, 0.35, is_tracking != 0, 200.0));
      EXPECT_EQ(plan.has_second, is_tracking);
      EXPECT_EQ(plan.has_second != 0, expected.has_second);
      EXPECT_EQ(plan.first.point_count, expected.first.look.point_count);
      EXPECT_EQ(plan.first.settles != 0, expected.first.look.settles);
      EXPECT_EQ(plan.second.return_count, expected.second.return_count);
      EXPECT_EQ(plan.constant, expected.constant);
      EXPECT_EQ(plan.doubt_above, expected.doubt_above);
      for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(plan.weights[i], expected.weights[i]);
      EXPECT_EQ(plan.first.site, expected.first.site);
    }
  }
  sightline_look_plan plan;
  const double nowhere_m[3] = {NAN, 0.0, 0.0};
  EXPECT_NE(sightline_get_look_plan(opened, nowhere_m, 0.25, 1, 90.0, &plan), 0);
  EXPECT_EQ(plan.first.range_m, 50.0);
  EXPECT_EQ(plan.has_second, 0);
  sightline_close(opened);
}

TEST(CInterface, ListsEverySiteWithWhatIsAnsweredThere) {
  for (const std::uint64_t seed : {1U, 2U, 5U}) {
    const CompiledMap map = random_map({.seed = seed, .site_count = 130});
    const std::string path = written_map(encode_map(map), "c_sites.slmap");
    sightline_map* opened = nullptr;
    ASSERT_EQ(sightline_open(path.c_str(), "annealed", &opened, nullptr, 0), 0);
    for (std::size_t limit = 0; limit < 2; ++limit) {
      std::vector<sightline_site> sites(130);
      ASSERT_EQ(sightline_get_sites(opened, limit, sites.data(), sites.size()), 0);
      for (std::uint32_t i = 0; i < sites.size(); ++i) {
        const Eigen::Vector3d p_m = map.sites.sites[i].p_map_m + map.sites.frame.origin_world_m;
        EXPECT_EQ(Eigen::Vector3d(sites[i].position_world_m), p_m);
        sightline_range range;
        sightline_observation_range(opened, p_m.data(), limit == 0 ? 0.1 : 0.25, &range);
        EXPECT_EQ(sites[i].site, i);
        EXPECT_EQ(range.site, i);
        EXPECT_EQ(sites[i].range_m, range.range_m);
        EXPECT_EQ(sites[i].probability, range.probability);
        EXPECT_EQ(sites[i].mean_error_m, range.mean_error_m);
        EXPECT_EQ(sites[i].flags, range.flags);
      }
      EXPECT_EQ(sightline_get_sites(opened, limit, sites.data(), 129), 1001);
    }
    std::vector<sightline_site> sites(130);
    EXPECT_EQ(sightline_get_sites(opened, 2, sites.data(), sites.size()), 1001);
    sightline_close(opened);
  }
}

TEST(CInterface, GivesColumnsOfSites) {
  const CompiledMap map = random_map({.seed = 1, .site_count = 130, .has_columns = true});
  const std::string path = written_map(encode_map(map), "c_columns.slmap");
  sightline_map* opened = nullptr;
  ASSERT_EQ(sightline_open(path.c_str(), "annealed", &opened, nullptr, 0), 0);
  ASSERT_EQ(sightline_column_count(opened), 2U);
  sightline_column column;
  ASSERT_EQ(sightline_get_column(opened, 0, &column), 0);
  EXPECT_STREQ(column.name, "clearance_m");
  EXPECT_STREQ(column.unit, "m");
  EXPECT_EQ(std::vector<float>(column.values, column.values + column.count), map.columns[0].values);
  ASSERT_EQ(sightline_get_column(opened, 1, &column), 0);
  sightline_column again;
  ASSERT_EQ(sightline_get_column(opened, 1, &again), 0);
  EXPECT_EQ(again.values, column.values) << "kept until the map is closed";
  EXPECT_EQ(std::vector<float>(column.values, column.values + column.count), map.columns[1].values);
  sightline_errors errors;
  EXPECT_EQ(sightline_get_errors(opened, 7, 0, &errors), 0);
  EXPECT_TRUE(std::isinf(errors.longitudinal_m)) << "a map without these columns";
  sightline_protection protection;
  EXPECT_EQ(sightline_get_protection(opened, 7, 0.01, 0, &protection), 0);
  EXPECT_TRUE(std::isfinite(protection.protection_m[1])) << "of all kinds of place";
  EXPECT_EQ(sightline_get_protection(opened, 7, 0.0, 0, &protection),
            static_cast<int>(ErrorCode::kBadArgument));
  EXPECT_TRUE(std::isinf(protection.protection_m[1]));
  EXPECT_EQ(sightline_get_column(opened, 2, &column), 1001);
  EXPECT_EQ(column.count, 0U);
  EXPECT_EQ(column.values, nullptr);
  sightline_close(opened);
}

TEST(CInterface, ListsNoSitesWhereAPageOfThemIsDamaged) {
  std::vector<std::byte> file = encode_map(random_map({.seed = 1, .site_count = 130}));
  // A row in the last page but one of the section, which ends where the directory begins.
  file[header_fields(file).directory_offset - 2 * kPageSize + 100] ^= std::byte{1};
  const std::string path = written_map(file, "c_damaged_sites.slmap");
  sightline_map* opened = nullptr;
  ASSERT_EQ(sightline_open(path.c_str(), "annealed", &opened, nullptr, 0), 0);
  std::vector<sightline_site> sites(130);
  EXPECT_EQ(sightline_get_sites(opened, 0, sites.data(), sites.size()), 4003);
  sightline_close(opened);
}

TEST(CInterface, TellsMapAndRanges) {
  const CompiledMap map = random_map({.seed = 2});
  const std::string path = written_map(encode_map(map), "c_info.slmap");
  sightline_map* opened = nullptr;
  ASSERT_EQ(sightline_open(path.c_str(), "annealed", &opened, nullptr, 0), 0);
  sightline_info info;
  sightline_get_info(opened, &info);
  EXPECT_STREQ(info.map_id, map.map_id.c_str());
  EXPECT_STREQ(info.version, map.version.c_str());
  EXPECT_EQ(info.release, 7u);
  EXPECT_EQ(info.site_count, 40u);
  ASSERT_EQ(info.range_count, 3u);
  EXPECT_EQ(info.ranges_m[2], 50.0);
  ASSERT_EQ(info.limit_count, 2u);
  EXPECT_EQ(info.limits_m[1], 0.25);
  sightline_promise promise;
  ASSERT_EQ(sightline_get_promise(opened, 1, &promise), 0);
  EXPECT_EQ(promise.is_earned, 1);
  EXPECT_EQ(promise.is_of_next_drive, 1);
  EXPECT_EQ(promise.coverage, 0.95);
  EXPECT_EQ(promise.drive_count, 6u);
  EXPECT_STREQ(promise.statement, map.ranges.promises[1].statement.c_str());
  EXPECT_EQ(sightline_get_promise(opened, 2, &promise), 1001);
  EXPECT_EQ(promise.is_earned, 0);
  EXPECT_STREQ(info.localizer, "annealed");
  EXPECT_EQ(info.localizer_version, 3u);
  EXPECT_STREQ(info.localizer_parameters, "coarse_cells=2, leaf_m=0.5");
  EXPECT_EQ(info.is_for_caller, 1);
  sightline_close(opened);
  sightline_close(nullptr);
}

TEST(CInterface, KnowsNothingForALocalizerWhoseErrorsWereNotMeasured) {
  const CompiledMap map = random_map({.seed = 2});
  const std::string path = written_map(encode_map(map), "c_localizer.slmap");
  const Eigen::Vector3d p_m = map.sites.sites[3].p_map_m + map.sites.frame.origin_world_m;
  for (const char* localizer : {static_cast<const char*>(nullptr), "pcl-ndt"}) {
    sightline_map* opened = nullptr;
    ASSERT_EQ(sightline_open(path.c_str(), localizer, &opened, nullptr, 0), 0);
    sightline_range range;
    EXPECT_EQ(sightline_observation_range(opened, p_m.data(), 0.1, &range), 0);
    EXPECT_EQ(range.flags, SIGHTLINE_UNKNOWN_LOCALIZER);
    EXPECT_TRUE(std::isnan(range.probability));
    EXPECT_EQ(range.range_m, 50.0);
    EXPECT_EQ(range.site, 3u);
    sightline_close(opened);
  }
}

TEST(CInterface, OpensAMapInMemory) {
  const std::string path = written_map(encode_map(random_map({.seed = 3})), "c_memory.slmap");
  sightline_map* mapped = nullptr;
  sightline_map* copied = nullptr;
  ASSERT_EQ(sightline_open(path.c_str(), "annealed", &mapped, nullptr, 0), 0);
  ASSERT_EQ(sightline_open_in_memory(path.c_str(), "annealed", &copied, nullptr, 0), 0);
  sightline_info expected;
  sightline_info found;
  sightline_get_info(mapped, &expected);
  sightline_get_info(copied, &found);
  EXPECT_STREQ(found.map_id, expected.map_id);
  EXPECT_EQ(found.site_count, expected.site_count);
  sightline_close(mapped);
  sightline_close(copied);
  EXPECT_EQ(sightline_open_in_memory("/nowhere.slmap", nullptr, &copied, nullptr, 0), 2001);
  EXPECT_EQ(copied, nullptr);
  EXPECT_EQ(sightline_open_in_memory(nullptr, nullptr, nullptr, nullptr, 0), 1001);
}

TEST(CInterface, TellsWhyAMapCannotBeOpened) {
  sightline_map* map = reinterpret_cast<sightline_map*>(1);
  char message[40];
  EXPECT_EQ(sightline_open("/nowhere.slmap", "annealed", &map, message, sizeof message), 2001);
  EXPECT_EQ(map, nullptr);
  EXPECT_EQ(std::strlen(message), sizeof message - 1);
  EXPECT_EQ(std::string(message).rfind("SL2001 file-not-found: /nowhere.slmap", 0), 0u);
  EXPECT_STREQ(sightline_error_name(2001), "file-not-found");
  EXPECT_STREQ(sightline_error_name(1), "unknown");
}

TEST(CInterface, TellsWhoWroteAMapOfAnotherMajorVersion) {
  const std::vector<std::byte> file =
      with_header(encode_map(random_map({.seed = 4})), [](FileHeader& header) {
        header.version = {2, 0};
      });
  const std::string path = written_map(file, "c_version.slmap");
  sightline_map* map = nullptr;
  char message[400];
  EXPECT_EQ(sightline_open(path.c_str(), "annealed", &map, message, sizeof message), 3001);
  EXPECT_EQ(map, nullptr);
  EXPECT_NE(std::string(message).find("written by sightline test, format 2.0, this program reads "
                                      "1.0. Compile again, or use that version"),
            std::string::npos)
      << message;
}

TEST(CInterface, AnswersTheLongestRangeAlsoOnFailure) {
  const std::string path = written_map(encode_map(random_map({.seed = 3})), "c_failure.slmap");
  const double nowhere[3] = {NAN, 0.0, 0.0};
  sightline_range range;
  EXPECT_EQ(range_from_c(path.c_str(), nowhere, 0.1, &range), 1001);
  EXPECT_EQ(range.range_m, 50.0);
  EXPECT_EQ(range.probability, 0.0);
  EXPECT_EQ(range.flags, SIGHTLINE_FAR);
  EXPECT_EQ(range.site, SIGHTLINE_NO_SITE);
}

constexpr int kBadArgument = 1001;

TEST(CInterface, EveryPointerMayBeNull) {
  const std::string path = written_map(encode_map(random_map({.seed = 6})), "c_null.slmap");
  sightline_map* map = nullptr;
  EXPECT_EQ(sightline_open(nullptr, "annealed", &map, nullptr, 0), kBadArgument);
  EXPECT_EQ(sightline_open(path.c_str(), "annealed", nullptr, nullptr, 0), kBadArgument);
  ASSERT_EQ(sightline_open(path.c_str(), nullptr, &map, nullptr, 0), 0);
  const double p_m[3] = {};
  sightline_range range;
  sightline_reasons reasons;
  sightline_look look;
  sightline_look_plan plan;
  EXPECT_EQ(sightline_get_promise(map, 0, nullptr), kBadArgument);
  EXPECT_EQ(sightline_observation_range(map, p_m, 0.1, nullptr), kBadArgument);
  EXPECT_EQ(sightline_observation_range(map, nullptr, 0.1, &range), kBadArgument);
  EXPECT_EQ(range.range_m, 50.0);
  EXPECT_EQ(sightline_get_reasons(map, p_m, 0.1, nullptr), kBadArgument);
  EXPECT_EQ(sightline_get_reasons(map, nullptr, 0.1, &reasons), kBadArgument);
  EXPECT_EQ(sightline_get_look(map, p_m, 0.1, 50.0, nullptr), kBadArgument);
  EXPECT_EQ(sightline_get_look(map, nullptr, 0.1, 50.0, &look), kBadArgument);
  EXPECT_EQ(sightline_get_look_plan(map, p_m, 0.1, 1, 50.0, nullptr), kBadArgument);
  EXPECT_EQ(sightline_get_look_plan(map, nullptr, 0.1, 1, 50.0, &plan), kBadArgument);
  sightline_info info;
  sightline_get_info(map, nullptr);
  sightline_get_info(map, &info);
  EXPECT_EQ(sightline_get_sites(map, 0, nullptr, info.site_count), kBadArgument);
  EXPECT_EQ(sightline_get_column(map, 0, nullptr), kBadArgument);
  EXPECT_EQ(sightline_get_errors(map, 0, 0, nullptr), kBadArgument);
  sightline_close(map);
  sightline_close(nullptr);
}

TEST(CInterface, WithoutAMapTheLongestRangeIsInfinite) {
  const double p_m[3] = {};
  sightline_promise promise;
  sightline_range range;
  sightline_reasons reasons;
  sightline_look look;
  sightline_look_plan plan;
  sightline_column column;
  sightline_info info;
  sightline_get_info(nullptr, &info);
  EXPECT_STREQ(info.map_id, "");
  EXPECT_EQ(info.site_count, 0u);
  EXPECT_EQ(sightline_get_promise(nullptr, 0, &promise), kBadArgument);
  EXPECT_STREQ(promise.statement, "");
  EXPECT_EQ(sightline_observation_range(nullptr, p_m, 0.1, &range), kBadArgument);
  EXPECT_EQ(range.range_m, std::numeric_limits<double>::infinity());
  EXPECT_EQ(range.flags, SIGHTLINE_FAR);
  EXPECT_EQ(sightline_get_reasons(nullptr, p_m, 0.1, &reasons), kBadArgument);
  EXPECT_EQ(sightline_get_look(nullptr, p_m, 0.1, 50.0, &look), kBadArgument);
  EXPECT_EQ(look.flags, SIGHTLINE_FAR);
  EXPECT_EQ(sightline_get_look_plan(nullptr, p_m, 0.1, 1, 50.0, &plan), kBadArgument);
  EXPECT_EQ(plan.first.flags, SIGHTLINE_FAR);
  EXPECT_EQ(sightline_get_sites(nullptr, 0, nullptr, 0), kBadArgument);
  EXPECT_EQ(sightline_column_count(nullptr), 0u);
  EXPECT_EQ(sightline_get_column(nullptr, 0, &column), kBadArgument);
  sightline_errors errors;
  EXPECT_EQ(sightline_get_errors(nullptr, 0, 0, &errors), kBadArgument);
  EXPECT_EQ(errors.longitudinal_m, std::numeric_limits<double>::infinity());
  sightline_protection protection;
  EXPECT_EQ(sightline_get_protection(nullptr, 0, 0.01, 0, &protection), kBadArgument);
  EXPECT_EQ(protection.protection_m[1], std::numeric_limits<double>::infinity());
  EXPECT_EQ(sightline_get_protection(nullptr, 0, 0.01, 0, nullptr), kBadArgument);
}

}  // namespace
}  // namespace sightline
