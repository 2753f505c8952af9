#include "formats/release/admission.h"

#include <gtest/gtest.h>

#include <functional>

#include <filesystem>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_writer.h"
#include "formats/release/record_text.h"
#include "tests/formats/map/random_map.h"
#include "tests/formats/release/signed_records.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

constexpr std::int64_t kNow = 1'900'000'000;

ReleaseRecord small_release(std::uint64_t counter = 5) {
  Random random(counter);
  ReleaseRecord record = random_release(random);
  record.map_id = "town";
  record.counter = counter;
  record.expires_s = kNow + 1000;
  return record;
}

struct Offer {
  std::string text;
  std::string signatures;
};

Offer offer_of(const ReleaseRecord& record, const std::vector<std::uint8_t>& signers = {1, 2}) {
  return {encode(record), signed_by(encode(record), signers)};
}

ErrorCode code_of(const Offer& offer, const VehicleFacts& vehicle,
                  const RootRecord& root = root_of({1, 2, 3}, 2)) {
  return code_of(admit_release(offer.text, offer.signatures, root, vehicle));
}

VehicleFacts vehicle_at(std::int64_t now_s = kNow) {
  VehicleFacts vehicle;
  vehicle.now_s = now_s;
  return vehicle;
}

TEST(Admission, TakesAReleaseSignedByTheThreshold) {
  const ReleaseRecord record = small_release();
  EXPECT_EQ(code_of(offer_of(record, {1, 2}), vehicle_at()), ErrorCode{});
  EXPECT_EQ(code_of(offer_of(record, {3, 9, 2}), vehicle_at()), ErrorCode{}) << "9 is skipped";
}

TEST(Admission, RefusesTooFewOrForeignSigners) {
  const ReleaseRecord record = small_release();
  EXPECT_EQ(code_of(offer_of(record, {1}), vehicle_at()), ErrorCode::kTooFewSignatures);
  EXPECT_EQ(code_of(offer_of(record, {1, 1, 1}), vehicle_at()), ErrorCode::kTooFewSignatures);
  EXPECT_EQ(code_of(offer_of(record, {1, 8, 9}), vehicle_at()), ErrorCode::kTooFewSignatures);
  EXPECT_EQ(code_of(offer_of(record, {8, 9}), vehicle_at()), ErrorCode::kWrongKey);
  EXPECT_EQ(code_of({encode(record), ""}, vehicle_at()), ErrorCode::kMalformedSignature);
}

TEST(Admission, RefusesEveryRecordChangedAfterItWasSigned) {
  const Offer offer = offer_of(small_release());
  for (std::size_t i = 0; i < offer.text.size(); ++i) {
    Offer damaged = offer;
    damaged.text[i] = static_cast<char>(damaged.text[i] ^ (1 << (i % 8)));
    EXPECT_EQ(code_of(damaged, vehicle_at()), ErrorCode::kBadSignature) << i;
    damaged.text = offer.text.substr(0, i);
    EXPECT_EQ(code_of(damaged, vehicle_at()), ErrorCode::kBadSignature) << i;
  }
}

TEST(Admission, RefusesOlderReleasesAndASecondOneWithTheSameCounter) {
  VehicleFacts vehicle = vehicle_at();
  vehicle.seen.release = encode(small_release(5));
  EXPECT_EQ(code_of(offer_of(small_release(4)), vehicle), ErrorCode::kReplayedRelease);
  EXPECT_EQ(code_of(offer_of(small_release(5)), vehicle), ErrorCode{});
  EXPECT_EQ(code_of(offer_of(small_release(6)), vehicle), ErrorCode{});
  ReleaseRecord other = small_release(5);
  other.map.size += 1;
  EXPECT_EQ(code_of(offer_of(other), vehicle), ErrorCode::kReplayedRelease);
}

TEST(Admission, RefusesWhatHasExpired) {
  const Offer offer = offer_of(small_release());
  EXPECT_EQ(code_of(offer, vehicle_at(kNow + 999)), ErrorCode{});
  EXPECT_EQ(code_of(offer, vehicle_at(kNow + 1000)), ErrorCode::kExpired);
  RootRecord old = root_of({1, 2, 3}, 2);
  old.expires_s = kNow;
  EXPECT_EQ(code_of(offer, vehicle_at(), old), ErrorCode::kExpired);
}

TEST(Admission, RefusesWhatIsForAnotherFleetMapSensorOrReader) {
  ReleaseRecord record = small_release();
  record.fleet = "gotham";
  EXPECT_EQ(code_of(offer_of(record), vehicle_at()), ErrorCode::kWrongFleet);
  record = small_release();
  VehicleFacts vehicle = vehicle_at();
  vehicle.map_id = "village";
  EXPECT_EQ(code_of(offer_of(record), vehicle), ErrorCode::kWrongFleet);
  vehicle = vehicle_at();
  vehicle.sensor = Digest{};
  EXPECT_EQ(code_of(offer_of(record), vehicle), ErrorCode::kWrongSensor);
  vehicle.sensor = record.sensor;
  EXPECT_EQ(code_of(offer_of(record), vehicle), ErrorCode{});
  record.minimum_major = 2;
  EXPECT_EQ(code_of(offer_of(record), vehicle), ErrorCode::kFutureVersion);
}

