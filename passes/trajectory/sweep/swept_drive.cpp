#include "passes/trajectory/sweep/swept_drive.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "passes/trajectory/sweep/sweep_times.h"

namespace sightline {
namespace {

constexpr std::int64_t kLongestSweep_ns = 100'000'000;  // 10 Hz; slower LiDARs are rare

std::int64_t sweep_ns(const Drive& drive) {
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = 1; i < drive.scans.size(); ++i) {
    steps_ns.push_back(drive.scans[i].stamp_ns - drive.scans[i - 1].stamp_ns);
  }
  std::ranges::sort(steps_ns);
  return std::min(kLongestSweep_ns, steps_ns[steps_ns.size() / 2]);
}

class SweptScanStore : public ScanStore {
 public:
  SweptScanStore(std::shared_ptr<const ScanStore> store, std::int64_t sweep_ns)
      : store_(std::move(store)), sweep_ns_(sweep_ns) {}

  Result<Scan> read(std::size_t index) const override {
    Result<Scan> scan = store_->read(index);
    if (!scan) return scan;
    for (const double time : sweep_times(scan->points_m)) {
      const double offset_ns = (time - 0.5) * static_cast<double>(sweep_ns_);
      scan->time_offset_ns.push_back(static_cast<std::int32_t>(std::floor(offset_ns)));
    }
    return scan;
  }

 private:
  std::shared_ptr<const ScanStore> store_;
  std::int64_t sweep_ns_;
};

}  // namespace

Result<Drive> with_sweep_times(const Drive& drive) {
  const bool has_times =
      std::ranges::any_of(drive.scans, [](const ScanInfo& scan) { return scan.has_point_times; });
  if (has_times || !drive.other_sensors.empty() || drive.scans.size() < 2) return drive;
  for (const std::size_t index : {std::size_t{0}, drive.scans.size() / 2}) {
    SIGHTLINE_ASSIGN(const Scan scan, drive.store->read(index));
    if (sweep_times(scan.points_m).empty()) return drive;
  }
  Drive swept =
      with_store(drive, std::make_shared<const SweptScanStore>(drive.store, sweep_ns(drive)));
  for (ScanInfo& scan : swept.scans) scan.has_point_times = true;
  return swept;
}

}  // namespace sightline
