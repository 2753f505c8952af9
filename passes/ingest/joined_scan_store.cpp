#include "passes/ingest/joined_scan_store.h"

#include <utility>

namespace sightline {
namespace {

class JoinedScanStore : public ScanStore {
 public:
  JoinedScanStore(std::shared_ptr<const ScanStore> first, std::shared_ptr<const ScanStore> other,
                  std::vector<ScanOrigin> origins)
      : first_(std::move(first)), other_(std::move(other)), origins_(std::move(origins)) {}

  Result<Scan> read(std::size_t index) const override {
    SIGHTLINE_CHECK(index < origins_.size());
    const ScanOrigin& origin = origins_[index];
    Result<Scan> scan = (origin.is_other ? other_ : first_)->read(origin.index);
    if (scan) scan->stamp_ns += origin.moved_ns;
    return scan;
  }

  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    SIGHTLINE_CHECK(index < origins_.size());
    const ScanOrigin& origin = origins_[index];
    const std::optional<Digest> within =
        (origin.is_other ? other_ : first_)->identity(origin.index);
    if (!within || origin.moved_ns == 0) return within;
    ByteWriter writer;
    writer.put(origin.moved_ns);
    return derived_digest("moved in time", *within, writer.bytes());
  }

 private:
  std::shared_ptr<const ScanStore> first_;
  std::shared_ptr<const ScanStore> other_;
  std::vector<ScanOrigin> origins_;
};

}  // namespace

std::shared_ptr<const ScanStore> joined_scan_store(std::shared_ptr<const ScanStore> first,
                                                   std::shared_ptr<const ScanStore> other,
                                                   std::vector<ScanOrigin> origins) {
  return std::make_shared<JoinedScanStore>(std::move(first), std::move(other), std::move(origins));
}

}  // namespace sightline
