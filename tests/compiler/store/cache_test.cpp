#include "compiler/store/cache.h"

#include <gtest/gtest.h>
#include <chrono>
#include <string_view>

#include "compiler/store/prune.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/files/temporary_name.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

class Cache : public TestInFolder {
 protected:
  void put(const fs::path& name, std::string_view text) const {
    ASSERT_TRUE(write_file_atomically(folder_ / name, text, IfExists::kReplace));
  }
  [[nodiscard]] fs::path at(const std::string& kind, const Digest& key) const {
    return folder_ / place_of({kind, key});
  }
  const Digest key_ = sha256("one");
  const Digest other_ = sha256("two");
  const std::vector<std::byte> content_ = std::vector<std::byte>(100, std::byte{7});
};

TEST_F(Cache, GivesBackWhatWasStored) {
  const ArtifactCache cache(folder_);
  EXPECT_EQ(*cache.load("ingest:mapping", key_), ArtifactCache::Content());
  ASSERT_TRUE(cache.store("ingest:mapping", key_, content_));
  EXPECT_EQ(*cache.load("ingest:mapping", key_), content_);
  EXPECT_EQ(*cache.load("ingest:localization", key_), content_) << "what one pass makes of equals";
  EXPECT_EQ(*cache.load("inspect", key_), ArtifactCache::Content());
  cache.store_part("measure-error:own", key_, content_);
  EXPECT_EQ(*cache.load_part("measure-error", key_), content_) << "the same work";
  EXPECT_EQ(*cache.load_part("measure-error", other_), ArtifactCache::Content());
}

TEST_F(Cache, CountsThePartsThatAreThere) {
  const ArtifactCache cache(folder_);
  EXPECT_FALSE(cache.part_count("a", key_));
  cache.store_part_list("a", key_, std::vector<Digest>{key_, other_, sha256("three")});
  cache.store_part("a", other_, content_);
  cache.store_part("a", sha256("of another step"), content_);
  const auto count = cache.part_count("a", key_);
  ASSERT_TRUE(count);
  EXPECT_EQ(count->all, 3U);
  EXPECT_EQ(count->there, 1U);
  EXPECT_FALSE(cache.part_count("a", other_));
  // What the pass reports later is kept beside it, and what it reported before counts once.
  const auto first_list = read_file(folder_ / place_of({"a part list", key_}));
  cache.store_part_list("a", key_, std::vector<Digest>{other_, sha256("four")}, 1);
  cache.store_part_list("a", key_, std::vector<Digest>{sha256("five")}, 2);
  EXPECT_EQ(cache.part_count("a", key_)->all, 5U);
  EXPECT_EQ(cache.part_count("a", key_)->there, 1U);
  EXPECT_EQ(*read_file(folder_ / place_of({"a part list", key_})), *first_list);
  EXPECT_EQ(look_at_cache(folder_)->useless.size(), 0U) << "each at its place";
  put(place_of({"a part list", key_}), "damaged");
  EXPECT_FALSE(cache.part_count("a", key_));
}

TEST_F(Cache, RefusesAnObjectOfAnotherKeyPassOrPart) {
  const ArtifactCache cache(folder_);
  ASSERT_TRUE(cache.store("a", key_, content_));
  cache.store_part("a", key_, content_);
  fs::copy_file(at("a", key_), at("a", other_));
  fs::copy_file(at("a", key_), at("b", key_));
  fs::copy_file(at("a part", key_), at("a part", other_));
  fs::copy_file(at("a", key_), at("a part", sha256("three")));
  EXPECT_EQ(cache.load("a", other_).error().code, ErrorCode::kBadLayer);
  EXPECT_EQ(cache.load("b", key_).error().code, ErrorCode::kBadLayer);
  EXPECT_EQ(cache.load_part("a", other_).error().code, ErrorCode::kBadLayer);
  EXPECT_EQ(cache.load_part("a", sha256("three")).error().code, ErrorCode::kBadLayer);
  EXPECT_EQ(*cache.load("a", key_), content_);
}

