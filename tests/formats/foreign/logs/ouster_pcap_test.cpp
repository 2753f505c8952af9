#include "tests/formats/foreign/logs/capture_files.h"

namespace sightline {
namespace {

constexpr std::size_t kColumns = 64;
constexpr std::size_t kBeams = 16;
constexpr std::size_t kBrokenColumn = 5;
constexpr std::int64_t kColumn_ns = 1'562'500;
bool has_return(std::size_t column, std::size_t beam) { return (7 * column + 3 * beam) % 11 != 0; }

std::size_t returns_of_frame() {
  std::size_t count = 0;
  for (std::size_t column = 0; column < kColumns; ++column) {
    for (std::size_t beam = 0; beam < kBeams; ++beam) {
      if (column != kBrokenColumn && has_return(column, beam)) ++count;
    }
  }
  return count;
}

class OusterPcap : public testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] std::filesystem::path file() const {
    return capture_file(std::string("ouster_") + GetParam() + ".pcap");
  }
  [[nodiscard]] bool is(const std::string& name) const { return name == GetParam(); }
};

TEST_P(OusterPcap, PutsReturnsOnTheWallsThatTheBeamsMet) {
  const Recording recording = value_of(open_capture_file(file()));
  ASSERT_EQ(recording.scans.size(), 2U);  // not the half frame before and the packet behind
  // Half a tick along the beam is no more across a wall, and rounding of the fixture's own numbers.
  const double tick_m = is("low") ? 0.008 : 0.001;
  for (std::size_t i = 0; i < 2; ++i) {
    const PointCloudFile cloud = value_of(read_recorded_scan(recording, i));
    std::size_t on_walls = 0;
    for (const Eigen::Vector3d& p_m : cloud.points_m) {
      if (to_wall_m(p_m) <= 0.5 * tick_m + 1e-6) ++on_walls;
    }
    EXPECT_EQ(on_walls, returns_of_frame());
    EXPECT_TRUE(is("dual") || cloud.points_m.size() == returns_of_frame());
    // Column 0, beam 1, which looks 1.42 degrees beside the encoder and behind the sensor.
    EXPECT_NEAR(azimuth_deg(cloud.points_m.front()), 180.0 - 1.42, 0.02);
    EXPECT_EQ(cloud.intensity.front(), 16.0F);
  }
}

TEST_P(OusterPcap, GivesEachColumnItsOwnTime) {
  const Recording recording = value_of(open_capture_file(file()));
  // The clock of the first one counts from its start: its first whole frame began when its first
  // packet was captured, which was 16 columns later.
  const std::int64_t first_ns =
      kCaptureStart_ns + static_cast<std::int64_t>(kColumns + (is("legacy") ? 16 : 0)) * kColumn_ns;
  EXPECT_EQ(recording.scans[0].stamp_ns, first_ns);
  EXPECT_EQ(recording.scans[1].stamp_ns, first_ns + std::int64_t{kColumns} * kColumn_ns);
  const Scan scan = value_of(recorded_scan_store(recording)->read(1));
  ASSERT_EQ(scan.time_offset_ns.size(), scan.points_m.size());
  std::size_t at = 0;
  for (std::size_t column = 0; column < kColumns; ++column) {
    for (std::size_t beam = 0; beam < kBeams; ++beam) {
      if (column == kBrokenColumn || !has_return(column, beam)) continue;
      const std::size_t returns = is("dual") && beam % 2 == 0 ? 2 : 1;
      for (std::size_t k = 0; k < returns; ++k, ++at) {
        ASSERT_EQ(scan.time_offset_ns[at], static_cast<std::int64_t>(column) * kColumn_ns);
      }
    }
  }
  EXPECT_EQ(at, scan.points_m.size());
}

TEST_P(OusterPcap, SurvivesDamage) {
  const std::filesystem::path json = std::filesystem::path(file()).replace_extension(".json");
  expect_damage_is_survived(*read_text_file(file()), *read_text_file(json), ".json", 2903);
}

