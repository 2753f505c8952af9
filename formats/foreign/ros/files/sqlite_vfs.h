#pragma once

namespace sightline {

// The name of a file system for SQLite in which regular files are read and nothing else is done;
// registered at the first call.
const char* read_only_vfs();

}  // namespace sightline
