#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/foreign/clouds/element_type.h"
#include "formats/foreign/text/file_bytes.h"

// What a PLY file says of its own numbers; not for other folders.

namespace sightline {

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };

struct PlyProperty {
  std::string name;
  ElementType type;
  bool is_list = false;
  ElementType count_type;  // of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  std::size_t data_offset = 0;  // bytes
  std::size_t lines = 0;        // of the header
};

// Errors: malformed-header with the line, truncated-scan where the file ends before end_header.
Result<PlyHeader> parse_ply_header(const FileBytes& file);

}  // namespace sightline
