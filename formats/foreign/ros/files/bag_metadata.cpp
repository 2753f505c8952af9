#include "formats/foreign/ros/files/bag_metadata.h"

#include <sstream>

#include "formats/base/files/regular_file.h"

// rosbag2 writes its metadata as YAML in blocks, one value a line. Two of them are needed here, so
// lines are read and no YAML is parsed.

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFirstKey = "rosbag2_bagfile_information:";

struct BagMetadata {
  std::vector<std::string> files;
  std::string compression_format;
};

// Without blanks around it, and without quotes.
std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kAround = " \t\r\"'";
  const std::size_t first = text.find_first_not_of(kAround);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kAround) - first + 1);
}

BagMetadata parse(const std::string& text) {
  BagMetadata metadata;
  std::istringstream lines(text);
  bool are_files = false;
  for (std::string line; std::getline(lines, line);) {
    const std::string_view words = trimmed(line);
    const auto value_of = [&](std::string_view key, std::string& value) {
      if (words.starts_with(key)) value = trimmed(words.substr(key.size()));
    };
    if (are_files && words.starts_with("- ")) {
      metadata.files.emplace_back(trimmed(words.substr(2)));
      continue;
    }
    are_files = words == "relative_file_paths:";
    value_of("compression_format:", metadata.compression_format);
  }
  return metadata;
}

Result<void> check_compression(const BagMetadata& metadata, const fs::path& file) {
  std::string format;
  for (const char c : metadata.compression_format) {
    format += static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  }
  if (format.empty() || format == "zstd") return {};
  return Error{ErrorCode::kUnsupportedFormat,
               "found compression " + metadata.compression_format +
                   ", expected zstd; `ros2 bag convert` writes the recording without",
               file.string()};
}

// Recorders up to Foxy wrote paths from the folder above.
Result<fs::path> find_file(const fs::path& folder, const std::string& name) {
  constexpr std::string_view kPacked = ".zstd";
  const fs::path file = folder / name;
  const fs::path here = folder / file.filename();
  std::error_code failure;
  const bool is_packed = name.ends_with(kPacked);
  for (const fs::path& candidate : {file, here}) {
    // A file that was packed as a whole, and was unpacked since.
    const fs::path plain = is_packed ? fs::path(candidate).replace_extension() : candidate;
    if (fs::is_regular_file(plain, failure)) return plain;
    if (!is_packed || !fs::is_regular_file(candidate, failure)) continue;
    return Error{ErrorCode::kUnsupportedFormat,
                 "the file is packed as a whole; unpack it with `zstd -d " +
                     candidate.filename().string() + " -o " + plain.filename().string() + "`",
                 candidate.string()};
  }
  return Error{
      ErrorCode::kFileNotFound,
      "the recording's " + std::string(kBagMetadata) + " names this file, and it is not there",
      file.string()};
}

}  // namespace

bool is_rosbag2_folder(const fs::path& folder) {
  constexpr std::size_t kEnough = 4096;  // the key is the first but for comments
  std::error_code failure;
  const fs::path file = folder / kBagMetadata;
  if (!fs::is_directory(folder, failure) || !fs::is_regular_file(file, failure)) return false;
  const Result<std::string> text = read_beginning(file.string(), kEnough);
  return text && text->find(kFirstKey) != std::string::npos;
}

Result<std::vector<fs::path>> files_of_rosbag2(const fs::path& folder) {
  constexpr std::size_t kMostBytes = 1U << 24U;
  const fs::path file = folder / kBagMetadata;
  SIGHTLINE_ASSIGN(const std::string text, read_beginning(file.string(), kMostBytes));
  const BagMetadata metadata = parse(text);
  if (metadata.files.empty()) {
    return Error{ErrorCode::kMalformedHeader, "found no relative_file_paths", file.string()};
  }
  SIGHTLINE_TRY(check_compression(metadata, file));
  std::vector<fs::path> files;
  for (const std::string& name : metadata.files) {
    SIGHTLINE_ASSIGN(fs::path found, find_file(folder, name));
    files.push_back(std::move(found));
  }
  return files;
}

}  // namespace sightline
