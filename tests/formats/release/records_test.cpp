#include "formats/release/records.h"

#include <gtest/gtest.h>

#include "formats/release/record_text.h"
#include "tests/formats/release/signed_records.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

constexpr const char* kRelease =
    "sightline-release 1\n"
    "fleet metropolis\n"
    "map-id town\n"
    "version 2026.1\n"
    "counter 9\n"
    "expires 2026-12-01T06:30:59Z\n"
    "minimum-reader 1.0\n"
    "sensor 0000000000000000000000000000000000000000000000000000000000000001\n"
    "map-release 7\n"
    "root-digest 00000000000000000000000000000000000000000000000000000000000000ff\n"
    "map town-7.slmap 123 00000000000000000000000000000000000000000000000000000000000000aa\n"
    "delta d.sldelta 45 00000000000000000000000000000000000000000000000000000000000000bb "
    "00000000000000000000000000000000000000000000000000000000000000cc\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

ErrorCode code_of(const std::string& text) { return code_of(decode_release_record(text)); }

TEST(ReleaseRecordText, ReadsWhatIsWrittenByHand) {
  const ReleaseRecord record = value_of(decode_release_record(kRelease));
  EXPECT_EQ(record.counter, 9u);
  EXPECT_EQ(record.expires_s, 1796106659);  // date -u -d 2026-12-01T06:30:59Z +%s
  EXPECT_EQ(record.minimum_major, 1u);
  EXPECT_EQ(record.sensor[31], 1);
  EXPECT_EQ(record.map.name, "town-7.slmap");
  EXPECT_EQ(record.map.size, 123u);
  ASSERT_EQ(record.deltas.size(), 1u);
  EXPECT_EQ(record.deltas[0].file.size, 45u);
  EXPECT_EQ(record.deltas[0].base_sha256[31], 0xcc);
  EXPECT_EQ(encode(record), kRelease);
}

TEST(ReleaseRecordText, RefusesNamesThatLeadElsewhere) {
  for (const char* name : {"../town.slmap", "/etc/passwd", "a/b", "..", ".hidden", "-o", "a\\b",
                           "%2e%2e", "", "town\x01.slmap", "caf\xc3\xa9"}) {
    EXPECT_EQ(code_of(replaced(kRelease, "town-7.slmap", name)), ErrorCode::kUnsafeName) << name;
    EXPECT_EQ(code_of(replaced(kRelease, "d.sldelta", name)), ErrorCode::kUnsafeName) << name;
  }
}

TEST(ReleaseRecordText, HasOneWayToWriteEachValue) {
  const std::string cases[][2] = {{"counter 9", "counter 09"},
                                  {"counter 9", "counter +9"},
                                  {"counter 9", "counter 9 "},
                                  {"counter 9", "counter 0"},
                                  {"counter 9", "counter 18446744073709551616"},
                                  {"2026-12-01T", "2026-12-1T"},
                                  {"2026-12-01T", "2026-02-30T"},
                                  {"06:30:59", "24:00:00"},
                                  {"06:30:59", "06:30:60"},
                                  {"00aa", "00AA"},
                                  {"00aa", "00a"},
                                  {"1.0\n", "1\n"},
                                  {"1.0\n", "01.0\n"},
                                  {"version 2026.1", "version  2026.1"},
                                  {"fleet metropolis\n", ""},
                                  {"\n", "\r\n"},
                                  {"sightline-release 1", "sightline-release 2"},
                                  {" 45 ", "  45 "},
                                  {"map-release 7", "map-release 7\nextra 1"},
                                  {"cc\n", "cc\n\n"},
                                  {"cc\n", "cc"},
                                  {"version 2026.1", "version 2026\t1"}};
  for (const auto& [from, to] : cases) {
    EXPECT_EQ(code_of(replaced(kRelease, from, to)), ErrorCode::kMalformedRecord) << to;
  }
  EXPECT_EQ(code_of(std::string(kRelease) + std::string(70000, 'x')), ErrorCode::kMalformedRecord);
}

