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

}  // namespace
}  // namespace sightline
