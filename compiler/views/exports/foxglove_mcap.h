#pragma once

#include "formats/base/bytes.h"
#include "formats/base/result.h"
#include "formats/geodesy.h"
#include "formats/map/compiled_map.h"

namespace sightline {

// A map as an MCAP file of messages that Foxglove shows, in JSON with their JSON schemas:
// /map/nds (foxglove.PointCloud: means, standard deviations, dimension class), /map/route and
// /map/sites (foxglove.SceneUpdate, coloured by the range at the tightest limit; a site has its
// answers as metadata), /drive (foxglove.PosesInFrame); then for each site /tf
// (foxglove.FrameTransform), /pose (foxglove.PoseInFrame), /site (sightline.Site: the numbers of
// site_properties()) and, where the world is known, /fix (foxglove.LocationFix).
// Frame "map": coordinates of export_frame.h, m. Maps have no times: the vehicle drives along the
// sites at 10 m/s, from 1 s on. The same map gives the same bytes. Errors: bad-argument (a site is
// no point of the world), those of `sink`.
Result<void> write_foxglove_mcap(const CompiledMap& map, const World& world, const ByteSink& sink);

}  // namespace sightline
