#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "formats/record/cells.h"
#include "formats/record/field_texts.h"
#include "formats/record/fields.h"
#include "tests/support/artifact_checks.h"
#include "tests/support/value_of.h"

namespace sightline {

enum class Weather : std::uint8_t { kDry, kWet };
template <>
inline constexpr auto kNamesOf<Weather> = enum_names("dry", "wet");

struct Stop {
  std::string name;
  double s_m = 0.0;
  friend bool operator==(const Stop&, const Stop&) = default;
};
SIGHTLINE_FIELDS(Stop, name, s_m)

struct Journey {
  std::uint32_t number = 0;
  bool is_return = false;
  Weather weather = Weather::kDry;
  std::optional<double> wait_s;
  Stop first;
  std::vector<Stop> stops;
  std::vector<float> speeds_m_per_s;
  std::vector<std::string> notes;
  std::vector<std::pair<std::string, std::string>> parameters;
  std::array<std::uint8_t, 2> code{};
  Eigen::Vector3d begin_m = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> line_m;
  std::vector<Journey> branches;
  friend bool operator==(const Journey&, const Journey&) = default;
};
SIGHTLINE_FIELDS(Journey, number, is_return, weather, wait_s, first, stops, speeds_m_per_s, notes,
                 parameters, code, begin_m, line_m, branches)
SIGHTLINE_ARTIFACT(Journey, "journey", 1)

Result<void> validate(const Journey& /*journey*/) { return {}; }

Table dump(const Journey& journey) {
  Table table = table_of("journey", journey.stops);
  append_facts(journey, table);
  return table;
}

namespace {

using testing::ElementsAre;
using testing::Pair;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Journey some_journey() {
  Journey journey;
  journey.number = 7;
  journey.is_return = true;
  journey.weather = Weather::kWet;
  journey.wait_s = 1.5;
  journey.first = {"gate", 2.0};
  journey.stops = {{"bridge", 10.0}, {"mill", 20.0}};
  journey.speeds_m_per_s = {1.0F, 2.5F};
  journey.notes = {"slow", ""};
  journey.parameters = {{"leaf_m", "1"}};
  journey.code = {3, 4};
  journey.begin_m = {1.0, -2.0, 3.0};
  journey.line_m = {{0.0, 0.0, 1.0}, {4.0, 5.0, 6.0}};
  journey.branches.resize(2);
  journey.branches[1].stops = {{"end", 1.0}};
  return journey;
}

bool is_readable(std::span<const std::byte> payload) {
  ByteReader reader(payload);
  Journey journey;
  decode(reader, journey);
  return reader.at_end();
}

TEST(Record, SurvivesTheDisk) { expect_survives_disk(some_journey()); }

TEST(Record, IsReadAsItWasWritten) {
  EXPECT_EQ(value_of(from_bytes<Journey>(to_bytes(some_journey()))), some_journey());
}

TEST(Record, HasTheBytesOfItsFieldsOneAfterAnother) {
  ByteWriter fields;
  encode(Stop{"mill", 2.0}, fields);
  ByteWriter by_hand;
  by_hand.put_string("mill");
  by_hand.put(2.0);
  EXPECT_EQ(fields.bytes(), by_hand.bytes());
}

TEST(Record, CutAtAnyByteIsRefused) {
  const std::vector<std::byte> payload = payload_of(some_journey());
  ASSERT_TRUE(is_readable(payload));
  for (std::size_t size = 0; size < payload.size(); ++size) {
    ASSERT_FALSE(is_readable(std::span(payload).first(size))) << "cut at byte " << size;
  }
}

TEST(Record, RefusesABoolAndAnEnumWithoutAName) {
  constexpr std::size_t kIsReturn = sizeof(std::uint32_t);
  constexpr std::size_t kWeather = kIsReturn + 1;
  constexpr std::size_t kHasWait = kWeather + 1;
  for (const std::size_t at : {kIsReturn, kWeather, kHasWait}) {
    std::vector<std::byte> payload = payload_of(some_journey());
    payload[at] = std::byte{2};
    EXPECT_FALSE(is_readable(payload)) << "byte " << at;
  }
}

TEST(Record, RefusesACountThatTheBytesCannotHold) {
  ByteWriter writer;
  writer.put<std::uint64_t>(std::uint64_t{1} << 60);
  ByteReader reader(writer.bytes());
  std::vector<Stop> stops;
  decode(reader, stops);
  EXPECT_FALSE(reader.ok());
  EXPECT_TRUE(stops.empty());
}

TEST(Record, RefusesRecordsThatLieTooDeepInEachOther) {
  Journey deep;
  for (int i = 0; i < 20; ++i) {
    Journey outer;
    outer.branches.push_back(std::move(deep));
    deep = std::move(outer);
  }
  EXPECT_FALSE(is_readable(payload_of(deep)));
}

TEST(Record, IsPrintedWithTheNamesOfItsFields) {
  const Table table = dump(some_journey());
  EXPECT_THAT(table.facts, ElementsAre(Pair("number", Cell(std::int64_t{7})),
                                       Pair("is_return", Cell(std::int64_t{1})),
                                       Pair("weather", Cell("wet")), Pair("wait_s", Cell(1.5)),
                                       Pair("name", Cell("gate")), Pair("s_m", Cell(2.0))));
  EXPECT_THAT(table.columns, ElementsAre("name", "s_m"));
  EXPECT_THAT(table.rows, ElementsAre(ElementsAre(Cell("bridge"), Cell(10.0)),
                                      ElementsAre(Cell("mill"), Cell(20.0))));
}

TEST(Record, HasATextForEveryField) {
  FieldTexts texts;
  texts.add_fields("journey", some_journey().branches[1]);
  EXPECT_THAT(texts.take(),
              ElementsAre(Pair("journey.number", "0"), Pair("journey.is_return", "no"),
                          Pair("journey.weather", "dry"), Pair("journey.first.name", ""),
                          Pair("journey.first.s_m", "0"), Pair("journey.stops.0.name", "end"),
                          Pair("journey.stops.0.s_m", "1"), Pair("journey.speeds_m_per_s", ""),
                          Pair("journey.notes", ""), Pair("journey.code", "0 0"),
                          Pair("journey.begin_m", "0 0 0")));
}

TEST(Record, IsFiniteWhereAllItsNumbersAre) {
  EXPECT_TRUE(are_finite(some_journey()));
  const auto is_finite_with = [](const auto& change) {
    Journey journey = some_journey();
    change(journey);
    return are_finite(journey);
  };
  EXPECT_FALSE(is_finite_with([](Journey& journey) { journey.first.s_m = kNan; }));
  EXPECT_FALSE(is_finite_with([](Journey& journey) { journey.wait_s = kNan; }));
  EXPECT_FALSE(is_finite_with([](Journey& journey) { journey.stops[1].s_m = kNan; }));
  EXPECT_FALSE(is_finite_with([](Journey& journey) { journey.speeds_m_per_s[0] = NAN; }));
  EXPECT_FALSE(is_finite_with([](Journey& journey) { journey.begin_m.y() = kNan; }));
  EXPECT_FALSE(is_finite_with([](Journey& journey) { journey.line_m[1].x() = kNan; }));
}

}  // namespace
}  // namespace sightline
