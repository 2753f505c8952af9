#include "formats/foreign/text/dataset_poses.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/text_lines.h"

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
      const std::optional<double> number = finite_number(word);
      if (!number) {
        return file.error(ErrorCode::kMalformedText,
                          concat("found ", in_quotes(word), ", expected a finite number"),
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
    return file.error(ErrorCode::kNotARotation, "the 3x3 part is not a rotation");
  }
  Pose pose = Pose::Identity();
  pose.linear() = nearest_rotation(rotation);
  pose.translation() = translation_m;
  return pose;
}

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

constexpr double kTolerance = 1e-3;  // of the norm of a quaternion

// Takes the members of the objects of one list; what else they hold is passed over.
class PoseTable : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit PoseTable(std::string file) : file_(std::move(file)) {}

  Result<std::vector<PoseRow>> finish(bool is_json) {
    if (failure_) return *failure_;
    if (!is_json || rows_.empty()) {
      return Error{ErrorCode::kMalformedText,
                   "expected a list of poses with timestamp, rotation and translation, as "
                   "nuScenes' ego_pose.json",
                   file_};
    }
    sort_once(rows_, [](const PoseRow& row) { return *row.stamp_ns; });
    return std::move(rows_);
  }

  bool number_integer(number_integer_t value) override { return take(static_cast<double>(value)); }
  bool number_unsigned(number_unsigned_t value) override {
    constexpr number_unsigned_t kMost_us = 4'000'000'000'000'000;  // the year 2096
    if (key_ == "timestamp" && depth_ == 2 && value <= kMost_us) {
      stamp_ns_ = static_cast<std::int64_t>(value) * 1000;
      return true;
    }
    return take(static_cast<double>(value));
  }
  bool number_float(number_float_t value, const string_t& /*text*/) override { return take(value); }
  bool key(string_t& name) override {
    if (depth_ == 2) key_ = name;
    return true;
  }
  bool start_object(std::size_t /*size*/) override { return deeper(); }
  bool start_array(std::size_t /*size*/) override { return deeper(); }
  bool end_array() override {
    --depth_;
    return true;
  }
  bool end_object() override {
    if (--depth_ != 1) return true;
    const bool is_taken = take_pose();
    stamp_ns_.reset();
    rotation_.clear();
    translation_m_.clear();
    return is_taken;
  }
  bool null() override { return true; }
  bool boolean(bool /*value*/) override { return true; }
  bool string(string_t& /*value*/) override { return true; }
  bool binary(binary_t& /*value*/) override { return true; }
  bool parse_error(std::size_t /*at*/, const std::string& /*token*/,
                   const nlohmann::detail::exception& /*reason*/) override {
    return false;
  }

 private:
  bool deeper() {
    constexpr std::size_t kMostDepth = 16;
    return ++depth_ <= kMostDepth;
  }

  bool take(double value) {
    if (depth_ != 3) return true;
    if (key_ == "rotation") rotation_.push_back(value);
    if (key_ == "translation") translation_m_.push_back(value);
    return rotation_.size() <= 4 && translation_m_.size() <= 3;
  }

  bool fail(ErrorCode code, const std::string& what) {
    failure_ = Error{code, what, file_, concat("pose ", rows_.size())};
    return false;
  }

  bool take_pose() {
    const auto is_finite = [](double value) { return std::isfinite(value); };
    if (!stamp_ns_ || rotation_.size() != 4 || translation_m_.size() != 3 ||
        !std::ranges::all_of(rotation_, is_finite) ||
        !std::ranges::all_of(translation_m_, is_finite)) {
      return fail(ErrorCode::kMalformedPose,
                  "expected timestamp, rotation of 4 numbers and translation of 3");
    }
    const Eigen::Quaterniond rotation(rotation_[0], rotation_[1], rotation_[2], rotation_[3]);
    if (!(std::abs(rotation.norm() - 1.0) <= kTolerance)) {
      return fail(ErrorCode::kNotARotation, "the norm of the quaternion is not 1");
    }
    PoseRow& row = rows_.emplace_back();
    row.stamp_ns = stamp_ns_;
    row.T_world_vehicle.linear() = rotation.normalized().toRotationMatrix();
    row.T_world_vehicle.translation() =
        Eigen::Vector3d(translation_m_[0], translation_m_[1], translation_m_[2]);
    return true;
  }

  std::string file_;
  std::size_t depth_ = 0;  // 1: in the list, 2: in an object of it, 3: in a list of that
  std::string key_;
  std::optional<std::int64_t> stamp_ns_;
  std::vector<double> rotation_;
  std::vector<double> translation_m_;
  std::vector<PoseRow> rows_;
  std::optional<Error> failure_;
};

}  // namespace

Result<KittiCalibration> read_kitti_calibration(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(path, kLargestFile));
  return parse_kitti_calibration(text, path);
}

Result<KittiCalibration> parse_kitti_calibration(std::string_view text,
                                                 const std::filesystem::path& path) {
  const FileBytes file = FileBytes::of_text(text, path.string());
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
                      "calib_imu_to_velo.txt (R: and 9, T: and 3)");
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

// The table of the whole data set holds millions of poses, so no tree of it is made.

bool is_nuscenes_poses(const std::filesystem::path& path) {
  return lower_extension(path) == ".json";
}

Result<std::vector<PoseRow>> parse_nuscenes_poses(std::string_view text,
                                                  const std::filesystem::path& path) {
  PoseTable table(path.string());
  return table.finish(nlohmann::json::sax_parse(text, &table));
}

Result<std::vector<PoseRow>> read_nuscenes_poses(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const std::string text, read_text_file(path));
  return parse_nuscenes_poses(text, path);
}

}  // namespace sightline
