#pragma once

#include "formats/artifact.h"
#include "formats/base/files/stored_bytes.h"
#include "formats/drive/localizer_profile.h"

namespace sightline {

// A map file that is finished and lies nowhere yet.
struct MapFile {
  StoredBytes bytes;
  LocalizerProfile predicted_localizer;  // whose errors the map predicts
};
SIGHTLINE_ARTIFACT(MapFile, "map-file", 1)

// Header and size. Its content was checked part by part before it was written.
Result<void> validate(const MapFile& file);
// As dump() of the compiled map, which it reads whole. Errors: cannot-read, those of read_map().
Result<Table> dump(const MapFile& file);

}  // namespace sightline
