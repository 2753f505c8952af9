#pragma once

#include <optional>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/trajectory/met_share.h"
#include "passes/vehicle/vehicle_localizer.h"

namespace sightline {

// Upright points of a scan, in the vehicle's frame: by which places differ.
std::vector<Eigen::Vector3d> upright_of(const Scan& scan, const SensorProfile& sensor);

// Decides whether a scan shows the map at a pose. Holds the NDs of the localizer's map.
class PlaceCheck {
 public:
  explicit PlaceCheck(const sightline_localizer_info& map);
  PlaceCheck(const PlaceCheck&) = delete;
  PlaceCheck& operator=(const PlaceCheck&) = delete;

  // The share of the points that meet walls and poles of the map; none where too few can be
  // compared.
  [[nodiscard]] std::optional<double> met_share(const std::vector<Eigen::Vector3d>& upright_m,
                                                const Pose& T_world_vehicle) const;
  [[nodiscard]] const NdtMap& map() const { return map_; }

 private:
  NdtMap map_;
  NdsByCell nds_;
};

}  // namespace sightline
