#include "formats/foreign/recording/listed_scan_store.h"

#include <utility>

#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/recording/point_times.h"

namespace sightline {
namespace {

class ListedScanStore : public ScanStore {
 public:
  explicit ListedScanStore(const Recording& recording)
      : recording_(recording), step_ns_(usual_step_ns(recording.scans)) {}

  Result<Scan> read(std::size_t index) const override {
    SIGHTLINE_CHECK(index < recording_.scans.size());
    SIGHTLINE_ASSIGN(PointCloudFile cloud, read_listed_scan(recording_, index));
    const std::int64_t stamp_ns = recording_.scans[index].stamp_ns;
    settle_point_times(stamp_ns, step_ns_, cloud);
    return Scan{stamp_ns, std::move(cloud.points_m), std::move(cloud.time_offset_ns)};
  }

 private:
  Recording recording_;
  std::int64_t step_ns_ = 0;
};

}  // namespace

std::shared_ptr<const ScanStore> listed_scan_store(const Recording& recording) {
  return std::make_shared<const ListedScanStore>(recording);
}

}  // namespace sightline
