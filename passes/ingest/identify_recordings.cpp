#include "passes/ingest/identify_recordings.h"

#include <algorithm>
#include <optional>
#include <span>

#include "formats/base/parallel.h"
#include "formats/drive/shared_scans.h"

namespace sightline {
namespace {

bool is_of_file(const RecordingCard& card) { return card.role == "map" || card.role == "base"; }

// Error: that of the first scan that cannot be read.
Result<std::vector<ScanSketch>> sketches_of(const PassContext& ctx, const Drive& drive) {
  std::vector<std::optional<Error>> failures(drive.scans.size());
  std::vector<ScanSketch> sketches(drive.scans.size());
  parallel_for(drive.scans.size(), ctx.threads, [&](std::size_t i) {
    const Result<Scan> scan = drive.store->read(i);
    if (scan) {
      sketches[i] = sketch_of(scan->points_m);
    } else {
      failures[i] = scan.error();
    }
  });
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  return sketches;
}

Result<void> compare(const PassContext& ctx, const RecordingCard& card,
                     const RecordingCard& earlier) {
  if (!have_common_scans(card, earlier)) return {};
  const std::size_t shared = shared_count(card, earlier);
  const std::string found =
      concat(card.role, ".scans: ", shared, " of ", card.scans.size(), " scans of '", card.name,
             "' are copies of scans of ", earlier.role, " ('", earlier.name, "')");
  if (2 * shared > card.scans.size()) {
    return Error{ErrorCode::kBadValue,
                 concat(found, ", expected another drive: the same recording is listed twice")};
  }
  ctx.warn(concat(found, ": both count as one recording"));
  return {};
}

}  // namespace

Result<RecordingCards> identify_recordings(PassContext& ctx, const NoOptions&,
                                           const RecordingCards& recordings, Many<Drive> drives) {
  RecordingCards identified = recordings;
  std::size_t next = 0;
  for (RecordingCard& card : identified.cards) {
    if (is_of_file(card) || next == drives.size()) continue;
    SIGHTLINE_ASSIGN(card.scans, sketches_of(ctx, *drives[next++]));
  }
  if (next < drives.size()) {
    return Error{ErrorCode::kMismatchedInputs,
                 concat("found ", drives.size(), " drives, expected at most ", next)};
  }
  for (auto card = identified.cards.begin(); card != identified.cards.end(); ++card) {
    for (auto earlier = identified.cards.begin(); earlier != card; ++earlier) {
      SIGHTLINE_TRY(compare(ctx, *card, *earlier));
    }
  }
  return identified;
}

}  // namespace sightline
