#include "formats/foreign/text/geodetic_track.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ctime>

#include "formats/base/files/atomic_file.h"
#include "formats/base/random.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/geometry.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

// Files of tracks/, which write_tracks.py makes from the same drive with its own geodesy.

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
fs::path track_file(const std::string& name) { return fs::path(SIGHTLINE_TRACKS) / name; }

TrackInWorld read_in(const fs::path& file, const std::string& world) {
  EXPECT_TRUE(is_geodetic(file)) << file;
  const Result<GeodeticTrack> track = read_geodetic_track(file);
  EXPECT_TRUE(track) << to_string(track.error());
  return value_of(in_world(*track, world, file.string()));
}

struct Form {
  const char* name;
  double tolerance_m;  // by the digits that the form holds
  bool has_attitude;
};

void expect_truth(const Form& form) {
  const std::vector<PoseRow> truth = *read_poses(track_file("truth.tum"), PoseFormat::kTum);
  const TrackInWorld found = read_in(track_file(form.name), "local");
  ASSERT_EQ(found.rows.size(), truth.size()) << form.name;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Pose error = truth[i].T_world_vehicle.inverse() * found.rows[i].T_world_vehicle;
    EXPECT_LT(error.translation().norm(), form.tolerance_m) << form.name << " " << i;
    if (form.has_attitude) {
      EXPECT_LT((error.linear() - Eigen::Matrix3d::Identity()).norm(), 1e-8) << form.name;
      EXPECT_EQ(found.rows[i].stamp_ns, truth[i].stamp_ns) << form.name;
    }
  }
  EXPECT_THAT(found.warnings.back() + found.warnings.front(), HasSubstr("world: enu:49,8.4,115"));
}

TEST(GeodeticTrack, IsTheSameDriveInEveryForm) {
  for (const Form& form :
       {Form{"gnss.csv", 2e-6, true}, Form{"ins.csv", 2e-6, true}, Form{"track.nmea", 2e-6, true},
        Form{"oxts", 2e-6, true}, Form{"oxts/data", 2e-6, true}}) {
    expect_truth(form);
  }
}

TEST(GeodeticTrack, WithoutHeadingLooksWhereItGoes) {
  const TrackInWorld found = read_in(track_file("places.csv"), "enu:49,8.4,0");
  ASSERT_EQ(found.rows.size(), 8U);
  for (std::size_t i = 1; i + 1 < 8; ++i) {
    const Eigen::Vector3d way_m = found.rows[i + 1].T_world_vehicle.translation() -
                                  found.rows[i - 1].T_world_vehicle.translation();
    EXPECT_GT(found.rows[i].T_world_vehicle.linear().col(0).dot(way_m.normalized()), 0.999) << i;
  }
  EXPECT_THAT(found.warnings, ::testing::Contains(HasSubstr("no height is given")));
  EXPECT_THAT(found.warnings, ::testing::Contains(HasSubstr("direction of travel")));
}

// By definition: from the last place a metre behind to the next a metre ahead.
std::optional<double> plain_direction(const std::vector<Eigen::Vector2d>& places_m,
                                      std::size_t at) {
  std::size_t behind = at;
  while (behind > 0 && (places_m[at] - places_m[behind]).norm() < 1.0) --behind;
  std::size_t ahead = at;
  while (ahead + 1 < places_m.size() && (places_m[ahead] - places_m[at]).norm() < 1.0) ++ahead;
  const Eigen::Vector2d way_m = places_m[ahead] - places_m[behind];
  if (way_m.norm() < 1.0) return std::nullopt;
  return portable_atan2(way_m.y(), way_m.x());
}

// A standing vehicle keeps its heading; before it first moved it has the next one.
std::vector<double> plain_headings(const std::vector<PoseRow>& rows) {
  std::vector<Eigen::Vector2d> places_m;
  for (const PoseRow& row : rows) {
    places_m.emplace_back(row.T_world_vehicle.translation().head<2>());
  }
  std::vector<std::optional<double>> found(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    found[i] = plain_direction(places_m, i);
    if (!found[i] && i > 0) found[i] = found[i - 1];
  }
  std::vector<double> headings_rad(rows.size());
  for (std::size_t i = rows.size(); i-- > 0;) {
    headings_rad[i] = found[i] ? *found[i] : headings_rad.at(i + 1);
  }
  return headings_rad;
}

