#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/drive/drive.h"
#include "formats/drive/localizer_profile.h"
#include "formats/drive/look.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/localize/area_localizers.h"
#include "passes/localize/tracking_starts.h"
#include "passes/matching/covariance/known_start.h"
#include "passes/matching/localizer.h"

namespace sightline {

// What measure-error localizes with at one site after the other: this program's own localizers, or
// PCL's NDT. One for each thread.
class SiteLocalizer {
 public:
  virtual ~SiteLocalizer() = default;
  // At another site. `seed` is this site's own.
  virtual void go_to(const Eigen::Vector3d& p_map_m, std::uint64_t seed) = 0;
  // The scan to be matched next, which outlives that. What a look takes of it may depend on the
  // start: then match() cuts it.
  virtual void take(const Scan& scan, const Look& look) = 0;
  // Of the scan taken last; T_map_sensor is the vehicle's pose.
  virtual MatchResult match(const Pose& T_map_start) = 0;
  // The same, given the start's covariance, as a vehicle does that tracks: PoseEstimate's pose. PCL
  // takes none.
  virtual MatchResult match_known(const KnownStart& start) { return match(start.T_map_vehicle); }
  // Of the last match.
  [[nodiscard]] virtual std::size_t point_count() const = 0;
  // CPU time of what the last match took over from an earlier start of the scan, which a vehicle
  // would have spent.
  [[nodiscard]] virtual double taken_over_ms() const { return 0.0; }
};

// Which localizer, and what its name leaves open; the three behind it of this program's own alone.
struct LocalizerChoice {
  LocalizerKind kind = LocalizerKind::kSearching;
  int coarse_cells = 1;
  double leaf_m = 1.0;
  bool takes_every_return = false;  // within a range, as ScanCut says
  bool in_small_map = false;        // whose NDs are fewer and rounded
};

// What all of them share. `own` and `of_samples`, for looks that take a sample, serve this
// program's localizers alone, `map` PCL's.
struct SiteLocalizerInputs {
  LocalizerChoice choice;
  const SensorProfile& sensor;
  const NdtMap& map;
  const Localizer& own;
  const Localizer& of_samples;
  const StructureMap* structures = nullptr;  // for match_known() of this program's localizers
};
std::unique_ptr<SiteLocalizer> make_site_localizer(const SiteLocalizerInputs& inputs);
// Refers to the area.
std::unique_ptr<SiteLocalizer> make_site_localizer(const LocalizerChoice& choice,
                                                   const SensorProfile& sensor,
                                                   const AreaLocalizer& area);

// What a vehicle must do alike for the errors to be its own.
// `cell_m`: of the map.
LocalizerProfile profile_of(const LocalizerChoice& choice, double cell_m);

// A match that ended farther off counts as lost.
inline constexpr double kLostBeyond_m = 0.5;

// What all sites of measure-error share.
struct SiteMeasuring {
  ErrorReference reference = ErrorReference::kKnownPose;
  const Drive& drive;
  const Trajectory& trajectory;  // in the map's frame
  const MatchStarts& starts;
  ByFamily<std::vector<Look>> looks;
  std::uint64_t seed = 0;
};

// Rows of sites in their order, each one's looks in theirs, and the ends of each row's tracking
// starts.
struct MeasuredRows {
  std::vector<ErrorRow> rows;
  std::vector<AxisErrors> tracking_ends;
};
using SiteRows = ByFamily<MeasuredRows>;

// A scan, where the vehicle was, and the pose that the scan came with.
struct ReferencedScan {
  const Scan& scan;
  Pose T_map_reference = Pose::Identity();
  Pose T_map_given = Pose::Identity();
};

// Appends the rows of one scan, which is matched by each look from every start: those of acquiring,
// then those of tracking, which do not change the rows.
void measure_scan(const MatchStarts& starts, const std::vector<Look>& looks,
                  const ReferencedScan& scan, SiteLocalizer& localizer, MeasuredRows& rows);

// Appends the rows of one site: its scan is matched at every look from every start and compared
// with the reference. Error: what reading the scan returns.
Result<void> measure_site(const SiteMeasuring& measuring, SiteLocalizer& localizer,
                          std::size_t scan_index, SiteRows& rows);

}  // namespace sightline
