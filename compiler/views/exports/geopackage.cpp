#include "compiler/views/exports/geopackage.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <array>
#include <map>
#include <memory>
#include <string>
#include <tuple>

#include "compiler/views/exports/geojson.h"
#include "compiler/views/picture/raster.h"
#include "compiler/views/verdict/recommended_answer.h"
#include "compiler/views/verdict/verdict.h"
#include "formats/annotation/range_rule.h"
#include "formats/base/bytes.h"
#include "formats/text/quoted_text.h"
#include "formats/text/table.h"

// OGC 12-128r17. The database is built in memory and handed out as its bytes. A failure of SQLite
// there is no memory, or a mistake of ours.

namespace sightline {
namespace {

constexpr int kUndefinedCartesian = -1;  // srs_id, as the standard names them
constexpr int kWgs84 = 4326;
// In place of the time of the export: equal maps give equal files.
constexpr const char* kNoTime = "1970-01-01T00:00:00.000Z";

// Doubles `"` in a name.
std::string quoted_name(const std::string& name) {
  std::string quoted = "\"";
  for (const char c : name) {
    quoted += c;
    if (c == '"') quoted += c;
  }
  return quoted + "\"";
}

class Database {
 public:
  Database() {
    sqlite3* opened = nullptr;
    status_ = sqlite3_open(":memory:", &opened);
    database_.reset(opened);
  }

  // The first failure stays; later calls do nothing.
  void run(const std::string& sql) {
    if (status_ != SQLITE_OK) return;
    status_ = sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  }

  // One row: `values` take the places of the question marks.
  using Value = std::variant<std::int64_t, double, std::string, std::vector<std::byte>>;
  void insert(const std::string& sql, const std::vector<Value>& values) {
    if (status_ != SQLITE_OK) return;
    sqlite3_stmt* statement = nullptr;
    status_ = sqlite3_prepare_v2(database_.get(), sql.c_str(), -1, &statement, nullptr);
    for (std::size_t i = 0; i < values.size() && status_ == SQLITE_OK; ++i) {
      status_ = bind(statement, static_cast<int>(i) + 1, values[i]);
    }
    if (status_ == SQLITE_OK) {
      const int stepped = sqlite3_step(statement);
      if (stepped != SQLITE_DONE) status_ = stepped;
    }
    sqlite3_finalize(statement);
  }

  Result<std::vector<std::byte>> bytes() {
    SIGHTLINE_CHECK(status_ == SQLITE_OK || status_ == SQLITE_NOMEM);
    sqlite3_int64 size = 0;
    unsigned char* content =
        status_ == SQLITE_OK ? sqlite3_serialize(database_.get(), "main", &size, 0) : nullptr;
    if (content == nullptr) {
      return Error{ErrorCode::kOutOfMemory, "no memory for the GeoPackage"};
    }
    const auto* begin = reinterpret_cast<const std::byte*>(content);
    std::vector<std::byte> all(begin, begin + size);
    sqlite3_free(content);
    return all;
  }

 private:
  static int bind(sqlite3_stmt* statement, int place, const Value& value) {
    if (const auto* whole = std::get_if<std::int64_t>(&value)) {
      return sqlite3_bind_int64(statement, place, *whole);
    }
    if (const auto* real = std::get_if<double>(&value)) {
      return sqlite3_bind_double(statement, place, *real);
    }
    if (const auto* text = std::get_if<std::string>(&value)) {
      return sqlite3_bind_text(statement, place, text->data(), static_cast<int>(text->size()),
                               SQLITE_TRANSIENT);
    }
    const auto& blob = std::get<std::vector<std::byte>>(value);
    return sqlite3_bind_blob(statement, place, blob.data(), static_cast<int>(blob.size()),
                             SQLITE_TRANSIENT);
  }

