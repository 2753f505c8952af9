#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <memory>

#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/map/map_reader.h"
#include "passes/localize/measure_site.h"
#include "passes/matching/look_plan.h"
#include "tests/passes/vehicle/localized_room.h"

namespace sightline {
namespace {

// To the bit, but that a start passes through the world.
void expect_same(const sightline_match& found, const MatchResult& expected, const MapFrame& frame) {
  EXPECT_EQ(PoseRows(found.T_world_vehicle), world_rows(expected.T_map_sensor, frame));
  EXPECT_EQ(found.score, expected.score);
  EXPECT_EQ(found.nearest_voxel_likelihood, expected.nearest_voxel_likelihood);
  EXPECT_EQ(found.iterations, expected.iterations);
  EXPECT_EQ(found.work, expected.work);
  EXPECT_EQ(found.stop, static_cast<unsigned>(expected.stop));
  EXPECT_EQ(found.scored_points, expected.scored_points);
}

Pose through_world(const Pose& T_map, const MapFrame& frame) {
  return rebase(rebase(T_map, frame, MapFrame{}), MapFrame{}, frame);
}

struct CompilersOwn {
  explicit CompilersOwn(const std::string& path)
      : map(read_map(path).value()),
        choice(choice_of(map.measurement)),
        own(make_localizer(map.ndt, localizer_options(choice.kind, choice.coarse_cells))),
        of_samples(make_localizer(map.ndt, options_for_samples(choice.coarse_cells))),
        structures(map.ndt, own.levels.back().grid) {}

  static LocalizerChoice choice_of(const MeasurementCard& card) {
    LocalizerChoice choice{.coarse_cells = static_cast<int>(card.coarse_cells),
                           .leaf_m = card.leaf_m};
    if (card.localizer.name == "plain") choice.kind = LocalizerKind::kPlain;
    if (card.localizer.name == "annealed") choice.kind = LocalizerKind::kAnnealed;
    return choice;
  }
  [[nodiscard]] std::unique_ptr<SiteLocalizer> at_site() const {
    return make_site_localizer({choice, map.sensor, map.ndt, own, of_samples, &structures});
  }

