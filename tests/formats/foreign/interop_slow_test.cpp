#include <set>

#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/recording/recording.h"
#include "formats/foreign/recording/scan_files.h"
#include "formats/foreign/text/text_lines.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/real_data.h"

// Every file of the set interop (tests/README.md) stands in interop_files.csv, which
// interop_values.py made without any code of ours: it is read as that says, or refused.

namespace sightline {
namespace {

struct Expected {
  std::string file;
  std::string outcome;  // "read", or the code of the refusal
  std::size_t scans = 0;
  std::uint64_t points = 0;
  std::uint64_t nonfinite = 0;
  std::uint64_t zero = 0;
  Eigen::Vector3d low_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d high_m = Eigen::Vector3d::Zero();
};

std::vector<Expected> expected_files() {
  const Result<std::string> text = read_text_file(SIGHTLINE_INTEROP_TABLE);
  std::vector<Expected> table;
  LineReader lines(*text);
  std::string_view line;
  std::vector<std::string_view> words;
  while (lines.next(line)) {
    split_words(line, words, ",");
    if (lines.number() == 1) continue;
    Expected& row = table.emplace_back();
    row.file = words.at(0);
    row.outcome = words.at(1);
    if (words.size() == 2) continue;
    row.scans = *to_number<std::size_t>(words.at(2));
    row.points = *to_number<std::uint64_t>(words.at(3));
    row.nonfinite = *to_number<std::uint64_t>(words.at(4));
    row.zero = *to_number<std::uint64_t>(words.at(5));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      row.low_m[static_cast<Eigen::Index>(axis)] = *to_number<double>(words.at(6 + axis));
      row.high_m[static_cast<Eigen::Index>(axis)] = *to_number<double>(words.at(9 + axis));
    }
  }
  return table;
}

Result<std::vector<PointCloudFile>> read_all(const std::filesystem::path& file) {
  std::vector<PointCloudFile> clouds;
  if (!is_scan_container(file)) {
    Result<PointCloudFile> cloud = read_point_cloud(file);
    if (!cloud) return cloud.error();
    clouds.push_back(std::move(*cloud));
    return clouds;
  }
  const auto container = open_scan_container(file, "");
  if (!container) return container.error();
  for (std::size_t i = 0; i < (*container)->scans().size(); ++i) {
    Result<PointCloudFile> cloud = (*container)->parse(*(*container)->read(i), i);
    if (!cloud) return cloud.error();
    clouds.push_back(std::move(*cloud));
  }
  return clouds;
}

void expect_read(const std::filesystem::path& file, const Expected& expected) {
  const std::vector<PointCloudFile> clouds = value_of(read_all(file));
  EXPECT_EQ(clouds.size(), expected.scans) << expected.file;
  Expected found;
  found.low_m.setConstant(1e300);
  found.high_m.setConstant(-1e300);
  for (const PointCloudFile& cloud : clouds) {
    EXPECT_EQ(cloud.intensity.size(), cloud.points_m.size()) << expected.file;
    found.points += cloud.points_m.size();
    found.nonfinite += cloud.nonfinite_count;
    found.zero += cloud.zero_count;
    for (const Eigen::Vector3d& point_m : cloud.points_m) {
      found.low_m = found.low_m.cwiseMin(point_m);
      found.high_m = found.high_m.cwiseMax(point_m);
    }
  }
  EXPECT_EQ(found.points, expected.points) << expected.file;
  EXPECT_EQ(found.nonfinite, expected.nonfinite) << expected.file;
  EXPECT_EQ(found.zero, expected.zero) << expected.file;
  EXPECT_LE((found.low_m - expected.low_m).cwiseAbs().maxCoeff(), 1e-7) << expected.file;
  EXPECT_LE((found.high_m - expected.high_m).cwiseAbs().maxCoeff(), 1e-7) << expected.file;
}

void expect_refused(const std::filesystem::path& file, const Expected& expected) {
  const Error error = failure_of(read_all(file), expected.file);
  EXPECT_EQ(error_name(error.code), expected.outcome) << to_string(error);
  EXPECT_EQ(error.file, file.string());
  EXPECT_GT(error.message.size(), 20U) << to_string(error);
}

TEST(InteropFiles, AreReadAsAnIndependentReaderReadsThemOrRefusedWithTheirCode) {
  const RealData data = real_data("interop");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  const std::filesystem::path& folder = data.folder;
  std::set<std::string> known;
  for (const Expected& expected : expected_files()) {
    known.insert(expected.file);
    if (expected.outcome == "read") {
      expect_read(folder / expected.file, expected);
    } else {
      expect_refused(folder / expected.file, expected);
    }
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = entry.path().lexically_relative(folder).string();
    EXPECT_TRUE(known.contains(name)) << name << " stands in no table";
  }
}

}  // namespace
}  // namespace sightline
