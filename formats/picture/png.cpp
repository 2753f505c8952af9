#include "formats/picture/png.h"

#include <png.h>

#include <string>

namespace sightline {

// libpng's simple interface: no callbacks, no jumps out of our frames.
Result<std::vector<std::byte>> encode_png(const Raster& raster) {
  static_assert(sizeof(Colour) == 3);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = raster.width;
  image.height = raster.height;
  image.format = PNG_FORMAT_RGB;
  constexpr int kAsIs = 0;  // no conversion to 8 bits
  constexpr png_int_32 kPacked = 0;
  std::vector<std::byte> file;
  png_alloc_size_t size = 0;
  // Asked first how large it becomes, then written.
  for (const bool is_asking : {true, false}) {
    file.resize(size);
    if (raster.pixels.empty() ||
        png_image_write_to_memory(&image, is_asking ? nullptr : file.data(), &size, kAsIs,
                                  raster.pixels.data(), kPacked, nullptr) == 0) {
      return Error{ErrorCode::kBadArgument,
                   "no PNG can be made of " + std::to_string(raster.width) + " x " +
                       std::to_string(raster.height) + " pixels",
                   "", ""};
    }
  }
  file.resize(size);
  return file;
}

}  // namespace sightline
