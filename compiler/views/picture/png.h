#pragma once

#include <vector>

#include "compiler/views/picture/raster.h"
#include "formats/base/result.h"

namespace sightline {

// A PNG file of 8 bits a channel, without times or texts: the same picture gives the same bytes
// (of one version of libpng and zlib). Error: bad-argument for a picture of no size.
Result<std::vector<std::byte>> encode_png(const Raster& raster);
// One channel.
Result<std::vector<std::byte>> encode_png(const GreyRaster& raster);

}  // namespace sightline