INSTANTIATE_TEST_SUITE_P(Profiles, OusterPcap, testing::Values("legacy", "single", "dual", "low"),
                         [](const auto& one) { return std::string(one.param); });

TEST(OusterCapture, SaysWhatItLeftOutAndWhatItAssumed) {
  const Recording recording = value_of(open_capture_file(capture_file("ouster_legacy.pcap")));
  ASSERT_EQ(recording.warnings.size(), 2U);
  EXPECT_THAT(
      recording.warnings[0],
      HasSubstr("2 frames in 11 data packets; 2 frames that lack more than a tenth were left out"));
  EXPECT_THAT(recording.warnings[1], HasSubstr("clock was not set"));
}

class OusterFolder : public testing::Test {
 protected:
  OusterFolder()
      : pcap_(*read_text_file(capture_file("ouster_single.pcap"))),
        json_(*read_text_file(capture_file("ouster_single.json"))) {}

  [[nodiscard]] std::string with(const std::string& from, const std::string& to) const {
    std::string changed = json_;
    const std::size_t at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return changed.replace(at, from.size(), to);
  }
  std::string outcome(const std::string& metadata) {
    folder_.write("drive.json", metadata);
    return outcome_of(folder_.write("drive.pcap", pcap_));
  }

  ScratchFolder folder_;
  std::string pcap_;
  std::string json_;
};

TEST_F(OusterFolder, FindsTheMetadataUnderAnyNameAndTakesTheOneThatIsNamed) {
  const std::filesystem::path drive = folder_.write("drive.pcap", pcap_);
  EXPECT_THAT(outcome_of(drive), HasSubstr("put it beside the capture as drive.json"));
  folder_.write("roof.json", json_);
  folder_.write("other.json", "{}");
  EXPECT_EQ(outcome_of(drive), "no error");
  folder_.write("front.json", json_);  // which of the two?
  EXPECT_THAT(outcome_of(drive), HasSubstr("SL2008"));
  EXPECT_EQ(outcome_of(drive, (folder_ / "front.json").string()), "no error");
  folder_.write("drive_0.json", json_);
  EXPECT_EQ(outcome_of(drive), "no error");
}

TEST_F(OusterFolder, OtherMetadataIsAnotherRecording) {
  const auto digest = [&](const std::string& metadata) {
    folder_.write("drive.json", metadata);
    return value_of(open_capture_file(folder_.write("drive.pcap", pcap_))).digest;
  };
  EXPECT_EQ(digest(json_), digest(json_ + "\n"));
  EXPECT_NE(digest(json_), digest(with("21.3,", "21.4,")));
}

TEST_F(OusterFolder, MetadataThatIsNoneOrOfAnotherSensorIsRefusedAndSaysWhy) {
  const auto expect = [&](const std::string& metadata, const std::string& code,
                          const std::string& words) {
    const std::string said = outcome(metadata);
    EXPECT_THAT(said, HasSubstr(code));
    EXPECT_THAT(said, HasSubstr(words));
  };
  EXPECT_EQ(outcome(json_), "no error");
  expect("no json", "SL2020", "beam_altitude_angles");
  expect(with("RNG19_RFL8_SIG16_NIR16", "FUSA_RNG15_RFL8_NIR8_DUAL"), "SL2004", "ouster-cli");
  expect(with("\"lidar_to_sensor_transform\"", "\"other\""), "SL2008", "lidar_to_sensor_transform");
  expect(with("\"beam_azimuth_angles\"", "\"other\""), "SL2008", "beam_azimuth_angles");
  expect(with("21.3,", "\"high\","), "SL2020", "beam_altitude_angles");
  expect(with("21.3,", ""), "beams", "as many azimuths");
  expect(with("\"columns_per_frame\": 64", "\"columns_per_frame\": 32"), "column_window",
         "from 0 to 31");
  const std::string window = R"("column_window": [
   0,
   63)";
  std::string shorter = with("\"columns_per_frame\": 64", "\"columns_per_frame\": 32");
  expect(shorter.replace(shorter.find(window), window.size(), R"("column_window": [0, 31)"),
         "SL2022", "column 32");
  expect(with("\"columns_per_frame\": 64", "\"columns_per_frame\": 1e9"), "columns_per_frame",
         "1 to 4096");
  std::string wider = with("\"columns_per_frame\": 64", "\"columns_per_frame\": 4096");
  expect(wider.replace(wider.find(window), window.size(), R"("column_window": [0, 4095)"), "SL2014",
         "A capture of several sensors is not read");
  expect(with("RNG19_RFL8_SIG16_NIR16", "LEGACY"), "SL2014", "no whole frame");
}

