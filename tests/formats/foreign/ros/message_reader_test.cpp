#include "formats/foreign/ros/ros_messages.h"

#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

using namespace std::string_literals;

MessageReader reader_of(const std::string& bytes,
                        MessageEncoding encoding = MessageEncoding::kCdr) {
  return MessageReader(std::as_bytes(std::span(bytes)), encoding);
}

TEST(MessageReader, AlignsBehindTheFirstFourBytes) {
  // A byte, 3 of padding, a 32-bit number, a byte, 7 of padding, a double.
  const std::string bytes = "\0\1\0\0"s + "\x05"s + "\0\0\0"s + as_bytes({7U}) + "\x06"s +
                            std::string(7, '\0') + as_bytes({1.5});
  MessageReader reader = reader_of(bytes);
  EXPECT_EQ(reader.get<std::uint8_t>(), 5);
  EXPECT_EQ(reader.get<std::uint32_t>(), 7U);
  EXPECT_EQ(reader.get<std::uint8_t>(), 6);
  EXPECT_EQ(reader.get<double>(), 1.5);
  EXPECT_TRUE(reader.ok());
  EXPECT_EQ(reader.remaining(), 0U);
  reader.get<std::uint8_t>();
  EXPECT_FALSE(reader.ok());
}

TEST(MessageReader, AlignsDoublesToFourInXcdr2) {
  const std::string bytes = "\0\7\0\0"s + as_bytes({7U}) + as_bytes({1.5});
  MessageReader reader = reader_of(bytes);
  EXPECT_EQ(reader.get<std::uint32_t>(), 7U);
  EXPECT_EQ(reader.get<double>(), 1.5);
  EXPECT_TRUE(reader.ok());
}

TEST(MessageReader, ReadsBothByteOrders) {
  const std::string bytes = "\0\0\0\0"s + "\0\0\1\2"s + "\0\0\0\3ab\0"s;
  MessageReader big = reader_of(bytes);
  EXPECT_EQ(big.get<std::uint32_t>(), 258U);
  EXPECT_EQ(big.text(), "ab");
  EXPECT_TRUE(big.ok());
}

TEST(MessageReader, RefusesOtherEncapsulationsAndLengthsThatAreNotThere) {
  EXPECT_FALSE(reader_of("\0\3\0\0"s).ok());  // a list of parameters
  EXPECT_FALSE(reader_of("\0\1\0"s).ok());
  const std::string long_text = "\0\1\0\0"s + as_bytes({0xffff'ffffU}) + "ab";
  MessageReader reader = reader_of(long_text);
  EXPECT_EQ(reader.text(), "");
  EXPECT_FALSE(reader.ok());
}

TEST(MessageReader, ReadsHeadersOfRos1AndRos2) {
  const std::string ros2 = "\0\1\0\0"s + as_bytes({7U, 5U, 6U}) + "lidar\0"s;
  EXPECT_EQ(reader_of(ros2).header().stamp_ns, 7'000'000'005);
  const std::string ros1 = as_bytes({9U, 7U, 5U, 6U}) + "/lidar"s;
  const MessageHeader header = reader_of(ros1, MessageEncoding::kRos1).header();
  EXPECT_EQ(header.stamp_ns, 7'000'000'005);
  EXPECT_EQ(header.frame, "lidar");
}

}  // namespace
}  // namespace sightline
