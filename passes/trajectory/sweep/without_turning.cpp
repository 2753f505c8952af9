#include "passes/trajectory/sweep/without_turning.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "passes/trajectory/sweep/turn_curve.h"

namespace sightline {
namespace {

// The range of an offset of 32 bits.
constexpr std::int64_t kFarthestPoint_ns = std::int64_t{1} << 31;

class UnturnedScanStore : public ScanStore {
 public:
  explicit UnturnedScanStore(const Drive& drive) : drive_(drive) {}

  Result<Scan> read(std::size_t index) const override {
    Result<Scan> scan = drive_.store->read(index);
    if (!scan || scan->time_offset_ns.empty()) return scan;
    const auto [least_ns, most_ns] = std::ranges::minmax(scan->time_offset_ns);
    const std::int64_t from_ns = scan->stamp_ns + std::min(least_ns, 0);
    const std::int64_t to_ns = scan->stamp_ns + std::max(most_ns, 0);
    const std::optional<TurnCurve> curve = TurnCurve::by_rates(drive_.turn_rates, from_ns, to_ns);
    if (!curve) return scan;
    const Pose& T_vehicle_lidar = drive_.sensor_of(drive_.scans[index]).T_vehicle_lidar;
    const Pose T_lidar_vehicle = T_vehicle_lidar.inverse();
    const Eigen::Matrix3d R_stamp_from = curve->at(scan->stamp_ns).transpose();
    Pose T_lidar_then = Pose::Identity();
    std::optional<std::int32_t> offset_ns;  // that T_lidar_then belongs to
    for (std::size_t i = 0; i < scan->points_m.size(); ++i) {
      if (offset_ns != scan->time_offset_ns[i]) {
        offset_ns = scan->time_offset_ns[i];
        Pose turn = Pose::Identity();
        turn.linear() = R_stamp_from * curve->at(scan->stamp_ns + *offset_ns);
        T_lidar_then = T_lidar_vehicle * turn * T_vehicle_lidar;
      }
      scan->points_m[i] = T_lidar_then * scan->points_m[i];
    }
    return scan;
  }

  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    const std::optional<Digest> as_measured = drive_.store->identity(index);
    if (!as_measured) return std::nullopt;
    const std::int64_t stamp_ns = drive_.scans[index].stamp_ns;
    ByteWriter writer;
    writer.put(stamp_ns);
    encode(drive_.sensor_of(drive_.scans[index]).T_vehicle_lidar, writer);
    for (const TurnRate& rate : rates_around(drive_.turn_rates, stamp_ns - kFarthestPoint_ns,
                                             stamp_ns + kFarthestPoint_ns)) {
      encode(rate, writer);
    }
    return derived_digest("without turning", *as_measured, writer.bytes());
  }

 private:
  Drive drive_;
};

}  // namespace

Drive without_turning(const Drive& drive) {
  return with_store(drive, std::make_shared<const UnturnedScanStore>(drive));
}

}  // namespace sightline