TEST(ReleaseRecordText, RandomRecordsReadBackTheSame) {
  Random random(5);
  for (int i = 0; i < 500; ++i) {
    const ReleaseRecord record = random_release(random);
    ASSERT_TRUE(validate(record));
    EXPECT_EQ(value_of(decode_release_record(encode(record))), record);
  }
}

TEST(ReleaseRecordText, WhateverIsAcceptedIsWrittenAgainTheSame) {
  const std::string text = kRelease;
  int accepted = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = text;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      const Result<ReleaseRecord> record = decode_release_record(damaged);
      if (!record) continue;
      ++accepted;  // another record, which no signature fits
      EXPECT_EQ(encode(*record), damaged);
    }
  }
  EXPECT_GT(accepted, 0);
  for (std::size_t size = 0; size < text.size(); ++size) {
    const Result<ReleaseRecord> record =
        decode_release_record(std::string_view(text).substr(0, size));
    // Without its last line it is a whole record too, of no deltas.
    EXPECT_TRUE(!record || encode(*record) == text.substr(0, size)) << "cut at " << size;
  }
}

TEST(RootRecordText, ReadsBackAndRefusesASignerWhoWouldCountTwice) {
  const RootRecord root = root_of({1, 2, 3}, 2);
  EXPECT_EQ(encode(value_of(decode_root_record(encode(root)))), encode(root));

  RootRecord twice = root;
  twice.keys[1].point = twice.keys[0].point;  // another id for the same key
  EXPECT_FALSE(decode_root_record(encode(twice)));
  twice = root;
  twice.keys[1].id = twice.keys[0].id;
  EXPECT_FALSE(decode_root_record(encode(twice)));
  twice = root;
  std::swap(twice.keys[0], twice.keys[1]);
  EXPECT_FALSE(decode_root_record(encode(twice)));
  twice = root;
  twice.threshold = 4;
  EXPECT_FALSE(decode_root_record(encode(twice)));
  twice.threshold = 0;
  EXPECT_FALSE(decode_root_record(encode(twice)));
}

// With these anybody signs anything: the eight points of small order, in every way to write them
// (the list of libsodium), and one that is on no curve.
TEST(RootRecordText, RefusesPointsThatAnybodyCanSignBy) {
  const char* const points[] = {"0000000000000000000000000000000000000000000000000000000000000000",
                                "0100000000000000000000000000000000000000000000000000000000000000",
                                "26e8958fc2b227b045c3f489f2ef98f0d5dfac05d3c63339b13802886d53fc05",
                                "26e8958fc2b227b045c3f489f2ef98f0d5dfac05d3c63339b13802886d53fc85",
                                "c7176a703d4dd84fba3c0b760d10670f2a2053fa2c39ccc64ec7fd7792ac037a",
                                "c7176a703d4dd84fba3c0b760d10670f2a2053fa2c39ccc64ec7fd7792ac03fa",
                                "ecffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff7f",
                                "edffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff7f",
                                "eeffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff7f",
                                "ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff",
                                "0200000000000000000000000000000000000000000000000000000000000000"};
  for (const char* const point : points) {
    RootRecord root = root_of({1}, 1);
    root.keys[0].point = *digest_of_hex(point);
    EXPECT_FALSE(is_sound(root.keys[0])) << point;
    EXPECT_EQ(validate(root).error().code, ErrorCode::kMalformedRecord) << point;
    EXPECT_FALSE(decode_root_record(encode(root))) << point;
  }
  for (std::uint8_t number = 1; number < 50; ++number) {
    EXPECT_TRUE(is_sound(public_key_of(key_of(number))));
  }
}

TEST(Times, AreUtcAndNothingElse) {
  EXPECT_EQ(utc_text(0), "1970-01-01T00:00:00Z");
  EXPECT_EQ(utc_text(951782400), "2000-02-29T00:00:00Z");
  EXPECT_EQ(utc_seconds("2000-02-29T00:00:00Z"), 951782400);
  EXPECT_FALSE(utc_seconds("2001-02-29T00:00:00Z"));
  EXPECT_FALSE(utc_seconds("1969-12-31T23:59:59Z"));
  EXPECT_FALSE(utc_seconds("2026-12-01 00:00:00Z"));
}

}  // namespace
}  // namespace sightline
