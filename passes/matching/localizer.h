#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/matcher.h"
#include "passes/matching/optimum_search.h"
#include "passes/matching/scan_cutter.h"

namespace sightline {

// How a map is matched; the variants are defined in schemas/definitions.md ("Localizers").
struct LocalizerOptions {
  // False: the plain one, Newton's method on the map's own NDs. True: a part of the points finds
  // the way on blurred NDs, then all points settle on sharpened ones.
  bool is_annealed = false;
  // Annealed alone, above 0: where the score leaves one horizontal direction loose, looks along it
  // for a better pose no farther than this from the start, which is how far off starts may be.
  double search_m = 0.0;
  // Matches first on cells so many times as long as the map's, pooled from them; 1: on its own
  // alone.
  int coarse_cells = 1;
  double lead_stop_m = 0.02;     // of the first level: steps shorter than this end it
  double loose_below = 0.5;      // searches where one curvature is below this part of the other
  std::size_t fewest_lead = 64;  // points that the first levels take, where there are as many
  bool has_quick_steps = false;  // MatchLevel's
};

// The localizers of schemas/definitions.md: plain, annealed, searching.
inline constexpr std::uint32_t kLocalizersVersion = 3;  // of that definition
// kPclNdt is PCL's own, which passes/localize runs; the functions below know the first three.
enum class LocalizerKind { kPlain, kAnnealed, kSearching, kPclNdt };
std::vector<std::string> localizer_names();  // of all kinds, in their order
std::string_view localizer_name(LocalizerKind kind);
LocalizerOptions localizer_options(LocalizerKind kind, int coarse_cells = 1);
// Searching, for scans of which a sample is taken: all of up to 128 points lead, and steps end and
// the search begins where a sample adds nothing ("Looks" in schemas/definitions.md).
LocalizerOptions options_for_samples(int coarse_cells = 1);
inline constexpr double kSampleStop_m = 0.01;  // of its last level, in MatchOptions
// By that name, as a map stores it. Any other name is taken for searching, the default.
LocalizerOptions localizer_named(std::string_view name, int coarse_cells = 1);

// A map made ready for a localizer. Costs time and memory in proportion to the number of NDs.
struct Localizer {
  struct Level {
    std::shared_ptr<const MatchGrid> grid;
    MatchLevel settings;  // without the grid
  };
  LocalizerOptions options;   // that matching needs still
  std::vector<Level> levels;  // from coarse to fine, one to three
};
Localizer make_localizer(const NdtMap& map, const LocalizerOptions& options);

// make_localizer() in steps of about a millisecond, to the bit. Its grids are kept as
// keep_for_kernels() does: MatchKernel::kExact cannot match in them.
class LocalizerBuilder {
 public:
  // `map` must outlive the last step.
  LocalizerBuilder(const NdtMap& map, const LocalizerOptions& options);

  bool step();  // true once all steps are taken
  Localizer take() { return std::move(localizer_); }

 private:
  const NdtMap& map_;
  std::unique_ptr<const NdtMap> coarse_;
  Localizer localizer_;
  std::optional<MatchGridBuilder> grid_;  // of the level that follows the last one of localizer_
  std::size_t added_count_ = 0;           // NDs of this level
};
// As make_localizer(map, options_for_samples(coarse_cells)); shares the grids of an annealed `own`.
Localizer localizer_for_samples(const Localizer& own, const NdtMap& map, int coarse_cells = 1);

ScanForMatch make_scan_for_match(const Localizer& localizer,
                                 std::span<const Eigen::Vector3d> points_m);
// One in so many of its points leads.
std::size_t lead_stride(const Localizer& localizer, std::size_t point_count);

// The points of a whole scan, cut in the sensor's frame and expressed in the vehicle's.
ScanForMatch make_scan_for_match(const Localizer& localizer, ScanCutter& cutter, const Scan& scan,
                                 const SensorProfile& sensor, const ScanCut& cut);

// The pose of `scan`, made for this localizer, in the map. The limits on steps in `options` are
// those of the last level; an annealed localizer ignores stop_step_rad and stops turning where no
// point moves farther than stop_step_m. Never fails: see `stop`. A searching one takes over from
// `shared`, and adds to it, what earlier starts of this scan found; without it nothing is
// allocated.
MatchResult localize(const Localizer& localizer, ScanForMatch& scan, const Pose& T_map_start,
                     const MatchOptions& options = {}, SharedClimbs* shared = nullptr);

// The last level alone, from a start that is nearly right, as predicted by a vehicle that tracks.
MatchResult settle(const Localizer& localizer, ScanForMatch& scan, const Pose& T_map_start,
                   const MatchOptions& options = {});

// No pose that localize() or settle() finds is farther from its start: there are at most three
// climbs of 35 steps of 0.2 m, and 1.5 m between two of them.
inline constexpr double kFarthestFound_m = 24.0;

// The map with cells `factor` times as long, each pooled from the NDs in it: count, mean and
// covariance are those of all their points. Points of cells that had too few for an ND stay lost.
// factor >= 1; where the tiles cannot hold the longer cells they become larger.
NdtMap coarse_map(const NdtMap& map, int factor);

}  // namespace sightline
