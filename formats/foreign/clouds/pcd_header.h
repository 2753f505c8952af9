#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/foreign/text/file_bytes.h"

namespace sightline {

struct PcdField {
  std::string name;         // "_" is padding
  char type = 'F';          // F, I or U
  std::size_t size = 4;     // bytes of one element
  std::size_t count = 1;    // elements
  std::size_t offset = 0;   // bytes from the start of a point
  std::size_t element = 0;  // elements before it, as words of a text line

  [[nodiscard]] std::size_t bytes() const { return size * count; }
};

enum class PcdEncoding { kAscii, kBinary, kBinaryCompressed };

// The header of a PCD file (versions .5 to .7), consistent in itself.
struct PcdHeader {
  std::vector<PcdField> fields;
  std::uint32_t point_count = 0;
  std::size_t point_size = 0;     // bytes
  std::size_t element_count = 0;  // words a text line
  PcdEncoding encoding = PcdEncoding::kAscii;
  std::size_t data_offset = 0;
  std::size_t header_lines = 0;

  // nullptr where there is none.
  [[nodiscard]] const PcdField* field(std::string_view name) const;
  [[nodiscard]] const PcdField* intensity() const;
  [[nodiscard]] const PcdField* time() const;  // of each point
};

// Errors: truncated-scan (ends before DATA), malformed-header, missing-field, unsupported-format (a
// later version), empty-scan (says it has no points).
Result<PcdHeader> parse_pcd_header(const FileBytes& file);

}  // namespace sightline
