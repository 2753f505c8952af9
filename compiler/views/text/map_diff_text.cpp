#include "compiler/views/text/map_diff_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

// One grid with a title; its first row names the columns.
struct Section {
  std::string title;
  TextGrid grid;
  std::string remark;
};

constexpr std::size_t kMostStretches = 20;  // what a reviewer reads in a minute

std::string signed_number(double value, int decimals) {
  return (value > 0.0 ? "+" : "") + fixed(value, decimals);
}

std::string limit_name(double limit_m) { return format_double(limit_m) + " m"; }

// The first twelve digits of a digest are enough to tell two apart; JSON has long texts whole.
std::string shortened(const std::string& value) {
  constexpr std::size_t kLongest = 36;
  constexpr std::size_t kDigestSize = 64;
  const bool is_digest = value.size() == kDigestSize &&
                         value.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (is_digest) return value.substr(0, 12);
  if (value.size() > kLongest) return value.substr(0, kLongest - 3) + "...";
  return value.empty() ? "-" : value;
}

std::string counts(std::uint64_t added, std::uint64_t removed, std::uint64_t moved) {
  std::string text;
  if (added > 0) text += fmt::format(" +{}", added);
  if (removed > 0) text += fmt::format(" -{}", removed);
  if (moved > 0) text += fmt::format(" ~{}", moved);
  return text.empty() ? "" : text.substr(1);
}

std::uint32_t changed_answers(const Stretch& stretch) {
  std::uint32_t most = stretch.sites_added + stretch.sites_removed;
  for (const StretchLimit& limit : stretch.limits) {
    most = std::max(most, limit.rose + limit.fell + limit.newly_unmet + limit.no_longer_unmet);
  }
  return most;
}

// Indices of the stretches to tell, along the route.
std::vector<std::size_t> shown_stretches(const MapDiff& diff) {
  std::vector<std::size_t> shown;
  for (std::size_t i = 0; i < diff.stretches.size(); ++i) shown.push_back(i);
  const auto weight = [&](std::size_t i) {
    const Stretch& stretch = diff.stretches[i];
    return 10 * std::uint64_t{changed_answers(stretch)} + stretch.nds_added + stretch.nds_removed +
           stretch.nds_moved;
  };
  if (shown.size() > kMostStretches) {
    std::stable_sort(shown.begin(), shown.end(),
                     [&](std::size_t a, std::size_t b) { return weight(a) > weight(b); });
    shown.resize(kMostStretches);
    std::sort(shown.begin(), shown.end());
  }
  return shown;
}

std::string answer_text(const Stretch& stretch, const StretchLimit& limit) {
  if (stretch.is_of_old_map) return "removed";
  if (stretch.is_new()) return "new";
  std::string text =
      concat(fixed(limit.mean_range_before_m, 1), " -> ", fixed(limit.mean_range_after_m, 1), " m");
  if (limit.newly_unmet > 0) text += fmt::format(", {} newly unmet", limit.newly_unmet);
  if (limit.no_longer_unmet > 0) text += fmt::format(", {} no longer", limit.no_longer_unmet);
  return text;
}

std::string sites_text(const Stretch& stretch) {
  if (stretch.sites_removed > 0) return fmt::format("-{}", stretch.sites_removed);
  return stretch.sites_added > 0 ? fmt::format("+{}", stretch.sites_added) : "";
}

std::vector<std::string> stretch_row(const Stretch& stretch) {
  const Eigen::Vector3d& middle_m = stretch.line_world_m[stretch.line_world_m.size() / 2];
  std::vector<std::string> row = {
      fmt::format("{}{}, {:.0f} - {:.0f} m", stretch.is_of_old_map ? "old run " : "run ",
                  stretch.run, stretch.begin_s_m, stretch.end_s_m),
      concat(fixed(middle_m.x(), 0), ", ", fixed(middle_m.y(), 0)),
      stretch.has_changed_place ? counts(stretch.nds_added, stretch.nds_removed, stretch.nds_moved)
                                : "",
      sites_text(stretch)};
  for (const StretchLimit& limit : stretch.limits) row.push_back(answer_text(stretch, limit));
  return row;
}

