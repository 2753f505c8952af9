#include "compiler/views/text/weakness_text.h"

#include <fmt/format.h>

#include "compiler/views/verdict/verdict_text.h"
#include "formats/base/portable_math.h"
#include "formats/base/units.h"

namespace sightline {
namespace {

std::string stretch_line(const ExplainedStretch& one, const Sites& sites, std::size_t number) {
  const WeakStretch& stretch = one.stretch;
  const Eigen::Vector3d p_m = sites.frame.world_m(sites.sites[stretch.worst_site].p_map_m);
  return fmt::format(
      "{:3}  {:3}  {:>7.0f}  {:>7.0f}  {:5}  {:>9.1f}  {:>9.1f}  {:>6.1f}  {:>5.3f}  {:>5.0f}  "
      "{:15}  {}\n",
      number, stretch.run, stretch.from_m, stretch.to_m, stretch.worst_site, p_m.x(), p_m.y(),
      100.0 * stretch.worst.error_m, stretch.worst.probability, 100.0 * stretch.worst.margin,
      name_of_way(one.loose.off_road_deg), stretch.unmet_count > 0 ? "unmet" : "thin");
}

std::string advice_line(const TargetAdvice& advice, const Sites& sites) {
  const Eigen::Vector3d p_m = sites.frame.world_m(advice.target.foot_map_m);
  const std::string text = fmt::format(
      "% less: at ({:.1f}, {:.1f}), ground {:.1f}, facing {:.0f} degrees; {:.1f} m {} of site {}; "
      "{} returns a scan",
      p_m.x(), p_m.y(), p_m.z(), facing_deg(advice.target), std::abs(advice.beside_m),
      advice.beside_m > 0.0 ? "left" : "right", advice.nearest_site, advice.return_count);
  return fmt::format("       {:>5.1f} ", 100.0 * advice.gain) + wrapped(text, 106, 9);
}

std::string explanation(const ExplainedStretch& one, const Weakness& weakness, const Sites& sites,
                        std::size_t number) {
  std::string text =
      fmt::format("{:3}  ", number) +
      wrapped(fmt::format("{}: {}", name_of(one.cause), cause_sentence(one)), 115, 5);
  if (one.kind != PlaceKind::kUnknown) {
    text += fmt::format("     kind of place: {}\n", name_of(one.kind));
  }
  text += fmt::format(
      "     loose {} ({:.0f} degrees from +x): {:.1f} times the strongest "
      "direction; yaw {:.3f} degrees\n",
      name_of_way(one.loose.off_road_deg), one.loose.heading_deg,
      one.loose.std_m / one.loose.strong_std_m, one.loose.yaw_rad * kDegPerRad);
  const TargetSize& size = weakness.options.advice.size;
  if (one.advice.empty()) {
    return text + fmt::format("     no place found for a board of {:g} x {:g} m that would help\n",
                              size.width_m, size.height_m);
  }
  text += fmt::format("     a board of {:g} x {:g} m, its loose standard deviation as simulated:\n",
                      size.width_m, size.height_m);
  for (const TargetAdvice& advice : one.advice) text += advice_line(advice, sites);
  return text;
}

using NamedCell = std::pair<const char*, Cell>;

// Of a missing advice: empty cells.
void append_advice(const ExplainedStretch& one, const Eigen::Vector3d& origin_m,
                   std::vector<NamedCell>& row) {
  const bool has_advice = !one.advice.empty();
  const TargetAdvice best = has_advice ? one.advice.front() : TargetAdvice();
  const Eigen::Vector3d p_m = best.target.foot_map_m + origin_m;
  const std::pair<const char*, double> cells[] = {
      {"target_x_m", p_m.x()},        {"target_y_m", p_m.y()},
      {"target_ground_z_m", p_m.z()}, {"target_facing_deg", facing_deg(best.target)},
      {"target_gain", best.gain},     {"target_gain_at_worst", best.gain_at_worst}};
  for (const auto& [name, value] : cells) {
    row.emplace_back(name, has_advice ? Cell(value) : Cell(std::string()));
  }
}

// `p_m`: of its worst site, in world coordinates like `origin_m` of the map's frame.
std::vector<NamedCell> row_of(const ExplainedStretch& one, const Eigen::Vector3d& p_m,
                              const Eigen::Vector3d& origin_m) {
  const WeakStretch& stretch = one.stretch;
  const auto number = [](std::size_t value) { return Cell(static_cast<std::int64_t>(value)); };
  std::vector<NamedCell> row = {{"run", number(stretch.run)},
                                {"from_m", stretch.from_m},
                                {"to_m", stretch.to_m},
                                {"first_site", number(stretch.first_site)},
                                {"last_site", number(stretch.last_site)},
                                {"unmet_sites", number(stretch.unmet_count)},
                                {"worst_site", number(stretch.worst_site)},
                                {"x_m", p_m.x()},
                                {"y_m", p_m.y()},
                                {"z_m", p_m.z()},
                                {"error_m", stretch.worst.error_m},
                                {"probability", stretch.worst.probability},
                                {"margin", stretch.worst.margin},
                                {"look", to_text(stretch.worst.look)},
                                {"place_kind", std::string(name_of(one.kind))},
                                {"cause", std::string(name_of(one.cause))},
                                {"loose_heading_deg", one.loose.heading_deg},
                                {"off_road_deg", one.loose.off_road_deg},
                                {"loose_std_m", one.loose.std_m},
                                {"strong_std_m", one.loose.strong_std_m},
                                {"yaw_std_rad", one.loose.yaw_rad}};
  append_advice(one, origin_m, row);
  return row;
}

}  // namespace

std::string summary_sentence(const Weakness& weakness) {
  const double limit_m = weakness.limit_m;
  std::string text = fmt::format(
      "limit {:g} m: {} weak stretches, {:.0f} of {:.0f} m of route ({:.0f} m unmet: no look or "
      "range "
      "is good enough)\n",
      limit_m, weakness.stretch_count, weakness.weak_m, weakness.route_m, weakness.unmet_m);
  return text + fmt::format(
                    "thin: the best look's predicted error leaves less than {:.0f} % of the limit; "
                    "thinnest: site {}, {:.0f} %\n",
                    100.0 * weakness.options.stretches.least_margin, weakness.thinnest_site,
                    100.0 * weakness.thinnest.margin);
}

std::string cause_sentence(const ExplainedStretch& one) {
  const UprightSights& sights = one.sights;
  const double range_m = one.stretch.worst.look.range_m;
  std::string text =
      fmt::format("{} of {} upright surfaces seen within {:g} m hold it {}", sights.holding_count,
                  sights.count, range_m, name_of_way(one.loose.off_road_deg));
  if (sights.nearest_holding_m) {
    text += fmt::format(", the nearest {:.0f} m away", *sights.nearest_holding_m);
  }
  switch (one.cause) {
    case WeakCause::kEmpty:
      return text + "; there is little else to see.";
    case WeakCause::kOneSided:
      return text + "; nearly all face one way.";
    case WeakCause::kRepeated:
      return text +
             fmt::format(
                 "; half a metre or more further it looks nearly the same ({:.2f} of the score).",
                 one.rival_score.value_or(1.0));
    case WeakCause::kDistant:
      return text + "; the surfaces that constrain it are far away.";
    case WeakCause::kUnclear:
      return text + "; the geometry alone does not explain it: traffic, change or noise may.";
  }
  SIGHTLINE_CHECK(false);
}

std::string to_text(const Weakness& weakness, const Sites& sites) {
  std::string text = summary_sentence(weakness);
  if (weakness.stretches.empty()) return text;
  text +=
      "\n  #  run   from m     to m   site   x world    y world  err cm      P   left%  loose      "
      "      state\n";
  for (std::size_t i = 0; i < weakness.stretches.size(); ++i) {
    text += stretch_line(weakness.stretches[i], sites, i + 1);
  }
  text += wrapped(fmt::format(
      "err cm: predicted error of the best look; P: its probability to be within the limit; left%: "
      "share of the limit that this error leaves; loose: direction that scans constrain least; "
      "unmet: no look is good enough; thin: left% is below {:g} (--margin)",
      100.0 * weakness.options.stretches.least_margin));
  text += "\n";
  for (std::size_t i = 0; i < weakness.stretches.size(); ++i) {
    text += explanation(weakness.stretches[i], weakness, sites, i + 1);
  }
  return text;
}

Table table_of(const Weakness& weakness, const Sites& sites) {
  Table table{"weak",
              {},
              {},
              {{"limit_m", weakness.limit_m},
               {"least_margin", weakness.options.stretches.least_margin},
               {"route_m", weakness.route_m},
               {"weak_m", weakness.weak_m},
               {"unmet_m", weakness.unmet_m},
               {"stretch_count", static_cast<std::int64_t>(weakness.stretch_count)},
               {"positions_are", std::string("world coordinates, m")}}};
  const Eigen::Vector3d& origin_m = sites.frame.origin_world_m;
  for (const auto& [name, cell] : row_of({}, origin_m, origin_m)) table.columns.emplace_back(name);
  for (const ExplainedStretch& one : weakness.stretches) {
    const Eigen::Vector3d p_m = sites.frame.world_m(sites.sites[one.stretch.worst_site].p_map_m);
    std::vector<Cell>& row = table.rows.emplace_back();
    for (const auto& [name, cell] : row_of(one, p_m, origin_m)) row.push_back(cell);
  }
  return table;
}

}  // namespace sightline
