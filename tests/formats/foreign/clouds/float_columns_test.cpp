#include "formats/foreign/clouds/float_columns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "formats/base/random.h"
#include "tests/formats/foreign/float_layouts.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

TEST(FloatColumns, AreTakenFromACountOrFromNames) {
  EXPECT_EQ(*parse_float_columns("4"), FloatColumns());
  EXPECT_EQ(*parse_float_columns("x y z intensity"), FloatColumns());
  EXPECT_EQ(*parse_float_columns("x, y, z, i"), FloatColumns());
  EXPECT_EQ(to_text(*parse_float_columns("3")), "x y z");
  EXPECT_EQ(to_text(*parse_float_columns("6")), "x y z intensity _ _");
  EXPECT_EQ(to_text(*parse_float_columns("t ring y x z reflectivity _ _")),
            "time _ y x z intensity _ _");
  EXPECT_EQ(*parse_float_columns(to_text(columns_of_count(7))), columns_of_count(7));
}

TEST(FloatColumns, RefuseWhatIsNoPoint) {
  for (const char* text : {"", "2", "65", "-4", "4.0", "xyz", "x y", "x y i", "x y z x",
                           "x y z i intensity", "x y z t time", "x y z ring ring"}) {
    const Error error = failure_of(parse_float_columns(text), text);
    EXPECT_EQ(error.code, ErrorCode::kBadValue) << text;
    EXPECT_THAT(error.message, testing::HasSubstr("x y z intensity ring"));
  }
}

// A scan of a street: ground and broken walls on both sides, beams taking turns as a spinning
// sensor fires them (low, high, next low, ...). A beam that sees nothing gives (0,0,0), or no row
// at all.
struct Street {
  int beams = 16;
  bool keeps_misses = false;
};

std::vector<Eigen::Vector3d> scan_of(const Street& street) {
  std::vector<Eigen::Vector3d> points_m;
  Random random(7);
  for (int step = 0; step < 900; ++step) {
    for (int fired = 0; fired < street.beams; ++fired) {
      const double azimuth = step * 0.4 * std::numbers::pi / 180.0;
      const int beam = fired / 2 + fired % 2 * street.beams / 2;
      const double elevation =
          (-25.0 + 40.0 * beam / (street.beams - 1)) * std::numbers::pi / 180.0;
      const Eigen::Vector3d ray(std::cos(azimuth) * std::cos(elevation),
                                std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
      double range_m = ray.z() < 0.0 ? 1.8 / -ray.z() : 1e9;
      const double wall_m = (ray.y() > 0.0 ? 15.0 : -9.0) / ray.y();
      const bool is_wall =
          wall_m * ray.z() < 6.0 && std::fmod(std::abs(wall_m * ray.x()), 40.0) < 25.0;
      if (is_wall) range_m = std::min(range_m, wall_m);
      if (range_m < 100.0) {
        points_m.emplace_back((range_m + random.uniform(-0.02, 0.02)) * ray);
      } else if (street.keeps_misses) {
        points_m.emplace_back(Eigen::Vector3d::Zero());
      }
    }
  }
  return points_m;
}

TEST(FloatCounts, FindTheOneCountOfEachLayout) {
  for (const int beams : {16, 64}) {
    const std::vector<Eigen::Vector3d> points_m = scan_of({beams, false});
    for (const std::string& layout : kLayouts) {
      EXPECT_EQ(counts_text(fitting(float_file(points_m, layout))), std::to_string(layout.size()))
          << layout << " of " << beams << " beams";
    }
  }
}

TEST(FloatCounts, DoNotDependOnTheOrderOfThePoints) {
  std::vector<Eigen::Vector3d> points_m = scan_of({});
  Random random(5);
  for (std::size_t i = points_m.size(); i > 1; --i)
    std::swap(points_m[i - 1], points_m[random.below(i)]);
  for (const std::string& layout : kLayouts) {
    EXPECT_EQ(counts_text(fitting(float_file(points_m, layout))), std::to_string(layout.size()))
        << layout;
  }
}

// Where beams that see nothing give (0,0,0), two points look like one of twice the floats.
TEST(FloatCounts, FindTheOneCountWhereBeamsTakeTurnsToMiss) {
  for (const int beams : {16, 32, 64}) {
    const std::vector<Eigen::Vector3d> points_m = scan_of({beams, true});
    for (const std::string layout : {"xyz", "xyzi", "xyzir", "xyzirt"}) {
      const std::string bytes = float_file(points_m, layout);
      EXPECT_EQ(counts_text(fitting(bytes)), std::to_string(layout.size()))
          << layout << " of " << beams;
      EXPECT_FALSE(is_refuted(std::as_bytes(std::span(bytes)), layout.size()));
    }
  }
}

TEST(FloatCounts, FitEachPartOfAScanThatIsLargeEnough) {
  const std::vector<Eigen::Vector3d> points_m = scan_of({});
  for (const std::string layout : {"xyz", "xyzi", "xyzir", "xyzirt", "xyzinnnd"}) {
    for (std::size_t begin = 0; begin + 1400 <= points_m.size(); begin += 1400) {
      const auto first = points_m.begin() + static_cast<long>(begin);
      const std::string bytes = float_file({first, first + 1400}, layout);
      EXPECT_NE(fitting(bytes) & only(layout.size()), 0U) << layout << " from point " << begin;
    }
  }
}

TEST(FloatCounts, LeaveOutWhatIsNoPoint) {
  const std::vector<Eigen::Vector3d> points_m = scan_of({});
  for (const std::string layout : {"d", "dI", "rxyzi", "lxyz", "txyzi"}) {
    EXPECT_EQ(counts_text(fitting(float_file(points_m, layout))), "none") << layout;
  }
}

TEST(FloatCounts, AreAllPossibleWhereThereIsTooLittleToTell) {
  EXPECT_EQ(fitting(std::string(4 * 4095, '\1')), kAnyCount);
  EXPECT_EQ(fitting(""), kAnyCount);
  EXPECT_EQ(counts_text(dividing_counts(48)), "3 or 4 or 6");
  EXPECT_EQ(counts_text(dividing_counts(0)), counts_text(kAnyCount));
}

TEST(FloatCounts, RefuteWhatSomebodySaysOnlyWhereItCannotBe) {
  const std::string bytes = float_file(scan_of({}), "xyzir");
  for (std::size_t count = kLeastFloats; count <= kMostFloats; ++count) {
    EXPECT_EQ(is_refuted(std::as_bytes(std::span(bytes)), count), count % 5 != 0) << count;
  }
}

TEST(FloatCounts, OneThatFitsAndDividesIsTaken) {
  EXPECT_EQ(*the_one_count(only(4), kAnyCount), 4U);
  EXPECT_EQ(*the_one_count(kAnyCount, only(5)), 5U);
  EXPECT_EQ(the_one_count(0, kAnyCount).error().code, ErrorCode::kUnsupportedFormat);
  EXPECT_EQ(the_one_count(only(5), only(4)).error().code, ErrorCode::kTruncatedScan);
  const Result<std::size_t> both = the_one_count(only(4) | only(8), kAnyCount);
  EXPECT_EQ(both.error().code, ErrorCode::kUnsupportedFormat);
  EXPECT_THAT(both.error().message, HasSubstr("4 or 8"));
}

}  // namespace
}  // namespace sightline
