#include "formats/foreign/ros/files/open_message_log.h"

#include <yaml-cpp/yaml.h>

#include <tuple>
#include <utility>

#include "formats/base/files/regular_file.h"
#include "formats/foreign/ros/files/bag_chunks.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

// The file that makes a folder a recording of ros2 bag.
constexpr std::string_view kBagMetadata = "metadata.yaml";
constexpr std::string_view kFirstKey = "rosbag2_bagfile_information";

struct BagMetadata {
  std::vector<std::string> files;
  std::string compression_format;
};

// Metadata that ros2 bag writes, or that another program wrote in any style of YAML. Aliases are
// followed where a value is needed, so that they cannot make the text endless.
BagMetadata metadata_in(const YAML::Node& root) {
  BagMetadata metadata;
  const YAML::Node bag = root[std::string(kFirstKey)];
  if (!bag) return metadata;
  const YAML::Node format = bag["compression_format"];
  if (format && format.IsScalar()) metadata.compression_format = format.Scalar();
  for (const YAML::Node& name : bag["relative_file_paths"]) {
    if (name.IsScalar() && !name.Scalar().empty()) metadata.files.push_back(name.Scalar());
  }
  return metadata;
}

Result<BagMetadata> parse(const std::string& text, const fs::path& file) {
  try {
    return metadata_in(YAML::Load(text));
  } catch (const YAML::Exception& exception) {
    return Error{ErrorCode::kMalformedHeader, "not the metadata of a bag: " + exception.msg,
                 file.string(), concat("line ", exception.mark.line + 1)};
  }
}

Result<void> check_compression(const BagMetadata& metadata, const fs::path& file) {
  std::string format;
  for (const char c : metadata.compression_format) {
    format += static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  }
  if (format.empty() || format == "zstd") return {};
  return Error{
      ErrorCode::kUnsupportedFormat,
      concat("found compression ", metadata.compression_format,
             ", expected zstd; `ros2 bag convert` writes the recording without compression"),
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
                 concat("the file is packed as a whole; unpack it with `zstd -d ",
                        candidate.filename().string(), " -o ", plain.filename().string(), "`"),
                 candidate.string()};
  }
  return Error{ErrorCode::kFileNotFound,
               concat("the recording's ", kBagMetadata, " lists this file, but it is missing"),
               file.string()};
}

// Whether a folder holds the metadata of ros2 bag.
bool is_rosbag2_folder(const fs::path& folder) {
  constexpr std::size_t kEnough = 4096;  // the key is the first but for comments
  std::error_code failure;
  const fs::path file = folder / kBagMetadata;
  if (!fs::is_directory(folder, failure) || !fs::is_regular_file(file, failure)) return false;
  const Result<std::string> text = read_beginning(file.string(), kEnough);
  return text && text->find(kFirstKey) != std::string::npos;
}

