#pragma once

#include <filesystem>
#include <string>
#include <string_view>

// Names of files that are not finished yet: ".sl-HOST-BOOTID-PID-STARTTIME-SERIAL". They say which
// process writes them, so that what a killed run left can be removed while others are at work in
// the same folder, also on other machines.

namespace sightline {

// A name that no other process has, and that this one has not used before. HOST is the name of the
// machine and the number of its process namespace, STARTTIME in clock ticks since the boot.
std::string temporary_name();

enum class TemporaryOwner {
  kNone,     // no such name
  kGone,     // a process of this namespace and this boot, and it has ended
  kAlive,    // likewise, and it runs
  kUnknown,  // of another machine, namespace or boot: nothing here can tell
};
TemporaryOwner owner_of(std::string_view file_name);

// Removes what processes left that are gone, in this folder alone. Age means nothing, other names
// are left alone, failures are passed over: the next run tries again.
void remove_leftovers(const std::filesystem::path& folder);

}  // namespace sightline
