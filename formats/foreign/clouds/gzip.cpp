#include "formats/foreign/clouds/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <limits>

namespace sightline {
namespace {

constexpr std::size_t kMost = std::size_t{1} << 30U;
// inflateInit2: 15 bits of window, and 16 asks for a gzip header.
constexpr int kGzipWindow = 15 + 16;

// Appends what the stream gives until it ends; false where it is cut or damaged.
bool inflate_all(z_stream& stream, std::vector<std::byte>& bytes) {
  constexpr std::size_t kStep = 1U << 20U;
  int status = Z_OK;
  while (status == Z_OK && bytes.size() <= kMost) {
    const std::size_t filled = bytes.size();
    bytes.resize(filled + kStep);
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data() + filled);
    stream.avail_out = static_cast<uInt>(kStep);
    status = inflate(&stream, Z_NO_FLUSH);
    bytes.resize(filled + kStep - stream.avail_out);
  }
  return status == Z_STREAM_END || bytes.size() > kMost;
}

}  // namespace

bool is_gzip(std::string_view text) {
  return text.size() >= 4 && text.starts_with("\x1f\x8b\x08") &&
         static_cast<unsigned char>(text[3]) < 0x20;
}

Result<std::vector<std::byte>> unpack_gzip(const FileBytes& file) {
  z_stream stream{};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(file.bytes.data()));
  const std::size_t given =
      std::min<std::size_t>(file.bytes.size(), std::numeric_limits<uInt>::max());
  stream.avail_in = static_cast<uInt>(given);
  SIGHTLINE_CHECK(inflateInit2(&stream, kGzipWindow) == Z_OK);
  std::vector<std::byte> bytes;
  const bool is_whole = inflate_all(stream, bytes);
  inflateEnd(&stream);
  if (!is_whole) {
    return file.error(ErrorCode::kTruncatedScan, "the gzip stream is cut or damaged",
                      at_byte(given - stream.avail_in));
  }
  if (bytes.size() > kMost) {
    return file.error(ErrorCode::kUnsupportedFormat,
                      "unpacks to more than 1 GiB, expected a single scan", at_byte(0));
  }
  return bytes;
}

}  // namespace sightline
