#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace sightline {

// How the chunks of a ROS 1 bag or of an MCAP file are packed.
enum class BagCompression { kNone, kBz2, kLz4, kZstd };

// "none", "bz2" or "lz4", as a chunk's header says it in ROS 1; nothing for any other.
std::optional<BagCompression> bag_compression_named(std::string_view name);
// "", "lz4" or "zstd", as MCAP says it.
std::optional<BagCompression> mcap_compression_named(std::string_view name);

// The most bytes that `packed_size` bytes may unpack to: 1 GiB, and 16 MiB plus 1024 for each byte,
// so that a small file never asks for much memory.
std::size_t most_unpacked(std::size_t packed_size);

// What a packed chunk (not kNone) holds; nothing where that is damaged or not `size` bytes, which
// must be at most most_unpacked().
std::optional<std::vector<std::byte>> unpack_chunk(BagCompression compression,
                                                   std::span<const std::byte> packed,
                                                   std::size_t size);

// What a frame of zstd holds, by the size that it says itself; nothing where it is damaged, says no
// size or one above most_unpacked().
std::optional<std::vector<std::byte>> unpack_zstd_frame(std::span<const std::byte> packed);
// Whether bytes begin like one.
bool is_zstd_frame(std::span<const std::byte> bytes);

}  // namespace sightline
