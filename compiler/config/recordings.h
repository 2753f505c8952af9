#pragma once

#include <deque>
#include <string>

#include "formats/base/result.h"
#include "formats/foreign/recording/recording.h"

// The key `recordings` of a section: several drives in one entry.

namespace sightline {

// `recordings` is a folder of recordings (what find_scans finds there, in natural order of their
// paths), or a text file of them: a line is the path of the scans and, behind a tab, that of their
// poses, each from the file's folder; empty lines and those that begin with # are skipped. `first`
// becomes the first of them (empty: nothing happens), `more` the others, with the options of
// `first`, whose `poses` and `stamps` are names of files with the scans of each or beside their
// folder. A drive is called by its path from that folder. Errors, with `section` in the text:
// bad-value (`first` names scans or a drive, or drives are listed), file-not-found (no such folder
// or file; a drive without its poses or stamps), empty-directory (no recording there),
// malformed-text (a list without a path), those of find_scans.
Result<void> expand_recordings(const std::string& section, const std::string& recordings,
                               RecordingOptions& first, std::deque<RecordingOptions>& more);

}  // namespace sightline
