#include "formats/base/machine.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {
namespace {

namespace fs = std::filesystem;

// The smaller of two limits, each of which may be missing.
std::optional<double> least(std::optional<double> a, std::optional<double> b) {
  if (!a || !b) return a ? a : b;
  return std::min(*a, *b);
}

std::optional<double> number_in(std::string_view text) {
  double number = 0.0;
  const auto [end, failure] = std::from_chars(text.begin(), text.end(), number);
  if (failure != std::errc() || number < 0.0) return std::nullopt;
  return number;
}

// Nothing where there is no such file, or "max" in it.
std::optional<double> number_of(const fs::path& file, const std::string& key = "") {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string word;
    if (!key.empty() && (!(words >> word) || word != key)) continue;
    words >> word;
    return number_in(word);
  }
  return std::nullopt;
}

struct Hierarchy {
  fs::path mount;
  fs::path group;  // relative to the mount
  bool is_unified = false;
};

// Whether a list such as "cpu,cpuacct" has this entry.
bool has_entry(const std::string& list, const std::string& entry) {
  return ("," + list + ",").find("," + entry + ",") != std::string::npos;
}

// The group of this process, by /proc/self/cgroup: "4:memory:/user" (version 1), "0::/user" (2).
std::optional<std::string> group_of(const fs::path& root, const std::string& controller) {
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string list = line.substr(first + 1, second - first - 1);
    if (controller.empty() ? list.empty() : has_entry(list, controller)) {
      return line.substr(second + 1);
    }
  }
  return std::nullopt;
}

// Where a hierarchy is mounted, by /proc/self/mountinfo: "... ROOT MOUNT ... - TYPE SOURCE
// OPTIONS". A container sees its own group as the root of the mount.
std::optional<Hierarchy> hierarchy_of(const fs::path& root, const std::string& controller) {
  const std::optional<std::string> group = group_of(root, controller);
  if (!group) return std::nullopt;
  std::ifstream mounts(root / "proc/self/mountinfo");
  for (std::string line; std::getline(mounts, line);) {
    std::istringstream words(line);
    std::string word;
    std::string mounted;
    std::string mount;
    words >> word >> word >> word >> mounted >> mount;
    while (words >> word && word != "-") continue;
    std::string type;
    std::string options;
    words >> type >> word >> options;
    const bool is_it =
        controller.empty() ? type == "cgroup2" : type == "cgroup" && has_entry(options, controller);
    if (!is_it) continue;
    const bool is_below = mounted != "/" && group->starts_with(mounted);
    const std::string below = is_below ? group->substr(mounted.size()) : *group;
    return Hierarchy{root / fs::path(mount).relative_path(), fs::path(below).relative_path(),
                     controller.empty()};
  }
  return std::nullopt;
}

// The group's folder and those around it. A group that is not below the mount, as in a container
// that sees the names of its host, counts as the mount itself.
std::vector<fs::path> folders_of(const Hierarchy& hierarchy) {
  std::vector<fs::path> folders = {hierarchy.mount};
  for (const fs::path& part : hierarchy.group) {
    std::error_code failure;
    const fs::path next = folders.back() / part;
    if (part.empty() || part == ".." || !fs::is_directory(next, failure)) break;
    folders.push_back(next);
  }
  return folders;
}

// Processors' worth of time.
std::optional<double> quota_in(const fs::path& folder, bool is_unified) {
  std::optional<double> quota;
  std::optional<double> period;
  if (is_unified) {
    std::ifstream stream(folder / "cpu.max");  // "150000 100000" or "max 100000"
    std::string first;
    std::string second;
    stream >> first >> second;
    quota = number_in(first);
    period = number_in(second);
  } else {
    quota = number_of(folder / "cpu.cfs_quota_us");  // -1: no limit
    period = number_of(folder / "cpu.cfs_period_us");
  }
  if (!quota || !period || *quota <= 0.0 || *period <= 0.0) return std::nullopt;
  return *quota / *period;
}

// Bytes. What the group holds of files can be taken back.
std::optional<double> left_in(const fs::path& folder, bool is_unified) {
  constexpr double kNoLimit = 9e18;  // what version 1 writes where there is none
  const auto file = [&](const char* two, const char* one) {
    return folder / (is_unified ? two : one);
  };
  const std::optional<double> limit = number_of(file("memory.max", "memory.limit_in_bytes"));
  const std::optional<double> used = number_of(file("memory.current", "memory.usage_in_bytes"));
  if (!limit || !used || *limit > kNoLimit) return std::nullopt;
  const std::optional<double> cached =
      number_of(folder / "memory.stat", is_unified ? "inactive_file" : "total_inactive_file");
  return std::max(0.0, *limit - std::max(0.0, *used - cached.value_or(0.0)));
}

template <class Limit>
std::optional<double> least_of_groups(const fs::path& root, const std::string& controller,
                                      const Limit& limit) {
  std::optional<double> found;
  for (const std::string& name : {controller, std::string()}) {
    const std::optional<Hierarchy> hierarchy = hierarchy_of(root, name);
    if (!hierarchy) continue;
    for (const fs::path& folder : folders_of(*hierarchy)) {
      found = least(found, limit(folder, hierarchy->is_unified));
    }
  }
  return found;
}

}  // namespace

int usable_processors() {
  // More processors than a cpu_set_t holds are rare, and the call fails then.
  cpu_set_t set;
  if (::sched_getaffinity(0, sizeof(set), &set) == 0) return std::max(1, CPU_COUNT(&set));
  return std::max(1, static_cast<int>(::sysconf(_SC_NPROCESSORS_ONLN)));
}

std::optional<double> free_memory_mib() {
  const std::optional<double> free_kib = number_of("/proc/meminfo", "MemAvailable:");
  std::optional<double> free_mib;
  if (free_kib) free_mib = *free_kib / 1024.0;
  return least(free_mib, memory_left_mib());
}

std::optional<double> processor_limit(const fs::path& root) {
  return least_of_groups(root, "cpu", quota_in);
}

std::optional<double> memory_left_mib(const fs::path& root) {
  std::optional<double> bytes = least_of_groups(root, "memory", left_in);
  if (bytes) *bytes /= 1048576.0;
  return bytes;
}

}  // namespace sightline
