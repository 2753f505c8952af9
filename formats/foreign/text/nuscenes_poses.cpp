#include "formats/foreign/text/nuscenes_poses.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/text/file_bytes.h"

// The table of the whole data set holds millions of poses, so no tree of it is made.

namespace sightline {
namespace {

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
    std::ranges::stable_sort(rows_, {}, [](const PoseRow& row) { return *row.stamp_ns; });
    const auto is_same_time = [](const PoseRow& a, const PoseRow& b) {
      return *a.stamp_ns == *b.stamp_ns;
    };
    rows_.erase(std::unique(rows_.begin(), rows_.end(), is_same_time), rows_.end());
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
    failure_ = Error{code, what, file_, "pose " + std::to_string(rows_.size())};
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

bool is_nuscenes_poses(const std::filesystem::path& path) {
  return lower_extension(path) == ".json";
}

Result<std::vector<PoseRow>> parse_nuscenes_poses(std::string_view text,
                                                  const std::filesystem::path& path) {
  PoseTable table(path.string());
  const bool is_json = nlohmann::json::sax_parse(text, &table);
  return table.finish(is_json);
}

Result<std::vector<PoseRow>> read_nuscenes_poses(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const std::string text, read_text_file(path));
  return parse_nuscenes_poses(text, path);
}

}  // namespace sightline
