#include "formats/foreign/recording/left_out_scans.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace sightline {
namespace {

// Scans that are on the longest subsequence of ascending times (patience sorting; Schensted 1961).
std::vector<bool> on_longest_ascent(const std::vector<RecordedScan>& scans) {
  constexpr std::size_t kNone = SIZE_MAX;
  std::vector<std::size_t> last_of;  // of the ascents of 1, 2, ... scans that end the earliest
  std::vector<std::size_t> before(scans.size(), kNone);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const auto place = std::ranges::lower_bound(
        last_of, scans[i].stamp_ns, {}, [&](std::size_t scan) { return scans[scan].stamp_ns; });
    if (place != last_of.begin()) before[i] = *std::prev(place);
    if (place == last_of.end()) {
      last_of.push_back(i);
    } else if (scans[i].stamp_ns < scans[*place].stamp_ns) {  // of equal ones the first stays
      *place = i;
    }
  }
  std::vector<bool> is_on(scans.size(), false);
  for (std::size_t at = last_of.empty() ? kNone : last_of.back(); at != kNone; at = before[at]) {
    is_on[at] = true;
  }
  return is_on;
}

}  // namespace

bool is_without_returns(const Error& error) {
  return error.code == ErrorCode::kEmptyScan || error.code == ErrorCode::kNoFinitePoints;
}

bool are_few(std::size_t odd, std::size_t all) {
  return static_cast<double>(odd) <= kMostOddScans * static_cast<double>(all);
}

void PosedScans::add(bool has_pose) {
  if (has_pose && !has_any()) begin_ = count_;
  if (has_pose) {
    end_ = count_ + 1;
  } else if (has_any()) {
    missing_.push_back(count_);
  }
  ++count_;
}

std::size_t PosedScans::missing_within() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(missing_, [&](std::size_t scan) { return is_within(scan); }));
}

bool PosedScans::may_be_used() const {
  return has_any() && are_few(missing_within(), end_ - begin_);
}

std::size_t PosedScans::first_missing() const {
  return missing_within() > 0 ? missing_.front() : 0;
}

void leave_out_unposed(const std::string& poses, Recording& recording) {
  PosedScans posed;
  std::vector<bool> is_odd;
  for (const RecordedScan& scan : recording.scans) {
    posed.add(scan.T_world_vehicle.has_value());
    is_odd.push_back(!scan.T_world_vehicle.has_value());
  }
  const auto missing = static_cast<std::size_t>(std::ranges::count(is_odd, true));
  if (!posed.has_any() || missing == 0) return;
  const std::string of_all =
      concat(" of ", recording.scans.size(), " scans have no pose: ", posed.before(),
             " before the first pose, ", posed.after(), " after the last, ", posed.missing_within(),
             " between");
  if (!posed.may_be_used()) {
    recording.warnings.push_back(concat(poses, ": ", missing, of_all));
    return;
  }
  recording.warnings.push_back(concat(poses, ": ", missing, of_all, ". They are left out"));
  leave_out(is_odd, recording);
}

void leave_out_untimely(Recording& recording) {
  std::vector<bool> is_odd = on_longest_ascent(recording.scans);
  is_odd.flip();
  const auto odd = static_cast<std::size_t>(std::ranges::count(is_odd, true));
  if (odd == 0 || !are_few(odd, recording.scans.size())) return;
  recording.warnings.push_back(
      concat("drive ", recording.name, ": ", odd, " of ", recording.scans.size(),
             " scans have the time of another scan or one out of order and are left out: ",
             names_of_odd(is_odd, recording)));
  leave_out(is_odd, recording);
}

void leave_out(const std::vector<bool>& is_odd, Recording& recording) {
  std::vector<RecordedScan> kept;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    if (!is_odd[i]) kept.push_back(std::move(recording.scans[i]));
  }
  recording.scans = std::move(kept);
}

std::string names_of_odd(const std::vector<bool>& is_odd, const Recording& recording) {
  constexpr std::size_t kMost = 3;
  std::string names;
  std::size_t count = 0;
  for (std::size_t i = 0; i < is_odd.size(); ++i) {
    if (is_odd[i] && ++count <= kMost) names += (count > 1 ? ", " : "") + recording.scans[i].name;
  }
  return count > kMost ? concat(names, " and ", count - kMost, " more") : names;
}

}  // namespace sightline
