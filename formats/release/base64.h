#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

// RFC 4648 with padding.
std::string base64_of(std::span<const std::uint8_t> bytes);
std::string base64_of(std::span<const std::byte> bytes);

// Exactly `size` bytes, from the one text that base64_of() writes for them; nothing otherwise.
std::optional<std::vector<std::uint8_t>> bytes_of_base64(std::string_view text, std::size_t size);

}  // namespace sightline
