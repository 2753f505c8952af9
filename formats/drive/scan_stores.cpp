#include "formats/drive/scan_stores.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "formats/base/random.h"

namespace sightline {
namespace {

// Of a store and of a scan in it.
using Key = std::pair<std::uint64_t, std::size_t>;

// A scan in as little memory as gives it back bit by bit.
struct PackedScan {
  std::int64_t stamp_ns = 0;
  std::vector<float> floats;    // three a point, where all coordinates are floats
  std::vector<double> doubles;  // else
  std::vector<std::int32_t> time_offset_ns;

  explicit PackedScan(const Scan& scan)
      : stamp_ns(scan.stamp_ns), time_offset_ns(scan.time_offset_ns) {
    const std::size_t count = 3 * scan.points_m.size();
    const double* const numbers = count == 0 ? nullptr : scan.points_m.front().data();
    if (std::all_of(numbers, numbers + count, is_float)) {
      floats.resize(count);
      std::transform(numbers, numbers + count, floats.begin(),
                     [](double number) { return static_cast<float>(number); });
    } else {
      doubles.assign(numbers, numbers + count);
    }
  }

  [[nodiscard]] Scan unpacked() const {
    Scan scan;
    scan.stamp_ns = stamp_ns;
    scan.time_offset_ns = time_offset_ns;
    const std::size_t count = std::max(floats.size(), doubles.size()) / 3;
    scan.points_m.reserve(count);
    for (std::size_t i = 0; i < 3 * count; i += 3) {
      if (floats.empty()) {
        scan.points_m.emplace_back(doubles[i], doubles[i + 1], doubles[i + 2]);
      } else {
        scan.points_m.emplace_back(floats[i], floats[i + 1], floats[i + 2]);
      }
    }
    return scan;
  }

  [[nodiscard]] std::size_t bytes() const {
    return sizeof(PackedScan) + floats.size() * sizeof(float) + doubles.size() * sizeof(double) +
           time_offset_ns.size() * sizeof(std::int32_t);
  }

 private:
  static bool is_float(double number) {
    return static_cast<double>(static_cast<float>(number)) == number;
  }
};

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
    return derived_digest("moved in time", *within, written(origin.moved_ns).bytes());
  }

  [[nodiscard]] bool has_origins() const override {
    return std::ranges::all_of(stores_, [](const auto& store) { return store->has_origins(); });
  }

 private:
  std::vector<std::shared_ptr<const ScanStore>> stores_;
  std::vector<ScanOrigin> origins_;
};

}  // namespace

struct ScanMemory::Kept {
  Kept(std::size_t bytes_bound, std::size_t scans_bound)
      : most_bytes(bytes_bound), most_scans(scans_bound) {}

  std::shared_ptr<const PackedScan> find(const Key& key) {
    const std::scoped_lock lock(mutex);
    const auto place = place_of.find(key);
    return place == place_of.end() ? nullptr : scans[place->second].second;
  }

  void insert(const Key& key, std::shared_ptr<const PackedScan> scan) {
    const std::scoped_lock lock(mutex);
    const std::size_t wanted = scan->bytes();
    if (wanted > most_bytes || most_scans == 0 || place_of.contains(key)) return;
    while (bytes + wanted > most_bytes || scans.size() >= most_scans) {
      remove(chance.below(scans.size()));
    }
    scans.reserve(scans.size() + 1);
    place_of.emplace(key, scans.size());
    scans.emplace_back(key, std::move(scan));
    bytes += wanted;
  }

  void forget(std::uint64_t store) {
    const std::scoped_lock lock(mutex);
    for (std::size_t i = scans.size(); i-- > 0;) {
      if (scans[i].first.first == store) remove(i);
    }
  }

  const std::size_t most_bytes;
  const std::size_t most_scans;
  std::size_t bytes = 0;
  std::uint64_t store_count = 0;
  std::mutex mutex;

 private:
  // The last one takes its place.
  void remove(std::size_t i) {
    bytes -= scans[i].second->bytes();
    place_of.erase(scans[i].first);
    if (i + 1 < scans.size()) {
      scans[i] = std::move(scans.back());
      place_of[scans[i].first] = i;
    }
    scans.pop_back();
  }

  std::vector<std::pair<Key, std::shared_ptr<const PackedScan>>> scans;
  std::map<Key, std::size_t> place_of;  // in `scans`
  Random chance{0};
};

class ScanMemory::Store : public ScanStore {
 public:
  Store(std::shared_ptr<const ScanStore> store, std::shared_ptr<ScanMemory> memory)
      : store_(std::move(store)), memory_(std::move(memory)) {
    const std::scoped_lock lock(memory_->kept_->mutex);
    number_ = memory_->kept_->store_count++;
  }
  ~Store() override { memory_->kept_->forget(number_); }
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  Result<Scan> read(std::size_t index) const override {
    const Key key{number_, index};
    if (const std::shared_ptr<const PackedScan> kept = memory_->kept_->find(key)) {
      return kept->unpacked();
    }
    Result<Scan> scan = store_->read(index);
    if (!scan) return scan;
    try {
      memory_->kept_->insert(key, std::make_shared<const PackedScan>(*scan));
    } catch (const std::bad_alloc&) {
      // Then it is read again.
    }
    return scan;
  }
  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    return store_->identity(index);
  }
  [[nodiscard]] bool has_origins() const override { return store_->has_origins(); }

 private:
  std::shared_ptr<const ScanStore> store_;
  std::shared_ptr<ScanMemory> memory_;
  std::uint64_t number_ = 0;
};

ScanMemory::ScanMemory(std::size_t most_bytes, std::size_t most_scans)
    : kept_(std::make_unique<Kept>(most_bytes, most_scans)) {}

ScanMemory::~ScanMemory() = default;

std::shared_ptr<const ScanStore> ScanMemory::before(std::shared_ptr<const ScanStore> store,
                                                    std::shared_ptr<ScanMemory> memory) {
  return std::make_shared<const Store>(std::move(store), std::move(memory));
}

std::size_t ScanMemory::bytes() const {
  const std::scoped_lock lock(kept_->mutex);
  return kept_->bytes;
}

std::shared_ptr<const ScanStore> joined_scan_store(
    std::vector<std::shared_ptr<const ScanStore>> stores, std::vector<ScanOrigin> origins) {
  return std::make_shared<JoinedScanStore>(std::move(stores), std::move(origins));
}

}  // namespace sightline
