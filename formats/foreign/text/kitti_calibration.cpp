#include "formats/foreign/text/kitti_calibration.h"

#include <cmath>
#include <map>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/text_lines.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

constexpr std::size_t kLargestFile = 65'536;

using Entries = std::map<std::string, std::vector<double>>;

Result<Entries> entries_of(const FileBytes& file) {
  Entries entries;
  LineReader lines(file.text());
  for (std::string_view line; lines.next(line);) {
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) continue;
    const std::string name(line.substr(0, colon));
    if (name != "Tr" && name != "R" && name != "T") continue;  // projections, times
    std::vector<std::string_view> words;
    split_words(line.substr(colon + 1), words);
    std::vector<double>& numbers = entries[name];
    numbers.clear();
    for (const std::string_view word : words) {
      const std::optional<double> number = to_number<double>(word);
      if (!number || !std::isfinite(*number)) {
        return file.error(ErrorCode::kMalformedText,
                          "found " + in_quotes(word) + ", expected a finite number",
                          at_line(lines.number()));
      }
      numbers.push_back(*number);
    }
  }
  return entries;
}

// Rows of rotation, then the translation's.
Result<Pose> pose_of(const FileBytes& file, const Eigen::Matrix3d& rotation,
                     const Eigen::Vector3d& translation_m) {
  constexpr double kTolerance = 1e-3;
  const Eigen::Matrix3d excess = rotation * rotation.transpose() - Eigen::Matrix3d::Identity();
  if (!(excess.cwiseAbs().maxCoeff() <= kTolerance) || rotation.determinant() <= 0.0) {
    return file.error(ErrorCode::kNotARotation, "the 3x3 part is no rotation", "");
  }
  Pose pose = Pose::Identity();
  pose.linear() = nearest_rotation(rotation);
  pose.translation() = translation_m;
  return pose;
}

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

}  // namespace

Result<KittiCalibration> read_kitti_calibration(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(path, kLargestFile));
  return parse_kitti_calibration(text, path);
}

Result<KittiCalibration> parse_kitti_calibration(std::string_view text,
                                                 const std::filesystem::path& path) {
  const FileBytes file{std::as_bytes(std::span(text.data(), text.size())), path.string()};
  SIGHTLINE_ASSIGN(const Entries entries, entries_of(file));
  const auto has = [&](const char* name, std::size_t size) {
    const auto found = entries.find(name);
    return found != entries.end() && found->second.size() == size;
  };
  KittiCalibration calibration;
  if (has("Tr", 12)) {
    const Eigen::Map<const RowMajor34> matrix(entries.at("Tr").data());
    SIGHTLINE_ASSIGN(calibration.T_posed_lidar, pose_of(file, matrix.leftCols<3>(), matrix.col(3)));
    calibration.is_of_camera = true;
    return calibration;
  }
  if (!has("R", 9) || !has("T", 3)) {
    return file.error(ErrorCode::kMissingField,
                      "expected KITTI's calib.txt (Tr: and 12 numbers), calib_velo_to_cam.txt or "
                      "calib_imu_to_velo.txt (R: and 9, T: and 3)",
                      "");
  }
  const Eigen::Map<const RowMajor3> rotation(entries.at("R").data());
  const Eigen::Map<const Eigen::Vector3d> translation_m(entries.at("T").data());
  SIGHTLINE_ASSIGN(const Pose pose, pose_of(file, rotation, translation_m));
  calibration.is_of_camera = path.filename().string().find("velo_to_cam") != std::string::npos;
  calibration.T_posed_lidar = calibration.is_of_camera ? pose : pose.inverse();
  return calibration;
}

Pose lidar_pose(const KittiCalibration& calibration, const Pose& T_world_posed) {
  const Pose T_world_lidar = T_world_posed * calibration.T_posed_lidar;
  return calibration.is_of_camera ? calibration.T_posed_lidar.inverse() * T_world_lidar
                                  : T_world_lidar;
}

}  // namespace sightline
