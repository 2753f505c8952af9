
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/ros/files/open_message_log.h"
#include "tests/formats/foreign/ros/read_damaged.h"
#include "tests/formats/foreign/ros/ros2_recordings.h"
#include "tests/support/test_files.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

std::string content_of(const std::string& name) {
  return value_of(read_text_file(recording_path(name)));
}

std::optional<std::vector<Digest>> read_bytes(const std::string& bytes) {
  const MemoryFile file(std::as_bytes(std::span(bytes)));
  return read_damaged(file.path());
}

constexpr const char* kMcaps[] = {"zstd.mcap", "lz4.mcap", "none.mcap", "without_index.mcap",
                                  "without_chunks.mcap"};

TEST(McapDamage, CutsAreRefusedOrGiveTheFirstScans) {
  for (const char* name : kMcaps) {
    const std::string whole = content_of(name);
    const std::optional<std::vector<Digest>> all = read_bytes(whole);
    ASSERT_TRUE(all.has_value()) << name;
    ASSERT_EQ(all->size(), 4U);
    for (std::size_t size = 8; size < whole.size(); size += 7) {
      const std::optional<std::vector<Digest>> found = read_bytes(whole.substr(0, size));
      if (!found) continue;
      ASSERT_LE(found->size(), all->size());
      ASSERT_TRUE(std::equal(found->begin(), found->end(), all->begin())) << name << " " << size;
    }
  }
}

TEST(McapDamage, ChangedBytesAreRefusedOrLeaveTheScansOfPackedChunks) {
  for (const char* name : kMcaps) {
    const std::string whole = content_of(name);
    const std::optional<std::vector<Digest>> all = read_bytes(whole);
    const bool has_checksums = std::string_view(name) != "without_chunks.mcap";
    for (std::size_t at = 8; at < whole.size(); at += 17) {
      std::string changed = whole;
      changed[at] = static_cast<char>(changed[at] ^ (at % 2 == 0 ? '\x01' : '\xff'));
      const std::optional<std::vector<Digest>> found = read_bytes(changed);
      if (found && has_checksums && found->size() == all->size()) {
        ASSERT_EQ(*found, *all) << name << ", byte " << at;
      }
    }
  }
}

TEST(McapDamage, LeavesTurnRatesThatAscendWhereverOneByteIsAnother) {
  const std::string whole = content_of("imus.mcap");
  for (std::size_t at = 8; at < whole.size(); at += 29) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ '\x11');
    const MemoryFile file(std::as_bytes(std::span(changed)));
    const BagTurns turns =
        value_of(read_bag_turns(file.path(), "", "lidar"), "they were not requested");
    for (std::size_t i = 1; i < turns.of_sensor.size(); ++i) {
      ASSERT_LT(turns.of_sensor[i - 1].stamp_ns, turns.of_sensor[i].stamp_ns);
    }
  }
}

TEST(McapDamage, SaysWhatIsWrongAndWhere) {
  const std::string whole = content_of("zstd.mcap");
  const auto error_of = [](const std::string& bytes) {
    const MemoryFile file(std::as_bytes(std::span(bytes)));
    return failure_of(open_bag(file.path(), ""));
  };
  const Error cut = error_of(whole.substr(0, 700));
  EXPECT_EQ(cut.code, ErrorCode::kTruncatedScan);
  EXPECT_EQ(cut.place.substr(0, 5), "byte ");
  std::string behind = whole + "x";
  EXPECT_EQ(error_of(behind).code, ErrorCode::kMalformedHeader);
  std::string packed = whole;
  packed.replace(packed.find("zstd"), 4, "zzzz");
  EXPECT_EQ(error_of(packed).code, ErrorCode::kUnsupportedFormat);
  // A byte of a chunk that is not packed: its checksum differs.
  std::string plain = content_of("none.mcap");
  plain[plain.find("lidar")] = 'L';
  const Error damaged = error_of(plain);
  EXPECT_EQ(damaged.code, ErrorCode::kMalformedHeader);
  EXPECT_THAT(damaged.message, HasSubstr("checksum")) << to_string(damaged);
}

