#include "passes/map/places/choose_field_sites.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <optional>

#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"
#include "passes/map/places/field_limits.h"
#include "passes/map/places/free_ground.h"
#include "passes/map/places/ground_floors.h"

namespace sightline {
namespace {

constexpr const char* kPlace = "pass choose-field-sites";

constexpr double kFinest_m = 0.5;       // of the raster of free ground, at most
constexpr double kNear_m = 10.0;        // from the place that a user names to free ground
constexpr double kAboveSensor_m = 0.2;  // the sensor is on the roof

// Numbers between commas. Error: bad-value.
Result<std::vector<double>> numbers_of(const std::string& name, const std::string& text,
                                       std::size_t count) {
  std::vector<double> values;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    if (*at == ' ' || *at == ',') {
      ++at;
      continue;
    }
    double value = 0.0;
    const std::from_chars_result read = std::from_chars(at, end, value);
    if (read.ec != std::errc() || !std::isfinite(value)) break;
    values.push_back(value);
    at = read.ptr;
  }
  if (at == end && values.size() == count) return values;
  return Error{
      ErrorCode::kBadValue,
      concat(name, ": found '", text, "', expected ", count, " numbers separated by commas"), "",
      kPlace};
}

struct Grid {
  int steps = 4;  // of the raster, from one place of the grid to the next; even
  double step_m = 0.5;

  // The middle of a square of the grid.
  [[nodiscard]] bool has(std::int32_t step) const {
    return step - floor_divide(step, steps) * steps == steps / 2;
  }
};

Grid grid_of(double spacing_m) {
  Grid grid;
  grid.steps = 2 * static_cast<int>(std::ceil(0.5 * spacing_m / kFinest_m));
  grid.step_m = spacing_m / grid.steps;
  return grid;
}

std::string metres(double length_m) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g m", length_m);
  return text;
}

// The free place nearest to (x, y) in the map frame. Error: no-ground.
Result<std::uint32_t> nearest_place(const FreeGround& free, const Eigen::Vector2d& from_map_m) {
  std::optional<std::uint32_t> best;
  double best_m = kNear_m;
  for (std::uint32_t i = 0; i < free.places().size(); ++i) {
    const GroundPlace& place = free.places()[i];
    const Eigen::Vector2d off_m =
        Eigen::Vector2d(place.x * free.step_m(), place.y * free.step_m()) - from_map_m;
    if (off_m.norm() >= best_m) continue;
    best = i;
    best_m = off_m.norm();
  }
  if (best) return *best;
  return Error{ErrorCode::kNoGround,
               concat("choose-field-sites.from: there is no room for a vehicle within ",
                      metres(kNear_m), " of it. Give it in the map's own coordinates"),
               "", kPlace};
}

// Errors: bad-value, no-ground.
Result<std::uint32_t> wanted_stretch(const ChooseFieldSitesOptions& options, const MapFrame& frame,
                                     const FreeGround& free) {
  if (free.places().empty()) {
    return Error{ErrorCode::kNoGround,
                 concat("the map has no ground with room for a vehicle of ",
                        metres(options.width_m), " by ", metres(options.height_m)),
                 "", kPlace};
  }
  if (!options.from.empty()) {
    SIGHTLINE_ASSIGN(const std::vector<double> from, numbers_of("from", options.from, 2));
    const Eigen::Vector2d from_m =
        Eigen::Vector2d(from[0], from[1]) - frame.origin_world_m.head<2>();
    SIGHTLINE_ASSIGN(const std::uint32_t place, nearest_place(free, from_m));
    return free.stretch_of(place);
  }
  const std::span<const std::size_t> sizes = free.stretch_sizes();
  return static_cast<std::uint32_t>(std::ranges::max_element(sizes) - sizes.begin());
}

// In the map frame; everything where nothing is named. Error: bad-value.
Result<Eigen::AlignedBox2d> wanted_box(const ChooseFieldSitesOptions& options,
                                       const MapFrame& frame) {
  constexpr double kFar_m = 1e12;
  const Eigen::Vector2d far_m(kFar_m, kFar_m);
  if (options.within.empty()) return Eigen::AlignedBox2d(-far_m, far_m);
  SIGHTLINE_ASSIGN(const std::vector<double> box, numbers_of("within", options.within, 4));
  const Eigen::Vector2d origin_m = frame.origin_world_m.head<2>();
  const Eigen::AlignedBox2d box_m(Eigen::Vector2d(box[0], box[1]) - origin_m,
                                  Eigen::Vector2d(box[2], box[3]) - origin_m);
  if (!box_m.isEmpty()) return box_m;
  return Error{ErrorCode::kBadValue,
               concat("within: found '", options.within, "', expected the lower corner first"), "",
               kPlace};
}

