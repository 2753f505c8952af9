#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/grid/cell_index.h"
#include "formats/surroundings/surface.h"
#include "passes/map/places/ground_floors.h"

namespace sightline {

// What a vehicle takes where it stands.
struct VehicleRoom {
  double width_m = 2.0;
  double height_m = 2.0;  // above ground
};

// A place of a raster, step_m x and step_m y in the map frame, and the ground there.
struct GroundPlace {
  std::int32_t x = 0;
  std::int32_t y = 0;
  double ground_m = 0.0;
};

// Where a vehicle could stand, and which of these places it could drive between, from a surface
// alone ("Everywhere" in schemas/definitions.md). Several floors are several places.
class FreeGround {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // The same for any number of threads. `floors` are those of the surface, of which one tile at a
  // time is in memory. Error: cannot-read.
  static Result<FreeGround> over(const TiledSurface& surface, const GroundFloors& floors,
                                 double step_m, const VehicleRoom& room, int threads);

  [[nodiscard]] double step_m() const { return step_m_; }
  // Ascending by (x, y, ground_m).
  [[nodiscard]] std::span<const GroundPlace> places() const { return places_; }

  // The place at (x, y) that the ground goes on to from a place near it; kNone where there is none.
  [[nodiscard]] std::uint32_t next(const GroundPlace& from, std::int32_t x, std::int32_t y) const;
  // True where the ground could rise or fall from one to the other.
  [[nodiscard]] bool goes_on(const GroundPlace& from, const GroundPlace& to) const;

  // The number of the stretch that a place belongs to: places from one to the next of which, a step
  // along x or y, the ground goes on.
  [[nodiscard]] std::uint32_t stretch_of(std::uint32_t place) const { return stretches_[place]; }
  // How many places each has.
  [[nodiscard]] std::span<const std::size_t> stretch_sizes() const { return stretch_sizes_; }

 private:
  void index();
  template <class Use>
  void visit_around(std::uint32_t place, const Use& use) const;
  void add_obstructed(const Surface& tile, double height_m,
                      std::vector<std::uint8_t>& is_obstructed) const;
  void keep_free(const std::vector<std::uint8_t>& is_obstructed, double width_m, int threads);
  void keep_near_seen(const GroundFloors& floors);
  void keep(const std::vector<std::uint8_t>& is_kept);
  void find_stretches();

  double step_m_ = 0.5;
  std::vector<GroundPlace> places_;
  CellTable<std::uint32_t> first_;  // of the places at (x, y); z is 0
  std::vector<std::uint32_t> stretches_;
  std::vector<std::size_t> stretch_sizes_;
};

}  // namespace sightline
