#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_writer.h"
#include "formats/reader/reader.h"
#include "tests/compiler/gate/route_map.h"
#include "tests/support/value_of.h"
#include "tests/system/program.h"

// Every verb but dump prints places in world coordinates. evaluate needs a drive: compile_test.cpp
// has its row. The page's panel is read in a browser (tests/compiler/views/report/page_test.py).

namespace sightline {
namespace {

using Json = nlohmann::json;

// Site i of a route_map() is at (640 + i, -64, 1.8) in the world and at (i, 0, 1.8) in the map.
const Eigen::Vector3d kSite0_m(640.0, -64.0, 1.8);

// A map whose site 0 is unmet, and the map before it, whose site 0 is not.
struct TwoMaps {
  std::filesystem::path folder = fresh_folder();
  std::string map = (folder / "new.slmap").string();
  std::string old_map = (folder / "old.slmap").string();
  TwoMaps() {
    CompiledMap made = route_map(40);
    made.looks.reset();
    write(made, old_map);
    set_site(made, 0, {2, 0.2, 0.2, kUnmet});
    sum_up(made);
    write(made, map);
  }
  static void write(const CompiledMap& made, const std::string& file) {
    EXPECT_TRUE(write_file_atomically(file, encode_map(made), IfExists::kRefuse));
  }
};

struct Printed {
  std::string by;  // verb and form
  std::vector<double> place_m;
};

// The numbers in the first match of `pattern`, whose groups are numbers.
std::vector<double> numbers_in(const std::string& text, const std::string& pattern) {
  std::smatch match;
  if (!std::regex_search(text, match, std::regex(pattern))) {
    ADD_FAILURE() << "no " << pattern << " in\n" << text;
    return {};
  }
  std::vector<double> numbers;
  for (std::size_t i = 1; i < match.size(); ++i) numbers.push_back(std::stod(match[i]));
  return numbers;
}

// Of the first row of a CSV with a heading.
std::vector<double> csv_place(const std::string& text, const std::vector<std::string>& columns) {
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line) && line.starts_with("#")) {
  }
  const auto cells_of = [](const std::string& row) {
    std::istringstream stream(row);
    std::vector<std::string> cells;
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    return cells;
  };
  const std::vector<std::string> names = cells_of(line);
  std::getline(lines, line);
  const std::vector<std::string> cells = cells_of(line);
  std::vector<double> place_m;
  for (const std::string& column : columns) {
    const auto at = std::ranges::find(names, column) - names.begin();
    EXPECT_LT(at, std::ssize(cells)) << column << " in\n" << text;
    if (at < std::ssize(cells)) place_m.push_back(std::stod(cells[static_cast<std::size_t>(at)]));
  }
  return place_m;
}

std::string output_of(const std::string& arguments) { return run_sightline(arguments).out; }

void append_gate(const TwoMaps& maps, std::vector<Printed>& table) {
  const std::filesystem::path rules = maps.folder / "rules.yaml";
  EXPECT_TRUE(write_file_atomically(rules, "stretch_m: 0.5\n", IfExists::kRefuse));
  const std::string gate = "gate " + maps.map + " --rules " + rules.string() + " --all --format ";
  for (const char* format : {"text", "github", "sarif"}) {
    table.push_back(
        {std::string("gate --format ") + format,
         numbers_in(output_of(gate + format),
                    R"(sites 0 to 0 \(run 0, 0 to 0 m, around \((.*?), (.*?), (.*?)\))")});
  }
  const Json report = Json::parse(output_of(gate + "json"));
  for (const Json& check : report.at("checks")) {
    if (check.at("rule") != "worst-stretch" || check.at("verdict") != "violated") continue;
    table.push_back({"gate --format json", check.at("place").at("middle_world_m")});
    return;
  }
  ADD_FAILURE() << report.dump(1);
}

