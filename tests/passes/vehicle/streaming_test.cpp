#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "tests/passes/vehicle/row_of_rooms.h"

namespace sightline {
namespace {

const MapFrame& frame() {
  static const MapFrame frame = row_of_rooms("searching", 1).ndt.frame;
  return frame;
}

std::vector<std::string> driven(const sightline_localizer* localizer) {
  std::vector<std::string> matches;
  for (int trip = 0; trip < 2; ++trip) {
    for (int i = 0; i < kRooms; ++i) {
      const RowMatch found = match_in_room(localizer, trip == 0 ? i : kRooms - 1 - i, frame());
      EXPECT_EQ(found.code, 0);
      EXPECT_EQ(found.match.stop, SIGHTLINE_CONVERGED);
      matches.emplace_back(bytes_of(found.match));
    }
  }
  return matches;
}

TEST(Streaming, MatchesAsInTheWholeMapToTheBit) {
  for (const char* name : {"plain", "searching"}) {
    for (const std::uint32_t coarse_cells : {1U, 3U}) {
      const std::string path = written_row(name, coarse_cells);
      const sightline_localizer_options whole = whole_map();
      const Opened all(path, &whole);
      const Opened near(path);
      sightline_localizer_options own_steps{};
      own_steps.has_no_thread = 1;
      const Opened stepped(path, &own_steps);
      ASSERT_TRUE(all.code == 0 && near.code == 0 && stepped.code == 0);
      EXPECT_GT(all.info().nd_count, 0u);
      EXPECT_EQ(near.info().nd_count, 0u);
      const std::vector<std::string> expected = driven(all.localizer);
      EXPECT_EQ(driven(near.localizer), expected) << name << coarse_cells;
      EXPECT_EQ(driven(stepped.localizer), expected) << name << coarse_cells;
      EXPECT_EQ(sightline_localizer_fault_count(near.localizer), 0u);
    }
  }
}

TEST(Streaming, MatchesAlikeFromThreadsInDifferentPlaces) {
  const std::string path = written_row("searching");
  const sightline_localizer_options whole = whole_map();
  const Opened all(path, &whole);
  const Opened near(path);
  const std::vector<std::string> expected = driven(all.localizer);
  std::vector<std::vector<std::string>> found(3);
  {
    std::vector<std::jthread> threads;
    for (std::vector<std::string>& of_thread : found) {
      threads.emplace_back([&] { of_thread = driven(near.localizer); });
    }
    threads.emplace_back([&] {
      for (int i = 0; i < 200; ++i) {
        const Eigen::Vector3d p_world_m = room_place_m(i % kRooms) + frame().origin_world_m;
        sightline_localizer_prepare(near.localizer, p_world_m.data(), 0.5, nullptr);
      }
    });
  }
  for (const std::vector<std::string>& of_thread : found) EXPECT_EQ(of_thread, expected);
}

TEST(Streaming, NamesACorruptTileAndDrivesOnWithTheRest) {
  const CompiledMap map = row_of_rooms("searching", 1);
  std::vector<std::byte> bytes = encode_map(map);
  const std::string good = written_row("searching");
  // A tile in the middle: the first ND layers come first in the file.
  const std::string bad = (scratch_folder() / "row_bad.slmap").string();
  bytes[bytes.size() / 3] ^= std::byte{1};
  ASSERT_TRUE(write_file_atomically(bad, bytes, IfExists::kReplace));
  const sightline_localizer_options whole = whole_map();
  EXPECT_NE(Opened(bad, &whole).code, 0);
  const Opened all(good, &whole);
  const Opened damaged(bad);
  ASSERT_EQ(damaged.code, 0) << damaged.message;
  EXPECT_EQ(sightline_localizer_fault_count(damaged.localizer), 0u);
  int same_count = 0;
  for (int room = 0; room < kRooms; ++room) {
    const RowMatch found = match_in_room(damaged.localizer, room, frame());
    EXPECT_EQ(found.code, 0);
    same_count +=
        bytes_of(found.match) == bytes_of(match_in_room(all.localizer, room, frame()).match);
  }
  EXPECT_GE(same_count, kRooms - 3);
  EXPECT_LT(same_count, kRooms);
  ASSERT_EQ(sightline_localizer_fault_count(damaged.localizer), 1u);
  std::array<char, 300> message{};
  EXPECT_EQ(sightline_localizer_get_fault(damaged.localizer, 0, message.data(), message.size()),
            static_cast<int>(ErrorCode::kChecksumMismatch));
  EXPECT_NE(std::string(message.data()).find("tile "), std::string::npos) << message.data();
  EXPECT_NE(std::string(message.data()).find("row_bad.slmap"), std::string::npos);
  EXPECT_NE(sightline_localizer_get_fault(damaged.localizer, 1, message.data(), message.size()), 0);
}

TEST(Streaming, PreparesWithinABudget) {
  sightline_localizer_options own_steps{};
  own_steps.has_no_thread = 1;
  const Opened near(written_row("searching"), &own_steps);
  const Eigen::Vector3d p_world_m = room_place_m(5) + frame().origin_world_m;
  int is_done = 0;
  int call_count = 0;
  for (; is_done == 0 && call_count < 10000; ++call_count) {
    ASSERT_EQ(sightline_localizer_prepare(near.localizer, p_world_m.data(), 0.0, &is_done), 0);
  }
  EXPECT_GT(call_count, 10);
  EXPECT_EQ(is_done, 1);
  ASSERT_EQ(sightline_localizer_prepare(near.localizer, p_world_m.data(), 0.0, &is_done), 0);
  EXPECT_EQ(is_done, 1);
  const Eigen::Vector3d far_m(1e300, 0.0, 0.0);
  EXPECT_NE(sightline_localizer_prepare(near.localizer, far_m.data(), 0.0, &is_done), 0);
  EXPECT_NE(sightline_localizer_prepare(near.localizer, nullptr, 0.0, &is_done), 0);
  EXPECT_NE(sightline_localizer_prepare(nullptr, p_world_m.data(), 0.0, &is_done), 0);
  EXPECT_EQ(sightline_localizer_fault_count(nullptr), 0u);
  EXPECT_NE(sightline_localizer_get_fault(nullptr, 0, nullptr, 0), 0);
}

}  // namespace
}  // namespace sightline
