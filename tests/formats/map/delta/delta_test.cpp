#include <gtest/gtest.h>

#include <fstream>

#include "formats/base/files/atomic_file.h"
#include "formats/base/random.h"
#include "formats/map/delta/apply_delta.h"
#include "formats/map/delta/delta_format.h"
#include "formats/map/delta/delta_steps.h"
#include "formats/map/delta/make_delta.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/changed_map.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

CompiledMap tiny_map() {
  return random_map(
      {.seed = 2, .site_count = 3, .nd_count = 6, .has_columns = true, .model_size = 90});
}

CompiledMap later(CompiledMap map) {
  map.release += 1;
  map.ndt.nds[0].point_count += 1;
  map.ranges.flags[0] ^= kExtrapolated;
  return map;
}

class Delta : public testing::Test {
 protected:
  Delta() { fs::create_directories(folder_); }
  ~Delta() override { fs::remove_all(folder_); }

  void write(const fs::path& path, std::span<const std::byte> bytes) const {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  Bytes make(const Bytes& base, const Bytes& result, const DeltaOptions& options = {}) const {
    const Result<Bytes> delta = make_delta(base, result, options);
    EXPECT_TRUE(delta) << to_string(delta.error());
    return delta ? *delta : Bytes();
  }
  Result<ApplyReport> apply(const Bytes& base, const Bytes& delta) const {
    write(map_, base);
    write(delta_, delta);
    return apply_delta(delta_, map_);
  }
  void expect_map(const Bytes& expected, const char* what) const {
    EXPECT_TRUE(value_of(read_file(map_)) == expected) << what;
  }
  void expect_refused(const Bytes& base, const Bytes& delta, ErrorCode code) const {
    const Error error = failure_of(apply(base, delta));
    EXPECT_EQ(error.code, code) << to_string(error);
    expect_map(base, "a refused delta leaves the map alone");
  }

  fs::path folder_ = scratch_folder();
  fs::path map_ = folder_ / "town.slmap";
  fs::path delta_ = folder_ / "town.sldelta";
  const Bytes base_ = encode_map(tiny_map());
  const Bytes result_ = encode_map(changed_map(tiny_map(), 1));
};

TEST_F(Delta, MakesTheNewMapByteForByteOverRandomMaps) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    const CompiledMap map = random_map({.seed = seed, .site_count = 50, .nd_count = 200});
    const Bytes base = encode_map(map);
    const Bytes result = seed % 4 == 0 ? encode_map(random_map({.seed = seed + 100}))
                                       : encode_map(changed_map(map, seed, seed % 3 == 0));
    for (const bool is_portable : {false, true}) {
      require(apply(base, make(base, result, {is_portable})));
      expect_map(result, "applied");
    }
  }
}

TEST_F(Delta, BetweenFullAndSmallMapsMakesTheNewMapByteForByte) {
  RandomMapOptions options{.seed = 5, .site_count = 40, .nd_count = 200, .has_columns = true};
  const CompiledMap full = random_map(options);
  options.size = MapSize::kPromise;
  const CompiledMap small = later(random_map(options));
  const Bytes full_file = encode_map(full);
  const Bytes small_file = encode_map(small);
  CompiledMap again = later(small);
  const Bytes again_file = encode_map(again);
  for (const auto& [base, result] : {std::pair(&full_file, &small_file),
                                     {&small_file, &full_file},
                                     {&small_file, &again_file}}) {
    EXPECT_TRUE(apply(*base, make(*base, *result)));
    expect_map(*result, "between sizes");
  }
  EXPECT_LT(make(small_file, again_file).size(), small_file.size() / 2);
}

TEST_F(Delta, OfEqualMapsHoldsNothing) {
  const Bytes base = encode_map(random_map({.seed = 3}));
  EXPECT_LE(make(base, base).size(), kDeltaHeaderSize + kDeltaStepSize);
}

TEST_F(Delta, SendsChangedLayersAlone) {
  CompiledMap map = random_map(
      {.seed = 4, .site_count = 400, .nd_count = 2000, .extent_m = 400.0, .model_size = 30000});
  const Bytes base = encode_map(map);
  for (std::size_t i = 0; i < 20; ++i) map.ndt.nds[i].point_count += 1;
  EXPECT_LT(make(base, encode_map(map)).size(), base.size() / 50);
}

TEST_F(Delta, PacksLayersAnewWhereThatIsSmallerUnlessItShallBePortable) {
  CompiledMap map = random_map({.seed = 5, .nd_count = 900, .extent_m = 30.0});
  const Bytes base = encode_map(map);
  for (std::size_t i = 0; i < map.ndt.nds.size(); i += 20) map.ndt.nds[i].point_count += 1;
  const Bytes result = encode_map(map);
  const Bytes small = make(base, result);
  const Bytes portable = make(base, result, {.is_portable = true});
  EXPECT_LT(small.size(), portable.size() / 2);
  EXPECT_EQ(decode_delta_header(small, small.size())->zstd_version, zstd_version());
  EXPECT_EQ(decode_delta_header(portable, portable.size())->zstd_version, 0u);
  ASSERT_TRUE(apply(base, small));
  expect_map(result, "packed anew");
}

