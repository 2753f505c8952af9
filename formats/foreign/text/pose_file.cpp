#include "formats/foreign/text/pose_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "formats/base/units.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/text_lines.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

// Farther off than this is no rounding: a wrong column order, or a scale.
constexpr double kRotationTolerance = 1e-3;
constexpr std::size_t kKittiColumns = 12;
constexpr std::size_t kTumColumns = 8;
constexpr std::size_t kApolloColumns = 9;

// One line of the file, for messages.
struct Row {
  const FileBytes& file;
  std::size_t line;
  const std::vector<std::string_view>& words;

  [[nodiscard]] Error error(ErrorCode code, std::string message) const {
    return file.error(code, std::move(message), at_line(line));
  }
};

// Six columns are often x y z roll pitch yaw, seven the same behind a time.
constexpr std::string_view kEulerHint =
    "; roll, pitch and yaw (rad) become a quaternion by scipy's Rotation.from_euler('xyz', [roll, "
    "pitch, yaw]).as_quat(): write lines of time x y z qx qy qz qw";

Result<PoseFormat> format_of(const Row& row, PoseFormat expected) {
  const std::size_t columns = row.words.size();
  PoseFormat found = PoseFormat::kAuto;
  if (columns == kKittiColumns) found = PoseFormat::kKitti;
  if (columns == kTumColumns) found = PoseFormat::kTum;
  if (columns == kApolloColumns) found = PoseFormat::kApollo;
  if (found != PoseFormat::kAuto && (expected == PoseFormat::kAuto || expected == found)) {
    return found;
  }
  const std::string wanted = expected == PoseFormat::kKitti ? "12 (KITTI)"
                             : expected == PoseFormat::kTum ? "8 (TUM: t x y z qx qy qz qw)"
                             : expected == PoseFormat::kApollo
                                 ? "9 (Apollo: id t x y z qx qy qz qw)"
                                 : "12 (KITTI), 8 (TUM) or 9 (Apollo)";
  const std::string hint = columns == 6 || columns == 7 ? std::string(kEulerHint) : "";
  return row.error(ErrorCode::kMalformedPose,
                   concat("found ", columns, " columns, expected ", wanted, hint));
}

// The numbers from column `first` on.
Result<std::vector<double>> finite_numbers(const Row& row, std::size_t first) {
  std::vector<double> numbers;
  for (std::size_t i = first; i < row.words.size(); ++i) {
    const std::optional<double> number = finite_number(row.words[i]);
    if (!number) {
      return row.error(ErrorCode::kMalformedPose,
                       concat("found ", in_quotes(row.words[i]), ", expected a finite number"));
    }
    numbers.push_back(*number);
  }
  return numbers;
}

Result<Eigen::Matrix3d> rotation_of(const Row& row, const Eigen::Matrix3d& matrix) {
  const Eigen::Matrix3d excess = matrix * matrix.transpose() - Eigen::Matrix3d::Identity();
  const double deviation = excess.cwiseAbs().maxCoeff();
  if (!(deviation <= kRotationTolerance) || matrix.determinant() <= 0.0) {
    return row.error(
        ErrorCode::kNotARotation,
        concat("the 3x3 part is not a rotation: its rows are off by ", format_double(deviation),
               ", its determinant is ", format_double(matrix.determinant())));
  }
  return nearest_rotation(matrix);
}

Result<PoseRow> kitti_row(const Row& row) {
  SIGHTLINE_ASSIGN(const std::vector<double> numbers, finite_numbers(row, 0));
  Eigen::Matrix<double, 3, 4> matrix;
  for (Eigen::Index i = 0; i < 12; ++i) matrix(i / 4, i % 4) = numbers[static_cast<std::size_t>(i)];
  SIGHTLINE_ASSIGN(const Eigen::Matrix3d rotation, rotation_of(row, matrix.leftCols<3>()));
  PoseRow pose;
  pose.T_world_vehicle.linear() = rotation;
  pose.T_world_vehicle.translation() = matrix.col(3);
  return pose;
}

