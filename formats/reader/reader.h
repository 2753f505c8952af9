#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/annotation/answer.h"
#include "formats/base/result.h"
#include "formats/reader/look_up.h"
#include "formats/reader/map_container.h"
#include "formats/reader/mapped_file.h"
#include "formats/reader/site_errors.h"
#include "formats/reader/site_looks.h"

// How far to look, for a vehicle: opens a compiled map and answers from it.

namespace sightline {

// Flags of an answer: 1, 2, 16 and 128 are the map's own flags (schemas/map_format.md).
inline constexpr std::uint32_t kAnswerUnmet = 1;         // no range is good enough here
inline constexpr std::uint32_t kAnswerExtrapolated = 2;  // unlike what the model was trained on
inline constexpr std::uint32_t kAnswerFar = 4;           // no site within the map's reach
inline constexpr std::uint32_t kAnswerTighterLimit = 8;  // a limit tighter than the map has any
// The street's own static answer: what a model would say of it is not believed, P included.
inline constexpr std::uint32_t kAnswerStatic = 16;
// The map's errors were measured with another localizer: unknown for the caller's.
inline constexpr std::uint32_t kAnswerUnknownLocalizer = 32;

// Neither the map's look nor its range lies within what can be seen now.
inline constexpr std::uint32_t kAnswerNotVisible = 64;
// No scan was ever seen here: what simulation found of the place decided. The map's own flag too.
inline constexpr std::uint32_t kAnswerSimulated = 128;

inline constexpr std::uint32_t kNoSite = std::numeric_limits<std::uint32_t>::max();

// A look as a map names it ("Looks" in schemas/definitions.md).
struct MapLook {
  double range_m = 0.0;            // 3D slant range from the sensor
  std::uint32_t return_count = 0;  // so many returns of a scan are looked at; 0: every one
  double even_beyond_m = 0.0;  // nearer returns are kept with chance (r / even_beyond_m)^2; 0: all
  std::uint32_t point_count = 0;  // matched at most; 0: all that are left
  bool is_by_normals = false;     // in turn from the directions of the map's normals
  bool settles = false;           // on the last level alone, for a vehicle that tracks
};

struct RangeAnswer {
  double range_m = 0.0;  // how far to look
  // Of an error within the limit, at this range; NaN with kAnswerUnknownLocalizer.
  double probability = 0.0;
  double mean_error_m = 0.0;  // predicted, at this range; infinity far from any site; NaN as above
  double distance_m = std::numeric_limits<double>::infinity();  // 3D, to the nearest site
  std::uint32_t flags = 0;
  std::uint32_t site = kNoSite;   // the nearest one
  Reason reason = Reason::kNone;  // why the site has this range; kNone where none of a site is used
};

// The cheapest way to localize.
struct LookAnswer {
  MapLook look;
  // As in RangeAnswer, of this look.
  double probability = 0.0;
  double mean_error_m = 0.0;
  double distance_m = std::numeric_limits<double>::infinity();
  std::uint32_t flags = 0;
  std::uint32_t site = kNoSite;
  Reason reason = Reason::kNone;
};

// How a vehicle localizes step by step ("Driving by a plan" in schemas/definitions.md).
struct LookPlanAnswer {
  // Its probability and mean error are NaN where a second look may follow: what a plan holds is
  // measured over whole drives, not predicted for a place.
  LookAnswer first;
  bool has_second = false;
  // Of the first look's match: doubt = constant + the sum of weights times signs. Where it is above
  // doubt_above, the second look is taken.
  std::array<double, 8> weights{};
  double constant = 0.0;
  double doubt_above = 0.0;
  MapLook second;
};

// What the map promises within one limit. A promise is about the next drive; what a threshold says
// of the drive that it was set on is none.
struct MapPromise {
  double limit_m = 0.0;
  bool is_earned = false;
  // Least share of the answered places (no kAnswerUnmet) expected within the limit; 0: not earned.
  double coverage = 0.0;
  bool is_of_next_drive = false;  // set on drives that the model did not learn from
  std::uint32_t place_count = 0;  // that it was set on
  std::uint32_t drive_count = 0;
  std::string_view statement;  // one sentence for people
};

// A further figure of every site, as the map names it.
struct MapColumn {  // refers into the map
  std::string_view name;
  std::string_view unit;          // for people
  std::span<const float> values;  // [site]; +-inf where there is none
  // Of a column that the map keeps in bytes: the memory of `values`.
  std::shared_ptr<const std::vector<float>> decoded = nullptr;
};

// Which sites have poses that scans do not constrain ("Unconstrained poses" in
// schemas/definitions.md). Refers into the map.
struct MapPoses {
  std::span<const float> directions;  // [site], or empty: every site is constrained
  std::span<const float> sigmas_m;