TEST_F(Delta, KeepsTheOldMapAndTakesItBack) {
  ASSERT_TRUE(apply(base_, make(base_, result_)));
  expect_map(result_, "applied");
  EXPECT_FALSE(fs::exists(part_path(map_)));
  EXPECT_EQ(value_of(roll_back(map_)), verify_map(base_)->root_digest);
  expect_map(base_, "taken back");
  EXPECT_EQ(failure_of(roll_back(map_)).code, ErrorCode::kFileNotFound);
  expect_map(base_, "nothing more to take back");
}

// As a kill leaves it between the rename and the end.
TEST_F(Delta, ThatIsNotThereToRollBackToTakesAwayTheEmptyFileOfAKilledRollback) {
  write(map_, encode_map(tiny_map()));
  for (const Bytes& left : {Bytes(), Bytes(7)}) {
    write(part_path(map_), left);
    EXPECT_EQ(roll_back(map_).error().code, ErrorCode::kFileNotFound);
    EXPECT_EQ(fs::exists(part_path(map_)), !left.empty());  // of an update that can go on
  }
}

TEST_F(Delta, DoesNotRollBackToADamagedMap) {
  ASSERT_TRUE(apply(base_, make(base_, result_)));
  Bytes damaged = base_;
  damaged[damaged.size() / 2] ^= std::byte{1};
  write(previous_path(map_), damaged);
  EXPECT_FALSE(roll_back(map_));
  expect_map(result_, "still the new map");
}

TEST_F(Delta, AppliedTwiceSaysThatItWasThere) {
  ASSERT_TRUE(apply(base_, make(base_, result_)));
  EXPECT_TRUE(value_of(apply_delta(delta_, map_)).was_there);
  const Bytes previous = value_of(read_file(previous_path(map_)));
  EXPECT_TRUE(previous == base_) << "the second apply must not lose the map before the first";
}

TEST_F(Delta, ToAnotherFileLeavesTheMapAlone) {
  write(map_, base_);
  write(delta_, make(base_, result_));
  const fs::path out = folder_ / "new.slmap";
  ASSERT_TRUE(apply_delta_to(delta_, map_, out));
  EXPECT_TRUE(*read_file(out) == result_);
  expect_map(base_, "the base");
  EXPECT_EQ(apply_delta_to(delta_, map_, out).error().code, ErrorCode::kOutputExists);
}

TEST_F(Delta, OntoAWrongBaseIsRefused) {
  const Bytes delta = make(base_, result_);
  expect_refused(encode_map(random_map({.seed = 77})), delta, ErrorCode::kWrongBase);
  // The same map without what engineers need has the same root digest, but not the same bytes.
  CompiledMap stripped = tiny_map();
  stripped.factors = {};
  stripped.model.bytes.clear();
  expect_refused(encode_map(stripped), delta, ErrorCode::kWrongBase);
}

TEST_F(Delta, OntoADamagedBaseIsRefused) {
  const Bytes delta = make(base_, result_);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < base_.size(); i += 13) {
    Bytes damaged = base_;
    damaged[i] ^= std::byte(1 << (i % 8));
    const Result<ApplyReport> report = apply(damaged, delta);
    if (report) {
      // The byte is of a layer that did not stay.
      EXPECT_EQ(report->root_digest, verify_map(*read_file(map_))->root_digest);
    } else {
      ++refused;
      expect_map(damaged, "left alone");
    }
  }
  EXPECT_GT(refused, base_.size() / 26);
}

TEST_F(Delta, CutShortAtAnyByteIsRefused) {
  const Bytes delta = make(base_, encode_map(later(tiny_map())));
  write(map_, base_);
  for (std::size_t size = 0; size < delta.size(); ++size) {
    write(delta_, std::span(delta).first(size));
    const Result<ApplyReport> report = apply_delta(delta_, map_);
    ASSERT_FALSE(report) << "accepted at " << size;
    ASSERT_EQ(report.error().code, ErrorCode::kTruncatedFile) << to_string(report.error());
  }
  expect_map(base_, "left alone");
}

TEST_F(Delta, WithOneBitFlippedInAnyByteIsRefused) {
  const Bytes delta = make(base_, encode_map(later(tiny_map())));
  write(map_, base_);
  for (std::size_t i = 0; i < delta.size(); ++i) {
    Bytes damaged = delta;
    damaged[i] ^= std::byte(1 << (i % 8));
    write(delta_, damaged);
    const Result<ApplyReport> report = apply_delta(delta_, map_);
    ASSERT_FALSE(report) << "accepted a flip in byte " << i;
    ASSERT_EQ(error_class(report.error().code), ErrorClass::kCorrupt) << to_string(report.error());
  }
  expect_map(base_, "left alone");
}

