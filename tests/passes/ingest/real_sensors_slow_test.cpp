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
  void use(const std::filesystem::path& scans) {
    RecordingOptions options;
    options.scans = scans.string();
    recording_ = value_of(open_recording(options));
  }
  // Or the refusal.
  std::string warning_under(const SensorProfile& sensor) {
    ctx_.warnings.clear();
    recording_.sensor = sensor;
    const Result<void> checked = check_sensor(ctx_, recording_);
    if (!checked) return to_string(checked.error());
    return ctx_.warnings.empty() ? "" : ctx_.warnings.front();
  }
  std::string warning_under(const std::string& sensor) {
    return warning_under(*sensor_profile(sensor));
  }

  Recording recording_;
  TestContext ctx_;
};

TEST_F(RealSensors, Kitti0005IsAnHdl64e) {
  const RealData data = real_data("kitti_0005");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  use(data.folder);
  EXPECT_EQ(warning_under("hdl-64e"), "");
  for (const char* other : {"generic-16", "generic-128", "os1-64"}) {
    EXPECT_THAT(warning_under(other), HasSubstr("guesses `sensor: hdl-64e`")) << other;
  }
}

TEST_F(RealSensors, MulranIsAnOs1) {
  const RealData data = real_data("mulran_kaist03");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  use(data.folder / "mulran_kaist03" / "Scans");
  EXPECT_EQ(warning_under("os1-64"), "");
  for (const char* other : {"generic-16", "generic-128", "hdl-64e"}) {
    EXPECT_THAT(warning_under(other), HasSubstr("guesses `sensor: os1-64`")) << other;
  }
}

TEST_F(RealSensors, ApolloSunnyvaleIsAnHdl64e) {
  const RealData data = real_data("apollo_sunnyvale_ndt");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  use(data.folder / "test_data" / "pcds");
  EXPECT_EQ(warning_under("hdl-64e"), "");
  for (const char* other : {"generic-16", "generic-128", "os1-64"}) {
    EXPECT_THAT(warning_under(other), HasSubstr("guesses `sensor: hdl-64e`")) << other;
  }
}

// Its name says Pandar128, as those who recorded it do. Its returns stand at the beams of a VLS-128
// to a fiftieth of the gap between them, and at all 128.
TEST_F(RealSensors, Pandar128StreetWasSeenByAVls128) {
  const RealData data = real_data("pandar128_street");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  use(data.folder / "pandar128_street" / "lidar");
  EXPECT_EQ(warning_under("vls-128"), "");
  for (const char* other : {"generic-16", "hdl-64e", "os1-64", "pandar128"}) {
    EXPECT_THAT(warning_under(other), HasSubstr("guesses `sensor: vls-128`")) << other;
  }
}

}  // namespace
}  // namespace sightline
