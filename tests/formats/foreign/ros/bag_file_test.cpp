#include "formats/foreign/ros/files/open_message_log.h"

#include <rosbag/view.h>
#include <sys/stat.h>

#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <thread>

#include "formats/base/random.h"
#include "formats/foreign/ros/files/bag_chunks.h"
#include "formats/foreign/ros/ros_bag.h"
#include "formats/foreign/ros/scan_messages.h"
#include "tests/formats/foreign/random_bags.h"

namespace sightline {
namespace {

using rosbag::compression::CompressionType;
constexpr CompressionType kCompressions[] = {rosbag::compression::Uncompressed,
                                             rosbag::compression::BZ2, rosbag::compression::LZ4};

struct ReadMessage {
  std::int64_t time_ns = 0;
  std::string topic;
  std::string type;
  std::string bytes;
  auto operator<=>(const ReadMessage&) const = default;
};

std::vector<ReadMessage> read_by_ros(const std::string& path) {
  std::vector<ReadMessage> messages;
  rosbag::Bag bag(path, rosbag::bagmode::Read);
  rosbag::View view(bag);
  for (const rosbag::MessageInstance& message : view) {
    std::string bytes(message.size(), '\0');
    ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                       message.size());
    message.write(stream);
    messages.push_back({static_cast<std::int64_t>(message.getTime().toNSec()), message.getTopic(),
                        message.getDataType(), bytes});
  }
  return messages;
}

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::vector<ReadMessage> read_by_us(const std::string& path) {
  const std::unique_ptr<MessageLog> bag = value_of(open_ros1_bag(path));
  std::set<std::uint32_t> all;
  for (const auto& [number, channel] : bag->channels()) all.insert(number);
  std::vector<ReadMessage> messages;
  require(bag->for_each_message(all, [&](const LoggedMessage& message) {
    const LogChannel& channel = bag->channels().at(message.channel);
    messages.push_back({message.time_ns, channel.topic, channel.type, text_of(message.bytes)});
    EXPECT_EQ(text_of(*bag->read(message.place)), messages.back().bytes);
    return Result<void>();
  }));
  return messages;
}

class BagFileTest : public testing::Test {
 protected:
  std::string path() const { return (folder_ / "drive.bag").string(); }
  std::string write(std::vector<BagMessage> messages,
                    CompressionType compression = rosbag::compression::Uncompressed,
                    std::uint32_t chunk_bytes = 600) {
    write_bag(path(), messages, compression, chunk_bytes);
    return *read_text_file(path());
  }
  std::string refusal(const std::string& bytes) {
    folder_.write("drive.bag", bytes);
    return outcome_of(open_bag(path(), ""));
  }
  ScratchFolder folder_;
};

// A number that stands behind "name=" for the n-th time (0: the first).
template <class T>
std::string with_field(std::string bag, const std::string& name, T value, int n = 0) {
  std::size_t at = bag.find(name + "=");
  while (n-- > 0) at = bag.find(name + "=", at + 1);
  std::memcpy(bag.data() + at + name.size() + 1, &value, sizeof value);
  return bag;
}

// As a recorder leaves a bag that it does not close: no index, and counts of 0.
std::string without_index(const std::string& bag) {
  std::uint64_t index = 0;
  std::memcpy(&index, bag.data() + bag.find("index_pos=") + 10, sizeof index);
  std::string open = with_field(bag.substr(0, index), "index_pos", std::uint64_t{0});
  open = with_field(open, "conn_count", std::uint32_t{0});
  return with_field(open, "chunk_count", std::uint32_t{0});
}

TEST_F(BagFileTest, ReadsWhatRosItselfReads) {
  std::mt19937 random(1);
  for (int i = 0; i < 60; ++i) {
    const CompressionType compression = kCompressions[i % 3];
    write(random_messages(random, 1 + random_below(random, 60)), compression,
          1 + random_below(random, 3000));
    std::vector<ReadMessage> wanted = read_by_ros(path());
    std::vector<ReadMessage> found = read_by_us(path());
    std::ranges::sort(wanted);
    std::ranges::sort(found);
    ASSERT_EQ(found, wanted) << "bag " << i;
  }
}

TEST_F(BagFileTest, KeepsTheOrderOfRosWithinATopicAndItsCounts) {
  std::mt19937 random(2);
  for (int i = 0; i < 30; ++i) {
    std::vector<BagMessage> messages = random_messages(random, 50);
    for (BagMessage& message : messages) message.nanoseconds -= message.nanoseconds % 20'000'000;
    write(messages, kCompressions[i % 3], 1 + random_below(random, 3000));
    std::map<std::string, std::vector<std::string>> wanted;
    for (const ReadMessage& message : read_by_ros(path())) {
      wanted[message.topic].push_back(message.bytes);
    }
    const auto scans = value_of(open_bag(path(), ""));
    std::vector<std::string> found;
    for (std::size_t k = 0; k < scans->scans().size(); ++k) {
      found.push_back(text_of(*scans->read(k)));
      EXPECT_EQ(sha256(found.back()), scans->scans()[k].content);
    }
    EXPECT_EQ(found, wanted["/points"]);
    const Result<std::vector<BagTopic>> topics = list_bag_topics(path());
    ASSERT_EQ(topics->size(), wanted.size());
    for (const BagTopic& topic : *topics) {
      EXPECT_EQ(topic.message_count, wanted[topic.name].size());
    }
  }
}

TEST_F(BagFileTest, ReadsTheChunksInTurnWhereThereIsNoIndex) {
  std::mt19937 random(3);
  for (const CompressionType compression : kCompressions) {
    const std::string bag = write(random_messages(random, 40), compression);
    std::vector<ReadMessage> wanted = read_by_ros(path());
    folder_.write("drive.bag", without_index(bag));
    std::vector<ReadMessage> found = read_by_us(path());
    std::ranges::sort(wanted);
    std::ranges::sort(found);
    EXPECT_EQ(found, wanted);
    const std::string cut = without_index(bag).substr(0, 4700);
    EXPECT_THAT(refusal(cut), HasSubstr("SL2006 truncated-scan"));
    EXPECT_THAT(refusal(cut), HasSubstr("run `rosbag reindex` on it"));
  }
}

TEST_F(BagFileTest, SaysAtWhichByteABagContradictsItself) {
  std::mt19937 random(4);
  const std::string bag = write(random_messages(random, 40));
  ASSERT_EQ(refusal(bag), "no error");
  EXPECT_THAT(refusal(bag.substr(0, bag.size() - 1)), HasSubstr("SL2006 truncated-scan"));
  EXPECT_THAT(refusal(bag + "x"), HasSubstr("(byte " + std::to_string(bag.size()) + ")"));
  EXPECT_THAT(refusal(with_field(bag, "index_pos", std::uint64_t{1} << 60U)),
              HasSubstr("SL2006 truncated-scan: " + path() + " (byte 1152921504606846976)"));
  EXPECT_THAT(refusal(with_field(bag, "conn_count", std::uint32_t{1})),
              HasSubstr("expected the record of a chunk's position"));
  EXPECT_THAT(refusal(with_field(bag, "chunk_count", 0xffff'ffffU)), HasSubstr("SL2006"));
  EXPECT_THAT(refusal(with_field(bag, "chunk_pos", std::uint64_t{13})),
              HasSubstr("(byte 13): expected a chunk"));
  EXPECT_THAT(refusal(with_field(bag, "size", 0xffff'ffffU)),
              HasSubstr("(byte 4117): found a chunk of 4294967295 bytes"));
  EXPECT_THAT(refusal(with_field(bag, "op", std::uint8_t{9}, 1)),
              HasSubstr("(byte 4117): expected a chunk"));
  std::string other = bag;
  other[9] = '1';
  EXPECT_THAT(refusal(other), HasSubstr("SL2004 unsupported-format"));
  other = bag;
  other.replace(bag.find("compression=none"), 16, "compression=zstd");
  EXPECT_THAT(refusal(other), HasSubstr("SL2004 unsupported-format"));
}

std::vector<BagMessage> in_turns() {
  std::vector<BagMessage> messages;
  for (std::uint32_t i = 0; i < 6; ++i) {
    BagMessage message{"/points", std::string(kPointCloud2), kBagFirst_s, i, ""};
    message.bytes = small_cloud(kBagFirst_s, i, 1.0F);
    if (i % 2 == 1) {
      message.topic = "/noise";
      message.type = "std_msgs/String";
    }
    messages.push_back(std::move(message));
  }
  return messages;
}

std::string with_number(std::string bag, std::size_t at, std::uint32_t value) {
  std::memcpy(bag.data() + at, &value, sizeof value);
  return bag;
}

TEST_F(BagFileTest, UnpacksNoByteOfTheFileTwice) {
  const std::string bag = write(in_turns(), rosbag::compression::Uncompressed, 1);
  ASSERT_EQ(refusal(bag), "no error");
  std::uint64_t first = 0;
  std::memcpy(&first, bag.data() + bag.find("chunk_pos=") + 10, sizeof first);
  EXPECT_THAT(refusal(with_field(bag, "chunk_pos", first, 2)),
              HasSubstr("found a chunk within the one before"));
}

TEST_F(BagFileTest, DropsNoChunkBecauseOfADamagedIndex) {
  const std::string bag = write(in_turns(), rosbag::compression::Uncompressed, 1);
  // The index ends with the only connection of the last chunk, and its count.
  const std::size_t in_index = bag.size() - 8;
  std::uint32_t number = 0;
  std::memcpy(&number, bag.data() + in_index, sizeof number);
  ASSERT_EQ(number, 1U);
  const std::string once = with_number(bag, in_index, 0);
  EXPECT_THAT(refusal(once), HasSubstr("list different messages"));
  // Said twice, it is believed until the chunk is read.
  std::uint64_t index = 0;
  std::memcpy(&index, bag.data() + bag.find("index_pos=") + 10, sizeof index);
  EXPECT_THAT(refusal(with_number(once, bag.rfind("conn=", index) + 5, 0)),
              HasSubstr("found 0 messages of connection 0 in this chunk, expected 1"));
}

TEST_F(BagFileTest, RefusesTwoConnectionsOfOneNumber) {
  const std::string bag = write(in_turns(), rosbag::compression::Uncompressed, 1);
  const std::string open = without_index(bag);
  ASSERT_EQ(refusal(open), "no error");
  const std::size_t noise = open.rfind("conn=", open.find("topic=/noise")) + 5;
  EXPECT_THAT(refusal(with_number(open, noise, 0)),
              HasSubstr("found two connections of one number"));
  EXPECT_THAT(refusal(with_number(open, noise, 7)),
              HasSubstr("found a message before its connection"));
  const std::size_t in_index = bag.rfind("conn=", bag.rfind("topic=/noise")) + 5;
  EXPECT_THAT(refusal(with_number(bag, in_index, 0)), HasSubstr("found connection 0 twice"));
}

TEST_F(BagFileTest, RefusesAFifoAtOnce) {
  ASSERT_EQ(::mkfifo(path().c_str(), 0600), 0);
  EXPECT_FALSE(is_ros_bag(path()));
  EXPECT_EQ(open_ros1_bag(path()).error().code, ErrorCode::kCannotRead);
}

TEST(BagCompression, AsksForNoMoreMemoryThanAFileCanFill) {
  EXPECT_EQ(most_unpacked(0), std::size_t{1} << 24U);
  EXPECT_EQ(most_unpacked(800), (std::size_t{1} << 24U) + 800 * 1024);
  EXPECT_EQ(most_unpacked(std::size_t{1} << 30U), std::size_t{1} << 30U);
  EXPECT_EQ(most_unpacked(std::size_t{1} << 40U), std::size_t{1} << 30U);
  const std::vector<std::byte> nothing;
  for (const BagCompression compression : {BagCompression::kBz2, BagCompression::kLz4}) {
    EXPECT_FALSE(unpack_chunk(compression, nothing, 100).has_value());
  }
}

using Bytes = std::vector<std::byte>;
constexpr std::size_t kChunkSize = 100;

// Chunks whose bytes are their number, with a count of how often each was unpacked.
struct Packed {
  RecentChunks recent;
  std::array<std::atomic<int>, 100> times{};

  Result<Bytes> read(std::size_t chunk, std::size_t offset = 10, std::size_t size = 20) {
    return recent.read({chunk, kChunkSize, offset, size}, [&]() -> Result<Bytes> {
      ++times.at(chunk);
      return Bytes(kChunkSize, static_cast<std::byte>(chunk));
    });
  }
};

TEST(RecentChunks, ThreadsThatReadDifferentPartsUnpackEachChunkOnce) {
  Packed packed;
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 8; ++t) {
    threads.emplace_back([&packed, t] {
      for (std::size_t chunk = 10 * t; chunk < 10 * t + 5; ++chunk) {
        for (std::size_t scan = 0; scan < 5; ++scan) {
          EXPECT_EQ(*packed.read(chunk, 20 * scan), Bytes(20, static_cast<std::byte>(chunk)));
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t chunk = 0; chunk < 80; ++chunk) {
    EXPECT_EQ(packed.times.at(chunk), chunk % 10 < 5 ? 1 : 0) << chunk;
  }
}

TEST(RecentChunks, WhatWasNotReadForLongestMakesRoom) {
  Packed packed{RecentChunks(3 * kChunkSize)};
  for (const std::size_t chunk : {1U, 2U, 3U, 1U, 4U, 1U, 3U, 4U}) {
    ASSERT_TRUE(packed.read(chunk));
  }
  EXPECT_EQ(packed.times[1], 1);
  EXPECT_EQ(packed.times[3], 1);
  EXPECT_EQ(packed.times[4], 1);
  ASSERT_TRUE(packed.read(2));
  EXPECT_EQ(packed.times[2], 2);
}

TEST(RecentChunks, AChunkLargerThanAllIsKeptUntilTheNext) {
  Packed packed{RecentChunks(kChunkSize / 2)};
  for (const std::size_t chunk : {1U, 1U, 1U, 2U, 1U}) ASSERT_TRUE(packed.read(chunk));
  EXPECT_EQ(packed.times[1], 2);
}

TEST(RecentChunks, GivesTheBytesOfAnyOrderOfReads) {
  Random random(1);
  Packed packed{RecentChunks(5 * kChunkSize)};
  for (int read = 0; read < 2000; ++read) {
    const std::size_t chunk = random.below(20);
    const std::size_t offset = random.below(kChunkSize + 1);
    const std::size_t size = random.below(kChunkSize - offset + 1);
    EXPECT_EQ(*packed.read(chunk, offset, size), Bytes(size, static_cast<std::byte>(chunk)));
  }
}

TEST(RecentChunks, AChunkThatDidNotUnpackIsTriedAgain) {
  RecentChunks recent;
  int times = 0;
  const auto unpack = [&]() -> Result<Bytes> {
    if (++times == 1) return Error{ErrorCode::kCannotRead, "gone", "", ""};
    return Bytes(kChunkSize, std::byte{7});
  };
  EXPECT_EQ(recent.read({1, kChunkSize, 0, 1}, unpack).error().code, ErrorCode::kCannotRead);
  EXPECT_EQ(*recent.read({1, kChunkSize, 0, 1}, unpack), Bytes(1, std::byte{7}));
}

}  // namespace
}  // namespace sightline