TEST_F(Delta, WithBytesAppendedIsRefused) {
  Bytes delta = make(base_, result_);
  delta.push_back(std::byte{0});
  expect_refused(base_, delta, ErrorCode::kOutOfBounds);
}

// Header and steps of a delta, to be sealed again with right checksums: what somebody could make
// who means harm.
struct Parts {
  DeltaHeader header;
  std::vector<DeltaStep> steps;
  Bytes payloads;
};

Parts take_apart(const Bytes& delta) {
  Parts parts;
  parts.header = *decode_delta_header(delta, delta.size());
  const std::size_t steps_size = parts.header.step_count * kDeltaStepSize;
  parts.steps =
      *decode_delta_steps(std::span(delta).subspan(kDeltaHeaderSize, steps_size), parts.header);
  parts.payloads.assign(delta.begin() + static_cast<std::ptrdiff_t>(kDeltaHeaderSize + steps_size),
                        delta.end());
  return parts;
}

Bytes put_together(const Parts& parts) {
  Bytes delta = encode_delta_front(parts.header, parts.steps);
  delta.insert(delta.end(), parts.payloads.begin(), parts.payloads.end());
  return delta;
}

TEST_F(Delta, WithABombInsideIsRefusedBeforeItGoesOff) {
  const Bytes bomb = pack_delta(Bytes(kLargestStep), {});
  ASSERT_LT(bomb.size(), 1000u);
  Parts parts = take_apart(make(base_, result_));
  parts.payloads = bomb;
  parts.steps = {{DeltaStepKind::kPacked, 100, 0, 0, bomb.size(), xxh3(bomb), 1}};
  parts.header.result_size = 100;
  expect_refused(base_, put_together(parts), ErrorCode::kBadDelta);
  parts.steps[0].size = parts.header.result_size = kLargestStep + 1;
  expect_refused(base_, put_together(parts), ErrorCode::kBadDelta);
}

TEST_F(Delta, ThatWouldFillTheDiskIsRefusedBeforeItWrites) {
  Parts parts = take_apart(make(base_, result_));
  parts.header.result_size = kLargestResult + 1;
  expect_refused(base_, put_together(parts), ErrorCode::kTooLarge);
  // Zeros without end, packed small: within all bounds of the format, beyond those of the disk.
  const Bytes zeros(kLargestStep);
  const Bytes packed = pack_delta(zeros, {});
  const DeltaStep step{DeltaStepKind::kPacked, kLargestStep, 0,          0,
                       packed.size(),          xxh3(packed), xxh3(zeros)};
  parts.payloads.clear();
  parts.steps.clear();
  for (std::uint64_t size = 0; size < kLargestResult; size += kLargestStep) {
    parts.steps.push_back(step);
    parts.payloads.insert(parts.payloads.end(), packed.begin(), packed.end());
  }
  parts.header.result_size = kLargestResult;
  if (fs::space(folder_).available < kLargestResult) {
    expect_refused(base_, put_together(parts), ErrorCode::kDiskFull);
    EXPECT_FALSE(fs::exists(part_path(map_)));
  }
  const DeltaStep copy{DeltaStepKind::kCopy, base_.size(), 0, base_.size(), 0, 0, xxh3(base_)};
  parts.steps = {copy, copy};
  parts.payloads.clear();
  parts.header.result_size = 2 * base_.size();
  expect_refused(base_, put_together(parts), ErrorCode::kBadDelta);
}

TEST_F(Delta, ThatAsksForBytesOutsideTheBaseIsRefused) {
  Parts parts = take_apart(make(base_, result_));
  parts.steps = {{DeltaStepKind::kCopy, 64, base_.size() - 32, 64, 0, 0, 0}};
  parts.payloads.clear();
  parts.header.result_size = 64;
  expect_refused(base_, put_together(parts), ErrorCode::kBadDelta);
  parts.steps[0].base_offset = ~std::uint64_t{0} - 31;  // the sum overflows
  expect_refused(base_, put_together(parts), ErrorCode::kBadDelta);
  parts.steps[0].kind = static_cast<DeltaStepKind>(9);
  expect_refused(base_, put_together(parts), ErrorCode::kBadDelta);
}

TEST_F(Delta, FromTheFutureIsRefusedByName) {
  Parts parts = take_apart(make(base_, result_));
  parts.header.major = 2;
  expect_refused(base_, put_together(parts), ErrorCode::kFutureVersion);
  parts.header.major = 1;
  parts.header.incompatible_features = 4;
  expect_refused(base_, put_together(parts), ErrorCode::kUnknownRequiredFeature);
  parts.header.incompatible_features = 0;
  parts.header.zstd_version = 10000;
  parts.header.zstd_level = 15;
  expect_refused(base_, put_together(parts), ErrorCode::kUnknownRequiredFeature);
}

