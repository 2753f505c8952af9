#include "compiler/views/exports/lanelet2.h"

#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <cmath>
#include <map>
#include <set>

#include "formats/base/random.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using tinyxml2::XMLElement;
using Points = std::vector<Eigen::Vector3d>;
using Tags = std::map<std::string, std::string>;

struct OpenMap {
  explicit OpenMap(std::uint64_t seed, bool has_looks = true)
      : OpenMap(random_map(options(seed, has_looks))) {}
  explicit OpenMap(const CompiledMap& given) : map(given), bytes(encode_map(map)) {
    reader = *MapReader::open(bytes, "annealed");
    reader = *MapReader::open(bytes, reader->info().localizer);
  }
  static RandomMapOptions options(std::uint64_t seed, bool has_looks) {
    RandomMapOptions options{.seed = seed, .site_count = 60, .extent_m = 40.0};
    if (!has_looks) options.looks.clear();
    return options;
  }
  CompiledMap map;
  std::vector<std::byte> bytes;
  std::optional<MapReader> reader;
};

struct Lane {
  Eigen::Vector2d from_m;
  Eigen::Vector2d to_m;
  std::optional<double> height_m;
  std::string tags;  // further ones, as they stand in the file

  [[nodiscard]] Eigen::Vector2d left_m() const {
    const Eigen::Vector2d along = (to_m - from_m).normalized();
    return 2.0 * Eigen::Vector2d(-along.y(), along.x());
  }
};

std::string node_text(int id, const Eigen::Vector2d& p_m, const std::optional<double>& height_m) {
  char place[200];
  std::snprintf(place, sizeof place, "<tag k=\"local_x\" v=\"%.6f\" /><tag k='local_y' v='%.6f'/>",
                p_m.x(), p_m.y());
  return " <node id=\"" + std::to_string(id) + "\" lat=\"\" lon=\"\">" + place +
         (height_m ? "<tag k=\"ele\" v=\"" + std::to_string(*height_m) + "\"/>" : "") + "</node>\n";
}

// Each side has a node at its quarter too; the right one is written backwards.
std::string document(const std::vector<Lane>& lanes) {
  std::string nodes, ways, relations;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const Lane& lane = lanes[i];
    const int first = 100 * (static_cast<int>(i) + 1);
    for (int side = 0; side < 2; ++side) {
      const Eigen::Vector2d beside_m = side == 0 ? lane.left_m() : Eigen::Vector2d(-lane.left_m());
      std::string refs;
      for (int k = 0; k < 3; ++k) {
        const double share = std::array{0.0, 0.25, 1.0}.at(static_cast<std::size_t>(k));
        const Eigen::Vector2d p_m = lane.from_m + share * (lane.to_m - lane.from_m) + beside_m;
        nodes += node_text(first + 10 * side + k, p_m, lane.height_m);
        const std::string ref = "<nd ref=\"" + std::to_string(first + 10 * side + k) + "\"/>";
        refs = side == 0 ? refs + ref : ref + refs;
      }
      ways += " <way id=\"" + std::to_string(first + 50 + side) + "\">" + refs + "</way>\n";
    }
    relations += " <relation id=\"" + std::to_string(first + 60) +
                 "\" version='1'>\n  <member type=\"way\" role=\"left\" ref=\"" +
                 std::to_string(first + 50) + "\"/><member type=\"way\" role=\"right\" ref=\"" +
                 std::to_string(first + 51) + "\"/>\n  <tag k=\"type\" v=\"lanelet\"/>" +
                 lane.tags + "\n </relation>\n";
  }
  return "<?xml version=\"1.0\"?>\n<osm generator=\"by > hand\">\n <!-- 2 > 1 <relation> -->\n" +
         nodes + ways + relations +
         " <relation id=\"7\"><tag k=\"type\" v=\"regulatory_element\"/></relation>\n</osm>\n";
}