// The files of a recording of ros2 bag, in its order. Errors: cannot-open, cannot-read,
// malformed-header (no files are named), file-not-found (one that is named),
// unsupported-format (files that are packed as a whole, or messages packed by anything but zstd).
Result<std::vector<fs::path>> files_of_rosbag2(const fs::path& folder) {
  constexpr std::size_t kMostBytes = 1U << 24U;
  const fs::path file = folder / kBagMetadata;
  SIGHTLINE_ASSIGN(const std::string text, read_beginning(file.string(), kMostBytes));
  SIGHTLINE_ASSIGN(const BagMetadata metadata, parse(text, file));
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

bool is_ros1_bag(const fs::path& path) {
  constexpr std::string_view kSignature = "#ROSBAG";
  const Result<std::string> bytes = read_beginning(path.string(), kSignature.size());
  return bytes && *bytes == kSignature;
}

// The files of one recording, with the channels of all.
class Rosbag2 : public MessageLog {
 public:
  Result<void> add(const fs::path& path) {
    File file{path, nullptr, {}};
    if (is_mcap(path)) {
      SIGHTLINE_ASSIGN(file.log, open_mcap(path));
    } else {
      SIGHTLINE_ASSIGN(file.log, open_db3(path));
    }
    for (const auto& [number, channel] : file.log->channels()) {
      file.channels[number] = number_of(channel);
    }
    warnings_.insert(warnings_.end(), file.log->warnings().begin(), file.log->warnings().end());
    files_.push_back(std::move(file));
    return {};
  }

  Result<void> for_each_message(const std::set<std::uint32_t>& channels,
                                const MessageBody& body) const override;
  Result<Bytes> read(const MessagePlace& place) const override;

 private:
  struct File {
    fs::path path;
    std::unique_ptr<MessageLog> log;
    std::map<std::uint32_t, std::uint32_t> channels;  // its numbers to those of the recording
  };

  [[nodiscard]] std::uint32_t number_of(const LogChannel& channel) {
    const auto next = static_cast<std::uint32_t>(channels_.size());
    const auto [entry, is_new] =
        numbers_.emplace(std::tuple(channel.topic, channel.type, channel.encoding), next);
    if (is_new) {
      channels_[next] = channel;
    } else {
      channels_[entry->second].message_count += channel.message_count;
    }
    return entry->second;
  }

  std::vector<File> files_;
  std::map<std::tuple<std::string, std::string, std::optional<MessageEncoding>>, std::uint32_t>
      numbers_;  // of the channels
};

// What a message that was packed by itself holds; no message of CDR begins like a frame of zstd.
Result<Bytes> unpack(std::span<const std::byte> packed, const fs::path& path) {
  std::optional<Bytes> unpacked = unpack_zstd_frame(packed);
  if (unpacked) return *std::move(unpacked);
  return Error{ErrorCode::kMalformedHeader, "found a packed message that does not unpack",
               path.string()};
}

Result<void> Rosbag2::for_each_message(const std::set<std::uint32_t>& channels,
                                       const MessageBody& body) const {
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const File& file = files_[i];
    std::set<std::uint32_t> wanted;
    for (const auto& [number, ours] : file.channels) {
      if (channels.contains(ours)) wanted.insert(number);
    }
    const auto pass_on = [&](LoggedMessage message) -> Result<void> {
      message.channel = file.channels.at(message.channel);
      message.place.file = i;
      if (!is_zstd_frame(message.bytes)) return body(message);
      SIGHTLINE_ASSIGN(const Bytes bytes, unpack(message.bytes, file.path));
      message.bytes = bytes;
      return body(message);
    };
    SIGHTLINE_TRY(file.log->for_each_message(wanted, pass_on));
  }
  return {};
}

Result<Bytes> Rosbag2::read(const MessagePlace& place) const {
  const File& file = files_.at(place.file);
  SIGHTLINE_ASSIGN(Bytes bytes, file.log->read(place));
  if (!is_zstd_frame(bytes)) return bytes;
  return unpack(bytes, file.path);
}

}  // namespace

bool is_message_log(const fs::path& path) {
  std::error_code failure;
  if (fs::is_directory(path, failure)) return is_rosbag2_folder(path);
  if (!fs::is_regular_file(path, failure)) return false;
  return is_ros1_bag(path) || is_mcap(path) || is_db3(path);
}

Result<std::unique_ptr<MessageLog>> open_message_log(const fs::path& path) {
  std::error_code failure;
  std::vector<fs::path> files = {path};
  if (fs::is_directory(path, failure)) {
    SIGHTLINE_ASSIGN(files, files_of_rosbag2(path));
  } else if (!is_mcap(path) && !is_db3(path)) {
    return open_ros1_bag(path);  // whose errors tell what it is not
  }
  auto bag = std::make_unique<Rosbag2>();
  for (const fs::path& file : files) SIGHTLINE_TRY(bag->add(file));
  return std::unique_ptr<MessageLog>(std::move(bag));
}

}  // namespace sightline
