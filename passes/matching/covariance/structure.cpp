#include "passes/matching/covariance/structure.h"

#include <cmath>
#include <utility>

namespace sightline {
namespace {

// A surface is so many times wider than thick, and this wide: rings of one wall are narrower.
constexpr double kLeastWidth = 3.0;
constexpr double kLeastWidth_m = 0.06;
constexpr double kLeastOfThick = 1.5;
// A line's axis is upright, and it is no thicker than a trunk.
constexpr double kUpright = 0.7;
constexpr double kThickest_m = 0.25;
// A line this near the plane of the next cell is the end of a wall, cut off by its cell.
constexpr double kOnSurface_m = 0.15;

}  // namespace

bool is_surface(const Nd& nd) {
  const double width_m = std::sqrt(nd.eigenvalues_m2[1]);
  return width_m >= kLeastWidth_m && width_m >= kLeastWidth * std::sqrt(nd.eigenvalues_m2[2]);
}

bool is_thick_surface(const Nd& nd) {
  const double width_m = std::sqrt(nd.eigenvalues_m2[1]);
  return width_m >= kLeastWidth_m && width_m >= kLeastOfThick * std::sqrt(nd.eigenvalues_m2[2]);
}

bool is_upright_line(const Nd& nd) {
  return dimension_class(nd) == 1 && std::abs(nd.eigenvectors(2, 0)) > kUpright &&
         std::sqrt(nd.eigenvalues_m2[1]) <= kThickest_m;
}

bool ends_surface(const Nd& line, const Nd& beside) {
  if (!is_surface(beside)) return false;
  const Eigen::Vector3d normal = beside.eigenvectors.col(2);
  return std::abs(normal.dot(line.mean_m - beside.mean_m)) < kOnSurface_m;
}

StructureMap::StructureMap(const NdtMap& map, std::shared_ptr<const MatchGrid> grid)
    : grid_(std::move(grid)), numbers_(grid_->records.places.size(), kNone) {
  CellIndex index;
  index.reserve(map.nds.size());
  for (const Nd& nd : map.nds) index.add(nd.key);
  const auto nd_at = [&](const CellKey& key) {
    const std::uint32_t number = index.find(key);
    return number == CellIndex::kNone ? nullptr : &map.nds[number];
  };
  for (const Nd& nd : map.nds) {
    const Structure structure = map_structure_of(nd, nd_at);
    const std::int32_t record = record_of_cell(*grid_, nd.key);
    if (record == 0) continue;
    std::uint32_t& number = numbers_[static_cast<std::size_t>(record)];
    number = kConstrainsNothing;
    if (structure.direction_count == 0) continue;
    number = static_cast<std::uint32_t>(structures_.size());
    structures_.push_back(structure);
  }
}

StructureMap::StructureMap(const NdtMap& map)
    : StructureMap(map, std::make_shared<const MatchGrid>(make_match_grid(map))) {}

}  // namespace sightline
