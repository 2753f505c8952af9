#include "formats/release/records.h"

#include <gtest/gtest.h>

#include "tests/formats/release/signed_records.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

constexpr std::int64_t kNow = 1'900'000'000;

ReleaseRecord release(std::uint64_t counter, std::int64_t expires_s = kNow + 1000) {
  Random random(1);
  ReleaseRecord record = random_release(random);
  record.map_id = "town";
  record.deltas.clear();  // cut before one, a record is whole
  record.counter = counter;
  record.expires_s = expires_s;
  return record;
}

Admission offer(const ReleaseRecord& record, const std::vector<std::uint8_t>& signers,
                const RootRecord& root, const VehicleFacts& vehicle) {
  const std::string text = encode(record);
  return admit_and_remember(text, signed_by(text, signers), root, vehicle);
}

VehicleFacts vehicle_that_saw(const ReleaseRecord& record, const std::vector<std::uint8_t>& signers,
                              const RootRecord& root) {
  VehicleFacts vehicle;
  vehicle.now_s = kNow;
  const Admission admission = offer(record, signers, root, vehicle);
  EXPECT_TRUE(admission.record);
  vehicle.seen = admission.seen;
  return vehicle;
}

const RootRecord kOld = root_of({1, 2, 3}, 2);

TEST(SeenState, ReadsWhatItWrites) {
  const std::string text = encode(vehicle_that_saw(release(5), {1, 2}, kOld).seen);
  const SeenState again = value_of(decode_seen_state(text));
  EXPECT_EQ(encode(again), text);
  EXPECT_EQ(again.time_s, kNow);
  EXPECT_EQ(again.keys, kOld.keys);
  EXPECT_EQ(again.release, encode(release(5)));
}

TEST(SeenState, ReadsAReleaseRecordAlone) {
  const SeenState state = value_of(decode_seen_state(encode(release(5))));
  EXPECT_EQ(state.time_s, 0);
  EXPECT_TRUE(state.keys.empty());
}

TEST(SeenState, IsRefusedEmptyAndCutShortAtEveryByte) {
  const std::string text = encode(vehicle_that_saw(release(5), {1, 2}, kOld).seen);
  for (std::size_t size = 0; size < text.size(); ++size) {
    const Error state = failure_of(decode_seen_state(text.substr(0, size)), size);
    EXPECT_EQ(state.code, ErrorCode::kMalformedRecord) << size;
  }
}

TEST(SeenState, NeverCrashesOnDamageAndReadsNothingTwoWays) {
  const std::string text = encode(vehicle_that_saw(release(5), {1, 2}, kOld).seen);
  for (std::size_t i = 0; i < 8 * text.size(); ++i) {
    std::string damaged = text;
    damaged[i / 8] = static_cast<char>(damaged[i / 8] ^ (1 << (i % 8)));
    const Result<SeenState> state = decode_seen_state(damaged);
    if (!state) continue;
    EXPECT_EQ(encode(*state), damaged) << i;
  }
}

TEST(SeenState, AClockThatJumpsBackBringsNothingBack) {
  VehicleFacts vehicle = vehicle_that_saw(release(5), {1, 2}, kOld);
  vehicle.now_s = kNow + 5000;
  const Admission late = offer(release(5), {1, 2}, kOld, vehicle);
  EXPECT_EQ(late.record.error().code, ErrorCode::kExpired);
  EXPECT_EQ(late.seen.time_s, kNow + 1000) << "no later than what was signed";
  vehicle.seen = late.seen;
  vehicle.now_s = kNow - 100'000;
  EXPECT_EQ(offer(release(5), {1, 2}, kOld, vehicle).record.error().code, ErrorCode::kExpired);
  EXPECT_TRUE(offer(release(6, kNow + 1001), {1, 2}, kOld, vehicle).record);
}

TEST(SeenState, AClockThatStandsNeverGoesBehindWhatWasSeen) {
  VehicleFacts vehicle = vehicle_that_saw(release(5), {1, 2}, kOld);
  vehicle.now_s = 0;
  const Admission again = offer(release(5), {1, 2}, kOld, vehicle);
  EXPECT_TRUE(again.record);
  EXPECT_EQ(again.seen.time_s, kNow);
}

TEST(SeenState, ARefusedReleaseIsNotSeen) {
  const VehicleFacts vehicle = vehicle_that_saw(release(5), {1, 2}, kOld);
  for (const auto& signers : std::vector<std::vector<std::uint8_t>>{{1}, {8, 9}}) {
    EXPECT_EQ(encode(offer(release(9), signers, kOld, vehicle).seen), encode(vehicle.seen));
  }
  EXPECT_EQ(encode(offer(release(4), {1, 2}, kOld, vehicle).seen), encode(vehicle.seen));
}

// 2^64 - 1 by stolen keys; TUF 5.3.11.
TEST(SeenState, NewKeysRecoverFromFastForward) {
  const VehicleFacts vehicle = vehicle_that_saw(release(UINT64_MAX), {1, 2}, kOld);
  const RootRecord next = root_of({3, 4, 5}, 2, 2);
  EXPECT_TRUE(begins_anew(next, vehicle.seen));
  const Admission admission = offer(release(6), {4, 5}, next, vehicle);
  ASSERT_TRUE(admission.record);
  VehicleFacts recovered = vehicle;
  recovered.seen = admission.seen;
  EXPECT_FALSE(begins_anew(next, recovered.seen));
  EXPECT_EQ(offer(release(5), {4, 5}, next, recovered).record.error().code,
            ErrorCode::kReplayedRelease);
}

TEST(SeenState, OldRecordsComeBackByNoRotation) {
  const VehicleFacts vehicle = vehicle_that_saw(release(9), {1, 2}, kOld);
  // Two of the old keys stay: what they signed long ago is still valid, so counters are kept.
  for (const auto& numbers :
       std::vector<std::vector<std::uint8_t>>{{1, 2}, {2, 3, 4}, {1, 2, 3, 4}}) {
    EXPECT_FALSE(begins_anew(root_of(numbers, 2, 2), vehicle.seen));
  }
  EXPECT_EQ(offer(release(4), {2, 3}, root_of({2, 3, 4}, 2, 2), vehicle).record.error().code,
            ErrorCode::kReplayedRelease);
  // One stays, but one is enough.
  EXPECT_FALSE(begins_anew(root_of({3, 4}, 1, 2), vehicle.seen));
}

TEST(SeenState, RetiredKeysThatComeBackResetNothing) {
  VehicleFacts vehicle = vehicle_that_saw(release(9), {1, 2}, kOld);
  vehicle.seen = offer(release(1), {4, 5}, root_of({4, 5, 6}, 2, 2), vehicle).seen;
  EXPECT_EQ(vehicle.seen.keys.size(), 6U);
  EXPECT_FALSE(begins_anew(root_of({1, 2, 7}, 2, 3), vehicle.seen));
  EXPECT_TRUE(begins_anew(root_of({1, 7, 8}, 2, 3), vehicle.seen));
}

}  // namespace
}  // namespace sightline
