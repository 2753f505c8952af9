#include "formats/drive/scan_stores.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <thread>

#include "formats/base/random.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

// Scans of some hundred points: those with an even index of floats, the others of doubles; every
// third one with times.
class CountingStore : public ScanStore {
 public:
  explicit CountingStore(std::uint64_t seed) : seed_(seed) {}

  [[nodiscard]] Scan scan(std::size_t index) const {
    Random random(seed_ + index);
    Scan scan;
    scan.stamp_ns = static_cast<std::int64_t>(random.next() >> 1);
    const std::size_t count = index == 7 ? 0 : 100 + random.below(400);
    for (std::size_t i = 0; i < count; ++i) {
      Eigen::Vector3d point_m(random.uniform(-90.0, 90.0), random.uniform(-90.0, 90.0), -0.0);
      if (index % 2 == 0) point_m = point_m.cast<float>().cast<double>();
      scan.points_m.push_back(point_m);
      if (index % 3 == 0) scan.time_offset_ns.push_back(static_cast<std::int32_t>(i) - 50);
    }
    return scan;
  }
  Result<Scan> read(std::size_t index) const override {
    if (++reads == fails_at) return Error{ErrorCode::kCannotRead, "the disk is gone"};
    return scan(index);
  }

  mutable std::atomic<int> reads = 0;
  int fails_at = -1;

 private:
  std::uint64_t seed_;
};

void expect_same_bits(const Scan& found, const Scan& expected) {
  EXPECT_EQ(found.stamp_ns, expected.stamp_ns);
  EXPECT_EQ(found.time_offset_ns, expected.time_offset_ns);
  ASSERT_EQ(found.points_m.size(), expected.points_m.size());
  const std::size_t size = expected.points_m.size() * sizeof(Eigen::Vector3d);
  if (size == 0) return;
  EXPECT_EQ(std::memcmp(found.points_m.data(), expected.points_m.data(), size), 0);
}

TEST(ScanMemory, GivesTheSameScansWhateverItsSize) {
  for (const std::size_t most_bytes : {std::size_t{0}, std::size_t{20'000}, std::size_t{1} << 30}) {
    const auto memory = std::make_shared<ScanMemory>(most_bytes, 100);
    const auto first = std::make_shared<CountingStore>(1);
    const auto second = std::make_shared<CountingStore>(2);
    const std::shared_ptr<const ScanStore> stores[] = {ScanMemory::before(first, memory),
                                                       ScanMemory::before(second, memory)};
    Random random(3);
    for (int i = 0; i < 500; ++i) {
      const std::size_t which = random.below(2);
      const std::size_t index = random.below(20);
      const Scan found = value_of(stores[which]->read(index));
      expect_same_bits(found, (which == 0 ? *first : *second).scan(index));
      EXPECT_LE(memory->bytes(), most_bytes);
    }
    const int reads = first->reads + second->reads;
    const bool holds_none = most_bytes == 0;
    const bool holds_all = most_bytes > 20'000;
    EXPECT_LE(reads, holds_none ? 500 : holds_all ? 40 : 490);
    EXPECT_GE(reads, holds_none ? 500 : 40);
  }
}

TEST(ScanMemory, FindsSomeScansThoughAllAreAskedForInTurn) {
  const auto memory = std::make_shared<ScanMemory>(1 << 20, 15);  // of 20
  const auto store = std::make_shared<CountingStore>(1);
  const std::shared_ptr<const ScanStore> remembered = ScanMemory::before(store, memory);
  for (std::size_t i = 0; i < 400; ++i) ASSERT_TRUE(remembered->read(i % 20));
  EXPECT_LT(store->reads, 260) << "that of the last use would find none";
}

TEST(ScanMemory, HoldsFloatsInHalfTheBytes) {
  std::size_t bytes[2] = {};
  for (const std::size_t index : {std::size_t{4}, std::size_t{5}}) {
    const auto memory = std::make_shared<ScanMemory>(1 << 20, 100);
    const auto store = std::make_shared<CountingStore>(1);
    ASSERT_TRUE(ScanMemory::before(store, memory)->read(index));
    const std::shared_ptr<const ScanStore> remembered = ScanMemory::before(store, memory);
    ASSERT_TRUE(remembered->read(index));
    bytes[index - 4] = memory->bytes() / store->scan(index).points_m.size();
  }
  EXPECT_NEAR(static_cast<double>(bytes[0]), 12.0, 2.0);
  EXPECT_NEAR(static_cast<double>(bytes[1]), 24.0, 2.0);
}

TEST(ScanMemory, ForgetsTheScansOfAStoreThatIsGone) {
  const auto memory = std::make_shared<ScanMemory>(1 << 20, 100);
  const auto store = std::make_shared<CountingStore>(1);
  const std::shared_ptr<const ScanStore> stays = ScanMemory::before(store, memory);
  ASSERT_TRUE(stays->read(1));
  const std::size_t bytes = memory->bytes();
  for (std::size_t i = 0; i < 5; ++i) ASSERT_TRUE(ScanMemory::before(store, memory)->read(i));
  EXPECT_EQ(memory->bytes(), bytes);
}

TEST(ScanMemory, AsksAgainForAScanThatCouldNotBeRead) {
  const auto memory = std::make_shared<ScanMemory>(1 << 20, 100);
  const auto store = std::make_shared<CountingStore>(1);
  store->fails_at = 1;
  const std::shared_ptr<const ScanStore> remembered = ScanMemory::before(store, memory);
  EXPECT_EQ(code_of(remembered->read(2)), ErrorCode::kCannotRead);
  ASSERT_TRUE(remembered->read(2));
  ASSERT_TRUE(remembered->read(2));
  EXPECT_EQ(store->reads, 2);
}

TEST(ScanMemory, IsSafeFromSeveralThreads) {
  const auto memory = std::make_shared<ScanMemory>(30'000, 100);
  const auto store = std::make_shared<CountingStore>(1);
  const std::shared_ptr<const ScanStore> remembered = ScanMemory::before(store, memory);
  std::vector<std::thread> threads;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    threads.emplace_back([&, seed] {
      Random random(seed);
      for (int i = 0; i < 300; ++i) {
        const std::size_t index = random.below(20);
        expect_same_bits(value_of(remembered->read(index)), store->scan(index));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_LE(memory->bytes(), 30'000U);
}

}  // namespace
}  // namespace sightline