GeodeticTrack random_track(Random& random) {
  GeodeticTrack track;
  const double noise_m = random.uniform(0.0, 0.6);
  const std::size_t count = 20 + random.below(400);
  Eigen::Vector2d at_m(0.0, 0.0);
  Eigen::Vector2d step_m(0.0, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    if (random.below(20) == 0) step_m = Eigen::Vector2d(random.normal(), random.normal());
    if (random.below(20) == 0) step_m.setZero();
    at_m += step_m;
    const Eigen::Vector2d seen_m =
        at_m + noise_m * Eigen::Vector2d(random.normal(), random.normal());
    GeodeticFix& fix = track.fixes.emplace_back();
    fix.at = {49.0 + seen_m.y() / 111'000.0, 8.4 + seen_m.x() / 73'000.0, 115.0};
  }
  track.fixes.back().at.latitude_deg += 1e-3;  // it moved, at least in the end
  return track;
}

TEST(GeodeticTrack, HeadingsAreTheDirectionsOfTravelByDefinition) {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const TrackInWorld found = value_of(in_world(random_track(random), "enu:49,8.4,115", "track"));
    const std::vector<double> headings_rad = plain_headings(found.rows);
    for (std::size_t i = 0; i < headings_rad.size(); ++i) {
      const Eigen::Matrix3d expected = rotation_matrix({Eigen::Vector3d::UnitZ(), headings_rad[i]});
      ASSERT_EQ(found.rows[i].T_world_vehicle.linear(), expected) << trial << " " << i;
    }
  }
}

GeodeticTrack standing_track(int count) {
  Random random(1);
  GeodeticTrack track;
  for (int i = 0; i < count; ++i) {
    track.fixes.emplace_back().at = {49.0 + 1e-7 * random.normal(), 8.4 + 1e-7 * random.normal(),
                                     115.0};
  }
  track.fixes.back().at.longitude_deg += 1e-4;
  return track;
}

std::clock_t cpu_of_standing(int count) {
  const GeodeticTrack track = standing_track(count);
  const std::clock_t begin = std::clock();
  EXPECT_TRUE(in_world(track, "enu:49,8.4,115", "track"));
  return std::clock() - begin;
}

