#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/foreign/clouds/point_cloud_file.h"

namespace sightline {

struct ContainedScan {
  std::int64_t stamp_ns = 0;
  Digest content{};  // SHA-256 of the bytes that read() gives
};

// A file that holds the scans of a whole drive. It is walked through once when it is opened; each
// scan is read on demand, so memory never holds more of it than one scan for each reader.
class ScanContainer {
 public:
  virtual ~ScanContainer() = default;

  [[nodiscard]] const std::vector<ContainedScan>& scans() const { return scans_; }
  // What was left out or doubtful, for the person who brought the file.
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

  // The frame that the scans name, by which transforms find them; empty: none.
  [[nodiscard]] const std::string& frame() const { return frame_; }

  // The file of the sensor's beams, as `sensor` of a recording takes it; empty: none.
  [[nodiscard]] const std::filesystem::path& sensor_file() const { return sensor_file_; }

  // All that the file says of one scan. Safe from several threads. Error: cannot-read.
  virtual Result<std::vector<std::byte>> read(std::size_t index) const = 0;
  // What read() gave, as points in the sensor's frame. Errors: as read_point_cloud.
  virtual Result<PointCloudFile> parse(std::span<const std::byte> bytes,
                                       std::size_t index) const = 0;

 protected:
  std::vector<ContainedScan> scans_;  // in the order of the file
  std::vector<std::string> warnings_;
  std::string frame_;
  std::filesystem::path sensor_file_;
};

}  // namespace sightline
