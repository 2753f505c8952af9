#pragma once

#include <filesystem>
#include <span>

#include "formats/base/files/atomic_file.h"
#include "formats/base/result.h"

namespace sightline {

// A point as PCD files hold it: metres in whatever frame the file is in. Float, so large world
// coordinates must have a local origin subtracted before.
struct PointXyzi {
  float x_m = 0.0F;
  float y_m = 0.0F;
  float z_m = 0.0F;
  float intensity = 0.0F;
};

// PCD 0.7, DATA binary, fields x y z intensity, one unorganised row. The same points give the same
// bytes; the file appears whole or not at all.
// Errors: output-exists, disk-full, cannot-write.
Result<void> write_pcd_binary(const std::filesystem::path& path, std::span<const PointXyzi> points,
                              IfExists if_exists = IfExists::kRefuse);

}  // namespace sightline