  CompiledMap map;
  LocalizerChoice choice;
  Localizer own;
  Localizer of_samples;
  StructureMap structures;
};

TEST(SameAsCompiler, MatchesAsTheCompilerDoesToTheBit) {
  Random random(3);
  for (const char* name : {"plain", "annealed", "searching"}) {
    const std::string path = written_room(name);
    const CompilersOwn compiler(path);
    const MapFrame& frame = compiler.map.ndt.frame;
    const Opened opened(path);
    ASSERT_EQ(opened.code, 0) << opened.message;
    EXPECT_STREQ(opened.info().localizer, name);
    const std::unique_ptr<SiteLocalizer> site = compiler.at_site();
    for (const Look& look : kLooks) {
      const Scan scan = float_scan(random.next(), 4000);
      const sightline_points points = points_of(scan);
      const sightline_look wanted = c_look(look);
      for (int trial = 0; trial < 3; ++trial) {
        site->take(scan, look);  // anew: starts of one scan share climbs, and a vehicle has one
        const Pose T_map_start = random_start(random);
        const PoseRows start = world_rows(T_map_start, frame);
        sightline_match match;
        ASSERT_EQ(sightline_localizer_match(opened.localizer, &points, start.data(), &wanted,
                                            nullptr, &match),
                  0);
        expect_same(match, site->match(through_world(T_map_start, frame)), frame);
        EXPECT_EQ(match.point_count, site->point_count());
        EXPECT_EQ(match.look_count, 1);
        EXPECT_EQ(match.stop, SIGHTLINE_CONVERGED);
      }
    }
  }
}

TEST(SameAsCompiler, MatchesFromAKnownStartAsTheCompilerDoesToTheBit) {
  Random random(6);
  const std::string path = written_room("searching");
  const CompilersOwn compiler(path);
  const MapFrame& frame = compiler.map.ndt.frame;
  const Opened opened(path);
  const std::unique_ptr<SiteLocalizer> site = compiler.at_site();
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << 0.01, 0.04, 0.0025, 1e-4, 1e-4, 1e-4;
  sightline_match_options options{};
  options.start_covariance = covariance.data();
  for (const Look& look : kLooks) {
    const Scan scan = float_scan(random.next(), 4000);
    const sightline_points points = points_of(scan);
    const sightline_look wanted = c_look(look);
    const Pose T_map_start = random_start(random);
    const PoseRows start = world_rows(T_map_start, frame);
    sightline_match match;
    ASSERT_EQ(sightline_localizer_match(opened.localizer, &points, start.data(), &wanted, &options,
                                        &match),
              0);
    site->take(scan, look);
    expect_same(match, site->match_known({through_world(T_map_start, frame), covariance}), frame);
  }
}

TEST(SameAsCompiler, GoesByAPlanAsTheCompilerDoesToTheBit) {
  Random random(4);
  const std::string path = written_room("searching");
  const CompilersOwn compiler(path);
  const MapFrame& frame = compiler.map.ndt.frame;
  const Opened opened(path);
  LookMemory memory{LookCutter(compiler.choice.leaf_m), {}};
  int second_count = 0;
  for (int trial = 0; trial < 20; ++trial) {
    LookPlan plan;
    plan.first = kLooks[5];
    plan.second = kLooks[3];
    for (double& weight : plan.test.weights) weight = random.uniform(-1.0, 1.0);
    plan.doubt_above = random.uniform(-1.0, 1.0);
    sightline_look_plan wanted{};
    wanted.first = c_look(plan.first);
    wanted.has_second = 1;
    std::copy(plan.test.weights.begin(), plan.test.weights.end(), wanted.weights);
    wanted.doubt_above = plan.doubt_above;
    wanted.second = c_look(plan.second);
    const Scan scan = float_scan(random.next(), 3000);
    const sightline_points points = points_of(scan);
    const Pose T_map_start = random_start(random);
    const PoseRows start = world_rows(T_map_start, frame);
    sightline_match match;
    ASSERT_EQ(sightline_localizer_match_plan(opened.localizer, &points, start.data(), &wanted,
                                             nullptr, &match),
              0);
    const PlannedMatch expected =
        localize_in_looks({compiler.of_samples, compiler.map.sensor, plan}, scan,
                          {through_world(T_map_start, frame), true}, memory);
    expect_same(match, expected.match, frame);
    EXPECT_EQ(match.look_count, expected.look_count);
    second_count += match.look_count - 1;
    // Without a second look a plan is its first.
    wanted.has_second = 0;
    sightline_match by_plan, by_look;
    const sightline_look first = c_look(plan.first);
    sightline_localizer_match_plan(opened.localizer, &points, start.data(), &wanted, nullptr,
                                   &by_plan);
    sightline_localizer_match(opened.localizer, &points, start.data(), &first, nullptr, &by_look);
    EXPECT_EQ(bytes_of(by_plan), bytes_of(by_look));
  }
  EXPECT_GT(second_count, 0);
  EXPECT_LT(second_count, 20);
}

struct RoomCloud {
  RoomCloud() : folder(scratch_folder() / "room_cloud") {
    std::filesystem::create_directories(folder);
    for (const Eigen::Vector3d& point_m : room_points(21, 30000, 0.02)) {
      points.push_back({static_cast<float>(point_m.x() + 700.0),
                        static_cast<float>(point_m.y() - 300.0), static_cast<float>(point_m.z())});
    }
    const std::span<const PointXyzi> all(points);
    EXPECT_TRUE(write_pcd_binary(file(), all, IfExists::kReplace));
    EXPECT_TRUE(write_pcd_binary(folder / "0.pcd", all.first(10000), IfExists::kReplace));
    EXPECT_TRUE(write_pcd_binary(folder / "1.pcd", all.subspan(10000), IfExists::kReplace));
  }
  [[nodiscard]] std::filesystem::path file() const { return scratch_folder() / "room.pcd"; }
  std::filesystem::path folder;
  std::vector<PointXyzi> points;
};

TEST(SameAsCompiler, MatchesInAPointCloudAsInTheNdsThatTheCompilerMakesOfIt) {
  const RoomCloud cloud;
  MapFrame frame;
  frame.origin_world_m = {640.0, -320.0, -64.0};
  std::vector<Eigen::Vector3d> points_m;
  for (const PointXyzi& point : cloud.points) {
    points_m.emplace_back(point.x_m - 640.0, point.y_m + 320.0, point.z_m + 64.0);
  }
  const NdtMap map = ndt_from_points(points_m, frame, {}, 1);
  const Localizer own = make_localizer(map, localizer_named("searching"));
  const Localizer of_samples = make_localizer(map, options_for_samples());
  const SensorProfile sensor;
  const std::unique_ptr<SiteLocalizer> site =
      make_site_localizer({{}, sensor, map, own, of_samples});
  Random random(5);
  for (const std::string& path : {cloud.file().string(), cloud.folder.string()}) {
    const Opened opened(path);
    ASSERT_EQ(opened.code, 0) << opened.message;
    const sightline_localizer_info info = opened.info();
    EXPECT_EQ(Eigen::Vector3d(info.origin_world_m), frame.origin_world_m);
    ASSERT_EQ(info.nd_count, map.nds.size());
    for (std::size_t i = 0; i < info.nd_count; ++i) {
      EXPECT_EQ(Eigen::Vector3d(info.nds[i].mean_world_m),
                map.nds[i].mean_m + frame.origin_world_m);
      EXPECT_EQ(info.nds[i].covariance_m2[4], map.nds[i].covariance_m2(1, 2));
      EXPECT_EQ(info.nds[i].point_count, map.nds[i].point_count);
    }
    for (const Look& look : kLooks) {
      const Scan scan = float_scan(random.next(), 3000);
      const sightline_points points = points_of(scan);
      const sightline_look wanted = c_look(look);
      Pose T_map_start = random_start(random);
      T_map_start.translation() += Eigen::Vector3d(60.0, 20.0, 64.0);
      const PoseRows start = world_rows(T_map_start, frame);
      sightline_match match;
      ASSERT_EQ(sightline_localizer_match(opened.localizer, &points, start.data(), &wanted, nullptr,
                                          &match),
                0);
      site->take(scan, look);
      expect_same(match, site->match(through_world(T_map_start, frame)), frame);
    }
  }
}

}  // namespace
}  // namespace sightline
