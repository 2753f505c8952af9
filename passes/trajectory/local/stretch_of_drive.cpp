#include "passes/trajectory/local/stretch_of_drive.h"

#include <memory>
#include <optional>
#include <utility>

namespace sightline {
namespace {

class StretchStore : public ScanStore {
 public:
  StretchStore(std::shared_ptr<const ScanStore> store, std::size_t first)
      : store_(std::move(store)), first_(first) {}
  Result<Scan> read(std::size_t index) const override { return store_->read(first_ + index); }
  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    return store_->identity(first_ + index);
  }

 private:
  std::shared_ptr<const ScanStore> store_;
  std::size_t first_;
};

}  // namespace

Drive stretch_of(const Drive& drive, std::size_t first, std::size_t count) {
  Drive stretch = with_store(drive, std::make_shared<const StretchStore>(drive.store, first));
  const auto begin = drive.scans.begin() + static_cast<std::ptrdiff_t>(first);
  stretch.scans = {begin, begin + static_cast<std::ptrdiff_t>(count)};
  return stretch;
}

}  // namespace sightline
