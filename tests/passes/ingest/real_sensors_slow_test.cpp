#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/foreign/recording/open_recording.h"
#include "passes/ingest/check_sensor.h"
#include "tests/support/real_data.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;

// Real LiDARs, each under its own profile and under others.
class RealSensors : public testing::Test {
 protected:
  void expect_guessed(const char* set, const std::filesystem::path& scans, const std::string& name,
                      const std::vector<std::string>& others) {
    const RealData data = real_data(set);
    if (!data.missing.empty()) GTEST_SKIP() << data.missing;
    RecordingOptions options;
    options.scans = (scans.empty() ? data.folder : data.folder / scans).string();
    recording_ = value_of(open_recording(options));
    EXPECT_EQ(warning_under(name), "");
    for (const std::string& other : others) {
      EXPECT_THAT(warning_under(other), HasSubstr("suggests `sensor: " + name + "`")) << other;
    }
  }

 private:
  // Or the refusal.
  std::string warning_under(const std::string& sensor) {
    ctx_.warnings.clear();
    recording_.sensor = *sensor_profile(sensor);
    const Result<void> checked = check_sensor(ctx_, recording_, notices_);
    if (!checked) return to_string(checked.error());
    return ctx_.warnings.empty() ? "" : ctx_.warnings.front();
  }

  Recording recording_;
  TestContext ctx_;
  std::vector<Notice> notices_;
};

TEST_F(RealSensors, Kitti0005IsAnHdl64e) {
  expect_guessed("kitti_0005", "", "hdl-64e", {"generic-16", "generic-128", "os1-64"});
}

TEST_F(RealSensors, MulranIsAnOs1) {
  expect_guessed("mulran_kaist03", "mulran_kaist03/Scans", "os1-64",
                 {"generic-16", "generic-128", "hdl-64e"});
}

TEST_F(RealSensors, ApolloSunnyvaleIsAnHdl64e) {
  expect_guessed("apollo_sunnyvale_ndt", "test_data/pcds", "hdl-64e",
                 {"generic-16", "generic-128", "os1-64"});
}

// Its name says Pandar128, as those who recorded it do. Its returns stand at the beams of a VLS-128
// to a fiftieth of the gap between them, and at all 128.
TEST_F(RealSensors, Pandar128StreetWasSeenByAVls128) {
  expect_guessed("pandar128_street", "pandar128_street/lidar", "vls-128",
                 {"generic-16", "hdl-64e", "os1-64", "pandar128"});
}

}  // namespace
}  // namespace sightline