TEST(McapDamage, OfARecordingThatWasNotClosedWarns) {
  const std::string whole = content_of("without_index.mcap");
  // Before the end of the data (its record of 13 bytes), the footer (29) and the magic number (8).
  const std::string open = whole.substr(0, whole.size() - 13 - 29 - 8);
  const MemoryFile file(std::as_bytes(std::span(open)));
  const auto scans = value_of(open_bag(file.path(), ""));
  EXPECT_EQ(scans->scans().size(), 4U);
  ASSERT_EQ(scans->warnings().size(), 1U);
  EXPECT_THAT(scans->warnings()[0], HasSubstr("not closed"));
}

TEST(McapDamage, ThatHidesAChunkWarns) {
  std::string hidden = content_of("none.mcap");
  // The last chunk and what stands behind it become records that are not known here.
  const std::string prefix = hidden.substr(0, 8);
  std::size_t last_chunk = 0;
  std::uint64_t size = 0;
  for (std::size_t at = prefix.size(); hidden[at] != '\x0f'; at += 9 + size) {
    std::memcpy(&size, hidden.data() + at + 1, sizeof size);
    if (hidden[at] == '\6') last_chunk = at;
  }
  for (std::size_t at = last_chunk; hidden[at] != '\x0f'; at += 9 + size) {
    std::memcpy(&size, hidden.data() + at + 1, sizeof size);
    hidden[at] = '\x80';
  }
  const MemoryFile file(std::as_bytes(std::span(hidden)));
  const auto log = value_of(open_message_log(file.path()));
  ASSERT_EQ(log->warnings().size(), 1U);
  EXPECT_THAT(log->warnings()[0], HasSubstr("messages, expected 24"));
}

TEST(Db3Damage, CutsAreRefused) {
  const std::string whole = content_of("drive.db3");
  ASSERT_EQ(read_bytes(whole)->size(), 4U);
  for (std::size_t size = 16; size < whole.size(); size += 13) {
    EXPECT_FALSE(read_bytes(whole.substr(0, size)).has_value()) << size;
  }
  const std::string cut = whole.substr(0, whole.size() - 1);
  const MemoryFile file(std::as_bytes(std::span(cut)));
  const Error error = open_bag(file.path(), "").error();
  EXPECT_EQ(error.code, ErrorCode::kTruncatedScan);
  EXPECT_EQ(error.place, "byte " + std::to_string(cut.size()));
}

TEST(Db3Damage, ChangedBytesGiveAValueOrAnError) {
  const std::string whole = content_of("drive.db3");
  for (std::size_t at = 16; at < whole.size(); at += 31) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ (at % 2 == 0 ? '\x01' : '\xff'));
    read_bytes(changed);
  }
}

TEST(Db3, ThatWasNotClosedIsRefusedWithTheRemedy) {
  const ScratchFolder folder;
  const std::string path = folder.write("drive.db3", content_of("drive.db3")).string();
  EXPECT_TRUE(open_bag(path, "").has_value());
  folder.write("drive.db3-wal", "messages");
  const Error error = open_bag(path, "").error();
  EXPECT_EQ(error.code, ErrorCode::kMalformedHeader);
  EXPECT_THAT(error.message, HasSubstr("drive.db3-wal"));
}

std::string replaced(std::string bytes, std::string_view from, std::string_view to) {
  for (std::size_t at = bytes.find(from); at != std::string::npos; at = bytes.find(from, at)) {
    bytes.replace(at, from.size(), to);
  }
  return bytes;
}

// As tools leave it that rewrite recordings: in SQLite's row of a topic the text of its encoding,
// of 3 bytes (type 19), becomes that of the column behind it, which was empty (type 13).
TEST(Db3, WithoutANameOfTheEncodingIsReadAndWithAnotherSaysSo) {
  const std::string whole = content_of("drive.db3");
  EXPECT_EQ(read_bytes(replaced(whole, "\x13\x0d/", "\x0d\x13/")), read_bytes(whole));
  const std::string other = replaced(whole, "cdr", "xml");
  const MemoryFile file(std::as_bytes(std::span(other)));
  const Error error = open_bag(file.path(), "/points").error();
  EXPECT_THAT(error.message, HasSubstr("/points (sensor_msgs/PointCloud2, neither in CDR"));
}