Section stretches_section(const MapDiff& diff) {
  Section section{"Stretches of route that changed", {}, ""};
  section.grid = {{"where", "around world x, y (m)", "NDs", "sites"}};
  for (const double limit_m : common_limits_m(diff)) {
    section.grid[0].push_back("mean range for " + limit_name(limit_m));
  }
  const std::vector<std::size_t> shown = shown_stretches(diff);
  for (const std::size_t i : shown) section.grid.push_back(stretch_row(diff.stretches[i]));
  const std::size_t hidden = diff.stretches.size() - shown.size();
  section.remark = concat("NDs: + added, - removed, ~ moved by more than ",
                          format_double(diff.options.tolerance_m),
                          " m. Where none are listed, only the ranges changed.");
  if (hidden > 0) section.remark += fmt::format(" {} smaller changes are not listed.", hidden);
  if (diff.nds_scattered > 0) {
    section.remark +=
        fmt::format(" {} changed NDs scattered along the rest of the route.", diff.nds_scattered);
  }
  if (diff.nds_off_route > 0) {
    section.remark += fmt::format(" {} changed NDs far from the route.", diff.nds_off_route);
  }
  return section;
}

std::vector<std::string> quality_row(const char* name, const LimitDiff& limit, double scale,
                                     double LimitQuality::*value) {
  std::vector<std::string> row = {name, "-", "-", ""};
  if (limit.before) row[1] = fixed(scale * ((*limit.before).*value), 1);
  if (limit.after) row[2] = fixed(scale * ((*limit.after).*value), 1);
  if (limit.is_common()) {
    row[3] = signed_number(scale * ((*limit.after).*value - (*limit.before).*value), 1);
  }
  return row;
}

Section limit_section(const LimitDiff& limit) {
  Section section{"Limit " + limit_name(limit.limit_m), {}, ""};
  section.grid = {
      {"all sites", "before", "after", ""},
      quality_row("mean range (m)", limit, 1.0, &LimitQuality::mean_range_m),
      quality_row("coverage expected (%)", limit, 100.0, &LimitQuality::expected_coverage),
      quality_row("coverage measured (%)", limit, 100.0, &LimitQuality::measured_coverage)};
  if (limit.work_before && limit.work_after) {
    section.grid.push_back({"work in changed tiles (% of the longest range's)",
                            fixed(100.0 * *limit.work_before, 1),
                            fixed(100.0 * *limit.work_after, 1),
                            signed_number(100.0 * (*limit.work_after - *limit.work_before), 1)});
  }
  std::vector<std::string> unmet = {"sites unmet", "-", "-", ""};
  if (limit.before) unmet[1] = std::to_string(limit.before->unmet_count);
  if (limit.after) unmet[2] = std::to_string(limit.after->unmet_count);
  if (limit.is_common()) {
    unmet[3] = signed_number(
        double{1} * limit.after->unmet_count - double{1} * limit.before->unmet_count, 0);
    section.remark =
        fmt::format("{} sites have a longer range, {} a shorter one; {} newly unmet, {} no longer.",
                    limit.rose, limit.fell, limit.newly_unmet, limit.no_longer_unmet);
  }
  section.grid.push_back(unmet);
  return section;
}

std::string difference(std::uint64_t before, std::uint64_t after) {
  const double change = static_cast<double>(after) - static_cast<double>(before);
  return change == 0.0 ? "" : signed_number(change, 0);
}

Section facts_section(const MapDiff& diff) {
  Section section{"What else changed", {{"", "before", "after"}}, ""};
  for (const FactDiff& fact : diff.facts) {
    section.grid.push_back({fact.name, shortened(fact.before), shortened(fact.after)});
  }
  for (const BlockDiff& block : diff.blocks) {
    if (block.is_required || block.added + block.removed + block.changed == 0) continue;
    section.grid.push_back(
        {"optional " + block.name, std::to_string(block.same + block.changed + block.removed),
         fmt::format("{}, {} changed", block.same + block.changed + block.added, block.changed)});
  }
  return section;
}

