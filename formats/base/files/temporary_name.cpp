#include "formats/base/files/temporary_name.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <fstream>
#include <iterator>
#include <optional>
#include <vector>

namespace sightline {
namespace {

constexpr std::string_view kPrefix = ".sl";

// Files of /proc have no size before they are read.
std::string system_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// A field of the name: what separates fields, and what is no part of a plain name, goes.
std::string plain(std::string text) {
  std::erase(text, '\n');
  std::ranges::replace_if(
      text,
      [](char c) {
        const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        return !is_letter && !(c >= '0' && c <= '9') && c != '.';
      },
      '_');
  return text;
}

// Machines may share a name, and containers on one machine that too; a process can be looked for
// in its own namespace only.
std::string host() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) name[0] = '?';
  std::array<char, 64> space{};
  if (::readlink("/proc/self/ns/pid", space.data(), space.size() - 1) < 0) space[0] = '?';
  std::string digits(space.data());
  std::erase_if(digits, [](char c) { return c < '0' || c > '9'; });
  return concat(plain(std::string(name.data()).substr(0, 64)), ".", digits);
}

// 32 hexadecimal digits; empty where the system does not tell.
std::string boot_id() {
  std::string id = system_text("/proc/sys/kernel/random/boot_id");
  std::erase(id, '-');
  return plain(id);
}

// Field 22 of /proc/PID/stat; the second one is in brackets and may hold anything.
std::string start_time(pid_t pid) {
  const std::string stat = system_text(concat("/proc/", pid, "/stat"));
  std::size_t begin = stat.rfind(')');
  if (begin == std::string::npos) return {};
  for (int field = 2; field < 22; ++field) {
    begin = stat.find(' ', begin + 1);
    if (begin == std::string::npos) return {};
  }
  return stat.substr(begin + 1, stat.find(' ', begin + 1) - begin - 1);
}

std::vector<std::string> fields_of(std::string_view name) {
  std::vector<std::string> fields;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('-', begin), name.size());
    fields.emplace_back(name.substr(begin, end - begin));
    begin = end + 1;
  }
  return fields;
}

std::optional<pid_t> pid_of(const std::string& text) {
  pid_t pid = 0;
  const char* const end = text.data() + text.size();
  const std::from_chars_result read = std::from_chars(text.data(), end, pid);
  if (read.ec != std::errc() || read.ptr != end || pid <= 0) return {};
  return pid;
}

bool is_gone(pid_t pid, const std::string& started) {
  if (::kill(pid, 0) != 0 && errno == ESRCH) return true;
  const std::string found = start_time(pid);
  return !found.empty() && found != started;  // another process has its number now
}

}  // namespace

std::string temporary_name() {
  static std::atomic<unsigned long> serial = 0;
  const pid_t pid = ::getpid();
  return concat(kPrefix, "-", host(), "-", boot_id(), "-", pid, "-", start_time(pid), "-",
                serial++);
}

TemporaryOwner owner_of(std::string_view file_name) {
  const std::vector<std::string> fields = fields_of(file_name);
  if (fields.size() != 6 || fields[0] != kPrefix) return TemporaryOwner::kNone;
  const std::optional<pid_t> pid = pid_of(fields[3]);
  const bool is_ours = fields[1] == host() && !fields[2].empty() && fields[2] == boot_id();
  if (!is_ours || !pid || fields[4].empty()) return TemporaryOwner::kUnknown;
  return is_gone(*pid, fields[4]) ? TemporaryOwner::kGone : TemporaryOwner::kAlive;
}

void remove_leftovers(const std::filesystem::path& folder) {
  std::error_code failure;
  std::vector<std::filesystem::path> leftovers;
  std::filesystem::directory_iterator entry(folder, failure);
  for (; !failure && entry != std::filesystem::directory_iterator(); entry.increment(failure)) {
    const std::filesystem::path& path = entry->path();
    if (owner_of(path.filename().string()) == TemporaryOwner::kGone) leftovers.push_back(path);
  }
  for (const std::filesystem::path& path : leftovers) (void)::unlink(path.c_str());
}

}  // namespace sightline