class BagFolder : public testing::Test {
 protected:
  Error error_of(const std::string& metadata) {
    folder_.write("metadata.yaml", metadata);
    const auto scans = open_bag(folder_.path(), "");
    return scans ? Error{} : scans.error();
  }
  const std::string begin_ = "rosbag2_bagfile_information:\n  relative_file_paths:\n";
  ScratchFolder folder_;
};

TEST_F(BagFolder, NamesWhatIsMissingOrPackedAsAWhole) {
  EXPECT_FALSE(is_message_log(folder_.path()));
  EXPECT_EQ(error_of("rosbag2_bagfile_information:\n  version: 5\n").code,
            ErrorCode::kMalformedHeader);
  EXPECT_TRUE(is_message_log(folder_.path()));
  const Error missing = error_of(begin_ + "    - drive_0.db3\n");
  EXPECT_EQ(missing.code, ErrorCode::kFileNotFound);
  EXPECT_THAT(missing.file, HasSubstr("drive_0.db3"));
  folder_.write("drive_0.db3.zstd", "packed");
  const Error packed = error_of(begin_ + "    - drive_0.db3.zstd\n");
  EXPECT_EQ(packed.code, ErrorCode::kUnsupportedFormat);
  EXPECT_THAT(packed.message, HasSubstr("zstd -d drive_0.db3.zstd -o drive_0.db3"));
  folder_.write("drive_0.db3", content_of("drive.db3"));
  EXPECT_TRUE(error_of(begin_ + "    - drive_0.db3.zstd\n").message.empty());
  EXPECT_TRUE(error_of(begin_ + "    - \"elsewhere/drive_0.db3\"\n").message.empty());
  EXPECT_EQ(
      error_of("# by hand\n" + begin_ + "    - drive_0.db3\n  compression_format: lz4\n").code,
      ErrorCode::kUnsupportedFormat);
}

TEST_F(BagFolder, MayDescribeItselfInAnyStyleOfYaml) {
  folder_.write("drive_0.db3", content_of("drive.db3"));
  for (const char* metadata :
       {"rosbag2_bagfile_information: {relative_file_paths: [drive_0.db3], version: 5}\n",
        "{\"rosbag2_bagfile_information\": {\"relative_file_paths\": [\"drive_0.db3\"]}}",
        "rosbag2_bagfile_information:\n  relative_file_paths: # one\n  - 'drive_0.db3'\n",
        "rosbag2_bagfile_information:\n  relative_file_paths:\n    - >-\n      drive_0.db3\n"}) {
    EXPECT_EQ(error_of(metadata).message, "") << metadata;
  }
  EXPECT_EQ(error_of("rosbag2_bagfile_information: {relative_file_paths: [a.db3], "
                     "compression_format: lz4}")
                .code,
            ErrorCode::kUnsupportedFormat);
  const Error broken = error_of("rosbag2_bagfile_information: {relative_file_paths: [\n");
  EXPECT_EQ(broken.code, ErrorCode::kMalformedHeader);
  EXPECT_THAT(broken.place, HasSubstr("line "));
  for (const char* none : {"rosbag2_bagfile_information: 5\n", "- rosbag2_bagfile_information\n",
                           "rosbag2_bagfile_information: {relative_file_paths: {a: b}}\n"}) {
    EXPECT_EQ(error_of(none).code, ErrorCode::kMalformedHeader) << none;
  }
}

TEST_F(BagFolder, MayMixFilesOfBothKinds) {
  folder_.write("a.db3", content_of("drive.db3"));
  folder_.write("b.mcap", content_of("zstd.mcap"));
  folder_.write("metadata.yaml", begin_ + "    - a.db3\n    - b.mcap\n");
  EXPECT_EQ(value_of(open_bag(folder_.path(), ""))->scans().size(), 8U);
}

}  // namespace
}  // namespace sightline
