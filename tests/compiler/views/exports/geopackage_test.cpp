#include "compiler/views/exports/geopackage.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstring>

#include "compiler/views/exports/geojson.h"
#include "compiler/views/verdict/recommended_answer.h"
#include "compiler/views/verdict/verdict.h"
#include "formats/annotation/range_rule.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

struct Opened {
  explicit Opened(std::vector<std::byte> content) : bytes(std::move(content)) {
    EXPECT_EQ(sqlite3_open(":memory:", &database), SQLITE_OK);
    auto* begin = reinterpret_cast<unsigned char*>(bytes.data());
    const auto size = static_cast<sqlite3_int64>(bytes.size());
    EXPECT_EQ(sqlite3_deserialize(database, "main", begin, size, size, SQLITE_DESERIALIZE_READONLY),
              SQLITE_OK);
  }
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;
  ~Opened() { sqlite3_close(database); }

  std::string value(const std::string& sql) const {
    sqlite3_stmt* statement = nullptr;
    EXPECT_EQ(sqlite3_prepare_v2(database, sql.c_str(), -1, &statement, nullptr), SQLITE_OK) << sql;
    EXPECT_EQ(sqlite3_step(statement), SQLITE_ROW) << sql;
    const auto* blob = static_cast<const char*>(sqlite3_column_blob(statement, 0));
    const std::string text(blob, static_cast<std::size_t>(sqlite3_column_bytes(statement, 0)));
    sqlite3_finalize(statement);
    return text;
  }

  std::vector<std::byte> bytes;
  sqlite3* database = nullptr;
};

TEST(GeoPackage, HoldsEverySiteAndRunWithWhatTheMapSays) {
  const CompiledMap map = random_map({.seed = 5});
  const std::vector<std::byte> package = value_of(to_geopackage(map, World{}));
  EXPECT_EQ(package, *to_geopackage(map, World{}));
  const Opened opened(package);
  EXPECT_EQ(opened.value("PRAGMA application_id"), "1196444487");
  EXPECT_EQ(opened.value("PRAGMA integrity_check"), "ok");
  EXPECT_EQ(opened.value("SELECT count(*) FROM sites"), std::to_string(map.sites.sites.size()));
  EXPECT_EQ(opened.value("SELECT srs_id FROM gpkg_geometry_columns WHERE table_name = 'sites'"),
            "-1");
  EXPECT_EQ(opened.value("SELECT count(*) FROM layer_styles WHERE useAsDefault"), "2");
  const std::size_t site = 7;
  const std::string point = opened.value("SELECT geom FROM sites WHERE site = 7");
  ASSERT_EQ(point.size(), 8U + 5U + 24U);
  EXPECT_EQ(point.substr(0, 4), std::string("GP\0\1", 4));
  double x_m = 0.0;
  std::memcpy(&x_m, point.data() + 13, sizeof x_m);
  EXPECT_EQ(x_m, map.sites.sites[site].p_map_m.x() + map.sites.frame.origin_world_m.x());
  for (const auto& [name, value] : site_properties(map, site)) {
    const std::string found = opened.value("SELECT \"" + name + "\" FROM sites WHERE site = 7");
    if (const auto* text = std::get_if<std::string>(&value)) {
      EXPECT_EQ(found, *text);
    }
    if (const auto* real = std::get_if<double>(&value)) {
      EXPECT_NEAR(std::stod(found), *real, 1e-12 * std::abs(*real));
    }
    if (const auto* truth = std::get_if<bool>(&value)) {
      EXPECT_EQ(found, *truth ? "1" : "0");
    }
  }
}

TEST(GeoPackage, NamesTheZoneOfItsCoordinates) {
  const CompiledMap map = random_map({.seed = 5});
  const Opened opened(*to_geopackage(map, *parse_world("mgrs:32UMV")));
  EXPECT_EQ(opened.value("SELECT srs_id FROM gpkg_contents WHERE table_name = 'sites'"), "32632");
  const std::string point = opened.value("SELECT geom FROM sites WHERE site = 0");
  double y_m = 0.0;
  std::memcpy(&y_m, point.data() + 21, sizeof y_m);
  EXPECT_EQ(y_m, map.sites.sites[0].p_map_m.y() + map.sites.frame.origin_world_m.y() + 5.4e6);
}

std::string name_at(const CompiledMap& map, std::size_t site) {
  const AnswerKind recommended = judge_map(map, nullptr, {}).limits[0].recommended;
  return answer_name(map, recommended_answer(map, recommended, site, 0));
}

