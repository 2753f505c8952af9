#include "formats/base/files/file_system_gap.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <initializer_list>
#include <mutex>
#include <set>
#include <utility>

#include "formats/base/concat.h"

namespace sightline {
namespace {

struct Reports {
  std::mutex mutex;
  std::function<void(const std::string& message)> receiver;
  std::set<FileSystemGap> done;
};

Reports& reports() {
  static Reports all;
  return all;
}

const char* consequence_of(FileSystemGap gap) {
  switch (gap) {
    case FileSystemGap::kSync:
      return "its file system cannot sync files: a loss of power in the next minute may lose them";
    case FileSystemGap::kRenameWithoutReplacing:
      return "its file system cannot rename without replacing: let no other process write there";
    case FileSystemGap::kLock:
      return "its file system has no locks: start one update of a map at a time; an interrupted "
             "update starts again";
  }
  return "";
}

}  // namespace

bool is_gap(FileSystemGap gap, int number) {
  const auto is_one_of = [&](std::initializer_list<int> numbers) {
    return std::ranges::find(numbers, number) != numbers.end();
  };
  if (is_one_of({EINVAL, ENOSYS, ENOTSUP, EOPNOTSUPP})) return true;
  if (gap == FileSystemGap::kLock) return number == ENOLCK;
  return gap == FileSystemGap::kRenameWithoutReplacing && number == EPERM;
}

void report_gap(FileSystemGap gap, const std::string& path, int number) {
  Reports& all = reports();
  const std::lock_guard<std::mutex> lock(all.mutex);
  if (!all.receiver || !all.done.insert(gap).second) return;
  all.receiver(concat(path, ": ", consequence_of(gap), " (", std::strerror(number), ")"));
}

void receive_gaps(std::function<void(const std::string& message)> receiver) {
  Reports& all = reports();
  const std::lock_guard<std::mutex> lock(all.mutex);
  all.receiver = std::move(receiver);
  all.done.clear();
}

}  // namespace sightline
