#pragma once

#include <filesystem>
#include <optional>

// What this process may use of the machine. Containers and schedulers give it less than the machine
// has: by its affinity (taskset, cpuset) and by the limits of its control groups, version 1 or 2,
// and of all groups around them.

namespace sightline {

// Of the affinity; at least one.
int usable_processors();

// Megabytes (2^20) that can still be allocated; nothing where it is unknown.
std::optional<double> free_memory_mib();

// The limits of the control groups alone, read below a root that stands in for "/": processors'
// worth of time, and memory that is left. Nothing: there is no limit.
std::optional<double> processor_limit(const std::filesystem::path& root = "/");
std::optional<double> memory_left_mib(const std::filesystem::path& root = "/");

}  // namespace sightline
