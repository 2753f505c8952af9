#include "formats/drive/scans/joined_scan_store.h"

#include <algorithm>
#include <utility>

namespace sightline {
namespace {

class JoinedScanStore : public ScanStore {
 public:
  JoinedScanStore(std::vector<std::shared_ptr<const ScanStore>> stores,
                  std::vector<ScanOrigin> origins)
      : stores_(std::move(stores)), origins_(std::move(origins)) {}

  Result<Scan> read(std::size_t index) const override {
    SIGHTLINE_CHECK(index < origins_.size());
    const ScanOrigin& origin = origins_[index];
    Result<Scan> scan = stores_[origin.store]->read(origin.index);
    if (scan) scan->stamp_ns += origin.moved_ns;
    return scan;
  }

  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    SIGHTLINE_CHECK(index < origins_.size());
    const ScanOrigin& origin = origins_[index];
    const std::optional<Digest> within = stores_[origin.store]->identity(origin.index);
    if (!within || origin.moved_ns == 0) return within;
    ByteWriter writer;
    writer.put(origin.moved_ns);
    return derived_digest("moved in time", *within, writer.bytes());
  }

  [[nodiscard]] bool has_origins() const override {
    return std::ranges::all_of(stores_, [](const auto& store) { return store->has_origins(); });
  }

 private:
  std::vector<std::shared_ptr<const ScanStore>> stores_;
  std::vector<ScanOrigin> origins_;
};

}  // namespace

std::shared_ptr<const ScanStore> joined_scan_store(
    std::vector<std::shared_ptr<const ScanStore>> stores, std::vector<ScanOrigin> origins) {
  return std::make_shared<JoinedScanStore>(std::move(stores), std::move(origins));
}

}  // namespace sightline
