#include "tests/formats/foreign/logs/capture_files.h"

namespace sightline {
namespace {

struct HesaiCase {
  const char* name;
  std::size_t channels;
  std::size_t scans;
  double blocks;  // of a packet that follow each other
  double block_us;
  double last_block_us;    // after the packet's time
  double first_firing_us;  // of all channels, after the block's time
  bool needs_correction = false;
};

class HesaiPcap : public testing::TestWithParam<HesaiCase> {
 protected:
  [[nodiscard]] std::filesystem::path file() const {
    return capture_file(std::string(GetParam().name) + ".pcap");
  }
  [[nodiscard]] bool is_dual() const {
    return std::string(GetParam().name).find("dual") != std::string::npos;
  }
};

TEST_P(HesaiPcap, PutsReturnsOnTheWallsThatTheBeamsMet) {
  const HesaiCase& sensor = GetParam();
  const Recording recording = value_of(open_capture_file(file()));
  ASSERT_EQ(recording.scans.size(), sensor.scans);
  const PointCloudFile cloud = value_of(read_recorded_scan(recording, 0));
  // 120 blocks of 3 degrees; one return in 13 is missing. Of the second returns those of even
  // channels are half as far.
  const double whole = 120.0 * static_cast<double>(sensor.channels);
  std::size_t on_walls = 0;
  for (const Eigen::Vector3d& p_m : cloud.points_m) on_walls += to_wall_m(p_m) <= 0.0021 ? 1U : 0U;
  EXPECT_NEAR(static_cast<double>(on_walls), whole * 12.0 / 13.0, 0.01 * whole);
  const double halves = is_dual() ? 0.5 * whole * 12.0 / 13.0 : 0.0;
  EXPECT_NEAR(static_cast<double>(cloud.points_m.size() - on_walls), halves, 0.01 * whole);
}

TEST_P(HesaiPcap, TakesTheTimesOfTheSensor) {
  const HesaiCase& sensor = GetParam();
  const Recording recording = value_of(open_capture_file(file()));
  // The head passes 0 with block 13 behind the first one, which fired so many blocks but one before
  // the time of its packet; 999 ms after the start.
  const double expected_us = 999'000.0 + (13.0 - (sensor.blocks - 1.0)) * sensor.block_us +
                             sensor.last_block_us + sensor.first_firing_us;
  EXPECT_NEAR(1e-3 * static_cast<double>(recording.scans[0].stamp_ns - kCaptureStart_ns),
              expected_us, 1.0);
  const Scan scan = value_of(recorded_scan_store(recording)->read(0));
  ASSERT_EQ(scan.time_offset_ns.size(), scan.points_m.size());
  EXPECT_GE(std::ranges::min(scan.time_offset_ns), 0);
  EXPECT_LE(std::ranges::min(scan.time_offset_ns), 4000);
  EXPECT_NEAR(1e-3 * std::ranges::max(scan.time_offset_ns), 120.0 * sensor.block_us, 10.0);
}

TEST_P(HesaiPcap, WithoutItsAngleCorrectionTakesTheNominalOneAndSaysSo) {
  const ScratchFolder folder;
  const std::filesystem::path alone = folder.write("drive.pcap", *read_text_file(file()));
  if (GetParam().needs_correction) {
    EXPECT_THAT(outcome_of(alone), HasSubstr("SL2008 missing-field"));
    EXPECT_THAT(outcome_of(alone), HasSubstr("angle correction file"));
    return;
  }
  const Recording nominal = value_of(open_capture_file(alone));
  ASSERT_FALSE(nominal.warnings.empty());
  EXPECT_THAT(nominal.warnings.back(), HasSubstr("angle correction file"));
  const std::filesystem::path csv = std::filesystem::path(file()).replace_extension(".csv");
  folder.write("front.csv", *read_text_file(csv));
  folder.write("poses.csv", "t,x,y,z\n1,2,3,4\n");
  const Recording measured = value_of(open_capture_file(alone));
  EXPECT_NE(measured.digest, nominal.digest);
  EXPECT_EQ(measured.warnings.back().find("angle correction file"), std::string::npos);
  // Named by its elevations' order in the manual: channel 1 looks highest.
  const PointCloudFile a = value_of(read_recorded_scan(nominal, 0));
  const PointCloudFile b = value_of(read_recorded_scan(measured, 0));
  ASSERT_EQ(a.points_m.size(), b.points_m.size());
  for (std::size_t i = 0; i < a.points_m.size(); ++i) {
    const double apart_rad = std::acos(
        std::clamp(a.points_m[i].normalized().dot(b.points_m[i].normalized()), -1.0, 1.0));
    ASSERT_LT(apart_rad * 180.0 / M_PI, 20.0);
  }
}

TEST_P(HesaiPcap, SurvivesDamage) {
  const std::filesystem::path csv = std::filesystem::path(file()).replace_extension(".csv");
  expect_damage_is_survived(*read_text_file(file()), *read_text_file(csv), ".csv", 2903);
}

INSTANTIATE_TEST_SUITE_P(
    Models, HesaiPcap,
    testing::Values(HesaiCase{"hesai_pandar64", 64, 1, 6.0, 55.56, -42.58, -54.668},
                    HesaiCase{"hesai_xt32", 32, 2, 8.0, 50.0, 0.0, 6.0},
                    HesaiCase{"hesai_xt16_dual", 16, 1, 4.0, 50.0, 0.0, 6.0},
                    HesaiCase{"hesai_pandar128", 128, 1, 2.0, 55.556, 3.148, 0.776, true},
                    HesaiCase{"hesai_pandar128_fine_dual", 128, 1, 1.0, 27.778, 3.148, 0.776,
                              true}),
    [](const auto& one) { return std::string(one.param.name); });

TEST(HesaiCapture, OfAnotherModelOrWithAnotherCorrectionIsRefusedAndSaysWhy) {
  const ScratchFolder folder;
  const std::string pcap = *read_text_file(capture_file("hesai_xt32.pcap"));
  const std::string csv = *read_text_file(capture_file("hesai_xt32.csv"));
  const std::filesystem::path drive = folder.write("drive.pcap", pcap);
  const auto with_csv = [&](const std::string& text) {
    folder.write("drive.csv", text);
    return outcome_of(drive);
  };
  EXPECT_EQ(with_csv(csv), "no error");
  EXPECT_NE(with_csv(csv.substr(0, csv.rfind("1,"))).find("found 31 channels, expected the 32"),
            std::string::npos);
  std::string repeated = csv;
  repeated.replace(repeated.find("\n31,"), 4, "\n32,");
  EXPECT_THAT(with_csv(repeated), HasSubstr("each of 1 to 32 once"));
  EXPECT_EQ(outcome_of(drive, capture_file("hesai_xt32.csv").string()), "no error");
  const auto changed = [&](std::size_t at, char value) {
    std::string other = pcap;
    for (std::size_t record = 24; record + 100 < other.size(); record += 58 + 1080 + 58 + 64) {
      other[record + 58 + at] = value;
    }
    return outcome_of(folder.write("drive.pcap", other));
  };
  folder.write("drive.csv", csv);
  EXPECT_THAT(changed(3, '\4'), HasSubstr("another model of Hesai (6.4, 1080 bytes)"));
  EXPECT_THAT(changed(3, '\4'), HasSubstr("PandarView"));
  EXPECT_THAT(changed(9, '\0'), HasSubstr("SL2005"));            // unit
  EXPECT_THAT(changed(13, '\xff'), HasSubstr("SL2005"));         // azimuth
  EXPECT_THAT(changed(1052 + 10, '\x3d'), HasSubstr("SL2004"));  // three returns
}

TEST(Capture, OfNoLidarSaysHowToConvertIt) {
  const ScratchFolder folder;
  const std::string pcap = *read_text_file(capture_file("hesai_xt32.pcap"));
  std::string other = pcap;
  for (std::size_t at = 24; at + 100 < other.size(); at += 58 + 1080 + 58 + 64)
    other[at + 58] = 'x';
  const std::string said = outcome_of(folder.write("drive.pcap", other));
  EXPECT_THAT(said, HasSubstr("SL2004"));
  EXPECT_THAT(said, HasSubstr("record its points in a bag"));
}

}  // namespace
}  // namespace sightline
