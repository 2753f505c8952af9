#include "compiler/store/cache.h"

#include <gtest/gtest.h>

#include "compiler/store/prune.h"
#include "formats/base/atomic_file.h"
#include "formats/base/temporary_name.h"
#include "tests/support/scratch_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

class Cache : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = scratch_folder();
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  void put(const fs::path& name, std::string_view text) const {
    ASSERT_TRUE(write_file_atomically(folder_ / name, text, IfExists::kReplace));
  }
  [[nodiscard]] fs::path at(const std::string& kind, const Digest& key) const {
    return folder_ / place_of({kind, key});
  }
  fs::path folder_;
  const Digest key_ = sha256("one");
  const Digest other_ = sha256("two");
  const std::vector<std::byte> content_ = std::vector<std::byte>(100, std::byte{7});
};

TEST_F(Cache, GivesBackWhatWasStored) {
  const ArtifactCache cache(folder_);
  EXPECT_EQ(*cache.load("ingest:mapping", key_), ArtifactCache::Content());
  ASSERT_TRUE(cache.store("ingest:mapping", key_, content_));
  EXPECT_EQ(*cache.load("ingest:mapping", key_), content_);
  cache.store_part("measure-error", key_, 3, content_);
  EXPECT_EQ(*cache.load_part("measure-error", key_, 3), content_);
  EXPECT_EQ(*cache.load_part("measure-error", key_, 4), ArtifactCache::Content());
}

TEST_F(Cache, RefusesAnObjectOfAnotherKeyPassOrPart) {
  const ArtifactCache cache(folder_);
  ASSERT_TRUE(cache.store("a", key_, content_));
  cache.store_part("a", key_, 1, content_);
  fs::copy_file(at("a", key_), at("a", other_));
  fs::copy_file(at("a", key_), at("b", key_));
  fs::copy_file(at("a part 1", key_), at("a part 2", key_));
  fs::copy_file(at("a", key_), at("a part 3", key_));
  EXPECT_EQ(cache.load("a", other_).error().code, ErrorCode::kBadLayer);
  EXPECT_EQ(cache.load("b", key_).error().code, ErrorCode::kBadLayer);
  EXPECT_EQ(cache.load_part("a", key_, 2).error().code, ErrorCode::kBadLayer);
  EXPECT_EQ(cache.load_part("a", key_, 3).error().code, ErrorCode::kBadLayer);
  EXPECT_EQ(*cache.load("a", key_), content_);
}

TEST_F(Cache, PrunesWhatIsOfNoUseAndNothingElse) {
  const ArtifactCache cache(folder_);
  for (const char* pass : {"whole", "damaged", "finished"}) {
    ASSERT_TRUE(cache.store(pass, key_, content_));
  }
  cache.store_part("finished", key_, 0, content_);
  cache.store_part("unfinished", key_, 0, content_);
  fs::copy_file(at("whole", key_), at("misplaced", key_));
  put(at("damaged", key_).filename(), "no object");
  put(".sl-elsewhere.1-" + std::string(32, '0') + "-1-1-0", "half");
  put(temporary_name(), "at work");
  for (const char* name : {"mine.tmp", "print.sla", "whole.last", "notes.txt"}) put(name, "mine");
  const Result<CacheContents> contents = look_at_cache(folder_);
  ASSERT_TRUE(contents);
  EXPECT_EQ(contents->object_count, 3U);
  EXPECT_EQ(contents->busy_count, 1U);
  EXPECT_EQ(contents->useless.size(), 4U);
  ASSERT_TRUE(prune_cache(*contents));
  EXPECT_FALSE(fs::exists(at("misplaced", key_)));
  EXPECT_FALSE(fs::exists(at("damaged", key_)));
  EXPECT_FALSE(fs::exists(at("finished part 0", key_).parent_path()));
  EXPECT_EQ(*cache.load("whole", key_), content_);
  EXPECT_EQ(*cache.load_part("unfinished", key_, 0), content_);
  EXPECT_EQ(look_at_cache(folder_)->useless.size(), 0U);
  for (const char* name : {"mine.tmp", "print.sla", "whole.last", "notes.txt"}) {
    EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  }
  EXPECT_EQ(look_at_cache(folder_ / "missing").error().code, ErrorCode::kFileNotFound);
}

}  // namespace
}  // namespace sightline