TEST(GeodeticTrack, StandingTakesTimeInProportion) {
  EXPECT_LT(cpu_of_standing(64'000), 24 * cpu_of_standing(8'000));
  const TrackInWorld found = value_of(in_world(standing_track(8'000), "enu:49,8.4,115", "track"));
  EXPECT_GT(found.rows.front().T_world_vehicle.linear()(0, 0), 0.999) << "east";
}

// Grid north differs from true north by the convergence of the meridians, -0.45 degrees here (PROJ:
// proj -S +proj=utm +zone=32).
TEST(GeodeticTrack, InUtmIsTurnedToTheGrid) {
  const TrackInWorld utm = read_in(track_file("gnss.csv"), "utm:32N");
  const TrackInWorld square = read_in(track_file("gnss.csv"), "mgrs:32UMV");
  const Eigen::Vector3d at_m = utm.rows.front().T_world_vehicle.translation();
  EXPECT_NEAR(at_m.x(), 456'114.596, 0.01);
  EXPECT_NEAR(at_m.y(), 5'427'629.204, 0.01);
  EXPECT_LT(
      (square.rows.front().T_world_vehicle.translation() + Eigen::Vector3d(4e5, 5.4e6, 0.0) - at_m)
          .norm(),
      1e-5);
  const Eigen::Vector3d forward = utm.rows.front().T_world_vehicle.linear().col(0);
  const double yaw_deg = std::atan2(forward.y(), forward.x()) * 180.0 / std::numbers::pi;
  EXPECT_NEAR(yaw_deg, 0.3 * 180.0 / std::numbers::pi - 0.4529, 0.001);
}

TEST(GeodeticTrack, SaysWhatItSkips) {
  const Result<GeodeticTrack> track = read_geodetic_track(track_file("track.nmea"));
  EXPECT_THAT(track->warnings,
              ::testing::Contains(HasSubstr("1 lines are not sentences with a correct checksum")));
  EXPECT_THAT(track->warnings, ::testing::Contains(HasSubstr("1 positions without a fix")));
}

// A receiver of several satellite systems may write a position for each of them.
TEST(GeodeticTrack, TakesTheBetterOfTwoPositionsOfOneTime) {
  const auto gga = [](const char* talker, int second, const char* longitude, int quality) {
    return "$" + std::string(talker) + "GGA,12000" + std::to_string(second) + ".00,4900.0000,N," +
           longitude + ",E," + std::to_string(quality) + ",12,0.8,100.0,M,0.0,M,,\n";
  };
  const fs::path file = scratch_folder() / "two.nmea";
  const std::string text = gga("GP", 0, "00800.0000", 1) + gga("GN", 0, "00800.0010", 4) +
                           gga("GP", 1, "00800.0020", 4) + gga("GN", 1, "00800.0030", 4) +
                           gga("GP", 2, "00800.0040", 4) + gga("GN", 2, "00800.0050", 5);
  EXPECT_TRUE(write_file_atomically(file, text, IfExists::kReplace));
  const GeodeticTrack track = value_of(read_geodetic_track(file));
  ASSERT_EQ(track.fixes.size(), 3U);
  EXPECT_NEAR(60.0 * (track.fixes[0].at.longitude_deg - 8.0), 0.0010, 1e-9) << "RTK fixed";
  EXPECT_NEAR(60.0 * (track.fixes[1].at.longitude_deg - 8.0), 0.0020, 1e-9) << "the first";
  EXPECT_NEAR(60.0 * (track.fixes[2].at.longitude_deg - 8.0), 0.0040, 1e-9) << "RTK fixed";
  EXPECT_THAT(track.warnings, ::testing::Contains(HasSubstr("3 positions have the time")));
}

TEST(GeodeticTrack, RefusesWhatIsNone) {
  const auto error_of = [](const std::string& text) {
    const fs::path file = scratch_folder() / "track.csv";
    EXPECT_TRUE(write_file_atomically(file, text, IfExists::kReplace));
    const Result<GeodeticTrack> track = read_geodetic_track(file);
    if (!track) return to_string(track.error());
    return outcome_of(in_world(*track, "local", "track.csv"));
  };
  EXPECT_THAT(error_of("time,lat\n1,49\n"), HasSubstr("SL2008"));
  EXPECT_THAT(error_of("lat,lon\n49\n"), HasSubstr("(line 2): found 1 columns, expected 2"));
  EXPECT_THAT(error_of("lat,lon\n49,x\n"), HasSubstr("found 'x', expected a finite number"));
  EXPECT_THAT(error_of("lat,lon\n149,8\n"), HasSubstr("expected a position on Earth"));
  EXPECT_THAT(error_of("t,lat,lon\n2,49,8\n1,49,8\n"), HasSubstr("SL2012"));
  EXPECT_THAT(error_of("lat,lon\n49,8\n49,8\n"), HasSubstr("add a column heading or yaw"));
  EXPECT_THAT(error_of("lat,lon\n"), HasSubstr("found no pose"));
  EXPECT_THAT(error_of("$GPGGA,1,4900.0,N\n"), HasSubstr("found no pose"));
  EXPECT_THAT(to_string(read_geodetic_track(scratch_folder()).error()), HasSubstr("KITTI's oxts"));
}

TEST(DateTime, IsReadAsUtc) {
  EXPECT_EQ(parse_date_time_ns("1970-01-02", "00:00:01.5"), 86'401'500'000'000);
  EXPECT_EQ(parse_date_time_ns("2011-09-26", "13:02:25.594360375"), 1317042145594360375);
  for (const char* date : {"2011-13-26", "2011-02-30", "11-09-26", "2011/09/26", "1969-01-01"}) {
    EXPECT_FALSE(parse_date_time_ns(date, "13:02:25")) << date;
  }
  EXPECT_FALSE(parse_date_time_ns("2011-09-26", "25:02:25"));
}

}  // namespace
}  // namespace sightline
