#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

struct ConfigDraft {
  std::string yaml;                  // a configuration whose comments give the reason for each key
  std::vector<std::string> summary;  // what it does with each drive, a line each, for a log
};

struct DraftOptions {
  std::string sensor = {};  // profile or file of beams of every drive; empty: each is recognized
  std::string schema = {};  // JSON Schema for editors, as the configuration names it; empty: none
};

// Looks at the recordings in `folder` and writes the configuration that `file` is to hold (empty:
// one in the current folder). Paths are relative where they lie beneath the file's folder. The
// drive called map..., else the first, makes the map; the next one that meets it localizes, the
// next judges; a single drive is split into even and odd scans. Scans that share their poses are
// sensors of one vehicle: the first one is used, the others are shown in comments, because nothing
// shows where they sit. A sensor that is named, in `options` or in the path or topic of scans that
// its beams fit, comes before one that fits as well. Errors: those of find_scans, unknown-name (no
// such sensor), empty-directory (no drive; the message lists what was
// passed over and why).
Result<ConfigDraft> draft_config(const std::filesystem::path& folder,
                                 const std::filesystem::path& file,
                                 const DraftOptions& options = {});

}  // namespace sightline
