#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "passes/map/build_ndt.h"
#include "tests/support/box_world.h"

namespace sightline {

// A street that was mapped, and a second drive along it, a scan every 0.4 m.
struct Street {
  NdtMap map;
  Sites sites;
  RangeTable ranges;  // 15 m, from site 4 on 30 m
  TestDrive second;
};

inline const Street& street() {
  static const Street kStreet = [] {
    Street made;
    const BoxWorld world = random_street(20);
    std::vector<Eigen::Vector3d> points_m;
    for (int i = 0; i < 16; ++i) {
      Site site;
      site.s_m = i;
      site.T_map_vehicle = pose_at(i, 0.0, 0.0);
      Pose T_map_lidar = site.T_map_vehicle;
      T_map_lidar.translation().z() = 2.0;
      site.p_map_m = T_map_lidar.translation();
      for (const Eigen::Vector3d& point_m : scan_world(world, T_map_lidar, 1.0).points_m) {
        points_m.push_back(T_map_lidar * point_m);
      }
      made.sites.sites.push_back(site);
      made.ranges.range_index.push_back(i < 4 ? 0 : 1);
      made.ranges.flags.push_back(0);
      made.ranges.reasons.push_back(Reason::kModel);
    }
    made.map = ndt_from_points(points_m, MapFrame{}, {}, 1);
    made.ranges.looks = every_return_at({15.0, 30.0});
    made.ranges.promises.resize(1);
    made.ranges.promises[0].limit_m = 0.1;
    made.ranges.site_count = 16;
    std::vector<Pose> poses;
    for (int i = 0; i < 18; ++i) poses.push_back(pose_at(0.5 + 0.4 * i, -0.3, 0.02));
    made.second = drive_through(world, poses, 1.0);
    return made;
  }();
  return kStreet;
}

inline ByFamily<RangeTable> ranges_with_looks(std::optional<LookPlan> plan) {
  ByFamily<RangeTable> ranges(street().ranges);
  RangeTable looks = ranges.ranges;
  looks.looks = {{.range_m = 30.0, .return_count = 300, .point_count = 60},
                 {.range_m = 30.0, .return_count = 800, .point_count = 150}};
  looks.plan = std::move(plan);
  ranges.samples = std::move(looks);
  return ranges;
}

}  // namespace sightline
