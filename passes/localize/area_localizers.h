#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <utility>

#include "formats/drive/localizer_profile.h"
#include "formats/grid/cell_key.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/localizer.h"

namespace sightline {

// This program's own localizers in one area of a map.
struct AreaLocalizer {
  Localizer own;
  Localizer of_samples;
};

// A localizer takes some twenty times the memory of its NDs, so they are made of one area after
// another, from the NDs that a match there can meet: what it finds is what a localizer of the whole
// map finds, to the bit.
class AreaLocalizers {
 public:
  struct Options {
    LocalizerKind kind = LocalizerKind::kSearching;  // not PCL's
    int coarse_cells = 1;
    double longest_m = 100.0;  // of the scans that are matched, from the vehicle's place
    std::size_t most = 1;      // areas that are kept ready
  };
  // Keeps a reference to the map.
  AreaLocalizers(const NdtMap& map, const Options& options) : map_(map), options_(options) {}

  // Those of the area of a place. Safe from several threads.
  std::shared_ptr<const AreaLocalizer> at(const Eigen::Vector3d& p_map_m);

 private:
  [[nodiscard]] AreaLocalizer make(const TileKey& area) const;

  const NdtMap& map_;
  Options options_;
  std::mutex mutex_;
  std::list<std::pair<TileKey, std::shared_ptr<const AreaLocalizer>>> ready_;  // the latest first
};

}  // namespace sightline
