#pragma once

#include <cstddef>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/map/compiled_map.h"
#include "formats/map/container/container_writer.h"
#include "formats/map/packed_model.h"
#include "formats/map/packed_nds.h"
#include "formats/tables/stored_table.h"

namespace sightline {

// The file of a valid map, as schemas/map_format.md describes it. The same map gives the same
// bytes; no clock, host name or command line enters. NDs are rounded as layers.h says; all else is
// exact.
std::vector<std::byte> encode_map(const CompiledMap& map);

// What a file is written from that no process holds whole.
struct MapParts {
  const CompiledMap& answers;  // all but NDs, factors and the model's bytes, of which it has none
  const PackedNds& nds;
  const PackedModel& model;
  // Those of the map; without any factor it has none.
  const ByFamily<StoredTable<FactorTable>>& factors;
};
// validate_factors() of a stored table, some sites at a time. Errors: invalid-artifact,
// cannot-read.
Result<void> validate_factors(const ByFamily<StoredTable<FactorTable>>& factors,
                              const CompiledMap& map);
// The same bytes, tile by tile. The parts are valid, each and together. Errors: cannot-read, those
// of `write`.
Result<void> write_map(const MapParts& parts, const ContainerWriter::Write& write);

// The same before it is put together: for who adds layers of their own.
ContainerParts parts_of(const CompiledMap& map);

}  // namespace sightline