std::vector<Lane> random_lanes(Random& random, const CompiledMap& map, int count) {
  const Eigen::Vector2d origin_m = map.sites.frame.origin_world_m.head<2>();
  const auto place = [&]() -> Eigen::Vector2d {
    const double x_m = random.uniform(-45.0, 45.0);
    return origin_m + Eigen::Vector2d(x_m, random.uniform(-45.0, 45.0));
  };
  std::vector<Lane> lanes;
  for (int i = 0; i < count; ++i) {
    Lane lane{place(), place(), std::nullopt, ""};
    if (i % 2 == 0) lane.height_m = random.uniform(-4.0, 1.0);
    lanes.push_back(lane);
  }
  return lanes;
}

// The document holds places to a micrometre, and so they are asked for.
Eigen::Vector2d as_written(const Eigen::Vector2d& p_m) {
  return {std::round(p_m.x() * 1e6) / 1e6, std::round(p_m.y() * 1e6) / 1e6};
}

std::vector<std::array<double, 3>> places(const OpenMap& open, const Lane& lane) {
  const double length_m = (lane.to_m - lane.from_m).norm();
  const int steps = static_cast<int>(std::ceil(length_m - 1e-9));
  std::vector<std::array<double, 3>> places_m;
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector2d p_m =
        as_written(lane.from_m + static_cast<double>(i) / steps * (lane.to_m - lane.from_m));
    double z_m = 0.0;
    if (lane.height_m) {
      z_m = *lane.height_m + open.map.sensor.height_m;
    } else {
      double nearest_m = open.map.reach_m;
      for (const Site& site : open.map.sites.sites) {
        const Eigen::Vector3d site_m = site.p_map_m + open.map.sites.frame.origin_world_m;
        const double distance_m = (site_m.head<2>() - p_m).norm();
        if (distance_m > nearest_m) continue;
        nearest_m = distance_m;
        z_m = site_m.z();
      }
    }
    places_m.push_back({p_m.x(), p_m.y(), z_m});
  }
  return places_m;
}

struct Read {
  explicit Read(const std::string& text) {
    EXPECT_EQ(document.Parse(text.c_str()), tinyxml2::XML_SUCCESS);
    const XMLElement* osm = document.FirstChildElement("osm");
    for (const XMLElement* e = osm->FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement()) {
      const int id = e->IntAttribute("id");
      EXPECT_TRUE(elements.emplace(std::pair(std::string(e->Name()), id), e).second) << id;
      EXPECT_TRUE(ids.insert(id).second) << "id " << id << " twice";
    }
  }
  [[nodiscard]] Tags tags(const std::string& name, int id) const {
    Tags tags;
    const XMLElement* element = elements.at({name, id});
    for (const XMLElement* tag = element->FirstChildElement("tag"); tag != nullptr;
         tag = tag->NextSiblingElement("tag")) {
      EXPECT_TRUE(tags.emplace(tag->Attribute("k"), tag->Attribute("v")).second)
          << tag->Attribute("k") << " twice";
    }
    return tags;
  }
  [[nodiscard]] std::vector<std::pair<Points, Tags>> areas() const {
    std::vector<std::pair<Points, Tags>> areas;
    for (const auto& [key, element] : elements) {
      if (key.first != "way" || tags("way", key.second).count("area") == 0) continue;
      Points corners_m;
      for (const XMLElement* nd = element->FirstChildElement("nd"); nd != nullptr;
           nd = nd->NextSiblingElement("nd")) {
        const Tags at = tags("node", nd->IntAttribute("ref"));
        corners_m.emplace_back(std::stod(at.at("local_x")), std::stod(at.at("local_y")), 0.0);
      }
      areas.emplace_back(corners_m, tags("way", key.second));
    }
    return areas;
  }

  tinyxml2::XMLDocument document;
  std::map<std::pair<std::string, int>, const XMLElement*> elements;
  std::set<int> ids;
};