  // False where the position of the site in the map rests on an assumed or given motion.
  [[nodiscard]] bool is_constrained(std::uint32_t site) const {
    return site >= directions.size() || directions[site] == 0.0F;
  }
  // Standard deviation of that position, relative to where the stretch of such sites begins, m.
  // Infinite where it is not known; 0 where scans constrain the pose or it was given.
  [[nodiscard]] double sigma_m(std::uint32_t site) const {
    return site >= sigmas_m.size() || sigmas_m[site] < 0.0F ? 0.0 : double{sigmas_m[site]};
  }
};

// A site, and what the map holds there for one limit.
struct MapSite {
  std::array<double, 3> position_world_m{};
  RangeAnswer range;  // its distance is 0
};

struct MapInfo {  // refers into the map
  std::string_view map_id;
  std::string_view version;
  std::uint64_t release = 0;
  std::array<double, 3> origin_world_m{};
  // Where positions that are asked for lie: "local" (the recording's own coordinates), "utm:32N",
  // "mgrs:32UMV" or "enu:LATITUDE,LONGITUDE,ALTITUDE".
  std::string_view world;
  // Of what `sightline export` writes as clouds (autoware, pcd, ply): a vehicle that localizes in
  // such a map asks at its position plus this. All 0 but for worlds of 100 km and more.
  std::array<double, 3> export_origin_world_m{};
  double tile_m = 0.0;
  double reach_m = 0.0;  // a site farther away than this says nothing about a position
  std::uint32_t site_count = 0;
  std::uint32_t simulated_site_count = 0;     // whose answers rest on simulation alone
  std::span<const double> ranges_m;           // ascending
  std::span<const double> limits_m;           // ascending
  std::span<const MapPromise> promises;       // one a limit
  std::span<const MapLook> looks;             // that take a sample, cheapest first; may be none
  std::span<const MapPromise> look_promises;  // one a limit, or none
  // The localizer whose errors were measured: its name, the version of its definition, and what the
  // name leaves open ("leaf_m=1, ...").
  std::string_view localizer;
  std::uint32_t localizer_version = 0;
  std::string_view localizer_parameters;
  bool is_for_caller = false;                 // whether that is the localizer that the caller named
  std::span<const std::string_view> columns;  // names of further figures of each site, ascending
};

// The caller's localizer, as it is named when a map is opened: "searching", "pcl-ndt", or the name
// under which errors of another program's were imported; "searching/3" asks for that version of its
// definition too. Where the map's errors are those of another localizer, or none is named, every
// answer is the longest range, probability and mean error NaN, and kAnswerUnknownLocalizer. A
// caller for whose localizer the numbers hold all the same names MapInfo::localizer.

// A map open for looking up. Safe to use from several threads at once. After open() a look-up
// allocates nothing (but to tell of a failure) and touches a few pages of 4 KiB; each is checked
// against its checksum before its first use.
class MapReader {
 public:
  // Maps the file into memory and checks header, trailer, manifest and the info page of "look-up".
  // The file must not be written to while it is open; replacing it by rename is fine. verify_map()
  // checks a whole file, once when it arrives. Errors: file-not-found, cannot-open, cannot-read,
  // and those of open_front() and LookUp::open().
  static Result<MapReader> open(const std::string& path, std::string_view callers_localizer);
  // Reads the whole file into memory first, for systems that cannot promise that no file is written
  // in place: what happens to it later changes nothing. Errors: the same, and out-of-memory.
  static Result<MapReader> open_in_memory(const std::string& path,
                                          std::string_view callers_localizer);
  // On bytes that outlive the reader and start at a multiple of 8.
  static Result<MapReader> open(std::span<const std::byte> bytes,
                                std::string_view callers_localizer);

  // The range for a sensor at this position in world coordinates (the recording's own, as the
  // map's frame defines), for an accuracy of limit_m: what the map holds at the nearest site on
  // its level (is_same_level: less than 1 m above or below), the lower id on a tie. A limit the map
  // does not have is served by the next tighter one; one tighter than all by the longest range,
  // probability 0 and kAnswerTighterLimit. Far from any site: the longest range, probability 0 and
  // kAnswerFar. Errors: bad-argument (not finite, or a limit not above 0), checksum-mismatch and
  // bad-layer where what is needed is damaged.
  [[nodiscard]] Result<RangeAnswer> observation_range(const std::array<double, 3>& position_world_m,
                                                      double limit_m) const;

