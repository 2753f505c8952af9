#include "compiler/init/find_scans.h"

#include <algorithm>
#include <array>
#include <optional>
#include <sstream>

#include "formats/base/files/regular_file.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/recording/scan_files.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 4;

bool is_hidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

bool path_less(const fs::path& a, const fs::path& b) {
  return natural_less(a.string(), b.string());
}

struct Listing {
  std::vector<fs::path> files;
  std::vector<fs::path> folders;
};

Result<Listing> list_folder(const fs::path& folder) {
  std::error_code failure;
  fs::directory_iterator entry(folder, failure);
  Listing listing;
  while (!failure && entry != fs::directory_iterator()) {
    std::error_code ignored;
    if (!is_hidden(entry->path())) {
      (entry->is_directory(ignored) ? listing.folders : listing.files).push_back(entry->path());
    }
    entry.increment(failure);
  }
  if (failure) {
    return Error{ErrorCode::kCannotOpen, "cannot list the folder: " + failure.message(),
                 folder.string()};
  }
  std::ranges::sort(listing.files, path_less);
  std::ranges::sort(listing.folders, path_less);
  return listing;
}

bool looks_like_text(const fs::path& file) {
  constexpr std::array<std::string_view, 6> kEndings = {".txt",   ".tum",   ".csv",
                                                        ".poses", ".kitti", ".dat"};
  return std::ranges::find(kEndings, lower_extension(file)) != kEndings.end();
}

// Words of a line, and how many of them are numbers; none of a comment.
struct Columns {
  std::size_t count = 0;
  std::size_t numbers = 0;
};

Columns columns_of(std::string line) {
  std::ranges::replace(line, ',', ' ');
  std::istringstream words(line);
  Columns columns;
  for (std::string word; words >> word; ++columns.count) {
    if (columns.count == 0 && word.starts_with('#')) break;
    std::istringstream number(word);
    double value = 0.0;
    columns.numbers += number >> value && number.eof() ? 1U : 0U;
  }
  return columns;
}

// Columns of the first line that is no comment, where all of them are numbers; else 0, also where
// that line does not end near the beginning. A line of names may stand before it.
std::size_t columns_of_numbers(const fs::path& file) {
  constexpr std::size_t kMostBytes = 64 * 1024;
  const Result<std::string> beginning = read_beginning(file.string(), kMostBytes);
  if (!beginning) return 0;
  const bool is_cut = beginning->size() == kMostBytes;
  std::istringstream stream(is_cut ? beginning->substr(0, beginning->rfind('\n') + 1) : *beginning);
  bool is_first = true;
  for (std::string line; std::getline(stream, line);) {
    const Columns columns =
        columns_of(std::string(is_first ? without_byte_order_mark(line) : line));
    if (columns.count == 0) continue;
    const bool is_head = is_first && columns.numbers == 0;
    is_first = false;
    if (is_head) continue;
    return columns.numbers == columns.count ? columns.count : 0;
  }
  return 0;
}

void sort_out(const fs::path& file, FoundScans& found) {
  if (!looks_like_text(file)) return;
  const std::size_t columns = columns_of_numbers(file);
  if (columns == 1) found.stamp_files.push_back(file);
  if (columns == 8 || columns == 9 || columns == 12) found.pose_files.push_back(file);
}

bool is_named_after(const fs::path& file, const fs::path& scans) {
  return std::ranges::find(scans.begin(), scans.end(), file.stem()) != scans.end() ||
         file.stem() == scans.stem();
}

// From beside the scans up to the folder that was named.
void find_companions(const fs::path& top, FoundScans& found) {
  std::error_code ignored;
  fs::path folder =
      fs::is_directory(found.scans, ignored) ? found.scans : found.scans.parent_path();
  for (int up = 0; up <= kDeepest; ++up) {
    const Result<Listing> listing = list_folder(folder);
    if (listing) {
      for (const fs::path& file : listing->files) sort_out(file, found);
    }
    const Result<Listing> poses = list_folder(folder / "poses");
    if (poses) {
      for (const fs::path& file : poses->files) {
        if (is_named_after(file, found.scans)) sort_out(file, found);
      }
    }
    if (folder == top) return;
    folder = folder.parent_path();
  }
}

void look_into(const fs::path& folder, int depth, ScanSearch& search) {
  if (is_scan_container(folder)) {  // a recording of several files
    search.found.push_back({folder, {}, {}});
    return;
  }
  const Result<Listing> listing = list_folder(folder);
  if (!listing) {
    search.passed_over.push_back({folder, listing.error().message});
    return;
  }
  for (const fs::path& file : listing->files) {
    if (is_scan_container(file)) search.found.push_back({file, {}, {}});
  }
  const Result<std::vector<fs::path>> scans = list_scan_files(folder);
  if (scans && scans->size() >= 2) {
    search.found.push_back({folder, {}, {}});
  } else if (scans) {
    search.passed_over.push_back({folder, "a single scan is no drive"});
  } else if (scans.error().code != ErrorCode::kEmptyDirectory) {
    const bool is_container =
        std::ranges::any_of(listing->files, [](const fs::path& f) { return is_scan_container(f); });
    if (!is_container) search.passed_over.push_back({folder, scans.error().message});
  }
  if (depth == kDeepest) return;
  for (const fs::path& inner : listing->folders) look_into(inner, depth + 1, search);
}

// A file that is no recording of many scans: how it is to be converted, or what is wanted.
Result<void> refuse_other_file(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return {};
  constexpr std::array<std::string_view, 13> kForeign = {".osf", ".lvx", ".lvx2", ".laz", ".e57",
                                                         ".zip", ".7z",  ".tar",  ".tgz", ".gz",
                                                         ".xz",  ".zst", ".xyz"};
  if (std::ranges::find(kForeign, lower_extension(file)) != kForeign.end()) {
    const Result<PointCloudFile> scan = read_point_cloud(file);
    if (!scan && scan.error().code == ErrorCode::kUnsupportedFormat) return scan.error();
  }
  return Error{ErrorCode::kCannotOpen,
               "no folder, and no bag of ROS (.bag, .db3, .mcap) or capture (.pcap, .pcapng) by "
               "what it begins with; expected one of these, of poses the folder with their scans",
               file.string()};
}

}  // namespace

Result<ScanSearch> find_scans(const fs::path& folder) {
  std::error_code failure;
  if (!fs::exists(folder, failure)) {
    return Error{ErrorCode::kFileNotFound, "there is no such folder", folder.string()};
  }
  const fs::path absolute = (fs::current_path() / folder).lexically_normal();
  const fs::path start = absolute.has_filename() ? absolute : absolute.parent_path();
  ScanSearch search;
  if (is_scan_container(start)) {
    search.found.push_back({start, {}, {}});
  } else {
    SIGHTLINE_TRY(refuse_other_file(start));
    SIGHTLINE_TRY(list_folder(start));
    look_into(start, 0, search);
  }
  std::ranges::sort(search.found, path_less, &FoundScans::scans);
  for (FoundScans& found : search.found) {
    find_companions(fs::is_directory(start, failure) ? start : start.parent_path(), found);
  }
  return search;
}

}  // namespace sightline
