#include "formats/base/bytes.h"

#include <gtest/gtest.h>

#include <limits>

namespace sightline {
namespace {

TEST(Bytes, ReadBackWhatWasWritten) {
  ByteWriter writer;
  writer.put<std::uint16_t>(513);
  writer.put(-2.5);
  writer.put_string("tile");
  writer.put_array(std::vector<float>{1.0F, 2.0F});
  EXPECT_EQ(writer.bytes()[0], std::byte{1}) << "little-endian: the low byte comes first";
  ByteReader reader(writer.bytes());
  EXPECT_EQ(reader.get<std::uint16_t>(), 513);
  EXPECT_EQ(reader.get<double>(), -2.5);
  std::string text;
  reader.get_string(text);
  EXPECT_EQ(text, "tile");
  std::vector<float> values;
  reader.get_array(values);
  EXPECT_EQ(values, (std::vector<float>{1.0F, 2.0F}));
  EXPECT_TRUE(reader.at_end());
}

TEST(Bytes, RefuseACountThatExceedsWhatRemainsBeforeAllocating) {
  ByteWriter writer;
  writer.put(std::numeric_limits<std::uint64_t>::max() / 2);
  ByteReader reader(writer.bytes());
  std::vector<double> values;
  reader.get_array(values);
  EXPECT_FALSE(reader.ok());
  EXPECT_TRUE(values.empty());
}

TEST(Bytes, LeaveTheArgumentAloneAfterTheEnd) {
  ByteReader reader({});
  int value = 7;
  reader.get(value);
  EXPECT_EQ(value, 7);
  EXPECT_FALSE(reader.ok());
  EXPECT_FALSE(reader.at_end());
}

TEST(ByteWriter, CountsWhatItWouldWriteAndKeepsNone) {
  const auto write = [](ByteWriter writer) {
    writer.put<std::uint32_t>(7);
    writer.put_string("street");
    writer.put_array(std::vector<double>{1.0, 2.0});
    writer.append("abc", 3);
    return writer;
  };
  const ByteWriter written = write(ByteWriter());
  const ByteWriter counted = write(ByteWriter::that_counts());
  EXPECT_EQ(written.count(), written.bytes().size());
  EXPECT_EQ(counted.count(), written.count());
  EXPECT_TRUE(counted.bytes().empty());
}

TEST(ByteWriter, NeverMovesWhatItHasRoomFor) {
  ByteWriter writer;
  writer.reserve(1000);
  writer.put<std::uint8_t>(1);
  const std::byte* const begin = writer.bytes().data();
  for (int i = 0; i < 999; ++i) writer.put<std::uint8_t>(2);
  EXPECT_EQ(writer.bytes().data(), begin);
}

}  // namespace
}  // namespace sightline