  struct Closer {
    void operator()(sqlite3* database) const { sqlite3_close(database); }
  };
  std::unique_ptr<sqlite3, Closer> database_;
  int status_ = SQLITE_OK;
};

struct Crs {
  int id = kUndefinedCartesian;
  std::string name = "Undefined Cartesian";
  std::string wkt = "undefined";
};

Crs crs_of(const World& world) {
  constexpr const char* kGeographic =
      "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],"
      "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]";
  if (world.kind == WorldKind::kLocal) return {};
  if (world.kind == WorldKind::kEnu) {
    return {kWgs84, "WGS 84", std::string(kGeographic) + ",AUTHORITY[\"EPSG\",\"4326\"]]"};
  }
  const int code = epsg_code(world);
  const std::string name =
      fmt::format("WGS 84 / UTM zone {}{}", world.utm_zone, world.is_north ? "N" : "S");
  return {code, name,
          fmt::format("PROJCS[\"{}\",{}],PROJECTION[\"Transverse_Mercator\"],"
                      "PARAMETER[\"latitude_of_origin\",0],PARAMETER[\"central_meridian\",{}],"
                      "PARAMETER[\"scale_factor\",0.9996],PARAMETER[\"false_easting\",500000],"
                      "PARAMETER[\"false_northing\",{}],UNIT[\"metre\",1],AXIS[\"Easting\",EAST],"
                      "AXIS[\"Northing\",NORTH],AUTHORITY[\"EPSG\",\"{}\"]]",
                      name, kGeographic, 6 * world.utm_zone - 183,
                      world.is_north ? "0" : "10000000", code)};
}

Result<Eigen::Vector3d> position_of(const CompiledMap& map, const World& world, const Site& site) {
  const Eigen::Vector3d p_world_m = map.sites.frame.world_m(site.p_map_m);
  if (world.kind == WorldKind::kLocal) return p_world_m;
  SIGHTLINE_ASSIGN(const Geodetic point, to_geodetic(world, p_world_m));  // also a check
  if (world.kind == WorldKind::kEnu) {
    return Eigen::Vector3d(point.longitude_deg, point.latitude_deg, point.altitude_m);
  }
  return Eigen::Vector3d(p_world_m.x() + world.corner_utm_m.x(),
                         p_world_m.y() + world.corner_utm_m.y(), p_world_m.z());
}

// A GeoPackage geometry without an envelope, then well-known binary: a point, or a line through
// several.
std::vector<std::byte> geometry(const std::vector<Eigen::Vector3d>& positions, bool is_line,
                                int srs_id) {
  ByteWriter writer;
  constexpr std::array<std::uint8_t, 4> kHead = {0x47, 0x50, 0x00, 0x01};  // "GP", 0, flags
  for (const std::uint8_t byte : kHead) writer.put(byte);
  writer.put(std::int32_t{srs_id});
  writer.put(std::uint8_t{1});                         // little-endian
  writer.put(std::uint32_t{is_line ? 1002U : 1001U});  // LineString Z, Point Z
  if (is_line) writer.put(static_cast<std::uint32_t>(positions.size()));
  for (const Eigen::Vector3d& p : positions) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) writer.put(p[axis]);
  }
  return writer.take();
}

void create_tables(const Crs& crs, Database& database) {
  database.run(
      "PRAGMA application_id=1196444487; PRAGMA user_version=10300; BEGIN;CREATE TABLE "
      "gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER PRIMARY KEY, organization TEXT "
      "NOT NULL, organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description "
      "TEXT);CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT "
      "NULL, identifier TEXT UNIQUE, description TEXT DEFAULT '', last_change DATETIME NOT NULL, "
      "min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER, FOREIGN KEY "
      "(srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));CREATE TABLE gpkg_geometry_columns "
      "(table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL, "
      "srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL, PRIMARY KEY (table_name, "
      "column_name), FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name), FOREIGN KEY "
      "(srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));CREATE TABLE layer_styles (id INTEGER "
      "PRIMARY KEY, f_table_catalog TEXT, f_table_schema TEXT, f_table_name TEXT, "
      "f_geometry_column TEXT, styleName TEXT, styleQML TEXT, styleSLD TEXT, useAsDefault BOOLEAN, "
      "description TEXT, owner TEXT, ui TEXT, update_time DATETIME)");
  const auto add = [&](const Crs& each, const std::string& organization) {
    database.insert(
        "INSERT INTO gpkg_spatial_ref_sys VALUES (?, ?, ?, ?, ?, NULL)",
        {each.name, std::int64_t{each.id}, organization, std::int64_t{each.id}, each.wkt});
  };
  World degrees;
  degrees.kind = WorldKind::kEnu;
  add({}, "NONE");
  add({0, "Undefined geographic", "undefined"}, "NONE");
  add(crs_of(degrees), "EPSG");
  if (crs.id > 0 && crs.id != kWgs84) add(crs, "EPSG");
}

// A layer with its entries in the package's own tables.
struct Layer {
  std::string name;
  std::string geometry_type;
  std::string columns;  // SQL, behind the geometry
  std::string style;
};

void create_layer(const Layer& layer, const Crs& crs, const Eigen::AlignedBox2d& bounds,
                  Database& database) {
  database.run(concat("CREATE TABLE ", layer.name,
                      " (fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, geom ",
                      layer.geometry_type, layer.columns, ")"));
  database.insert("INSERT INTO gpkg_contents VALUES (?, 'features', ?, '', ?, ?, ?, ?, ?, ?)",
                  {layer.name, layer.name, std::string(kNoTime), bounds.min().x(), bounds.min().y(),
                   bounds.max().x(), bounds.max().y(), std::int64_t{crs.id}});
  database.insert("INSERT INTO gpkg_geometry_columns VALUES (?, 'geom', ?, ?, 1, 0)",
                  {layer.name, layer.geometry_type, std::int64_t{crs.id}});
  database.insert(
      "INSERT INTO layer_styles (f_table_catalog, f_table_schema, f_table_name, "
      "f_geometry_column, styleName, styleQML, styleSLD, useAsDefault, description, owner, "
      "update_time) VALUES ('', '', ?, 'geom', 'sightline', ?, '', 1, '', '', ?)",
      {layer.name, layer.style, std::string(kNoTime)});
}

