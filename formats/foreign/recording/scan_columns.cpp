#include "formats/foreign/recording/scan_columns.h"

namespace sightline {
namespace {

constexpr std::size_t kKitti = 4;

Error of_scan(Error error, const Recording& recording, std::size_t index) {
  error.file = recording.file_of(recording.scans[index]).string();
  return error;
}

Result<void> check_given(const std::vector<FloatEvidence>& evidence, const Recording& recording) {
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!evidence[i].refutes) continue;
    return of_scan(
        {ErrorCode::kUnsupportedFormat,
         "its floats are not " + std::to_string(recording.columns->count) + " a point (" +
             to_text(*recording.columns) + "); take `columns` away to see what fits"},
        recording, i);
  }
  return {};
}

// What fits the scans up to here and none further.
Error mixed(const std::vector<FloatEvidence>& evidence, const Recording& recording,
            std::size_t index, FloatCounts before) {
  return {ErrorCode::kMixedFormats,
          "scans of different numbers of floats a point: " + counts_text(before) + " fit up to " +
              recording.scans[index - 1].name + ", " + counts_text(evidence[index].fitting) +
              " fit " + recording.scans[index].name,
          recording.file_of(recording.scans[index]).parent_path().string()};
}

Result<FloatCounts> common_counts(const std::vector<FloatEvidence>& evidence,
                                  const Recording& recording) {
  FloatCounts fitting = kAnyCount;
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const FloatCounts both = fitting & evidence[i].fitting;
    if (evidence[i].fitting == 0) {
      return of_scan(the_one_count(0, kAnyCount).error(), recording, i);
    }
    if (both == 0) return mixed(evidence, recording, i, fitting);
    fitting = both;
  }
  return fitting;
}

}  // namespace

Result<void> settle_columns(const std::vector<FloatEvidence>& evidence, Recording& recording) {
  if (recording.columns) return check_given(evidence, recording);
  SIGHTLINE_ASSIGN(const FloatCounts fitting, common_counts(evidence, recording));
  FloatCounts dividing = kAnyCount;
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    dividing &= evidence[i].dividing;
    const Result<std::size_t> count = the_one_count(fitting, dividing);
    const bool is_cut = !count && count.error().code == ErrorCode::kTruncatedScan;
    if (is_cut) return of_scan(count.error(), recording, i);
  }
  const Result<std::size_t> count = the_one_count(fitting, dividing);
  if (!count) return of_scan(count.error(), recording, 0);
  recording.columns = columns_of_count(*count);
  if (*count != kKitti) {
    recording.warnings.push_back("scans without a header: " + std::to_string(*count) +
                                 " floats a point fit, they are read as `columns: " +
                                 to_text(*recording.columns) + "` (_ is left out)");
  }
  return {};
}

}  // namespace sightline