bool is_inside(const Points& corners_m, const Eigen::Vector2d& p_m) {
  bool is_inside = false;
  for (std::size_t i = 0; i < corners_m.size(); ++i) {
    const Eigen::Vector3d& a = corners_m[i];
    const Eigen::Vector3d& b = corners_m[(i + 1) % corners_m.size()];
    if ((a.y() > p_m.y()) == (b.y() > p_m.y())) continue;
    const double x_m = a.x() + (p_m.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (p_m.x() < x_m) is_inside = !is_inside;
  }
  return is_inside;
}

Lanelet2Export exported(const OpenMap& open, const std::string& text,
                        const Lanelet2Options& options = {}, const World& world = {}) {
  Result<Lanelet2Export> made = to_lanelet2(open.map, *open.reader, world, text, options);
  if (made) return *made;
  ADD_FAILURE() << to_string(made.error());
  return {};
}

ErrorCode refusal(const OpenMap& open, const std::string& text,
                  const Lanelet2Options& options = {}) {
  return code_of(to_lanelet2(open.map, *open.reader, {}, text, options));
}

void expect_tags(const OpenMap& open, const Lane& lane, double limit_m, const Tags& tags) {
  std::vector<double> ranges_m;
  double unmet = 0.0;
  double look_unmet = 0.0;
  Look dearest_look;
  std::size_t dearest = 0;
  const std::vector<std::array<double, 3>> asked_m = places(open, lane);
  for (const std::array<double, 3>& p_m : asked_m) {
    const RangeAnswer range = *open.reader->observation_range(p_m, limit_m);
    if ((range.flags & kAnswerFar) != 0) continue;
    ranges_m.push_back(range.range_m);
    unmet += (range.flags & kAnswerUnmet) != 0 ? 1.0 : 0.0;
    const LookAnswer look = *open.reader->look(p_m, limit_m);
    look_unmet += (look.flags & kAnswerUnmet) != 0 ? 1.0 : 0.0;
    for (std::size_t i = 0; i < open.map.looks->ranges.looks.size(); ++i) {
      const Look& known = open.map.looks->ranges.looks[i];
      const bool is_it =
          known.range_m == look.look.range_m && known.return_count == look.look.return_count;
      if (is_it && i >= dearest) {
        dearest = i;
        dearest_look = known;
      }
    }
  }
  const std::string range = "observation_range_" + limit_suffix(limit_m);
  const std::string look = "observation_look_" + limit_suffix(limit_m);
  const auto count = static_cast<double>(ranges_m.size());
  EXPECT_NEAR(std::stod(tags.at("observation_known")), count / static_cast<double>(asked_m.size()),
              5.01e-4);
  if (ranges_m.empty()) {
    EXPECT_EQ(tags.at(range), "unknown");
    EXPECT_EQ(tags.at(look + "_range"), "unknown");
    EXPECT_EQ(tags.count(look + "_returns"), 0U);
    EXPECT_EQ(tags.count(range + "_p95"), 0U);
    return;
  }
  std::sort(ranges_m.begin(), ranges_m.end());
  EXPECT_EQ(std::stod(tags.at(range)), ranges_m.back());
  EXPECT_EQ(std::stod(tags.at(range + "_least")), ranges_m.front());
  double p95_m = 0.0;
  for (const double range_m : ranges_m) {
    const auto enough = static_cast<double>(std::count_if(
        ranges_m.begin(), ranges_m.end(), [&](double r_m) { return r_m <= range_m; }));
    if (p95_m == 0.0 && enough >= 0.95 * count) p95_m = range_m;
  }
  EXPECT_EQ(std::stod(tags.at(range + "_p95")), p95_m);
  EXPECT_NEAR(std::stod(tags.at(range + "_unmet")), unmet / count, 5.01e-4);
  EXPECT_NEAR(std::stod(tags.at(look + "_unmet")), look_unmet / count, 5.01e-4);
  EXPECT_EQ(std::stod(tags.at(look + "_range")), dearest_look.range_m);
  EXPECT_EQ(tags.at(look + "_returns"), std::to_string(dearest_look.return_count));
  EXPECT_EQ(tags.at(look + "_points"), std::to_string(dearest_look.point_count));
  EXPECT_EQ(std::stod(tags.at(look + "_even_beyond")), dearest_look.even_beyond_m);
  EXPECT_EQ(tags.at(look + "_by_normals"), dearest_look.is_by_normals ? "yes" : "no");
  EXPECT_EQ(tags.at(look + "_settles"), dearest_look.mode == LookMode::kSettle ? "yes" : "no");
  EXPECT_EQ(tags.count(look), 0U) << "no text for people";
}

TEST(Lanelet2, TagsAreWhatTheReaderAnswersAlongTheLane) {
  Random random(7);
  std::size_t known = 0;
  for (const std::uint64_t seed : {1U, 2U, 5U}) {
    const OpenMap open(seed);
    const std::vector<Lane> lanes = random_lanes(random, open.map, 20);
    const Read read(exported(open, document(lanes)).text);
    for (std::size_t i = 0; i < lanes.size(); ++i) {
      const Tags tags = read.tags("relation", 100 * (static_cast<int>(i) + 1) + 60);
      for (const double limit_m : {0.10, 0.25}) expect_tags(open, lanes[i], limit_m, tags);
      EXPECT_EQ(tags.at("observation_localizer"), open.reader->info().localizer);
      known += tags.at("observation_known") == "0" ? 0 : 1;
    }
    EXPECT_EQ(read.tags("relation", 7).size(), 1U) << "it is no lanelet";
  }
  EXPECT_GT(known, 30U);
}

TEST(Lanelet2, AMapWithoutLooksAnswersWithItsRanges) {
  const OpenMap open(4, /*has_looks=*/false);
  Random random(1);
  const Read read(exported(open, document(random_lanes(random, open.map, 5))).text);
  for (int i = 1; i <= 5; ++i) {
    const Tags tags = read.tags("relation", 100 * i + 60);
    if (tags.at("observation_range_010") == "unknown") continue;
    EXPECT_EQ(tags.at("observation_look_010_range"), tags.at("observation_range_010"));
    EXPECT_EQ(tags.at("observation_look_010_returns"), "0");
    EXPECT_EQ(tags.at("observation_look_010_points"), "0");
  }
}

TEST(Lanelet2, AllElseStaysAsItWas) {
  const OpenMap open(2);
  Random random(3);
  std::vector<Lane> lanes = random_lanes(random, open.map, 6);
  lanes[0].tags =
      "<tag k=\"name\" v=\"A &amp; &lt;B&gt; '>'\"/><!-- </relation> -->\n  <tag k='one_way' "
      "v='no'/>"
      "<tag k=\"observation_tower\" v=\"yes\"/>";
  for (const std::string& line_end : {std::string("\n"), std::string("\r\n")}) {
    std::string text = document(lanes);
    for (std::size_t at = 0; line_end.size() > 1 && (at = text.find('\n', at)) != std::string::npos;
         at += 2) {
      text.replace(at, 1, line_end);
    }
    const Lanelet2Export made = exported(open, text);
    EXPECT_GT(made.area_count, 0U);
    std::size_t at = 0;
    std::string added;
    for (std::size_t begin = 0; begin < made.text.size();) {
      const std::size_t end = made.text.find('\n', begin) + 1;
      const std::string line = made.text.substr(begin, end - begin);
      begin = end;
      if (text.compare(at, line.size(), line) == 0) {
        at += line.size();
      } else {
        added += line;
      }
    }
    EXPECT_EQ(at, text.size()) << text.substr(at, 200);
    EXPECT_EQ(added.find("relation"), std::string::npos) << added;
    EXPECT_EQ(exported(open, made.text).text, made.text);
    EXPECT_EQ(Read(made.text).tags("relation", 160).at("observation_tower"), "yes");
  }
  std::string one_line = document(lanes);
  std::erase(one_line, '\n');
  const Lanelet2Export made = exported(open, one_line);
  EXPECT_EQ(exported(open, made.text).text, made.text);
  EXPECT_EQ(Read(made.text).tags("relation", 160),
            Read(exported(open, document(lanes)).text).tags("relation", 160));
}

bool is_weak(const OpenMap& open, const std::array<double, 3>& p_world_m, double limit_m,
             double margin) {
  const Sites& sites = open.map.sites;
  const Eigen::Vector3d p_m = Eigen::Vector3d(p_world_m.data()) - sites.frame.origin_world_m;
  std::size_t nearest = 0;  // on its level; there is one where the place is answered
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    const Eigen::Vector3d off_m = sites.sites[i].p_map_m - p_m;
    if (std::abs(off_m.z()) >= 1.0 || off_m.norm() >= nearest_m) continue;
    nearest = i;
    nearest_m = off_m.norm();
  }
  WeakStretchOptions options;
  options.limit_m = limit_m;
  options.least_margin = margin;
  const std::vector<BestLook> best = best_looks(open.map, *limit_of(open.map, limit_m));
  return std::ranges::any_of(weak_stretches(sites, best, options), [&](const WeakStretch& stretch) {
    return stretch.first_site <= nearest && nearest <= stretch.last_site;
  });
}