ErrorCode rotation_code(const RootRecord& next, const std::vector<std::uint8_t>& signers) {
  const std::string text = encode(next);
  return code_of(next_root(root_of({1, 2, 3}, 2, 4), text, signed_by(text, signers)));
}

TEST(Rotation, NeedsTheThresholdOfOldAndOfNewKeys) {
  const RootRecord next = root_of({3, 4, 5}, 2, 5);
  EXPECT_EQ(rotation_code(next, {2, 3, 4}), ErrorCode{});
  EXPECT_EQ(rotation_code(next, {1, 2, 4, 5}), ErrorCode{});
  EXPECT_EQ(rotation_code(next, {3, 4}), ErrorCode::kTooFewSignatures) << "one old key";
  EXPECT_EQ(rotation_code(next, {2, 3}), ErrorCode::kTooFewSignatures) << "one new key";
  EXPECT_EQ(rotation_code(next, {1, 2}), ErrorCode::kWrongKey) << "no new key";
  EXPECT_EQ(rotation_code(next, {4, 5}), ErrorCode::kWrongKey) << "no old key";
}

TEST(Rotation, GoesOneVersionAtATimeWithinOneFleet) {
  EXPECT_EQ(rotation_code(root_of({1, 2}, 2, 4), {1, 2}), ErrorCode::kRootOutOfOrder);
  EXPECT_EQ(rotation_code(root_of({1, 2}, 2, 6), {1, 2}), ErrorCode::kRootOutOfOrder);
  RootRecord other = root_of({1, 2}, 2, 5);
  other.fleet = "gotham";
  EXPECT_EQ(rotation_code(other, {1, 2}), ErrorCode::kWrongFleet);
}

TEST(Rotation, RefusesEveryRootChangedAfterItWasSigned) {
  const RootRecord trusted = root_of({1, 2, 3}, 2, 4);
  const std::string text = encode(root_of({3, 4, 5}, 2, 5));
  const std::string signatures = signed_by(text, {2, 3, 4});
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string damaged = text;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    EXPECT_FALSE(next_root(trusted, damaged, signatures)) << i;
    EXPECT_FALSE(next_root(trusted, text.substr(0, i), signatures)) << i;
  }
}

TEST(Rotation, MakesReleasesOfRetiredKeysWorthless) {
  const RootRecord next = root_of({3, 4, 5}, 2, 5);
  EXPECT_EQ(code_of(offer_of(small_release(), {1, 2}), vehicle_at(), next), ErrorCode::kWrongKey);
  EXPECT_EQ(code_of(offer_of(small_release(), {3, 4}), vehicle_at(), next), ErrorCode{});
}

class MapOnDisk : public TestInFolder {
 protected:
  MapOnDisk() {
    write(file_);
    record_ = value_of(release_of_map(path()));
  }

  [[nodiscard]] std::filesystem::path path() const { return folder_ / "town.slmap"; }
  void write(const std::vector<std::byte>& bytes) const {
    ASSERT_TRUE(write_file_atomically(path(), bytes, IfExists::kReplace));
  }
  [[nodiscard]] ErrorCode checked() const { return code_of(check_map(path(), record_)); }

  std::vector<std::byte> file_ =
      encode_map(random_map({.seed = 3, .site_count = 5, .nd_count = 8}));
  ReleaseRecord record_;
};

TEST_F(MapOnDisk, IsTheReleasedOneOrRefused) {
  EXPECT_EQ(checked(), ErrorCode{});
  file_.push_back(std::byte{0});
  write(file_);
  EXPECT_EQ(checked(), ErrorCode::kLongerThanReleased);
  file_.resize(file_.size() - 2);
  write(file_);
  EXPECT_EQ(checked(), ErrorCode::kNotAsReleased);
  write(encode_map(random_map({.seed = 4, .site_count = 5, .nd_count = 8})));
  EXPECT_NE(checked(), ErrorCode{});
}

TEST_F(MapOnDisk, IsRefusedWhenItsManifestIsNotTheOneReleased) {
  const ReleaseRecord right = record_;
  for (const auto& change : std::vector<std::function<void(ReleaseRecord&)>>{
           [](ReleaseRecord& record) { record.version = "2027.1"; },
           [](ReleaseRecord& record) { record.map_id = "other"; },
           [](ReleaseRecord& record) { record.map_release += 1; },
           [](ReleaseRecord& record) { record.root_digest[0] ^= 1; },
           [](ReleaseRecord& record) { record.sensor[0] ^= 1; }}) {
    record_ = right;
    change(record_);
    EXPECT_EQ(checked(), ErrorCode::kNotAsReleased);
  }
}

TEST_F(MapOnDisk, DecidesWhatToFetch) {
  EXPECT_EQ(to_text(plan_fetch(path(), record_)), "nothing");
  ReleaseRecord next = record_;
  next.map = {"new.slmap", 7, Digest{}};
  EXPECT_EQ(to_text(plan_fetch(path(), next)).substr(0, 16), "map new.slmap 7 ");
  next.deltas = {{{"d.sldelta", 3, Digest{}}, record_.map.sha256}};
  EXPECT_EQ(to_text(plan_fetch(path(), next)).substr(0, 18), "delta d.sldelta 3 ");
  EXPECT_EQ(to_text(plan_fetch("", next)).substr(0, 4), "map ");
  EXPECT_EQ(to_text(plan_fetch(folder_ / "missing", next)).substr(0, 4), "map ");
}

}  // namespace
}  // namespace sightline