TEST_F(OusterFolder, TakesAPacketOnceAndLeavesOutAFrameThatLacksAFourth) {
  const std::size_t record = 16 + 14 + 28 + 3328;
  const std::size_t other = 16 + 14 + 28 + 48;
  std::string twice = pcap_.substr(0, 24);
  for (std::size_t at = 24; at < pcap_.size(); at += record + other) {
    twice += pcap_.substr(at, record) + pcap_.substr(at, record + other);
  }
  folder_.write("drive.json", json_);
  const Recording plain = value_of(open_capture_file(folder_.write("drive.pcap", pcap_)));
  const Recording again = value_of(open_capture_file(folder_.write("drive.pcap", twice)));
  EXPECT_EQ(again.digest, plain.digest);
  EXPECT_TRUE(recorded_scan_store(again)->read(1));
  // The fourth packet belongs to frame 0.
  std::string torn = pcap_;
  torn.erase(24 + 3 * (record + other), record + other);
  EXPECT_EQ(value_of(open_capture_file(folder_.write("drive.pcap", torn))).scans.size(), 1U);
}

TEST(IpFragments, InAnyOrderAndAmongOthersAreOneDatagram) {
  const std::string whole = *read_text_file(capture_file("ouster_legacy.pcap"));
  std::vector<std::string> records;
  for (std::size_t at = 24; at < whole.size();) {
    std::uint32_t size = 0;
    std::memcpy(&size, whole.data() + at + 8, sizeof size);
    records.push_back(whole.substr(at, 16 + size));
    at += 16 + size;
  }
  // Three fragments a packet of 3392 bytes, then one of another kind.
  ASSERT_EQ(records.size() % 4, 0U);
  std::string shuffled = whole.substr(0, 24);
  for (std::size_t i = 0; i + 7 < records.size(); i += 8) {
    for (const std::size_t k : {2U, 4U, 1U, 3U, 0U, 6U, 5U, 7U}) shuffled += records[i + k];
  }
  for (std::size_t i = records.size() / 8 * 8; i < records.size(); ++i) shuffled += records[i];
  const ScratchFolder folder;
  folder.write("drive.json", *read_text_file(capture_file("ouster_legacy.json")));
  const Recording plain = value_of(open_capture_file(folder.write("drive.pcap", whole)));
  const Recording mixed = value_of(open_capture_file(folder.write("drive.pcap", shuffled)));
  ASSERT_EQ(mixed.scans.size(), plain.scans.size());
  for (std::size_t i = 0; i < mixed.scans.size(); ++i) {
    EXPECT_EQ(mixed.scans[i].content, plain.scans[i].content);
    EXPECT_TRUE(read_recorded_scan(mixed, i));
  }
  // Without one of its fragments a packet is none.
  std::string lost = whole.substr(0, 24);
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (i != 13) lost += records[i];
  }
  EXPECT_EQ(value_of(open_capture_file(folder.write("drive.pcap", lost))).scans.size(), 1U);
}

}  // namespace
}  // namespace sightline
