#include "compiler/views/picture/png.h"

#include <png.h>

#include <string>

namespace sightline {

namespace {

// libpng's simple interface: no callbacks, no jumps out of our frames.
Result<std::vector<std::byte>> encode(const void* pixels, std::uint32_t width, std::uint32_t height,
                                      png_uint_32 format) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format;
  constexpr int kAsIs = 0;  // no conversion to 8 bits
  constexpr png_int_32 kPacked = 0;
  std::vector<std::byte> file;
  png_alloc_size_t size = 0;
  // Asked first how large it becomes, then written.
  for (const bool is_asking : {true, false}) {
    file.resize(size);
    if (width == 0 || height == 0 ||
        png_image_write_to_memory(&image, is_asking ? nullptr : file.data(), &size, kAsIs, pixels,
                                  kPacked, nullptr) == 0) {
      return Error{ErrorCode::kBadArgument, "no PNG can be made of " + std::to_string(width) +
                                                " x " + std::to_string(height) + " pixels"};
    }
  }
  file.resize(size);
  return file;
}

}  // namespace

Result<std::vector<std::byte>> encode_png(const Raster& raster) {
  static_assert(sizeof(Colour) == 3);
  return encode(raster.pixels.data(), raster.width, raster.height, PNG_FORMAT_RGB);
}

Result<std::vector<std::byte>> encode_png(const GreyRaster& raster) {
  return encode(raster.pixels.data(), raster.width, raster.height, PNG_FORMAT_GRAY);
}

}  // namespace sightline
