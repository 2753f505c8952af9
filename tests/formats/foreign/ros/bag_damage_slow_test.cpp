#include <sys/resource.h>

#include <chrono>

#include "tests/formats/foreign/random_bags.h"
#include "tests/formats/foreign/ros/read_damaged.h"
#include "tests/support/test_files.h"

namespace sightline {
namespace {

std::string damaged(std::string bag, std::mt19937& random) {
  const std::size_t at = random() % bag.size();
  switch (random() % 6) {
    case 0:
      bag[at] = static_cast<char>(bag[at] ^ static_cast<char>(1U << random() % 8));
      break;
    case 1:
      bag.resize(at);
      break;
    case 2:
      bag.erase(at, 1 + random() % 40);
      break;
    case 3:
      bag.insert(at, std::string(1 + random() % 40, static_cast<char>(random())));
      break;
    case 4: {
      const std::uint32_t huge =
          random() % 2 == 0 ? 0xffff'ffffU : std::uint32_t{1} << random() % 32;
      std::memcpy(bag.data() + std::min(at, bag.size() - 4), &huge, sizeof huge);
      break;
    }
    default: {
      constexpr const char* kNames[] = {"index_pos=", "conn_count=", "chunk_count=", "chunk_pos=",
                                        "size=",      "count=",      "conn=",        "ver="};
      const std::size_t field = bag.find(kNames[random() % 8], at);
      if (field == std::string::npos) break;
      const std::size_t value = bag.find('=', field) + 1;
      for (std::size_t i = 0; i < 4 && value + i < bag.size(); ++i) {
        bag[value + i] = static_cast<char>(random() % 4 == 0 ? 0xff : random() % 3);
      }
    }
  }
  return bag;
}

long peak_kib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

struct Outcomes {
  int values = 0;
  int refused = 0;
};

struct WholeBag {
  std::string bytes;
  bool is_packed = false;  // so that its chunks carry checksums
  std::vector<Digest> contents;
};

std::vector<WholeBag> whole_bags(std::mt19937& random) {
  using namespace rosbag::compression;
  const ScratchFolder folder;
  const std::string path = (folder / "drive.bag").string();
  std::vector<WholeBag> bags;
  for (const CompressionType compression : {Uncompressed, BZ2, LZ4, Uncompressed, BZ2, LZ4}) {
    write_bag(path, random_messages(random, 12), compression, bags.size() < 3 ? 400 : 3000);
    bags.push_back({*read_text_file(path), compression != Uncompressed, *read_damaged(path)});
  }
  return bags;
}

TEST(BagDamage, EndsWithAValueOrAnErrorUnder20000Faults) {
  constexpr int kFaults = 20'000;
  constexpr std::size_t kPaddedHeader = 4117;  // its padding is half of a small bag
  constexpr long kMostGrowth_kib = 600'000;    // a sanitizer keeps 256 MiB of what was freed
  constexpr std::chrono::seconds kMostForOne{2};
  std::mt19937 random(1);
  const std::vector<WholeBag> bags = whole_bags(random);
  const long before_kib = peak_kib();
  Outcomes outcomes;
  for (int i = 0; i < kFaults; ++i) {
    const WholeBag& bag = bags[static_cast<std::size_t>(i) % bags.size()];
    const std::size_t kept = random() % 8 == 0 ? 7 : kPaddedHeader;
    const std::string changed = bag.bytes.substr(0, kept) + damaged(bag.bytes.substr(kept), random);
    const MemoryFile file(std::as_bytes(std::span(changed)));
    const auto begin = std::chrono::steady_clock::now();
    const std::optional<std::vector<Digest>> contents = read_damaged(file.path());
    ASSERT_LT(std::chrono::steady_clock::now() - begin, kMostForOne) << "fault " << i;
    ++(contents ? outcomes.values : outcomes.refused);
    if (contents && bag.is_packed) {
      ASSERT_EQ(*contents, bag.contents) << "fault " << i;
    }
  }
  const long growth_kib = peak_kib() - before_kib;
  EXPECT_LT(growth_kib, kMostGrowth_kib);
  EXPECT_GT(outcomes.values, 1000);
  EXPECT_GT(outcomes.refused, 10'000);
  std::printf("%d faults: %d times a value, %d errors, peak %ld KiB more\n", kFaults,
              outcomes.values, outcomes.refused, growth_kib);
}

}  // namespace
}  // namespace sightline