// Places that are wanted, row by row of the grid, ascending by (y, x, ground).
std::vector<std::uint32_t> rows_of(const FreeGround& free, const Grid& grid, std::uint32_t stretch,
                                   const Eigen::AlignedBox2d& box_m) {
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t i = 0; i < free.places().size(); ++i) {
    const GroundPlace& place = free.places()[i];
    if (free.stretch_of(i) != stretch || !grid.has(place.x) || !grid.has(place.y)) continue;
    if (box_m.contains(Eigen::Vector2d(place.x * grid.step_m, place.y * grid.step_m))) {
      chosen.push_back(i);
    }
  }
  std::ranges::stable_sort(chosen, {}, [&](std::uint32_t i) { return free.places()[i].y; });
  return chosen;
}

// Rows without a gap, of places one after the other.
std::vector<std::vector<std::uint32_t>> runs_of(const FreeGround& free, const Grid& grid,
                                                const std::vector<std::uint32_t>& rows) {
  std::vector<std::vector<std::uint32_t>> runs;
  std::size_t first_of_row = 0;
  for (const std::uint32_t i : rows) {
    const GroundPlace& place = free.places()[i];
    const bool is_new_row = runs.empty() || free.places()[runs.back().back()].y != place.y;
    if (is_new_row) first_of_row = runs.size();
    const auto goes_on = [&](const std::vector<std::uint32_t>& run) {
      const GroundPlace& last = free.places()[run.back()];
      return last.x == place.x - grid.steps && free.goes_on(last, place);
    };
    const auto run =
        std::find_if(runs.begin() + static_cast<std::ptrdiff_t>(first_of_row), runs.end(), goes_on);
    if (run == runs.end()) {
      runs.push_back({i});
    } else {
      run->push_back(i);
    }
  }
  return runs;
}

// Counts are information, ground without answers is a warning.
void report_places(const PassContext& ctx, const ChooseFieldSitesOptions& options,
                   const FreeGround& free, std::uint32_t stretch, std::size_t count) {
  const double square_m2 = free.step_m() * free.step_m();
  const std::size_t apart = free.places().size() - free.stretch_sizes()[stretch];
  const auto places = static_cast<double>(count);
  const double minutes = std::ceil(places * kCpuOfPlace_s / 60.0);
  char text[320];
  std::snprintf(
      text, sizeof text,
      "everywhere: %zu places, %s apart, on %.0f m^2 of connected ground. They need about "
      "%.0f minute%s of one core and %.1f GiB of memory",
      count, metres(options.spacing_m).c_str(),
      static_cast<double>(free.stretch_sizes()[stretch]) * square_m2, minutes,
      minutes > 1.0 ? "s" : "", memory_of_places_mib(places) / 1024.0);
  ctx.inform(text);
  const std::size_t areas = free.stretch_sizes().size() - 1;
  if (areas == 0) return;
  std::snprintf(text, sizeof text,
                "everywhere: %.0f m^2 of ground in %zu separate area%s left out, without answers. "
                "To annotate one of them, name a place in it (from)",
                static_cast<double>(apart) * square_m2, areas, areas > 1 ? "s are" : " is");
  ctx.warn(text);
}

constexpr int kWays = 16;              // of half a turn
constexpr double kLookAlong_m = 20.0;  // each way

// How far free ground goes on that way, in steps of the raster.
int steps_ahead(const FreeGround& free, std::uint32_t place, const Eigen::Vector2d& way, int most) {
  const GroundPlace begin = free.places()[place];
  for (int step = 1; step <= most; ++step) {
    const std::int32_t x = begin.x + static_cast<std::int32_t>(std::lround(step * way.x()));
    const std::int32_t y = begin.y + static_cast<std::int32_t>(std::lround(step * way.y()));
    place = free.next(free.places()[place], x, y);
    if (place == FreeGround::kNone) return step - 1;
  }
  return most;
}

std::array<Eigen::Vector2d, kWays> ways() {
  std::array<Eigen::Vector2d, kWays> all;
  for (int i = 0; i < kWays; ++i) {
    const SinCos turned = portable_sin_cos(i * std::numbers::pi / kWays);
    all[static_cast<std::size_t>(i)] = {turned.cos, turned.sin};
  }
  return all;
}