const char* sql_type(const SiteProperty& value) {
  if (std::holds_alternative<bool>(value)) return "BOOLEAN";
  if (std::holds_alternative<std::int64_t>(value)) return "INTEGER";
  return std::holds_alternative<double>(value) ? "DOUBLE" : "TEXT";
}

Database::Value sql_value(const SiteProperty& value) {
  if (const auto* truth = std::get_if<bool>(&value)) return std::int64_t{*truth ? 1 : 0};
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return *whole;
  if (const auto* real = std::get_if<double>(&value)) return *real;
  return std::get<std::string>(value);
}

using Positions = std::vector<Eigen::Vector3d>;

void add_sites(const CompiledMap& map, const Positions& positions, const Crs& crs,
               const Eigen::AlignedBox2d& bounds, Database& database) {
  std::string columns;
  std::string marks = "?";
  std::string names = "geom";
  for (const auto& [name, value] : site_properties(map, 0)) {
    columns += concat(", ", quoted_name(name), " ", sql_type(value));
    names += ", " + quoted_name(name);
    marks += ", ?";
  }
  create_layer({"sites", "POINT", columns,
                qgis_range_style("marker", range_property(map, 0), ranges_of(map.ranges.looks))},
               crs, bounds, database);
  const std::string sql = concat("INSERT INTO sites (", names, ") VALUES (", marks, ")");
  for (std::size_t i = 0; i < positions.size(); ++i) {
    std::vector<Database::Value> row = {geometry({positions[i]}, /*is_line=*/false, crs.id)};
    for (const auto& [name, value] : site_properties(map, i)) row.push_back(sql_value(value));
    database.insert(sql, row);
  }
}

// The answers of a route within the tightest limit.
struct RouteAnswers {
  std::vector<std::string> names;  // [site]
  std::vector<QgisClass> classes;  // of the answers that occur: good ones, then none
};

RouteAnswers answers_of_route(const CompiledMap& map) {
  constexpr Colour kOfPlan = {0, 114, 178};
  constexpr Colour kOfNone = {163, 50, 11};
  const AnswerKind recommended = judge_map(map, nullptr, {}).limits.front().recommended;
  RouteAnswers route;
  std::map<std::tuple<bool, AnswerKind, std::size_t>, std::string> occurring;
  for (std::size_t site = 0; site < map.sites.sites.size(); ++site) {
    const RecommendedAnswer answer = recommended_answer(map, recommended, site, 0);
    route.names.push_back(answer_name(map, answer));
    const bool is_one = !answer.is_good || answer.kind == AnswerKind::kPlan;
    occurring[{!answer.is_good, answer.kind, is_one ? 0 : answer.choice}] = route.names.back();
  }
  for (const auto& [key, name] : occurring) {
    const auto& [is_none, kind, choice] = key;
    const bool is_plan = kind == AnswerKind::kPlan;
    const Colour colour =
        is_none
            ? kOfNone
            : (is_plan ? kOfPlan : range_colour_on_paper(route.classes.size(), occurring.size()));
    route.classes.push_back({name, name, colour});
  }
  return route;
}

// A line for each stretch of one answer, which begins where the one before ends; a run's last site
// belongs to the stretch before it.
void add_route(const CompiledMap& map, const Positions& positions, const Crs& crs,
               const Eigen::AlignedBox2d& bounds, Database& database) {
  const std::string range = range_property(map, 0);
  const RouteAnswers route = answers_of_route(map);
  create_layer(
      {"route", "LINESTRING",
       concat(", run INTEGER, answer TEXT, ", quoted_name(range), " DOUBLE, unmet BOOLEAN"),
       qgis_style("line", "answer", route.classes)},
      crs, bounds, database);
  const std::vector<Site>& sites = map.sites.sites;
  const auto answer = [&](std::size_t i) { return answer_of(map.ranges, map.predicted, i, 0); };
  const auto is_unmet = [&](std::size_t i) { return (answer(i).flags & kUnmet) != 0; };
  const auto is_alike = [&](std::size_t i, std::size_t k) {
    return route.names[i] == route.names[k] && answer(i).look.range_m == answer(k).look.range_m &&
           is_unmet(i) == is_unmet(k);
  };
  for (std::size_t begin = 0; begin + 1 < sites.size();) {
    std::size_t end = begin + 1;
    while (end + 1 < sites.size() && sites[end].run == sites[begin].run && is_alike(end, begin)) {
      ++end;
    }
    const bool is_of_run = sites[end].run == sites[begin].run;
    const std::size_t last = is_of_run ? end : end - 1;
    // A line has two points at least.
    if (last > begin) {
      const Positions line(positions.begin() + static_cast<std::ptrdiff_t>(begin),
                           positions.begin() + static_cast<std::ptrdiff_t>(last) + 1);
      database.insert(
          concat("INSERT INTO route (geom, run, answer, ", quoted_name(range),
                 ", unmet) VALUES (?, ?, ?, ?, ?)"),
          {geometry(line, /*is_line=*/true, crs.id), std::int64_t{sites[begin].run},
           route.names[begin], answer(begin).look.range_m, std::int64_t{is_unmet(begin) ? 1 : 0}});
    }
    begin = end;
  }
}

