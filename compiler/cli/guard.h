#pragma once

#include <functional>

namespace sightline {

// Runs the program's body, and turns what no function can return into failures with a code:
// memory that is not there, on any thread and out of any library (out-of-memory); threads that
// cannot be had (likewise); a mapped file that became shorter (cannot-read); output that does not
// fit behind stdout (disk-full, cannot-write). A limit on the size of files ends no process from
// here on, writing fails instead. Returns the exit status. Our own mistakes still abort.
int run_guarded(const std::function<int()>& body);

}  // namespace sightline
