#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/annotation/by_family.h"
#include "formats/annotation/direction_errors.h"
#include "formats/artifact.h"
#include "formats/drive/drive.h"
#include "formats/drive/localizer_profile.h"
#include "formats/drive/look.h"
#include "formats/grid/site_shape.h"
#include "formats/record/fields.h"

namespace sightline {

// What the errors were measured against. kSimulated: the places at which scans were simulated,
// which was not measured.
enum class ErrorReference : std::uint8_t { kKnownPose, kFullRangeMatch, kSimulated };
template <>
inline constexpr auto kNamesOf<ErrorReference> = enum_names("known-pose", "full-range-match",
                                                            "simulated");
// For people: "known poses", "the match at full range", "the places of simulated scans".
std::string_view reference_text(ErrorReference reference);

// The runs from all offsets at one site by one look. Lengths in metres, angles in radians.
struct ErrorRow {
  std::uint32_t point_count = 0;  // of the subsampled scan
  double mean_m = 0.0;            // of the 3D translation distance
  double median_m = 0.0;
  double p90_m = 0.0;  // linear interpolation
  double max_m = 0.0;
  double longitudinal_m = 0.0;  // mean absolute component along the vehicle's x
  double lateral_m = 0.0;       // along its y
  double yaw_rad = 0.0;         // mean absolute
  double lost_share = 0.0;      // runs that ended more than 0.5 m off
  double from_given_m = 0.0;    // mean 3D distance from the pose that the scan came with
  double mean_iterations = 0.0;
  double mean_work = 0.0;  // points x iterations: deterministic stand-in for time
  double max_work = 0.0;
  double tracking_work = 0.0;  // mean over the tracking starts
  // CPU time of crop, subsample and match, one thread. The only numbers of any artifact that differ
  // from run to run: they serve reports and nothing else, and never enter a map.
  double mean_time_ms = 0.0;
  double max_time_ms = 0.0;
  double tracking_time_ms = 0.0;  // mean over the tracking starts
  DirectionErrors directions;     // of the runs from the offsets
};
SIGHTLINE_FIELDS(ErrorRow, point_count, mean_m, median_m, p90_m, max_m, longitudinal_m, lateral_m,
                 yaw_rad, lost_share, from_given_m, mean_iterations, mean_work, max_work,
                 tracking_work, mean_time_ms, max_time_ms, tracking_time_ms, directions)

// How the scans of a drive were matched.
struct MatchingCard {
  ScanSelection scans = ScanSelection::kAll;  // of the recording
  LocalizerProfile localizer;
  // Of this program's own localizers, once more as numbers: cells of the first level, and the voxel
  // grid to which scans were thinned.
  std::uint32_t coarse_cells = 1;
  double leaf_m = 1.0;
  // A site that was measured stands for so many along its run: dear localizers take every tenth.
  std::uint32_t site_step = 1;
};

// Localization error of one drive at the sites of a map, by the looks of a family.
struct MeasuredError {
  std::string drive;
  MatchingCard matching;
  ErrorReference reference = ErrorReference::kKnownPose;
  std::vector<Look> looks;
  std::vector<InitialOffset> offsets;           // acquiring: the pose is known to about a metre
  std::vector<InitialOffset> tracking_offsets;  // of a vehicle that tracks; none: not measured
  // Per site: recording_index of the scan that was matched there, or -1 where the drive has none
  // near.
  std::vector<std::int64_t> scan_of_site;
  std::vector<ErrorRow> rows;             // [site][look]; all zero where there was no scan
  std::vector<AxisErrors> tracking_ends;  // [site][look][tracking offset]; zeros too

  [[nodiscard]] SiteShape shape() const { return {looks.size()}; }

  [[nodiscard]] const ErrorRow& row(std::size_t site, std::size_t range) const {
    return rows[shape().index(site, range)];
  }
  [[nodiscard]] std::span<const AxisErrors> tracking(std::size_t site, std::size_t look) const {
    const std::size_t count = tracking_offsets.size();
    return std::span(tracking_ends).subspan(shape().index(site, look) * count, count);
  }
};

template <>
struct ArtifactTraits<MeasuredError> {
  static constexpr std::string_view kName = "measured-error";
  static constexpr std::uint32_t kVersion = 8;
};

// From tracking starts: root mean square over them of the 3D translation distance, m.
double tracking_error_m(const MeasuredError& measured, std::size_t site, std::size_t look);

Result<void> validate(const MeasuredError& measured);
Table dump(const MeasuredError& measured);
void encode(const MeasuredError& measured, ByteWriter& writer);
void decode(ByteReader& reader, MeasuredError& measured);

// A row has the errors at a site.
template <>
struct RowsOf<MeasuredError> {
  static std::size_t size(const MeasuredError& head);
  static std::size_t count(const MeasuredError& table) { return table.scan_of_site.size(); }
  static MeasuredError head_of(const MeasuredError& table);
  static MeasuredError part_of(const MeasuredError& head, std::size_t first, std::size_t count);
  static void resize(MeasuredError& head, std::size_t count);
  static void encode_head(const MeasuredError& table, ByteWriter& writer);
  static void decode_head(ByteReader& reader, MeasuredError& table);
  static void encode(const MeasuredError& table, std::size_t first, std::size_t count,
                     ByteWriter& writer);
  static void decode(ByteReader& reader, MeasuredError& table, std::size_t first,
                     std::size_t count);
};

}  // namespace sightline