Section size_section(const MapDiff& diff) {
  const DiffedMap& before = diff.before;
  const DiffedMap& after = diff.after;
  Section section{"Map " + after.map_id, {{"", "before", "after", ""}}, ""};
  const auto append = [&](const char* name, std::uint64_t old_count, std::uint64_t new_count,
                          const std::string& change) {
    section.grid.push_back({name, std::to_string(old_count), std::to_string(new_count), change});
  };
  section.grid.push_back({"root digest", shortened(to_hex(before.root_digest)),
                          shortened(to_hex(after.root_digest)), ""});
  append("tiles", before.tile_count, after.tile_count,
         counts(diff.tiles_added, diff.tiles_removed, diff.tiles_changed));
  append("NDs", before.nd_count, after.nd_count,
         diff.has_comparable_nds ? counts(diff.nds_added, diff.nds_removed, diff.nds_moved)
                                 : "not comparable");
  append("sites", before.site_count, after.site_count,
         counts(diff.sites_added, diff.sites_removed,
                diff.sites.size() - diff.sites_added - diff.sites_removed));
  append("bytes", before.file_size, after.file_size, difference(before.file_size, after.file_size));
  const double size = static_cast<double>(before.file_size + after.file_size);
  section.remark =
      percent(static_cast<double>(diff.bytes_read) / size) + " of both files were read.";
  return section;
}

std::string headline(const MapDiff& diff) {
  if (diff.is_same()) return "The maps are the same.";
  if (diff.stretches.empty()) return "The maps differ, but not along the route.";
  double changed_m = 0.0;
  for (const Stretch& stretch : diff.stretches) {
    const bool is_street = stretch.has_changed_place || stretch.is_of_old_map;
    if (is_street) changed_m += stretch.end_s_m - stretch.begin_s_m;
  }
  return fmt::format(
      "{}{} of {} sites have other answers.",
      changed_m > 0.0 ? fixed(changed_m, 0) + " m of street changed; " : "No street changed; ",
      diff.sites.size(), diff.after.site_count);
}

std::vector<Section> sections_of(const MapDiff& diff) {
  std::vector<Section> sections;
  if (!diff.stretches.empty()) sections.push_back(stretches_section(diff));
  if (!diff.is_same()) {
    for (const LimitDiff& limit : diff.limits) sections.push_back(limit_section(limit));
    sections.push_back(facts_section(diff));
    if (sections.back().grid.size() == 1) sections.pop_back();
  }
  sections.push_back(size_section(diff));
  return sections;
}

// A cell of a Markdown table; what people wrote may hold its signs.
std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (std::string_view("|\\`*_<>[]").find(c) != std::string_view::npos) safe += '\\';
    safe += c == '\n' || c == '\r' ? ' ' : c;
  }
  return safe;
}

std::string markdown_table(const TextGrid& grid) {
  std::string text;
  for (std::size_t row = 0; row < grid.size(); ++row) {
    text += "|";
    for (std::size_t i = 0; i < grid[0].size(); ++i) {
      text += concat(" ", (i < grid[row].size() ? escaped(grid[row][i]) : ""), " |");
    }
    text += "\n";
    if (row > 0) continue;
    text += "|---|";
    for (std::size_t i = 1; i < grid[0].size(); ++i) text += "---:|";
    text += "\n";
  }
  return text;
}

}  // namespace

std::string to_text(const MapDiff& diff) {
  std::string text = headline(diff) + "\n";
  for (const Section& section : sections_of(diff)) {
    text += concat("\n", section.title, "\n", aligned(section.grid));
    if (!section.remark.empty()) text += section.remark + "\n";
  }
  return text;
}

std::string to_markdown(const MapDiff& diff) {
  std::string text = concat("### Map diff: ", headline(diff), "\n");
  for (const Section& section : sections_of(diff)) {
    text += concat("\n**", escaped(section.title), "**\n\n", markdown_table(section.grid));
    if (!section.remark.empty()) text += concat("\n", escaped(section.remark), "\n");
  }
  return text;
}

}  // namespace sightline
