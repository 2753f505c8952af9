#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/surface.h"
#include "passes/pass/pass_context.h"
#include "passes/rays/site_blocks.h"

// Where rays meet a surface. The home of Embree: nothing else in passes/ knows it.

namespace sightline {

// Which directions lie in the azimuth view of a sensor: all, or those within half the view of where
// its +x axis points, both in the plane of the map.
class AzimuthView {
 public:
  AzimuthView() = default;  // all round
  explicit AzimuthView(const SensorProfile& sensor);

  [[nodiscard]] bool is_all_round() const { return is_all_round_; }
  // Where the sensor looks at a site, unit length, map axes: its +x axis, or the vehicle's where
  // that points straight up or down.
  [[nodiscard]] Eigen::Vector2d forward(const Site& site) const;
  [[nodiscard]] bool holds(const Eigen::Vector2d& forward, const Eigen::Vector3d& direction) const {
    const Eigen::Vector2d level = direction.head<2>();
    return is_all_round_ || level.dot(forward) >= least_cosine_ * level.norm();
  }

 private:
  bool is_all_round_ = true;
  double least_cosine_ = -1.0;  // of half the view
  Eigen::Vector3d x_in_vehicle_ = Eigen::Vector3d::UnitX();
};

// Whether anybody asks for a ray at a site, which is named by its position in what is cast from.
using WantsRay = std::function<bool(std::size_t site, std::size_t ray)>;

// Directions of unit length in map axes; neighbours in the list should be neighbours in the world,
// because eight rays at a time go through the scene together: of a sensor, beam by beam, not
// azimuth by azimuth, with which the whole of simulate-error took 1.6 times as long.
struct RayFan {
  std::vector<Eigen::Vector3d> directions;
  double near_m = 0.5;
  double far_m = 50.0;
  AzimuthView view = {};  // at each site rays out of it are not cast
  WantsRay wants = {};    // nor are those that it does not want; all are where it is empty
};

// distance_m[i] belongs to directions[i]: to the first hit between near_m and far_m, +inf where
// there is none, NaN where it was not cast. Sites are named by their position in what was cast
// from.
using TakeDistances = std::function<void(std::size_t site, std::span<const double> distance_m)>;

// What the sites of one block may see of a surface, in memory. Keeps references to sites and block.
class BlockScene {
 public:
  struct Patches;
  BlockScene(const Sites& sites, const SiteBlock& block, std::unique_ptr<const Patches> patches);
  BlockScene(BlockScene&&) noexcept;
  ~BlockScene();

  [[nodiscard]] const SiteBlock& block() const { return block_; }

  // Casts one fan from the p of every site of the block and hands over the distances; sites side by
  // side on `threads` threads, so `take` may write only what is that site's.
  void cast(const RayFan& fan, int threads, const TakeDistances& take) const;

 private:
  const Sites& sites_;
  const SiteBlock& block_;
  std::unique_ptr<const Patches> patches_;
};

// Casts fans on a surface from sites. Both faces of a patch count, seen at 0.6 degrees or more from
// its plane. What is hit and how far off is decided in double, so that distances are the same on
// every processor. Keeps a reference to the sites. Safe from several threads.
class SiteCaster {
 public:
  // What is done to each patch before rays meet it. Its centre stays within kMostMoved_m.
  using ChangePatch = std::function<void(SurfacePatch& patch)>;
  static constexpr double kMostMoved_m = 16.0;

  // For fans that end at reach_m or before. Surface and sites lie in one frame.
  SiteCaster(const TiledSurface& surface, const Sites& sites, double reach_m,
             ChangePatch change = {});
  SiteCaster(SiteCaster&&) noexcept;
  ~SiteCaster();

  [[nodiscard]] const std::vector<SiteBlock>& blocks() const { return blocks_; }

  // Of one of the blocks. Must not outlive this. Error: cannot-read.
  [[nodiscard]] Result<BlockScene> scene(const SiteBlock& block) const;

 private:
  struct Scenes;
  [[nodiscard]] Result<std::vector<SurfacePatch>> patches_near(const SiteBlock& block) const;

  TiledSurface surface_;
  const Sites& sites_;
  double far_m_;    // no fan ends beyond
  double reach_m_;  // of what is seen: with half a patch
  ChangePatch change_;
  std::vector<SiteBlock> blocks_;
  std::unique_ptr<Scenes> scenes_;
};

// Casts one fan from every site, block after block. Reports progress. Errors: mismatched-inputs
// where surface and sites lie in different frames; cannot-read.
Result<void> cast_at_sites(PassContext& ctx, const TiledSurface& surface, const Sites& sites,
                           const RayFan& fan, const TakeDistances& take);

// The instruction set that Embree computes with.
enum class CasterIsa : std::uint8_t { kFastest, kSse2, kAvx, kAvx2 };

// From here on casts of the whole process use this one, which the processor must have; kFastest
// undoes it. So that tests can show that results are the same.
void replace_caster_isa(CasterIsa isa);

}  // namespace sightline
