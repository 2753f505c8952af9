#include "formats/drive/shared_scans.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace sightline {
namespace {

constexpr std::size_t kHashes = std::size_t{kNoHash} + 1;
constexpr std::size_t kCompared = 64;  // scans of a recording, evenly among all
constexpr std::size_t kLeastShared = 2;
constexpr std::size_t kOneIn = 20;

// All scans of some recordings, and whose they are.
struct ScansOfAll {
  std::vector<ScanSketch> scans;
  std::vector<std::uint32_t> recording_of_scan;
};

ScansOfAll scans_of(std::span<const RecordingCard* const> recordings) {
  ScansOfAll all;
  for (std::uint32_t i = 0; i < recordings.size(); ++i) {
    const std::vector<ScanSketch>& of_recording = recordings[i]->scans;
    all.scans.insert(all.scans.end(), of_recording.begin(), of_recording.end());
    all.recording_of_scan.insert(all.recording_of_scan.end(), of_recording.size(), i);
  }
  return all;
}

// [other recording]: how many of `compared` scans of a recording are copies of scans of it.
std::map<std::uint32_t, std::size_t> count_shared(const ScansOfAll& all, const ScanIndex& index,
                                                  const RecordingCard& recording,
                                                  std::size_t compared) {
  std::map<std::uint32_t, std::size_t> shared;
  for (std::size_t i = 0; i < compared; ++i) {
    std::vector<std::uint32_t> others;
    const ScanSketch& scan = recording.scans[i * recording.scans.size() / compared];
    for (const std::uint32_t copy : index.copies_of(scan)) {
      others.push_back(all.recording_of_scan[copy]);
    }
    others.erase(std::unique(others.begin(), others.end()), others.end());
    for (const std::uint32_t other : others) ++shared[other];
  }
  return shared;
}

// Of groups that are joined one by one; the number of a group is its least member.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }
  void join(std::uint32_t a, std::uint32_t b) {
    const auto [least, other] = std::minmax({root_of(a), root_of(b)});
    parent_[other] = least;
  }
  // From 0 on.
  [[nodiscard]] std::vector<std::uint32_t> numbers() const {
    std::map<std::uint32_t, std::uint32_t> number;
    std::vector<std::uint32_t> all;
    for (std::uint32_t i = 0; i < parent_.size(); ++i) {
      const auto next = static_cast<std::uint32_t>(number.size());
      all.push_back(number.try_emplace(root_of(i), next).first->second);
    }
    return all;
  }

 private:
  [[nodiscard]] std::uint32_t root_of(std::uint32_t i) const {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  std::vector<std::uint32_t> parent_;
};

void join_equal_digests(std::span<const RecordingCard* const> recordings, Groups& groups) {
  std::map<Digest, std::uint32_t> first;
  for (std::uint32_t i = 0; i < recordings.size(); ++i) {
    groups.join(first.try_emplace(recordings[i]->digest, i).first->second, i);
  }
}

}  // namespace

ScanIndex::ScanIndex(std::span<const ScanSketch> scans) : scans_(scans), first_(kHashes + 1, 0) {
  for (const ScanSketch& scan : scans) {
    for (const std::uint16_t hash : scan) ++first_[hash + std::size_t{1}];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  entries_.resize(scans.size() * kSketchSize);
  std::vector<std::uint32_t> next = first_;
  for (std::uint32_t i = 0; i < scans.size(); ++i) {
    for (const std::uint16_t hash : scans[i]) entries_[next[hash]++] = i;
  }
}

std::vector<std::uint32_t> ScanIndex::copies_of(const ScanSketch& scan) const {
  constexpr std::size_t kFewestCommon = 3;
  std::vector<std::uint32_t> near;
  for (const std::uint16_t hash : scan) {
    if (hash == kNoHash) break;
    near.insert(near.end(), entries_.begin() + first_[hash], entries_.begin() + first_[hash + 1U]);
  }
  std::ranges::sort(near);
  std::vector<std::uint32_t> copies;
  for (std::size_t begin = 0, end = 0; begin < near.size(); begin = end) {
    while (end < near.size() && near[end] == near[begin]) ++end;
    const bool is_copy =
        end - begin >= kFewestCommon && likeness(scan, scans_[near[begin]]) >= kCopyLikeness;
    if (is_copy) copies.push_back(near[begin]);
  }
  return copies;
}

std::size_t shared_count(const RecordingCard& a, const RecordingCard& b) {
  const ScanIndex index(b.scans);
  return static_cast<std::size_t>(std::ranges::count_if(
      a.scans, [&](const ScanSketch& scan) { return !index.copies_of(scan).empty(); }));
}

std::vector<std::uint32_t> recording_numbers(std::span<const RecordingCard* const> recordings) {
  Groups groups(recordings.size());
  join_equal_digests(recordings, groups);
  const ScansOfAll all = scans_of(recordings);
  const ScanIndex index(all.scans);
  for (std::uint32_t i = 0; i < recordings.size(); ++i) {
    const std::size_t compared = std::min(kCompared, recordings[i]->scans.size());
    for (const auto& [other, shared] : count_shared(all, index, *recordings[i], compared)) {
      const std::size_t least = std::min(compared, std::max(kLeastShared, compared / kOneIn));
      if (shared >= least) groups.join(i, other);
    }
  }
  return groups.numbers();
}

bool have_common_scans(const RecordingCard& a, const RecordingCard& b) {
  const RecordingCard* const both[] = {&a, &b};
  return recording_numbers(both)[1] == 0;
}

bool have_common_scans(const RecordingCard& card, const RecordingCards& recordings) {
  return std::ranges::any_of(
      recordings.cards, [&](const RecordingCard& other) { return have_common_scans(card, other); });
}

}  // namespace sightline
