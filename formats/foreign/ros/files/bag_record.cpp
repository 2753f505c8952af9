#include "formats/foreign/ros/files/bag_record.h"

#include "formats/base/units.h"

namespace sightline {
namespace {

// What stands behind the length at `offset`, and sets `offset` behind it.
std::optional<std::span<const std::byte>> take_sized(std::span<const std::byte> bytes,
                                                     std::size_t& offset) {
  std::uint32_t size = 0;
  if (bytes.size() - offset < sizeof size) return std::nullopt;
  std::memcpy(&size, bytes.data() + offset, sizeof size);
  if (size > bytes.size() - offset - sizeof size) return std::nullopt;
  const std::span<const std::byte> taken = bytes.subspan(offset + sizeof size, size);
  offset += sizeof size + size;
  return taken;
}

}  // namespace

std::optional<BagFields> BagFields::parse(std::span<const std::byte> bytes) {
  BagFields fields;
  for (std::size_t offset = 0; offset < bytes.size();) {
    const auto field = take_sized(bytes, offset);
    if (!field) return std::nullopt;
    const std::string_view text(reinterpret_cast<const char*>(field->data()), field->size());
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos) return std::nullopt;
    fields.values_[std::string(text.substr(0, equals))] = text.substr(equals + 1);
  }
  return fields;
}

std::optional<std::string> BagFields::text(std::string_view name) const {
  const auto found = values_.find(name);
  return found == values_.end() ? std::nullopt : std::optional(found->second);
}

std::optional<std::int64_t> BagFields::time_ns() const {
  const auto time = number<std::uint64_t>("time");
  if (!time) return std::nullopt;
  const auto seconds = static_cast<std::int64_t>(*time & 0xffff'ffffU);
  return seconds * kSecond_ns + static_cast<std::int64_t>(*time >> 32U);
}

std::optional<BagRecord> take_bag_record(std::span<const std::byte> bytes, std::size_t& offset) {
  std::size_t at = offset;
  const auto header = take_sized(bytes, at);
  const auto data = header ? take_sized(bytes, at) : std::nullopt;
  if (!data) return std::nullopt;
  std::optional<BagFields> fields = BagFields::parse(*header);
  if (!fields) return std::nullopt;
  offset = at;
  return BagRecord{*std::move(fields), *data};
}

}  // namespace sightline
