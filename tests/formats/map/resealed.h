#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "formats/reader/map_layout.h"

namespace sightline {

inline std::vector<std::byte> with_header(std::vector<std::byte> file,
                                          const std::function<void(FileHeader&)>& change) {
  FileHeader header = *decode_header(file);
  change(header);
  const std::array<std::byte, kHeaderSize> start = encode_header(header);
  const std::array<std::byte, kTrailerSize> end = encode_trailer(header, start);
  std::copy(start.begin(), start.end(), file.begin());
  std::copy(end.begin(), end.end(), file.end() - kTrailerSize);
  return file;
}

}  // namespace sightline