TEST_F(Cache, PrunesWhatIsOfNoUseAndNothingElse) {
  const ArtifactCache cache(folder_);
  for (const char* pass : {"whole", "damaged"}) {
    ASSERT_TRUE(cache.store(pass, key_, content_));
  }
  cache.store_part("whole", key_, content_);
  cache.store_part("whole", other_, content_);
  cache.store_part_list("whole", key_, std::vector<Digest>{key_, other_});
  put(at("whole part", other_).lexically_relative(folder_), "no part");
  fs::copy_file(at("whole", key_), at("misplaced", key_));
  put(at("damaged", key_).filename(), "no object");
  put(".sl-elsewhere.1-" + std::string(32, '0') + "-1-1-0", "half");
  put(temporary_name(), "at work");
  for (const char* name : {"mine.tmp", "print.sla", "whole.last", "notes.txt"}) put(name, "mine");
  const CacheContents contents = value_of(look_at_cache(folder_));
  EXPECT_EQ(contents.object_count, 3U);
  EXPECT_EQ(contents.busy_count, 1U);
  EXPECT_EQ(contents.useless.size(), 4U);
  ASSERT_TRUE(prune_cache(contents));
  EXPECT_FALSE(fs::exists(at("misplaced", key_)));
  EXPECT_FALSE(fs::exists(at("damaged", key_)));
  EXPECT_FALSE(fs::exists(at("whole part", other_)));
  EXPECT_EQ(*cache.load("whole", key_), content_);
  EXPECT_EQ(*cache.load_part("whole", key_), content_);
  EXPECT_EQ(cache.part_count("whole", key_)->there, 1U);
  EXPECT_EQ(look_at_cache(folder_)->useless.size(), 0U);
  for (const char* name : {"mine.tmp", "print.sla", "whole.last", "notes.txt"}) {
    EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  }
  EXPECT_EQ(look_at_cache(folder_ / "missing").error().code, ErrorCode::kFileNotFound);
}

void grow_old(const fs::path& path) {
  fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(240));
}

TEST_F(Cache, RemovesWhatNoRunUsedForLongWhereItIsAsked) {
  const ArtifactCache cache(folder_);
  for (const Digest& key : {key_, other_}) {
    ASSERT_TRUE(cache.store("pass", key, content_));
    ASSERT_TRUE(cache.store_warnings("pass", key, {"a warning"}));
    const Digest later = derived_digest("reported later", key, {});
    cache.store_part_list("pass", key, std::vector<Digest>{key});
    cache.store_part_list("pass", key, std::vector<Digest>{later}, 1);
    cache.store_part("pass", key, content_);
    cache.store_part("pass", later, content_);
  }
  for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
    if (entry.is_regular_file()) grow_old(entry.path());
  }
  EXPECT_EQ(look_at_cache(folder_)->unused.size(), 0U) << "not requested";
  EXPECT_EQ(look_at_cache(folder_, std::chrono::hours(480))->unused.size(), 0U);
  cache.mark_used("pass", other_);
  const CacheContents contents = value_of(look_at_cache(folder_, std::chrono::hours(120)));
  EXPECT_EQ(contents.unused.size(), 6U);
  EXPECT_EQ(contents.object_count, 6U);
  ASSERT_TRUE(prune_cache(contents));
  EXPECT_FALSE(cache.has("pass", key_));
  EXPECT_EQ(*cache.load_part("pass", key_), ArtifactCache::Content());
  EXPECT_FALSE(cache.part_count("pass", key_));
  EXPECT_EQ(*cache.load("pass", other_), content_);
  EXPECT_EQ(*cache.load_part("pass", other_), content_) << "the part of a list that is used";
  EXPECT_EQ(cache.part_count("pass", other_)->there, 2U);
  EXPECT_EQ(cache.load_warnings("pass", other_).size(), 1U);
}

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

const ObjectName kName{"measure-error part 3", sha256("key")};

std::vector<std::byte> sealed(std::string_view content) {
  std::vector<std::byte> object;
  const auto bytes = bytes_of(content);
  const auto byte_by_byte = [&](const ByteSink& sink) -> Result<void> {
    for (const std::byte& byte : bytes) SIGHTLINE_TRY(sink(std::span(&byte, 1)));
    return {};
  };
  EXPECT_TRUE(write_sealed(kName, byte_by_byte, [&](std::span<const std::byte> piece) {
    object.insert(object.end(), piece.begin(), piece.end());
    return Result<void>();
  }));
  return object;
}

Result<SealedObject> open_object(std::vector<std::byte> bytes) {
  return open_object(StoredBytes(std::move(bytes)));
}

TEST(SealedObject, SaysWhatItIsAndHoldsWhatWasSealed) {
  for (const std::string_view content : {"", "x", "some content"}) {
    const std::vector<std::byte> object = sealed(content);
    const SealedObject opened = value_of(open_object(object));
    EXPECT_EQ(opened.name, kName);
    EXPECT_EQ(*opened.content.read(0, opened.content.size()), bytes_of(content));
  }
}

TEST(SealedObject, IsRefusedCutShortAtEveryByte) {
  const std::vector<std::byte> object = sealed("some content");
  for (std::size_t size = 0; size < object.size(); ++size) {
    const auto cut = object.begin() + static_cast<std::ptrdiff_t>(size);
    EXPECT_FALSE(open_object(std::vector(object.begin(), cut))) << size;
    EXPECT_FALSE(open_object(std::vector(cut + 1, object.end()))) << size;
  }
}

TEST(SealedObject, IsRefusedDamagedAtEveryBit) {
  const std::vector<std::byte> object = sealed("some content");
  for (std::size_t i = 0; i < 8 * object.size(); ++i) {
    std::vector<std::byte> damaged = object;
    damaged[i / 8] ^= std::byte{1} << (i % 8);
    EXPECT_FALSE(open_object(damaged)) << i;
  }
}

}  // namespace
}  // namespace sightline