using Values = std::vector<std::pair<std::string, std::string>>;

// QGIS writes an option twice: as <Option> since 3.26, as <prop> before.
std::string symbol(const std::string& type, const std::string& name, const std::string& layer,
                   const Values& values) {
  std::string options;
  std::string props;
  for (const auto& [key, value] : values) {
    options += fmt::format(R"(<Option name="{}" type="QString" value="{}"/>)", key, value);
    props += fmt::format(R"(<prop k="{}" v="{}"/>)", key, value);
  }
  return fmt::format(R"(<symbol type="{}" name="{}" alpha="1" clip_to_extent="1" force_rhr="0">)"
                     R"(<layer class="{}" enabled="1" locked="0" pass="0">)"
                     "<Option type=\"Map\">{}</Option>{}</layer></symbol>\n",
                     type, name, layer, options, props);
}

std::string rgba(const Colour& colour) {
  return fmt::format("{},{},{},255", colour.red, colour.green, colour.blue);
}

std::string circle_symbol(const std::string& name, const std::string& colour) {
  return symbol("marker", name, "SimpleMarker",
                {{"name", "circle"},
                 {"color", colour},
                 {"outline_style", "no"},
                 {"size", "2"},
                 {"size_unit", "MM"}});
}

std::string line_symbol(const std::string& name, const std::string& colour) {
  return symbol("line", name, "SimpleLine",
                {{"line_color", colour},
                 {"line_style", "solid"},
                 {"line_width", "1.2"},
                 {"line_width_unit", "MM"},
                 {"capstyle", "round"}});
}

std::string document(const std::string& renderer) {
  return concat(
      "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
      "<qgis version=\"3.22\" styleCategories=\"Symbology\">\n",
      renderer, "</qgis>\n");
}

}  // namespace

Result<std::vector<std::byte>> to_geopackage(const CompiledMap& map, const World& world) {
  const Crs crs = crs_of(world);
  Positions positions;
  Eigen::AlignedBox2d bounds;
  for (const Site& site : map.sites.sites) {
    SIGHTLINE_ASSIGN(const Eigen::Vector3d position, position_of(map, world, site));
    positions.push_back(position);
    bounds.extend(Eigen::Vector2d(position.head<2>()));
  }
  Database database;
  create_tables(crs, database);
  add_route(map, positions, crs, bounds, database);
  add_sites(map, positions, crs, bounds, database);
  database.run("COMMIT");
  return database.bytes();
}

std::string qgis_style(const std::string& type, const std::string& attribute,
                       const std::vector<QgisClass>& classes) {
  std::string categories;
  std::string symbols;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    const std::string name = std::to_string(i);
    const std::string colour = rgba(classes[i].colour);
    categories +=
        fmt::format("<category value=\"{}\" label=\"{}\" symbol=\"{}\" render=\"true\"/>\n",
                    xml_text(classes[i].value), xml_text(classes[i].label), name);
    symbols += type == "line" ? line_symbol(name, colour) : circle_symbol(name, colour);
  }
  return document(
      concat("<renderer-v2 type=\"categorizedSymbol\" attr=\"", attribute,
             "\" symbollevels=\"0\" enableorderby=\"0\" forceraster=\"0\">\n<categories>\n",
             categories, "</categories>\n<symbols>\n", symbols, "</symbols>\n</renderer-v2>\n"));
}

std::string qgis_range_style(const std::string& type, const std::string& attribute,
                             const std::vector<double>& ranges_m) {
  std::vector<QgisClass> classes;
  for (std::size_t i = 0; i < ranges_m.size(); ++i) {
    const std::string range = format_double(ranges_m[i]);
    classes.push_back({range, range + " m", range_colour_on_paper(i, ranges_m.size())});
  }
  return qgis_style(type, attribute, classes);
}

}  // namespace sightline
