#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "formats/foreign/logs/velodyne_packet.h"
#include "formats/foreign/recording/open_recording.h"
#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

constexpr std::uint8_t kHdl32 = 0x21;
constexpr std::uint8_t kVlp16 = 0x22;
constexpr std::uint32_t kDay_s = 1'700'000'000;  // on the hour plus 800 s

// A packet whose blocks begin at `azimuth_cdeg` and turn by `step_cdeg`; every laser sees 10 m.
std::string packet(std::uint8_t product, unsigned azimuth_cdeg, unsigned step_cdeg,
                   std::uint32_t hour_us, std::uint8_t mode = 0x37) {
  std::string bytes;
  for (unsigned block = 0; block < 12; ++block) {
    bytes += "\xff\xee" +
             as_bytes({static_cast<std::uint16_t>((azimuth_cdeg + block * step_cdeg) % 36000)});
    for (unsigned i = 0; i < 32; ++i) {
      bytes += as_bytes({std::uint16_t{5000}}) + static_cast<char>(i);
    }
  }
  return bytes + as_bytes({hour_us}) + static_cast<char>(mode) + static_cast<char>(product);
}

std::string big16(unsigned value) {
  return {static_cast<char>(value >> 8U), static_cast<char>(value & 255U)};
}

std::string record(std::uint32_t seconds, std::uint32_t us, const std::string& datagram) {
  const auto size = static_cast<unsigned>(datagram.size());
  std::string frame = std::string(12, '\x01') + big16(0x0800);
  frame += "\x45" + std::string(1, '\0') + big16(28 + size) + std::string(4, '\0') + "\x40\x11" +
           std::string(10, '\0');
  frame += big16(2368) + big16(2368) + big16(8 + size) + big16(0) + datagram;
  const auto length = static_cast<std::uint32_t>(frame.size());
  return as_bytes({seconds, us, length, length}) + frame;
}

std::string pcap_header() { return as_bytes({0xa1b2c3d4U, 0x00040002U, 0U, 0U, 0x40000U, 1U}); }

// A VLP-16 at 10 Hz: 0.4 degrees a block, so a revolution is 75 packets and 90 blocks a quarter.
std::string vlp16_drive(int packets, unsigned first_azimuth_cdeg = 18000) {
  std::string bytes = pcap_header();
  for (int i = 0; i < packets; ++i) {
    const auto us = static_cast<std::uint32_t>(i) * 1327;
    const unsigned azimuth_cdeg = (first_azimuth_cdeg + 480U * static_cast<unsigned>(i)) % 36000;
    bytes += record(kDay_s + 5, us, packet(kVlp16, azimuth_cdeg, 40, 800'000'000 + us));
  }
  return bytes;
}

// The same packets as a pcapng: a section, an interface with times in nanoseconds, a packet a
// block.
std::string as_pcapng(const std::string& pcap, bool is_swapped = false) {
  const auto u32 = [&](std::uint32_t value) {
    std::string bytes = as_bytes({value});
    if (is_swapped) std::ranges::reverse(bytes);
    return bytes;
  };
  const auto u16_pair = [&](std::uint16_t first, std::uint16_t second) {
    return is_swapped ? big16(first) + big16(second) : as_bytes({first, second});
  };
  const auto block = [&](std::uint32_t type, std::string body) {
    body.resize((body.size() + 3) / 4 * 4);
    const auto length = static_cast<std::uint32_t>(body.size() + 12);
    return u32(type) + u32(length) + body + u32(length);
  };
  std::string bytes = block(0x0a0d0d0a, u32(0x1a2b3c4d) + u16_pair(1, 0) + std::string(8, '\xff'));
  bytes += block(1, u16_pair(1, 0) + u32(0) + u16_pair(9, 1) + std::string("\x09\0\0\0", 4));
  bytes += block(4, std::string(4, '\0'));  // names, which are not needed
  for (std::size_t at = 24; at < pcap.size();) {
    std::uint32_t head[4] = {};
    std::memcpy(head, pcap.data() + at, sizeof head);
    const std::uint64_t time_ns = head[0] * 1'000'000'000ULL + head[1] * 1000ULL;
    bytes += block(6, u32(0) + u32(static_cast<std::uint32_t>(time_ns >> 32U)) +
                          u32(static_cast<std::uint32_t>(time_ns)) + u32(head[2]) + u32(head[3]) +
                          pcap.substr(at + 16, head[2]));
    at += 16 + head[2];
  }
  return bytes;
}

