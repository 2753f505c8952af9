#include "formats/foreign/ros/message_reader.h"

#include "formats/base/units.h"

namespace sightline {

MessageReader::MessageReader(std::span<const std::byte> message, MessageEncoding encoding)
    : bytes_(message), is_cdr_(encoding == MessageEncoding::kCdr) {
  if (!is_cdr_) return;
  // DDS-XTypes 1.3, 7.6.3.1.2: a kind in two bytes, big-endian, and two of options.
  constexpr unsigned kXcdr2 = 6;
  const std::span<const std::byte> begin = take(4);
  if (!ok_) return;
  const auto kind =
      (std::to_integer<unsigned>(begin[0]) << 8U) + std::to_integer<unsigned>(begin[1]);
  ok_ = kind < 2 || kind == kXcdr2 || kind == kXcdr2 + 1;
  is_swapped_ = kind % 2 == 0;
  origin_ = offset_;
  widest_alignment_ = kind < 2 ? 8 : 4;
}

void MessageReader::align(std::size_t size) {
  if (!is_cdr_) return;
  const std::size_t step = std::min(size, widest_alignment_);
  const std::size_t past = (offset_ - origin_) % step;
  if (past > 0) take(step - past);
}

std::span<const std::byte> MessageReader::take(std::size_t size) {
  if (ok_ && remaining() < size) ok_ = false;
  if (!ok_) return {};
  const std::span<const std::byte> taken = bytes_.subspan(offset_, size);
  offset_ += size;
  return taken;
}

std::uint32_t MessageReader::count(std::size_t element_size) {
  const auto count = get<std::uint32_t>();
  if (ok_ && count > remaining() / element_size) ok_ = false;
  return ok_ ? count : 0;
}

std::string MessageReader::text() {
  const std::uint32_t size = count(1);
  const std::span<const std::byte> bytes = take(size);
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (is_cdr_ && !text.empty()) text.pop_back();  // CDR counts the zero at the end
  return text;
}

std::int64_t MessageReader::time_ns() {
  const std::int64_t seconds =
      is_cdr_ ? std::int64_t{get<std::int32_t>()} : std::int64_t{get<std::uint32_t>()};
  return seconds * kSecond_ns + std::int64_t{get<std::uint32_t>()};
}

MessageHeader MessageReader::header() {
  if (!is_cdr_) get<std::uint32_t>();  // ROS 1 counts its messages
  MessageHeader header;
  header.stamp_ns = time_ns();
  header.frame = text();
  if (header.frame.starts_with('/')) header.frame.erase(0, 1);
  return header;
}

}  // namespace sightline