TEST(Lanelet2, StretchesThatAreMetAndWeakBecomeAreasWithATagOfTheirOwn) {
  Random random(12);
  std::size_t inside = 0;
  std::size_t strong = 0;
  for (const double margin : {0.0, 0.5, 1.0}) {
    const OpenMap open(2);
    const std::vector<Lane> lanes = random_lanes(random, open.map, 6);
    const Lanelet2Export made = exported(open, document(lanes), {0.25, margin});
    std::vector<std::pair<Points, Tags>> areas = Read(made.text).areas();
    std::erase_if(
        areas, [](const auto& area) { return area.second.at("subtype") != "feature_weak_road"; });
    EXPECT_EQ(areas.size(), made.weak_area_count);
    for (std::size_t i = 0; i < lanes.size(); ++i) {
      const std::string id = std::to_string(100 * (i + 1) + 60);
      for (const std::array<double, 3>& p_m : places(open, lanes[i])) {
        const Eigen::Vector2d at_m(p_m[0], p_m[1]);
        const bool is_end =
            (at_m - lanes[i].from_m).norm() < 0.1 || (at_m - lanes[i].to_m).norm() < 0.1;
        if (is_end) continue;
        const RangeAnswer range = *open.reader->observation_range(p_m, 0.25);
        const bool is_known = (range.flags & (kAnswerFar | kAnswerUnknownLocalizer)) == 0;
        const bool is_met = is_known && ((range.flags & kAnswerUnmet) == 0 ||
                                         (open.reader->look(p_m, 0.25)->flags & kAnswerUnmet) == 0);
        const bool is_in_one = std::ranges::any_of(areas, [&](const auto& area) {
          return area.second.at("lanelet") == id && is_inside(area.first, at_m);
        });
        const bool is_weak_here = is_met && is_weak(open, p_m, 0.25, margin);
        EXPECT_EQ(is_in_one, is_weak_here);
        inside += is_weak_here ? 1 : 0;
        strong += is_met && !is_weak_here ? 1 : 0;
      }
    }
  }
  EXPECT_GT(inside, 20U);
  EXPECT_GT(strong, 20U);
}