TEST(VelodynePacket, PutsTheLasersOfAVlp16WhereTheManualDoes) {
  const std::string bytes = packet(kVlp16, 9000, 40, 17);
  const VelodynePacket decoded(std::as_bytes(std::span(bytes)));
  ASSERT_TRUE(decoded.is_valid());
  EXPECT_EQ(decoded.model(), VelodyneModel::kVlp16);
  EXPECT_EQ(decoded.hour_us(), 17U);
  PointCloudFile cloud;
  decoded.append_block(2, 1000, cloud);
  ASSERT_EQ(cloud.points_m.size(), 32U);
  // Block 2 begins at 90.8 degrees, clockwise: to the right. Laser 0 looks 15 degrees down and sits
  // 11.2 mm high.
  const double turn = 90.8 * std::numbers::pi / 180.0;
  const double down = -15.0 * std::numbers::pi / 180.0;
  const Eigen::Vector3d first_m(10.0 * std::cos(down) * std::cos(turn),
                                -10.0 * std::cos(down) * std::sin(turn),
                                10.0 * std::sin(down) + 0.0112);
  EXPECT_TRUE(cloud.points_m[0].isApprox(first_m, 1e-12)) << cloud.points_m[0].transpose();
  // Four firing sequences of 55.296 us before block 2; its second sequence is half a step on.
  EXPECT_EQ(cloud.time_offset_ns[0], 1000 + 4 * 55'296);
  EXPECT_EQ(cloud.time_offset_ns[17], 1000 + 5 * 55'296 + 2'304);
  const Eigen::Vector3d& later_m = cloud.points_m[16];
  EXPECT_NEAR(std::atan2(-later_m.y(), later_m.x()) * 180.0 / std::numbers::pi, 91.0, 1e-9);
  EXPECT_EQ(cloud.intensity[17], 17.0F);
}

TEST(VelodynePacket, PutsTheLasersOfAnHdl32WhereTheManualDoes) {
  const std::string bytes = packet(kHdl32, 0, 16, 0);
  const VelodynePacket decoded(std::as_bytes(std::span(bytes)));
  PointCloudFile cloud;
  decoded.append_block(11, 0, cloud);
  ASSERT_EQ(cloud.points_m.size(), 32U);
  const auto elevation_deg = [&](std::size_t i) {
    return std::asin(cloud.points_m[i].z() / 10.0) * 180.0 / std::numbers::pi;
  };
  EXPECT_NEAR(elevation_deg(0), -30.67, 0.005);
  EXPECT_NEAR(elevation_deg(1), -9.33, 0.005);
  EXPECT_NEAR(elevation_deg(2), -29.33, 0.005);
  EXPECT_NEAR(elevation_deg(15), 0.0, 0.005);
  EXPECT_NEAR(elevation_deg(31), 10.67, 0.005);
  EXPECT_EQ(cloud.time_offset_ns[31], 11 * 46'080 + 31 * 1'152);
}

TEST(VelodynePacket, ReadsBothReturnsAndNoneTwice) {
  std::string bytes = packet(kVlp16, 100, 0, 0, 0x39);
  bytes[100 + 4] = '\x01';  // block 1, laser 0: another distance than in block 0
  const VelodynePacket decoded(std::as_bytes(std::span(bytes)));
  PointCloudFile cloud;
  decoded.append_block(0, 0, cloud);
  decoded.append_block(1, 0, cloud);
  EXPECT_EQ(cloud.points_m.size(), 33U);
  EXPECT_EQ(cloud.zero_count, 31U);
  EXPECT_EQ(cloud.time_offset_ns[32], 0);  // measured with block 0
}

class VelodynePcapTest : public testing::Test {
 protected:
  Result<Recording> open(const std::string& bytes) {
    RecordingOptions options;
    options.scans = folder_.write("drive.pcap", bytes).string();
    options.sensor = "vlp-16";
    return open_recording(options);
  }
  ErrorCode refusal(const std::string& bytes) { return code_of(open(bytes)); }
  ScratchFolder folder_;
};

TEST_F(VelodynePcapTest, IsADriveOfWholeRevolutionsWithTheSensorsOwnTimes) {
  // From 180 degrees on: half a revolution, then two and a quarter.
  const Recording recording = value_of(open(vlp16_drive(206)));
  ASSERT_EQ(recording.scans.size(), 2U);
  EXPECT_EQ(recording.scans[1].name, "drive.pcap#1");
  // The first fall is at block 6 of packet 37 (18000 + 37 * 480 + 6 * 40 = 36000), 12 firings in.
  // Seconds and microseconds are the sensor's own, the hour is the capture's: 5 s are no matter.
  EXPECT_EQ(recording.scans[0].stamp_ns,
            std::int64_t{kDay_s} * 1'000'000'000 + 37 * 1'327'000 + 12 * 55'296);
  const std::shared_ptr<const ScanStore> store = recorded_scan_store(recording);
  for (std::size_t i = 0; i < 2; ++i) {
    const Scan scan = value_of(store->read(i));
    ASSERT_EQ(scan.points_m.size(), 900U * 32U);  // 360 degrees of 0.4
    ASSERT_EQ(scan.time_offset_ns.size(), scan.points_m.size());
    EXPECT_EQ(scan.time_offset_ns.front(), 0);
    EXPECT_NEAR(scan.time_offset_ns.back(), 75 * 1'327'000, 200'000);
    EXPECT_NEAR(scan.points_m.front().x(), 10.0 * std::cos(15.0 * std::numbers::pi / 180.0), 1e-9);
  }
  ASSERT_EQ(recording.warnings.size(), 1U);
  EXPECT_THAT(recording.warnings[0], HasSubstr("2 whole revolutions in 206 data packets"));
}

TEST_F(VelodynePcapTest, SkipsOtherPacketsAndThoseCapturedTwice) {
  const std::string whole = vlp16_drive(206);
  const std::size_t record_size = 16 + 42 + kVelodynePacketSize;
  std::string mixed = whole.substr(0, 24);
  for (std::size_t at = 24; at < whole.size(); at += record_size) {
    mixed += whole.substr(at, record_size) + whole.substr(at, record_size);
    mixed += record(kDay_s, 0, std::string(512, '$'));
  }
  const Recording plain = value_of(open(whole));
  const Recording recording = value_of(open(mixed));
  EXPECT_EQ(recording.digest, plain.digest);
  EXPECT_TRUE(recorded_scan_store(recording)->read(1).has_value());
}

TEST_F(VelodynePcapTest, LeavesOutTheRevolutionAroundAGapAndSaysWhere) {
  const std::string whole = vlp16_drive(300);
  const std::size_t record_size = 16 + 42 + kVelodynePacketSize;
  std::string torn = whole;
  torn.erase(24 + 130 * record_size, 10 * record_size);  // 13 ms of the second revolution
  const Recording recording = value_of(open(torn));
  EXPECT_EQ(recording.scans.size(), 2U);  // of three
  ASSERT_EQ(recording.warnings.size(), 2U);
  EXPECT_THAT(recording.warnings[1],
              HasSubstr("1 gaps of more than 10 ms between packets, the first at "
                        "byte " +
                        std::to_string(24 + 130 * record_size)));
}

TEST_F(VelodynePcapTest, CountsOnThroughTheFullHour) {
  std::string bytes = pcap_header();
  for (std::uint32_t i = 0; i < 206; ++i) {
    const std::uint64_t us = 3'599'900'000ULL + i * 1327ULL;
    bytes += record(kDay_s, 0,
                    packet(kVlp16, (18000 + 480 * i) % 36000, 40,
                           static_cast<std::uint32_t>(us % 3'600'000'000ULL)));
  }
  const Recording recording = value_of(open(bytes));
  EXPECT_NEAR(static_cast<double>(recording.scans[1].stamp_ns - recording.scans[0].stamp_ns),
              75 * 1'327'000, 2.0);
}

TEST_F(VelodynePcapTest, RefusesWhatItCannotDecodeAndSaysWhy) {
  const std::string whole = vlp16_drive(206);
  EXPECT_EQ(refusal(whole.substr(0, 24)), ErrorCode::kDriveTooShort);
  EXPECT_EQ(refusal(vlp16_drive(60)), ErrorCode::kDriveTooShort);
  EXPECT_EQ(refusal(whole.substr(0, 20)), ErrorCode::kTruncatedScan);
  EXPECT_EQ(refusal(whole.substr(0, whole.size() - 1)), ErrorCode::kTruncatedScan);
  std::string other = whole;
  other[24 + 16 + 42 + 1205] = '\x28';  // VLP-32C
  EXPECT_EQ(refusal(other), ErrorCode::kUnsupportedFormat);
  std::string noise = whole;
  noise[24 + 16 + 42] = 'x';
  EXPECT_EQ(refusal(noise), ErrorCode::kMalformedHeader);
  const std::string back = whole + record(kDay_s, 0, packet(kVlp16, 0, 40, 799'999'999));
  EXPECT_EQ(refusal(back), ErrorCode::kTimeRunsBackwards);
  // A hole in the place of packets would be walked through for as long as it is.
  EXPECT_EQ(refusal(whole + std::string(16, '\0')), ErrorCode::kMalformedHeader);
  std::string link = whole;
  link[20] = 5;
  EXPECT_EQ(refusal(link), ErrorCode::kUnsupportedFormat);
}

TEST_F(VelodynePcapTest, ReadsTheOtherByteOrder) {
  std::string bytes = vlp16_drive(206);
  const auto turn = [&](std::size_t at, std::size_t size) {
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                 bytes.begin() + static_cast<std::ptrdiff_t>(at + size));
  };
  for (const std::size_t at : {0U, 8U, 12U, 16U, 20U}) turn(at, 4);
  for (std::size_t at = 24; at < bytes.size(); at += 16 + 42 + kVelodynePacketSize) {
    for (std::size_t word = 0; word < 16; word += 4) turn(at + word, 4);
  }
  EXPECT_EQ(value_of(open(bytes)).digest, open(vlp16_drive(206))->digest);
}

TEST(VelodynePcap, IsTheSameAsAPcapng) {
  const ScratchFolder folder;
  const std::string pcap = vlp16_drive(300);
  RecordingOptions options;
  options.scans = folder.write("drive.pcap", pcap).string();
  const Recording classic = value_of(open_recording(options));
  ASSERT_GT(classic.scans.size(), 1U);
  for (const bool is_swapped : {false, true}) {
    options.scans = folder.write("drive.pcapng", as_pcapng(pcap, is_swapped)).string();
    const Recording blocks = value_of(open_recording(options));
    ASSERT_EQ(blocks.scans.size(), classic.scans.size());
    for (std::size_t i = 0; i < classic.scans.size(); ++i) {
      EXPECT_EQ(blocks.scans[i].content, classic.scans[i].content);
      EXPECT_EQ(blocks.scans[i].stamp_ns, classic.scans[i].stamp_ns);
      EXPECT_EQ(read_recorded_scan(blocks, i)->points_m, read_recorded_scan(classic, i)->points_m);
    }
  }
}

TEST(VelodynePcap, OfAPcapngThatIsCutOrOfSeveralSectionsIsRefused) {
  const ScratchFolder folder;
  const std::string whole = as_pcapng(vlp16_drive(80));
  RecordingOptions options;
  const auto error_of = [&](const std::string& bytes) {
    options.scans = folder.write("drive.pcapng", bytes).string();
    return outcome_of(open_recording(options));
  };
  EXPECT_THAT(error_of(whole + whole), HasSubstr("editcap -F pcap"));
  EXPECT_NE(error_of(whole.substr(0, whole.size() - 7)).find("SL2006"), std::string::npos);
  for (std::size_t cut = 4; cut < 200; ++cut) EXPECT_NE(error_of(whole.substr(0, cut)), "no error");
}

}  // namespace
}  // namespace sightline
