#include "formats/foreign/recording/recording.h"

namespace sightline {

std::filesystem::path Recording::file_of(const ScanInFile& scan) const {
  return container ? source : source / scan.name;
}

Result<void> validate(const Recording& recording) {
  if (!recording.scans.empty()) return {};
  return Error{ErrorCode::kInvalidArtifact, "a recording without scans", "", recording.name};
}

Table dump(const Recording& recording) {
  Table table{"recording", {"scan", "file", "stamp_ns", "has_pose", "content_sha256"}, {}, {}};
  table.facts = {{"name", recording.name}, {"sensor", recording.sensor.name}};
  if (recording.columns) table.facts.emplace_back("columns", to_text(*recording.columns));
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const RecordedScan& scan = recording.scans[i];
    table.rows.push_back({static_cast<std::int64_t>(i), scan.name, scan.stamp_ns,
                          std::int64_t{scan.T_world_vehicle ? 1 : 0}, to_hex(scan.content)});
  }
  return table;
}

}  // namespace sightline