TEST(Lanelet2, StretchesThatAreUnmetBecomeAreasOfTheLanesWidth) {
  Random random(11);
  std::size_t inside = 0;
  for (const std::uint64_t seed : {1U, 2U, 4U}) {
    const OpenMap open(seed);
    const std::vector<Lane> lanes = random_lanes(random, open.map, 8);
    const std::string text = document(lanes);
    for (const double limit_m : {0.10, 0.25}) {
      const Lanelet2Export made = exported(open, text, {.area_limit_m = limit_m});
      const Read read(made.text);
      auto areas = read.areas();
      std::erase_if(
          areas, [](const auto& area) { return area.second.at("subtype") == "feature_weak_road"; });
      EXPECT_EQ(areas.size(), made.area_count);
      for (const auto& [corners_m, tags] : areas) {
        EXPECT_EQ(tags.at("type"), "degenerate_area");
        EXPECT_EQ(tags.at("subtype"), "feature_poor_road");
        EXPECT_EQ(tags.at("area"), "yes");
        EXPECT_EQ(std::stod(tags.at("observation_limit_m")), limit_m);
        // Nodes of the lane that stand within the stretch are its corners too.
        const Lane& lane = lanes.at(std::stoul(tags.at("lanelet")) / 100 - 1);
        double from = 1.0;
        double to = 0.0;
        for (const Eigen::Vector3d& corner_m : corners_m) {
          const Eigen::Vector2d along_m = lane.to_m - lane.from_m;
          const double share =
              (corner_m.head<2>() - lane.from_m).dot(along_m) / along_m.squaredNorm();
          from = std::min(from, share);
          to = std::max(to, share);
        }
        EXPECT_EQ(corners_m.size(), from < 0.249 && to > 0.251 ? 6U : 4U);
      }
      for (std::size_t i = 0; i < lanes.size(); ++i) {
        const std::string id = std::to_string(100 * (i + 1) + 60);
        for (const std::array<double, 3>& p_m : places(open, lanes[i])) {
          const Eigen::Vector2d middle_m(p_m[0], p_m[1]);
          const bool is_end =
              (middle_m - lanes[i].from_m).norm() < 0.1 || (middle_m - lanes[i].to_m).norm() < 0.1;
          if (is_end) continue;  // on the polygon's edge
          const bool is_unmet =
              (open.reader->observation_range(p_m, limit_m)->flags & kAnswerUnmet) != 0 &&
              (open.reader->look(p_m, limit_m)->flags & kAnswerUnmet) != 0;
          for (const double beside : {-1.1, -0.9, 0.0, 0.9, 1.1}) {
            const Eigen::Vector2d at_m = middle_m + beside * lanes[i].left_m();
            bool is_in_one = false;
            for (const auto& [corners_m, tags] : areas) {
              is_in_one |= tags.at("lanelet") == id && is_inside(corners_m, at_m);
            }
            EXPECT_EQ(is_in_one, is_unmet && std::abs(beside) < 1.0);
          }
          inside += is_unmet ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(inside, 20U);
}

TEST(Lanelet2, NoVehicleDrivesOnACrosswalkSoItIsNoArea) {
  const OpenMap open(2);
  Random random(3);
  std::vector<Lane> lanes = random_lanes(random, open.map, 6);
  for (Lane& lane : lanes) lane.tags = "<tag k=\"subtype\" v=\"crosswalk\"/>";
  const Lanelet2Export made = exported(open, document(lanes));
  EXPECT_EQ(made.area_count + made.weak_area_count, 0U);
}

TEST(Lanelet2, LanesOutsideTheMapAreNamedAndSayUnknown) {
  const OpenMap open(1);
  Random random(5);
  std::vector<Lane> lanes = random_lanes(random, open.map, 2);
  for (Lane& lane : lanes) lane.height_m.reset();
  Lane away = lanes[0];
  away.from_m.x() += 500.0;
  away.to_m.x() += 500.0;
  const Lanelet2Export made = exported(open, document({lanes[0], away, lanes[1]}));
  EXPECT_EQ(made.outside, std::vector<std::string>{"260"});
  const Tags tags = Read(made.text).tags("relation", 260);
  EXPECT_EQ(tags.at("observation_range_010"), "unknown");
  EXPECT_EQ(tags.at("observation_look_025_range"), "unknown");
  EXPECT_EQ(tags.at("observation_known"), "0");
  EXPECT_EQ(refusal(open, document({away})), ErrorCode::kNoOverlap);
  Lane high = lanes[0];
  high.height_m = 47.0;  // above another datum
  EXPECT_EQ(refusal(open, document({high})), ErrorCode::kNoOverlap);
}

// Exported clouds leave out whole 100 km, and so do the lanes that are drawn on them.
TEST(Lanelet2, LanesThatLieAsExportedCloudsDoAreOfTheSamePlaces) {
  const OpenMap open(1);
  Random random(6);
  std::vector<Lane> lanes = random_lanes(random, open.map, 4);
  const Lanelet2Export in_world = exported(open, document(lanes));
  ASSERT_EQ(open.reader->info().export_origin_world_m[0], 400'000.0);
  for (Lane& lane : lanes) {
    lane.from_m.x() -= 400'000.0;
    lane.to_m.x() -= 400'000.0;
  }
  const Lanelet2Export in_export = exported(open, document(lanes));
  for (int i = 1; i <= 4; ++i) {
    EXPECT_EQ(Read(in_world.text).tags("relation", 100 * i + 60),
              Read(in_export.text).tags("relation", 100 * i + 60));
  }
}

TEST(Lanelet2, LatitudesOfAKnownWorldAreTheSamePlaces) {
  const OpenMap open(1);
  Random random(6);
  const std::vector<Lane> lanes = random_lanes(random, open.map, 6);
  const World world = *parse_world("utm:32S");
  const std::string local = document(lanes);
  std::string text = local;
  for (std::size_t at = 0; (at = text.find("lat=\"\" lon=\"\"", at)) != std::string::npos;) {
    const std::size_t x = text.find("local_x\" v=\"", at) + 12;
    const std::size_t y = text.find("local_y' v='", at) + 12;
    const Geodetic place = *to_geodetic(
        world, {std::stod(text.substr(x, 20)), std::stod(text.substr(y, 20)) + 6e6, 0.0});
    char head[100];
    std::snprintf(head, sizeof head, "lat=\"%.11f\" lon=\"%.11f\"", place.latitude_deg,
                  place.longitude_deg);
    text.replace(at, 13, head);
  }
  CompiledMap moved = open.map;
  moved.ndt.frame.origin_world_m.y() += 6e6;
  moved.sites.frame = moved.ndt.frame;
  const Read of_degrees(exported(OpenMap(moved), text, {}, world).text);
  const Read of_metres(exported(open, local).text);
  ASSERT_EQ(of_degrees.areas().size(), of_metres.areas().size());
  for (int i = 1; i <= 6; ++i) {
    EXPECT_EQ(of_degrees.tags("relation", 100 * i + 60), of_metres.tags("relation", 100 * i + 60));
  }
  for (const auto& [key, element] : of_degrees.elements) {
    if (key.first != "node" || of_degrees.tags("node", key.second).count("added_by") == 0) continue;
    const Tags tags = of_degrees.tags("node", key.second);
    const Eigen::Vector3d p_m = *from_geodetic(
        world, {element->DoubleAttribute("lat"), element->DoubleAttribute("lon"), 0.0});
    EXPECT_NEAR(p_m.x(), std::stod(tags.at("local_x")), 1e-3);
    EXPECT_NEAR(p_m.y() - 6e6, std::stod(tags.at("local_y")), 1e-3);
  }
}

TEST(Lanelet2, RefusesWhatIsNoMapOfLanes) {
  const OpenMap open(1);
  Random random(5);
  const std::string text = document(random_lanes(random, open.map, 2));
  for (const char* bad : {"<osm><node", "lanes", "<gpx></gpx>"}) {
    EXPECT_EQ(refusal(open, bad), ErrorCode::kMalformedText) << bad;
  }
  EXPECT_EQ(refusal(open, "<osm></osm>"), ErrorCode::kMissingField);
  for (std::size_t at = 1; at < text.rfind("</osm>"); at += 7) {
    EXPECT_EQ(refusal(open, text.substr(0, at)), ErrorCode::kMalformedText) << at;
  }
  EXPECT_EQ(refusal(open, text, {.area_limit_m = 0.2}), ErrorCode::kBadArgument);
  std::string full = text;
  full.replace(full.find("id=\"100\""), 8, "id=\"9223372036854775807\"");
  EXPECT_NE(refusal(open, full), ErrorCode{}) << "a node that a way names is gone";
}

TEST(Lanelet2, LimitsNameTheirTags) {
  EXPECT_EQ(limit_suffix(0.10), "010");
  EXPECT_EQ(limit_suffix(0.25), "025");
  EXPECT_EQ(limit_suffix(0.125), "0125");
  EXPECT_EQ(limit_suffix(1.0), "100");
  EXPECT_EQ(limit_suffix(12.5), "1250");
}

}  // namespace
}  // namespace sightline