// All bytes of the result are sent as they are, so that its maker can say anything.
Bytes delta_to(const Bytes& base, const Bytes& result, const Digest& root) {
  Parts parts;
  parts.header.base = *identity_of(base);
  parts.header.result_size = result.size();
  parts.header.result_root = root;
  parts.header.result_sha256 = sha256(result);
  parts.steps = {
      {DeltaStepKind::kPlain, result.size(), 0, 0, result.size(), xxh3(result), xxh3(result)}};
  parts.payloads = result;
  return put_together(parts);
}

TEST_F(Delta, ToAMapWhoseLayersDoNotHaveTheirDigestsIsRefused) {
  // Tiles of the new map under digests of the old: what mixing two versions comes to.
  ContainerParts mixed = parts_of(changed_map(tiny_map(), 1));
  const Digest root = verify_map(assemble(mixed))->root_digest;
  mixed.tiles[0].layers = parts_of(tiny_map()).tiles[0].layers;
  const Bytes mixture = assemble(mixed);
  ASSERT_NE(verify_map(mixture)->root_digest, root);
  expect_refused(base_, delta_to(base_, mixture, root), ErrorCode::kDigestMismatch);
  // Bytes of one layer in the place of another's, below the digests of the whole map.
  const Bytes whole = encode_map(random_map({.seed = 6, .site_count = 1, .nd_count = 200}));
  ASSERT_TRUE(apply(base_, delta_to(base_, whole, verify_map(whole)->root_digest)));
  Bytes damaged = whole;
  std::swap_ranges(damaged.begin() + 1024, damaged.begin() + 1088, damaged.begin() + 2048);
  const Error error =
      failure_of(apply(base_, delta_to(base_, damaged, verify_map(whole)->root_digest)));
  EXPECT_EQ(error_class(error.code), ErrorClass::kCorrupt) << to_string(error);
  expect_map(base_, "left alone");
}

TEST_F(Delta, ThatIsRefusedAtItsEndLeavesNoPart) {
  const Bytes whole = encode_map(random_map({.seed = 6, .site_count = 1, .nd_count = 200}));
  Digest other = verify_map(whole)->root_digest;
  other[0] ^= 1;
  expect_refused(base_, delta_to(base_, whole, other), ErrorCode::kDigestMismatch);
  EXPECT_FALSE(fs::exists(part_path(map_)));
  const fs::path out = folder_ / "out.slmap";
  EXPECT_FALSE(apply_delta_to(delta_, map_, out));
  EXPECT_FALSE(fs::exists(part_path(out)));
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(Delta, IsNotReadFromAnythingButARegularFile) {
  write(map_, base_);
  for (const char* endless : {"/dev/zero", "/dev/urandom", "/"}) {
    EXPECT_EQ(failure_of(apply_delta(endless, map_)).code, ErrorCode::kCannotRead) << endless;
  }
}

TEST_F(Delta, FollowsNoLinkThatSomebodyPutInItsWay) {
  const Bytes delta = make(base_, result_);
  const fs::path precious = folder_ / "precious";
  write(precious, base_);
  fs::create_symlink(precious, part_path(map_));
  EXPECT_EQ(apply(base_, delta).error().code, ErrorCode::kCannotOpen);
  fs::remove(part_path(map_));
  fs::create_hard_link(precious, part_path(map_));
  EXPECT_EQ(apply(base_, delta).error().code, ErrorCode::kCannotOpen);
  fs::remove(part_path(map_));
  EXPECT_TRUE(*read_file(precious) == base_);
  // A map that is a link would be replaced by a file, and what it names stay old.
  fs::remove(map_);
  fs::create_symlink(precious, map_);
  EXPECT_EQ(apply_delta(delta_, map_).error().code, ErrorCode::kCannotOpen);
  EXPECT_TRUE(*read_file(precious) == base_);
}

TEST_F(Delta, GoesOnFromAnyByteWhereItWasStopped) {
  const Bytes delta = make(base_, result_);
  Random random(1);
  for (std::size_t size = 0; size <= result_.size(); size += 1 + size % 97) {
    Bytes part(result_.begin(), result_.begin() + static_cast<std::ptrdiff_t>(size));
    for (std::uint64_t i = random.below(300); i > 0; --i) part.push_back(std::byte(random.next()));
    write(part_path(map_), part);
    const Result<ApplyReport> report = apply(base_, delta);
    ASSERT_TRUE(report) << size << ": " << to_string(report.error());
    ASSERT_TRUE(*read_file(map_) == result_) << size;
  }
}

}  // namespace
}  // namespace sightline