// Columns from `first` on: t x y z qx qy qz qw.
Result<PoseRow> stamped_row(const Row& row, std::size_t first) {
  PoseRow pose;
  pose.stamp_ns = parse_stamp_ns(row.words[first]);
  if (!pose.stamp_ns) {
    return row.error(ErrorCode::kMalformedPose,
                     concat("found ", in_quotes(row.words[first]), ", expected a time in seconds"));
  }
  SIGHTLINE_ASSIGN(const std::vector<double> n, finite_numbers(row, first + 1));
  const Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
  if (!(std::abs(rotation.norm() - 1.0) <= kRotationTolerance)) {
    return row.error(
        ErrorCode::kNotARotation,
        concat("the norm of the quaternion is ", format_double(rotation.norm()), ", expected 1"));
  }
  pose.T_world_vehicle.linear() = rotation.normalized().toRotationMatrix();
  pose.T_world_vehicle.translation() = Eigen::Vector3d(n[0], n[1], n[2]);
  return pose;
}

Result<PoseRow> parse_row(const Row& row, PoseFormat format) {
  if (format == PoseFormat::kKitti) return kitti_row(row);
  if (format == PoseFormat::kTum) return stamped_row(row, 0);
  SIGHTLINE_ASSIGN(PoseRow pose, stamped_row(row, 1));
  pose.id = to_number<std::int64_t>(row.words[0]);
  if (!pose.id) {
    return row.error(ErrorCode::kMalformedPose,
                     concat("found ", in_quotes(row.words[0]), ", expected a whole number as id"));
  }
  return pose;
}

Error backwards(const FileBytes& file, std::size_t line, std::int64_t before_ns,
                std::int64_t stamp_ns) {
  return file.error(ErrorCode::kTimeRunsBackwards,
                    concat("found time ", format_stamp(stamp_ns), " s, expected one after ",
                           format_stamp(before_ns), " s"),
                    at_line(line));
}

// `lines`: of rows with the time of the row before them, ascending.
Result<void> check_repeated(const FileBytes& file, const std::vector<std::size_t>& lines,
                            std::size_t all) {
  const double most = kRepeatedTimesShare * static_cast<double>(all);
  if (static_cast<double>(lines.size()) <= most) return {};
  return file.error(ErrorCode::kTimeRunsBackwards,
                    concat("found ", lines.size(), " of ", all,
                           " rows with the time of the row before them, expected ascending times"),
                    at_line(lines.front()));
}

bool is_line_of_names(const std::vector<std::string_view>& words) {
  return std::ranges::none_of(
      words, [](std::string_view word) { return to_number<double>(word).has_value(); });
}

// "t x y z qx qy qz qw" in the words of many writers (timestamp, pos_x, orientation.w), in this
// order.
bool names_tum_columns(const std::vector<std::string_view>& words) {
  constexpr std::array<char, kTumColumns> kLast = {0, 'x', 'y', 'z', 'x', 'y', 'z', 'w'};
  if (words.size() != kTumColumns || !is_line_of_names(words)) return false;
  for (std::size_t i = 1; i < kTumColumns; ++i) {
    if ((words[i].back() | 0x20) != kLast[i]) return false;
  }
  return true;
}

// What stands in a file of another layout, and what to do with it; empty: nothing known.
std::string foreign_layout(const std::vector<std::string_view>& words) {
  const bool has_semicolons = std::ranges::any_of(
      words, [](std::string_view word) { return word.find(';') != std::string_view::npos; });
  if (has_semicolons) {
    return "; the columns are separated by ';' and commas may be decimal ones: write spaces "
           "between columns and decimal points in numbers";
  }
  if (is_line_of_names(words)) {
    return "; this line names columns: they are read in the order t x y z qx qy qz qw";
  }
  return "";
}

// Calls row(line number, words) for every line that is neither blank nor a comment.
template <class Body>
Result<void> for_each_row(const FileBytes& file, Body body) {
  if (file.text().starts_with("version https://git-lfs")) {
    return file.error(ErrorCode::kGitLfsPointer,
                      "the file is a git-LFS pointer; run `git lfs pull` where it was cloned",
                      at_line(1));
  }
  LineReader reader(without_byte_order_mark(file.text()));
  std::string_view line;
  std::vector<std::string_view> words;
  for (bool is_first = true; reader.next(line);) {
    split_words(line, words, " \t\r,");
    if (words.empty() || words.front().starts_with('#')) continue;
    const bool is_head = std::exchange(is_first, false) && names_tum_columns(words);
    if (is_head) continue;
    const Result<void> taken = body(reader.number(), words);
    if (taken) continue;
    Error error = taken.error();
    error.message += foreign_layout(words);
    return error;
  }
  return {};
}

}  // namespace