TEST(GeoPackage, ColoursTheRouteByItsAnswers) {
  CompiledMap map = random_map({.seed = 5, .site_count = 80});
  ASSERT_TRUE(map.looks);
  for (std::size_t site = 0; site < 40; ++site) {
    const std::size_t at = map.ranges.shape().index(site, 0);
    map.looks->ranges.flags[at] = kUnmet;
    map.ranges.flags[at] = site < 20 ? kUnmet : std::uint8_t{0};
  }
  const Opened opened(value_of(to_geopackage(map, World{})));
  EXPECT_EQ(opened.value("SELECT answer FROM route ORDER BY fid LIMIT 1"), "no good answer");
  EXPECT_EQ(name_at(map, 0), "no good answer");
  EXPECT_TRUE(name_at(map, 30).starts_with("range ")) << name_at(map, 30);
  const std::string style =
      opened.value("SELECT styleQML FROM layer_styles WHERE f_table_name = 'route'");
  EXPECT_NE(style.find("attr=\"answer\""), std::string::npos);
  // That of no good answer is the last, and its colour is that of nothing else.
  const std::string none = "163,50,11,255";
  EXPECT_NE(style.find(none, style.rfind("<symbol ")), std::string::npos);
  EXPECT_GT(style.find(none), style.rfind("<symbol "));
  for (const std::size_t site : {0U, 30U, 60U}) {
    const std::string name = name_at(map, site);
    EXPECT_NE(style.find("value=\"" + name + "\" label=\"" + name + "\""), std::string::npos);
    EXPECT_NE(opened.value("SELECT count(*) FROM route WHERE answer = '" + name + "'"), "0");
  }
}

TEST(GeoPackage, HasNoDotInTheNameOfAField) {
  const CompiledMap map = random_map({.seed = 5});
  const Opened opened(value_of(to_geopackage(map, World{})));
  for (const char* layer : {"sites", "route"}) {
    EXPECT_EQ(opened.value(std::string("SELECT count(*) FROM pragma_table_info('") + layer +
                           "') WHERE name LIKE '%.%'"),
              "0");
  }
}

// Stretches of a run meet; together they are the run.
TEST(GeoPackage, CutsTheRouteWhereTheAnswerChanges) {
  const CompiledMap map = random_map({.seed = 5});
  const Opened opened(value_of(to_geopackage(map, World{})));
  const std::vector<Site>& sites = map.sites.sites;
  std::size_t stretches = 0;
  std::size_t steps = 0;
  for (std::size_t i = 0; i + 1 < sites.size(); ++i) {
    if (sites[i + 1].run != sites[i].run) continue;
    ++steps;
    const Answer here = answer_of(map.ranges, map.predicted, i, 0);
    const bool begins = i == 0 || sites[i - 1].run != sites[i].run;
    const Answer before = begins ? here : answer_of(map.ranges, map.predicted, i - 1, 0);
    const bool is_alike = here.look.range_m == before.look.range_m &&
                          ((here.flags ^ before.flags) & kUnmet) == 0 &&
                          name_at(map, i) == name_at(map, begins ? i : i - 1);
    stretches += begins || !is_alike ? 1 : 0;
  }
  EXPECT_GT(stretches, 2u);
  EXPECT_EQ(opened.value("SELECT count(*) FROM route"), std::to_string(stretches));
  // 13 bytes before the number of points, 24 bytes each.
  EXPECT_EQ(opened.value("SELECT sum((length(geom) - 17) / 24 - 1) FROM route"),
            std::to_string(steps));
  EXPECT_EQ(opened.value("SELECT count(DISTINCT run) FROM route"), "2");
  EXPECT_EQ(opened.value("SELECT range_m_within_10_cm FROM route ORDER BY fid LIMIT 1"),
            opened.value("SELECT range_m_within_10_cm FROM sites WHERE site = 0"));
}

TEST(QgisStyle, HasAClassForEveryRange) {
  const std::string style = qgis_range_style("line", "range_m_within_10_cm", {10.0, 20.0, 50.0});
  for (const char* value : {"value=\"10\"", "value=\"20\"", "value=\"50\""}) {
    EXPECT_NE(style.find(value), std::string::npos) << value;
  }
  EXPECT_NE(style.find("attr=\"range_m_within_10_cm\""), std::string::npos);
}

}  // namespace
}  // namespace sightline
