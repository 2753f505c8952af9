#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>

#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/localizer_profile.h"
#include "formats/drive/trajectory.h"
#include "formats/grid/cell_key.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/covariance/structure.h"
#include "passes/matching/localizer.h"
#include "passes/pass/tile_digests.h"

namespace sightline {

// This program's own localizers in one area of a map; for PCL's, which makes its own of them, the
// NDs that it meets there.
struct AreaLocalizer {
  Localizer own;
  Localizer of_samples;
  StructureMap structures;
  NdtMap for_pcl;
};

// A localizer takes some twenty times the memory of its NDs, so they are made of one area after
// another, from the NDs that a match there can meet: what it finds is what a localizer of the whole
// map finds, to the bit.
class AreaLocalizers {
 public:
  struct Options {
    LocalizerKind kind = LocalizerKind::kSearching;
    int coarse_cells = 1;
    // Of the scans that are matched, from the vehicle's place; as far as PCL's takes NDs.
    double longest_m = 100.0;
    // That ask side by side (0: all there are), each in an area of its own: so many are kept ready.
    int threads = 1;
  };
  AreaLocalizers(const TiledNds& nds, const Options& options);

  // Those of an area around a place: one that is ready, where it reaches so far. Safe from several
  // threads. Error: cannot-read.
  Result<std::shared_ptr<const AreaLocalizer>> at(const Eigen::Vector3d& p_map_m);

 private:
  struct Place {
    TileKey area;
    std::mutex mutex;
    std::shared_ptr<const AreaLocalizer> localizer;  // none until it was asked for
  };
  [[nodiscard]] Result<AreaLocalizer> make(const TileKey& area) const;
  std::shared_ptr<Place> place_of(const Eigen::Vector3d& p_map_m);

  TiledNds nds_;
  Options options_;
  std::size_t most_;  // areas that are kept ready
  std::mutex mutex_;
  std::list<std::shared_ptr<Place>> places_;  // the latest first
};

// What decides how scans are matched by this program's own localizers (PartedWork::content): the
// scans, where they are, and the NDs that they may meet.
class MatchContents {
 public:
  // `trajectory` is in the map's frame; scans reach so far from there. `nds`: of the map. Keeps
  // references to drive and trajectory.
  MatchContents(const Drive& drive, const Trajectory& trajectory, TileDigests nds,
                double longest_m);

  // Of scans of the drive. Nothing where one is not known without reading it.
  [[nodiscard]] std::optional<Digest> of(std::span<const std::optional<std::size_t>> scans) const;

 private:
  const Drive& drive_;
  const Trajectory& trajectory_;
  double longest_m_;
  TileDigests nds_;
};

}  // namespace sightline