// A vehicle's heading at a free place, of unit length: the first of 16, evenly over half a turn
// from +x, along which free ground goes on farthest, ahead and behind together, 20 m each at most.
Eigen::Vector2d free_heading(const FreeGround& free, std::uint32_t place) {
  static const std::array<Eigen::Vector2d, kWays> kAll = ways();
  const auto most = static_cast<int>(kLookAlong_m / free.step_m());
  int longest = -1;
  Eigen::Vector2d heading = kAll.front();
  for (const Eigen::Vector2d& way : kAll) {
    const int length = steps_ahead(free, place, way, most) + steps_ahead(free, place, -way, most);
    if (length <= longest) continue;
    longest = length;
    heading = way;
  }
  return heading;
}

Sites sites_of(const PassContext& ctx, const FreeGround& free,
               const std::vector<std::vector<std::uint32_t>>& runs, double spacing_m,
               const SensorProfile& sensor) {
  std::vector<std::uint32_t> places;
  Sites sites;
  sites.spacing_m = spacing_m;
  for (const std::vector<std::uint32_t>& run : runs) {
    places.insert(places.end(), run.begin(), run.end());
  }
  sites.sites.resize(places.size());
  parallel_for(places.size(), ctx.threads, [&](std::size_t i) {
    const GroundPlace& place = free.places()[places[i]];
    const Eigen::Vector3d vehicle_m(place.x * free.step_m(), place.y * free.step_m(),
                                    place.ground_m + vehicle_above_ground_m(sensor));
    sites.sites[i] = level_site(0, 0.0, vehicle_m, free_heading(free, places[i]), sensor);
  });
  std::size_t site = 0;
  for (std::uint32_t run = 0; run < runs.size(); ++run) {
    for (std::size_t i = 0; i < runs[run].size(); ++i, ++site) {
      sites.sites[site].run = run;
      sites.sites[site].s_m = static_cast<double>(i) * spacing_m;
    }
  }
  return sites;
}

}  // namespace

std::vector<OptionField> option_fields(ChooseFieldSitesOptions& options) {
  return {
      number("spacing_m", options.spacing_m, "distance between neighbouring sites, m", 0.5, 50.0),
      number("width_m", options.width_m, "width of free ground that a vehicle needs, m", 0.5, 10.0),
      number("height_m", options.height_m,
             "free height that a vehicle needs, m; at least 0.2 m more than the sensor's height",
             0.5, 10.0),
      text("from", options.from,
           "start point: only ground that a vehicle can reach from here is used, \"x, y\" in the "
           "coordinates of the map file; empty: the largest connected ground"),
      text("within", options.within,
           "part of the map, \"x0, y0, x1, y1\" in the coordinates of the map file; empty: all"),
      number("memory_gib", options.memory_gib, "largest memory for the sites, GiB; more is refused",
             0.25, 1000.0),
      integer("most_places", options.most_places,
              "largest number of sites; more are refused; 0: limited by memory_gib only", 0,
              100'000'000)};
}

Result<Sites> choose_field_sites(PassContext& ctx, const ChooseFieldSitesOptions& options,
                                 const TiledSurface& surface, const SensorProfile& sensor) {
  SIGHTLINE_ASSIGN(const Eigen::AlignedBox2d box_m, wanted_box(options, surface.head().frame));
  SIGHTLINE_ASSIGN(const GroundFloors floors, floors_of(surface));
  const double ground_m2 = static_cast<double>(floors.columns().size()) * GroundFloors::kColumn_m *
                           GroundFloors::kColumn_m;
  SIGHTLINE_TRY(check_ground(ground_m2, options));
  const Grid grid = grid_of(options.spacing_m);
  const VehicleRoom room{options.width_m,
                         std::max(options.height_m, sensor.height_m + kAboveSensor_m)};
  SIGHTLINE_ASSIGN(const FreeGround free,
                   FreeGround::over(surface, floors, grid.step_m, room, ctx.threads));
  SIGHTLINE_ASSIGN(const std::uint32_t stretch,
                   wanted_stretch(options, surface.head().frame, free));
  const std::vector<std::uint32_t> rows = rows_of(free, grid, stretch, box_m);
  if (rows.empty()) {
    return Error{
        ErrorCode::kNoGround,
        concat("no place of the grid of ", metres(options.spacing_m), " is on connected ground",
               (options.within.empty() ? "" : " in " + options.within)),
        "", kPlace};
  }
  SIGHTLINE_TRY(check_places(rows.size(), options));
  report_places(ctx, options, free, stretch, rows.size());
  if (!sensor.sees_all_round()) {
    ctx.warn(concat(
        "the sensor ", sensor.name, " has a view of ", format_double(sensor.azimuth_view_deg),
        " degrees, but `everywhere` annotates each place for one heading only: name a route"));
  }
  Sites sites = sites_of(ctx, free, runs_of(free, grid, rows), options.spacing_m, sensor);
  sites.frame = surface.head().frame;
  return sites;
}

}  // namespace sightline
