#include "passes/ingest/check_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/text/table.h"
#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// A vehicle drives 100 m to the north-east past points up to 40 m away, in ten scans.
class CheckFrameTest : public testing::Test {
 protected:
  struct Files {
    bool are_registered = false;
    bool have_viewpoint = false;
  };
  Recording write(const Files& files, bool has_poses) {
    Random random(3);
    std::string poses;
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector3d at_m(1000.0 + 7.0 * i, 500.0 + 7.0 * i, 2.0);
      std::string points;
      for (int k = 0; k < 200; ++k) {
        Eigen::Vector3d point_m(random.uniform(-40, 40), random.uniform(-30, 30), 1.0);
        if (files.are_registered) point_m += at_m;
        points += concat(format_double(point_m.x()), " ", format_double(point_m.y()), " ",
                         format_double(point_m.z()), "\n");
      }
      const std::string place = concat(format_double(at_m.x()), " ", format_double(at_m.y()), " ",
                                       format_double(at_m.z()));
      folder_.write(concat("scans/", i, ".pcd"),
                    "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 200\nHEIGHT 1\n" +
                        (files.have_viewpoint ? "VIEWPOINT " + place + " 1 0 0 0\n" : "") +
                        "POINTS 200\nDATA ascii\n" + points);
      poses += concat(i, " ", place, " 0 0 0 1\n");
    }
    RecordingOptions options;
    options.scans = (folder_ / "scans").string();
    if (has_poses) options.poses = folder_.write("poses.txt", poses).string();
    return value_of(open_recording(options));
  }
  ScratchFolder folder_;
};

TEST_F(CheckFrameTest, RefusesScansWhosePointsMoveAsThePosesDo) {
  const Error refused = failure_of(check_frame(write({.are_registered = true}, true)));
  EXPECT_EQ(refused.code, ErrorCode::kUnsupportedFormat);
  EXPECT_THAT(refused.message, HasSubstr("the scans are in the frame of the poses"));
  EXPECT_THAT(refused.message, HasSubstr("their points move"));
  EXPECT_TRUE(check_frame(write({.are_registered = true}, false)).has_value()) << "no poses";
}

TEST_F(CheckFrameTest, TakesTheViewpointOfAPcdForAPoseWhereThereAreNone) {
  const Files registered = {.are_registered = true, .have_viewpoint = true};
  EXPECT_EQ(code_of(check_frame(write(registered, false))), ErrorCode::kUnsupportedFormat);
}

TEST_F(CheckFrameTest, AcceptsPointsAroundTheSensor) {
  EXPECT_TRUE(check_frame(write({}, true)).has_value());
  EXPECT_TRUE(check_frame(write({.have_viewpoint = true}, false)).has_value());
}

}  // namespace
}  // namespace sightline
