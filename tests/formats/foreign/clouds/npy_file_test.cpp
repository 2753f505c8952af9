#include "formats/foreign/clouds/read_point_cloud.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

// As numpy.save writes it: the head padded with blanks so that the numbers begin at a multiple of
// 64.
std::string npy(const std::string& descr, const std::string& shape, const std::string& numbers,
                const char* order = "False") {
  std::string head =
      "{'descr': " + descr + ", 'fortran_order': " + order + ", 'shape': " + shape + ", }";
  while ((10 + head.size() + 1) % 64 != 0) head += ' ';
  head += '\n';
  return std::string("\x93NUMPY\1\0", 8) + as_bytes({static_cast<std::uint16_t>(head.size())}) +
         head + numbers;
}

Result<PointCloudFile> parse(const std::string& bytes) {
  return parse_point_cloud(std::as_bytes(std::span(bytes)), "0.npy", {});
}

TEST(NpyFile, HoldsPointsRowByRow) {
  const PointCloudFile floats = value_of(
      parse(npy("'<f4'", "(2, 4)", as_bytes({1.0F, 2.0F, 3.0F, 0.5F, 4.0F, 5.0F, 6.0F, 7.0F}))));
  ASSERT_EQ(floats.points_m.size(), 2U);
  EXPECT_EQ(floats.points_m[1], Eigen::Vector3d(4.0, 5.0, 6.0));
  EXPECT_EQ(floats.intensity[0], 0.5F);
  const Result<PointCloudFile> doubles =
      parse(npy("'<f8'", "(1, 3)", as_bytes({456'500.125, 5'429'500.25, 1.0})));
  EXPECT_EQ(doubles->points_m[0], Eigen::Vector3d(456'500.125, 5'429'500.25, 1.0));
  std::string big = as_bytes({1.0F, 2.0F, 3.0F});
  for (std::size_t i = 0; i < 12; i += 4)
    std::reverse(big.begin() + static_cast<long>(i), big.begin() + static_cast<long>(i) + 4);
  EXPECT_EQ(parse(npy("'>f4'", "(1, 3)", big))->points_m[0], Eigen::Vector3d(1.0, 2.0, 3.0));
}

TEST(NpyFile, HoldsNamedFields) {
  const std::string rows =
      as_bytes({std::uint8_t{9}}) + as_bytes({3.0F, 2.0F, 1.0F}) + as_bytes({std::uint16_t{300}});
  const PointCloudFile cloud = value_of(
      parse(npy("[('ring', '|u1'), ('z', '<f4'), ('y', '<f4'), ('x', '<f4'), ('intensity', '<u2')]",
                "(1,)", rows)));
  EXPECT_EQ(cloud.points_m[0], Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(cloud.intensity[0], 300.0F);
}

TEST(NpyFile, RefusesWhatHoldsNoPoints) {
  const auto error_of = [](const std::string& bytes) { return outcome_of(parse(bytes)); };
  const std::string row = as_bytes({1.0F, 2.0F, 3.0F});
  EXPECT_THAT(error_of(npy("'<f4'", "(2, 3)", row)), HasSubstr("SL2006"));
  EXPECT_THAT(error_of(npy("'<f4'", "(3, 1)", row)), HasSubstr("numpy.save"));
  EXPECT_THAT(error_of(npy("'<f4'", "(1, 3)", row, "True")), HasSubstr("column by column"));
  EXPECT_THAT(error_of(npy("'|O'", "(1, 3)", row)), HasSubstr("'|O'"));
  EXPECT_THAT(error_of(npy("[('x', '<f4'), ('y', '<f4')]", "(1,)", row)), HasSubstr("SL2008"));
  const std::string whole = npy("'<f4'", "(1, 3)", row);
  for (std::size_t cut = 6; cut < whole.size(); ++cut) {
    EXPECT_NE(error_of(whole.substr(0, cut)), "no error") << cut;
  }
}

}  // namespace
}  // namespace sightline