Result<std::vector<PoseRow>> read_poses(const std::filesystem::path& path, PoseFormat format) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, read_file(path));
  const FileBytes file{bytes, path.string()};
  std::vector<PoseRow> poses;
  std::vector<std::size_t> repeated_lines;
  const auto add = [&](std::size_t line,
                       const std::vector<std::string_view>& words) -> Result<void> {
    const Row row{file, line, words};
    SIGHTLINE_ASSIGN(const PoseFormat found, format_of(row, format));
    format = found;  // all further lines are like the first
    SIGHTLINE_ASSIGN(const PoseRow pose, parse_row(row, format));
    if (pose.stamp_ns && !poses.empty()) {
      const std::int64_t before_ns = *poses.back().stamp_ns;
      if (*pose.stamp_ns < before_ns) return backwards(file, line, before_ns, *pose.stamp_ns);
      if (*pose.stamp_ns == before_ns) repeated_lines.push_back(line);
    }
    poses.push_back(pose);
    return {};
  };
  SIGHTLINE_TRY(for_each_row(file, add));
  SIGHTLINE_TRY(check_repeated(file, repeated_lines, poses.size()));
  return poses;
}

std::optional<PoseRow> pose_at(const std::vector<PoseRow>& rows, std::int64_t stamp_ns) {
  // Positions between rows farther apart are unknown. Receivers of 1 Hz vary by some milliseconds.
  constexpr std::int64_t kLongestGap_ns = kSecond_ns * 3 / 2;
  const auto after = std::ranges::lower_bound(rows, stamp_ns, {},
                                              [](const PoseRow& row) { return *row.stamp_ns; });
  if (after != rows.end() && *after->stamp_ns == stamp_ns) return *after;
  if (after == rows.begin() || after == rows.end()) return std::nullopt;
  const PoseRow& before = *std::prev(after);
  const std::int64_t gap_ns = *after->stamp_ns - *before.stamp_ns;
  if (gap_ns > kLongestGap_ns) return std::nullopt;
  PoseRow pose;
  pose.stamp_ns = stamp_ns;
  pose.T_world_vehicle =
      interpolate(before.T_world_vehicle, after->T_world_vehicle,
                  static_cast<double>(stamp_ns - *before.stamp_ns) / static_cast<double>(gap_ns));
  return pose;
}

Result<std::vector<std::int64_t>> read_stamps(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, read_file(path));
  const FileBytes file{bytes, path.string()};
  std::vector<std::int64_t> stamps_ns;
  std::vector<std::size_t> repeated_lines;
  const auto add = [&](std::size_t line,
                       const std::vector<std::string_view>& words) -> Result<void> {
    std::optional<std::int64_t> stamp_ns = parse_stamp_ns(words.front());
    if (!stamp_ns && words.size() > 1) stamp_ns = parse_date_time_ns(words[0], words[1]);
    if (!stamp_ns) {
      return file.error(ErrorCode::kMalformedText,
                        concat("found ", in_quotes(words.front()),
                               ", expected a time in seconds, or as 2011-09-26 13:02:25.594"),
                        at_line(line));
    }
    if (!stamps_ns.empty() && *stamp_ns < stamps_ns.back()) {
      return backwards(file, line, stamps_ns.back(), *stamp_ns);
    }
    if (!stamps_ns.empty() && *stamp_ns == stamps_ns.back()) repeated_lines.push_back(line);
    stamps_ns.push_back(*stamp_ns);
    return {};
  };
  SIGHTLINE_TRY(for_each_row(file, add));
  SIGHTLINE_TRY(check_repeated(file, repeated_lines, stamps_ns.size()));
  return stamps_ns;
}

Result<void> write_tum(const std::filesystem::path& path, std::span<const PoseRow> rows,
                       IfExists if_exists) {
  std::string text = "# t_s x_m y_m z_m qx qy qz qw\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Eigen::Vector3d position_m = rows[i].T_world_vehicle.translation();
    Eigen::Quaterniond rotation(rows[i].T_world_vehicle.linear());
    // q and -q are one rotation: one of them is written.
    if (rotation.w() < 0.0) rotation.coeffs() = -rotation.coeffs();
    text += format_stamp(rows[i].stamp_ns.value_or(static_cast<std::int64_t>(i) * kSecond_ns));
    for (const double number : {position_m.x(), position_m.y(), position_m.z(), rotation.x(),
                                rotation.y(), rotation.z(), rotation.w()}) {
      text += ' ';
      text += format_double(number);
    }
    text += "\n";
  }
  return write_file_atomically(path, text, if_exists);
}

}  // namespace sightline