  // The look for a sensor there, if it now sees no farther than visible_m: the map's look where
  // that reaches no farther, else the observation range as a look at every return within it, else
  // the longest range with kAnswerNotVisible and probability 0. Everything else, and where a map
  // has no looks: as observation_range(). Allocates nothing. Errors: the same, and bad-argument
  // where visible_m is not above 0 (infinity is).
  [[nodiscard]] Result<LookAnswer> look(
      const std::array<double, 3>& position_world_m, double limit_m,
      double visible_m = std::numeric_limits<double>::infinity()) const;

  // What to do there. A vehicle that tracks: the map's plan, where the limit is not tighter than
  // the plan's; its first look is the place's own, settling, where that looks at no more returns
  // and matches fewer points. Without a plan: the place's look for tracking starts, with its
  // probability, where the map has one that reaches no farther than visible_m; in both cases
  // kAnswerUnmet is about tracking starts then. A vehicle that does not track, or is far from any
  // site: the answer of look() alone. Allocates nothing, except that the first call for a vehicle
  // that tracks reads the directory and checks these columns. Errors: as look(), and those of
  // column().
  [[nodiscard]] Result<LookPlanAnswer> look_plan(
      const std::array<double, 3>& position_world_m, double limit_m, bool is_tracking,
      double visible_m = std::numeric_limits<double>::infinity()) const;

  // Every site in the order of their numbers, with what observation_range() answers there for
  // MapInfo::limits_m[limit]. Reads the whole section: for tools, not on the way. Errors:
  // bad-argument (no such limit); checksum-mismatch, bad-layer where something is damaged.
  [[nodiscard]] Result<std::vector<MapSite>> sites(std::size_t limit) const;

  // A column of sites by its name (MapInfo::columns): look up once and keep it, its values are
  // those of RangeAnswer::site. Reads the directory and checks the whole column. Errors:
  // bad-argument (no such column), checksum-mismatch, bad-layer, and those of open_directory().
  [[nodiscard]] Result<MapColumn> column(std::string_view name) const;

  // By the columns "unconstrained" and "pose_sigma_m": look up once and keep it. A map without them
  // has no such site, or is older than these columns. Errors: those of column().
  [[nodiscard]] Result<MapPoses> poses() const;

  // Errors by direction of a vehicle that tracks: look up once and keep it, by RangeAnswer::site. A
  // map without these columns: nothing was measured at any site. Errors: those of column().
  [[nodiscard]] Result<MapErrors> errors() const;

  [[nodiscard]] const MapInfo& info() const { return info_; }

 private:
  MapReader(MappedFile file, const MapFront& front, LookUp look_up,
            std::string_view callers_localizer);
  // The section of columns_[number], which has a value of so many bytes for each site.
  [[nodiscard]] Result<std::span<const std::byte>> column_bytes(std::size_t number) const;
  [[nodiscard]] Result<MapErrors::Column> stepped_column(std::string_view name) const;
  [[nodiscard]] Result<TrackingLookColumns> read_tracking_looks() const;
  // The answer from tracking starts instead of that from acquiring starts, where there is one.
  [[nodiscard]] Result<LookAnswer> tracking_look(const LookAnswer& look, double limit_m,
                                                 double visible_m) const;
  static Result<MapReader> open_file(const std::string& path, MappedFile::Use use,
                                     std::string_view callers_localizer);
  static Result<MapReader> open(MappedFile file, std::span<const std::byte> bytes,
                                std::string_view callers_localizer);
  [[nodiscard]] std::optional<std::size_t> limit_for(double limit_m) const;
  // What is nearest to a place in world coordinates, and the limit that serves limit_m.
  struct Found {
    LookUp::Nearest nearest;
    std::optional<std::size_t> limit;
  };
  [[nodiscard]] Result<Found> find(const std::array<double, 3>& position_world_m,
                                   double limit_m) const;
  [[nodiscard]] Result<RangeAnswer> range_of(const Found& found) const;
  [[nodiscard]] RangeAnswer default_answer(std::uint32_t flags) const;

  MappedFile file_;
  MapFront front_;
  LookUp look_up_;
  MapInfo info_;
  std::vector<double> limits_m_;
  std::vector<double> ranges_m_;
  std::vector<MapPromise> promises_;
  std::vector<MapLook> looks_;
  std::vector<MapPromise> look_promises_;
  std::vector<std::string_view> columns_;
  std::optional<LookPlanAnswer> plan_;  // without a place
  double plan_limit_m_ = 0.0;
  // Read by the first call that needs it, from any thread.
  struct TrackingLooksOnce {
    std::once_flag is_read;
    Result<TrackingLookColumns> columns = TrackingLookColumns{};
  };
  std::unique_ptr<TrackingLooksOnce> tracking_ = std::make_unique<TrackingLooksOnce>();
  std::vector<char> parameters_;  // a view of a short string would not outlive a move
};

}  // namespace sightline
