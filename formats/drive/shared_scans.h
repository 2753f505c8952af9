#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "formats/drive/identity/scan_sketch.h"
#include "formats/drive/recording_cards.h"

// Which recordings have scans in common, however they are named, stored or timed ("Identity of
// recordings" in schemas/definitions.md). Training, calibration, history and evaluation all decide
// it here.

namespace sightline {

// Finds copies of a scan among many.
class ScanIndex {
 public:
  explicit ScanIndex(std::span<const ScanSketch> scans);

  // Ascending: the scans that a scan is a copy of, or a part of.
  [[nodiscard]] std::vector<std::uint32_t> copies_of(const ScanSketch& scan) const;

 private:
  std::span<const ScanSketch> scans_;   // of the caller
  std::vector<std::uint32_t> first_;    // [hash]: of its entries
  std::vector<std::uint32_t> entries_;  // scans, by hash
};

// How many scans of `a` are copies of scans of `b`.
std::size_t shared_count(const RecordingCard& a, const RecordingCard& b);

// [recording]: a number, from 0 on in their order. Recordings have the same number that have the
// same digest, or of which one in twenty scans of one, and two at least, are copies of scans of the
// other (64 scans of each are compared), directly or by way of others.
std::vector<std::uint32_t> recording_numbers(std::span<const RecordingCard* const> recordings);
// Whether two have the same number.
bool have_common_scans(const RecordingCard& a, const RecordingCard& b);
bool have_common_scans(const RecordingCard& card, const RecordingCards& recordings);

}  // namespace sightline