void append_diff(const TwoMaps& maps, std::vector<Printed>& table) {
  const std::string diff = "diff " + maps.old_map + " " + maps.map;
  table.push_back(
      {"diff --all", numbers_in(output_of(diff + " --all"), R"(run 0, 0 - 0 m +(\S+), (\S+))")});
  table.push_back({"diff --format markdown", numbers_in(output_of(diff + " --format markdown"),
                                                        R"(run 0, 0 - 0 m \| (\S+), (\S+) \|)")});
  const Json json = Json::parse(output_of(diff + " --format json"));
  table.push_back({"diff --format json", json.at("stretches").at(0).at("begin_world_m")});
  const Json features = Json::parse(output_of(diff + " --format geojson"));
  table.push_back(
      {"diff --format geojson", features.at("features").at(0).at("geometry").at("coordinates")});
}

void append_weak(const TwoMaps& maps, std::vector<Printed>& table) {
  const std::string weak = "weak " + maps.map + " --limit 0.1 --margin 0.3 ";
  table.push_back(
      {"weak --format csv", csv_place(output_of(weak + "--format csv"), {"x_m", "y_m", "z_m"})});
  table.push_back(
      {"weak", numbers_in(output_of(weak), R"(\n +1 +0 +\S+ +\S+ +0 +(-?[0-9.]+) +(-?[0-9.]+) )")});
}

void append_exports(const TwoMaps& maps, std::vector<Printed>& table) {
  export_to(maps.folder / "route.geojson", maps.map, "--format geojson");
  const Json route = Json::parse(bytes_of(maps.folder / "route.geojson"));
  for (const Json& feature : route.at("features")) {
    if (!feature.at("properties").contains("site")) continue;
    EXPECT_EQ(feature.at("properties").at("site"), 0);
    table.push_back({"export --format geojson", feature.at("geometry").at("coordinates")});
    break;
  }
  export_to(maps.folder / "tables", maps.map, "--format csv");
  table.push_back({"export --format csv", csv_place(bytes_of(maps.folder / "tables" / "sites.csv"),
                                                    {"p_x_m", "p_y_m", "p_z_m"})});
}

TEST(Weak, EndsWithTheNextCommand) {
  const TwoMaps maps;
  const std::string text = output_of("weak " + maps.map + " --limit 0.1 --margin 0.3");
  const std::string last = text.substr(text.rfind('\n', text.size() - 2) + 1);
  EXPECT_EQ(last, "Next: sightline report " + maps.map +
                      " -o map.html  # shows these stretches on a page\n");
}

TEST(World, EveryVerbPrintsSite0WhereTheRecordingHasIt) {
  const TwoMaps maps;
  std::vector<Printed> table;
  table.push_back({"inspect --site 0", numbers_in(output_of("inspect " + maps.map + " --site 0"),
                                                  R"(at \((.*?), (.*?), (.*?)\) m in the world)")});
  append_gate(maps, table);
  append_diff(maps, table);
  append_weak(maps, table);
  append_exports(maps, table);
  const MapReader reader = value_of(MapReader::open(maps.map, ""));
  const auto place_m = value_of(reader.sites(0)).at(0).position_world_m;
  table.push_back({"the vehicle's reader", {place_m.begin(), place_m.end()}});
  EXPECT_EQ(table.size(), 14U);
  for (const Printed& row : table) {
    std::cout << row.by << ":";
    EXPECT_GE(row.place_m.size(), 2U) << row.by;
    for (std::size_t axis = 0; axis < std::min<std::size_t>(row.place_m.size(), 3); ++axis) {
      std::cout << " " << row.place_m[axis];
      EXPECT_NEAR(row.place_m[axis], kSite0_m[static_cast<Eigen::Index>(axis)], 1e-9) << row.by;
    }
    std::cout << "\n";
  }
}

TEST(World, DumpAlonePrintsTheMapsOwnCoordinates) {
  const TwoMaps maps;
  const std::vector<double> place_m =
      csv_place(output_of("dump " + maps.map + " --what sites --format csv"), {"p_x_m", "p_y_m"});
  EXPECT_EQ(place_m, (std::vector<double>{0.0, 0.0}));
}

}  // namespace
}  // namespace sightline
