#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/surroundings/surface.h"
#include "passes/pass/pass_context.h"

// Where rays meet a surface. The home of Embree: nothing else in passes/ knows it.

namespace sightline {

// Directions of unit length in map axes; neighbours in the list should be neighbours in the world,
// because eight rays at a time go through the scene together.
struct RayFan {
  std::vector<Eigen::Vector3d> directions;
  double near_m = 0.5;
  double far_m = 50.0;
};

// distance_m[i] belongs to directions[i]: to the first hit between near_m and far_m, +inf where
// there is none.
using TakeDistances = std::function<void(std::size_t site, std::span<const double> distance_m)>;

// Casts one fan from the p of every site and hands over the distances, site by site; sites of one
// block of the plane side by side on ctx.threads threads, so `take` may write only what is that
// site's. Both faces of a patch count, seen at 0.6 degrees or more from its plane. What is hit and
// how far off is decided in double, so that distances are the same on every processor. Reports
// progress. One scene at a time is in memory. Error: mismatched-inputs where surface and sites lie
// in different frames.
Result<void> cast_at_sites(PassContext& ctx, const Surface& surface, const Sites& sites,
                           const RayFan& fan, const TakeDistances& take);

// The instruction set that Embree computes with.
enum class CasterIsa : std::uint8_t { kFastest, kSse2, kAvx, kAvx2 };

// From here on casts of the whole process use this one, which the processor must have; kFastest
// undoes it. So that tests can show that results are the same.
void replace_caster_isa(CasterIsa isa);

}  // namespace sightline
