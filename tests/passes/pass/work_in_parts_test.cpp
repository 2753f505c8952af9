#include "passes/pass/work_in_parts.h"

#include <gtest/gtest.h>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "formats/base/bytes.h"
#include "formats/base/hash.h"
#include "tests/support/kept_parts.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

class Squares {
 public:
  explicit Squares(std::size_t count) : squares_(count) {
    ctx_.saved_part = [this](const PartName& part) -> std::optional<std::vector<std::byte>> {
      const std::lock_guard<std::mutex> lock(mutex_);
      const auto found = store_.find(part.number);
      return found == store_.end() ? std::nullopt : std::optional(found->second);
    };
    ctx_.part_sink = [this](const PartName& part, std::span<const std::byte> bytes) {
      const std::lock_guard<std::mutex> lock(mutex_);
      store_[part.number].assign(bytes.begin(), bytes.end());
    };
    ctx_.parts_sink = [this](std::span<const PartName> reported) { reported_ = reported.size(); };
  }

  // Fails at `broken`, none where it is negative.
  Result<void> run(WorkShare share = {}, int threads = 1, int broken = -1) {
    made_.clear();
    ctx_.share = share;
    PartedWork work;
    work.count = squares_.size();
    work.order = order_;
    work.make = [&](std::size_t part, int may_use) -> Result<std::vector<std::byte>> {
      const std::lock_guard<std::mutex> lock(mutex_);
      made_.push_back(part);
      threads_of_[part] = may_use;
      if (static_cast<int>(part) >= broken && broken >= 0) {
        return Error{ErrorCode::kNoOverlap, "part " + std::to_string(part)};
      }
      ByteWriter writer;
      writer.put<std::uint64_t>(part * part);
      return writer.take();
    };
    work.take = [&](std::size_t part, std::span<const std::byte> bytes) {
      ByteReader reader(bytes);
      squares_[part] = reader.get<std::uint64_t>();
      return reader.at_end();
    };
    return work_in_parts(ctx_, work, threads);
  }

  void expect_squares() const {
    for (std::size_t i = 0; i < squares_.size(); ++i) EXPECT_EQ(squares_[i], i * i);
  }
  [[nodiscard]] const std::vector<std::size_t>& made() const { return made_; }
  [[nodiscard]] std::size_t reported() const { return reported_; }
  std::map<std::size_t, std::vector<std::byte>>& store() { return store_; }
  void have_threads(int threads) { ctx_.threads = threads; }
  void stand_apart() { order_ = PartOrder::kApart; }
  [[nodiscard]] const std::map<std::size_t, int>& threads_of() const { return threads_of_; }

 private:
  PassContext ctx_;
  std::mutex mutex_;
  std::map<std::size_t, std::vector<std::byte>> store_;
  std::vector<std::uint64_t> squares_;
  std::vector<std::size_t> made_;
  std::map<std::size_t, int> threads_of_;
  std::size_t reported_ = 0;
  PartOrder order_ = PartOrder::kSideBySide;
};

TEST(WorkInParts, MakesEveryPartOnce) {
  for (const std::size_t count : std::vector<std::size_t>{0, 1, 7, 100}) {
    Squares squares(count);
    ASSERT_TRUE(squares.run({}, 3));
    squares.expect_squares();
    EXPECT_EQ(squares.made().size(), count);
    EXPECT_EQ(squares.reported(), count);
    ASSERT_TRUE(squares.run());
    EXPECT_TRUE(squares.made().empty()) << "what is there is taken";
    squares.expect_squares();
  }
}

TEST(WorkInParts, BeginsWithItsShareAndGoesOnBackwards) {
  Squares squares(7);
  ASSERT_TRUE(squares.run({1, 3}));
  EXPECT_EQ(squares.made(), (std::vector<std::size_t>{2, 3, 1, 0, 6, 5, 4}));
  squares.expect_squares();
}

TEST(WorkInParts, SharesHaveEachPartOnce) {
  for (const std::size_t count : std::vector<std::size_t>{0, 1, 5, 64, 65}) {
    std::vector<int> begun(count);
    for (std::size_t number = 0; number < 7; ++number) {
      Squares squares(count);
      ASSERT_TRUE(squares.run({number, 7}));
      const std::size_t own = count * (number + 1) / 7 - count * number / 7;
      for (std::size_t i = 0; i < own; ++i) ++begun[squares.made()[i]];
    }
    EXPECT_EQ(begun, std::vector<int>(count, 1));
  }
}

TEST(WorkInParts, TheLastPartsMayUseTheThreadsThatHaveNoneOfTheirOwn) {
  using ThreadsOf = std::map<std::size_t, int>;
  Squares few(3);
  few.have_threads(8);
  ASSERT_TRUE(few.run({}, 2));
  EXPECT_EQ(few.threads_of(), (ThreadsOf{{0, 4}, {1, 4}, {2, 8}}));
  Squares many(6);
  many.have_threads(4);
  ASSERT_TRUE(many.run({}, 0));
  EXPECT_EQ(many.threads_of(), (ThreadsOf{{0, 1}, {1, 1}, {2, 1}, {3, 1}, {4, 2}, {5, 4}}));
}

