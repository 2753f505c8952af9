#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "formats/foreign/recording/recording.h"

// Scans of a recording that are left out, with a warning, so that a few odd ones do not end it. The
// others keep their ScanInFile::index.

namespace sightline {

// The share of odd scans that a recording may have.
inline constexpr double kMostOddScans = 0.05;
bool are_few(std::size_t odd, std::size_t all);

// Whether a scan could not be read because it has no returns.
bool is_without_returns(const Error& error);

// Which scans have a pose, in the order of the recording.
class PosedScans {
 public:
  void add(bool has_pose);

  // The scans from the first to the last one that has a pose.
  [[nodiscard]] bool has_any() const { return begin_ < end_; }
  [[nodiscard]] bool is_within(std::size_t scan) const { return scan >= begin_ && scan < end_; }
  [[nodiscard]] std::size_t before() const { return begin_; }
  [[nodiscard]] std::size_t after() const { return count_ - end_; }
  // Without a pose between the first and the last one.
  [[nodiscard]] std::size_t missing_within() const;
  // Whether any scan has a pose, and few of those between the first and the last one have none.
  [[nodiscard]] bool may_be_used() const;
  // The first scan without a pose between the first and the last one; 0 where there is none.
  [[nodiscard]] std::size_t first_missing() const;

 private:
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t count_ = 0;
  std::vector<std::size_t> missing_;  // behind the first pose
};

// Scans without a pose, where others have one: before the first pose and after the last at any
// share, between them up to kMostOddScans. Where more have none, all stay and a warning counts
// them. `poses` is the file, for messages.
void leave_out_unposed(const std::string& poses, Recording& recording);

// Scans whose times are not after those of the scans before them: the fewest whose removal leaves
// times that ascend, up to kMostOddScans; where there are more, all stay.
void leave_out_untimely(Recording& recording);

// The scans whose flag is not set.
void leave_out(const std::vector<bool>& is_odd, Recording& recording);

// "bag#3" or "000003.pcd, 000017.pcd and 2 more", for messages.
std::string names_of_odd(const std::vector<bool>& is_odd, const Recording& recording);

}  // namespace sightline
