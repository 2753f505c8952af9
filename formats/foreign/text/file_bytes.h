#pragma once

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "formats/base/result.h"

namespace sightline {

// A file in memory, and its name for messages.
struct FileBytes {
  std::span<const std::byte> bytes;
  std::string file;

  [[nodiscard]] std::string_view text() const {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  static FileBytes of_text(std::string_view text, std::string file) {
    return {std::as_bytes(std::span(text.data(), text.size())), std::move(file)};
  }
  [[nodiscard]] Error error(ErrorCode code, std::string message, std::string place = "") const {
    return {code, std::move(message), file, std::move(place)};
  }
};

// A number as it lies in a file, little-endian; the caller has checked that it is there.
template <class T>
T read_at(std::span<const std::byte> bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

inline std::string at_byte(std::size_t offset) { return "byte " + std::to_string(offset); }
inline std::string at_line(std::size_t number) { return "line " + std::to_string(number); }

// ".pcd" of "a/B.PCD".
inline std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

// Some writers pad a file to whole pages with zeros, and editors add line ends. Anything else
// behind the data means that the header and the data disagree.
inline bool is_padding(std::string_view rest) {
  return rest.find_first_not_of(std::string_view("\0\r\n", 3)) == std::string_view::npos;
}

}  // namespace sightline