TEST(WorkInParts, MakesADamagedPartAnew) {
  Squares squares(5);
  ASSERT_TRUE(squares.run());
  squares.store()[3].pop_back();
  ASSERT_TRUE(squares.run());
  EXPECT_EQ(squares.made(), std::vector<std::size_t>{3});
  squares.expect_squares();
}

// Whatever the threads do: each has at most one part in its hands when the first fails.
TEST(WorkInParts, StopsAfterTheFirstFailureAndKeepsWhatIsBeforeIt) {
  for (const int threads : {1, 4}) {
    Squares squares(200);
    EXPECT_EQ(failure_of(squares.run({}, threads, 11)).message, "part 11");
    EXPECT_EQ(squares.store().size(), 11U);
    EXPECT_LE(squares.made().size(), 11U + static_cast<std::size_t>(threads));
  }
}

TEST(WorkInParts, OfItsOwnShareFailsBeforeItTakesAnother) {
  for (const int threads : {1, 4}) {
    Squares squares(20);
    const Error failed = failure_of(squares.run({2, 3}, threads, 11));
    EXPECT_EQ(failed.message, "part 13") << "its share begins there";
    EXPECT_TRUE(squares.store().empty());
    Squares backwards(20);
    const Error later = failure_of(backwards.run({0, 3}, threads, 11));
    EXPECT_EQ(later.message, "part 19") << "of the others it comes first";
    EXPECT_EQ(backwards.store().size(), 6U);
  }
}

TEST(WorkInParts, ThatStandApartStopAfterAFailureToo) {
  for (const int threads : {1, 4}) {
    Squares squares(200);
    squares.stand_apart();
    const Error failed = failure_of(squares.run({}, threads, 0));
    EXPECT_TRUE(squares.store().empty());
    EXPECT_LE(squares.made().size(), static_cast<std::size_t>(threads));
    EXPECT_TRUE(threads > 1 || failed.message == "part 0") << failed.message;
  }
}

class Texts {
 public:
  std::vector<std::size_t> run(const std::vector<std::string>& texts) {
    std::vector<std::size_t> made;
    PartedWork work;
    work.count = texts.size();
    work.content = [&](std::size_t part) { return sha256(texts[part]); };
    work.make = [&](std::size_t part, int /*threads*/) -> Result<std::vector<std::byte>> {
      made.push_back(part);
      ByteWriter writer;
      writer.put_string(texts[part]);
      return writer.take();
    };
    work.take = [&](std::size_t part, std::span<const std::byte> bytes) {
      ByteReader reader(bytes);
      std::string text;
      reader.get_string(text);
      return reader.at_end() && text == texts[part];
    };
    PassContext ctx = kept_.context();
    EXPECT_TRUE(work_in_parts(ctx, work, 1));
    return made;
  }
  [[nodiscard]] const std::vector<PartName>& reported() const { return kept_.names(); }

 private:
  KeptParts kept_;
};

TEST(WorkInParts, FindsWhatItMadeOfTheSameContentWhereverThatIs) {
  Texts texts;
  EXPECT_EQ(texts.run({"a", "b", "c"}), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(texts.run({"c", "x", "a", "b"}), std::vector<std::size_t>{1});
  ASSERT_EQ(texts.reported().size(), 4U);
  EXPECT_EQ(texts.reported()[3].number, 3U);
  EXPECT_EQ(texts.reported()[3].content, sha256("b"));
}

// Two parts begin side by side, where neither ends before the other has begun.
TEST(WorkInParts, ThatStandApartBeginInStretchesOfTheirOwn) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "one thread";
  constexpr std::size_t kCount = 10;
  std::mutex mutex;
  std::condition_variable has_begun;
  std::set<std::size_t> begun;
  PartedWork work;
  work.count = kCount;
  work.order = PartOrder::kApart;
  work.make = [&](std::size_t part, int /*threads*/) -> Result<std::vector<std::byte>> {
    std::unique_lock<std::mutex> lock(mutex);
    begun.insert(part);
    has_begun.notify_all();
    const bool is_first = part == 0 || part == kCount / 2;
    const auto both = [&] { return begun.contains(0) && begun.contains(kCount / 2); };
    if (is_first) {
      EXPECT_TRUE(!both() || begun.size() == 2) << "another came before " << part;
      EXPECT_TRUE(has_begun.wait_for(lock, std::chrono::seconds(30), both)) << part;
    }
    return std::vector<std::byte>(part);
  };
  std::map<std::size_t, std::size_t> taken;
  work.take = [&](std::size_t part, std::span<const std::byte> bytes) {
    const std::lock_guard<std::mutex> lock(mutex);
    ++taken[part];
    return bytes.size() == part;
  };
  ASSERT_TRUE(work_in_parts(TestContext(2), work));
  EXPECT_EQ(taken.size(), kCount);
  for (const auto& [part, times] : taken) EXPECT_EQ(times, 1U) << part;
}

}  // namespace
}  // namespace sightline
