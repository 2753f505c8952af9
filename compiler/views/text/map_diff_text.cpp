#include "compiler/views/text/map_diff_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "compiler/views/verdict/verdict_text.h"
#include "formats/text/numbers.h"
#include "formats/text/quoted_text.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

// One grid with a title; its first row names the columns.
struct Section {
  std::string title;
  TextGrid grid;
  std::string remark;  // a sentence a line
};

constexpr std::size_t kMostStretches = 20;  // what a reviewer reads in a minute
constexpr std::size_t kScreenStretches = 5;
constexpr std::size_t kScreenLimits = 2;
constexpr std::size_t kScreenWidth = 120;

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

// Indices of the stretches to list, along the route: the `most` with the most changes.
std::vector<std::size_t> shown_stretches(const MapDiff& diff, std::size_t most) {
  std::vector<std::size_t> shown;
  for (std::size_t i = 0; i < diff.stretches.size(); ++i) shown.push_back(i);
  const auto weight = [&](std::size_t i) {
    const Stretch& stretch = diff.stretches[i];
    return 10 * std::uint64_t{changed_answers(stretch)} + stretch.nds_added + stretch.nds_removed +
           stretch.nds_moved;
  };
  if (shown.size() > most) {
    std::stable_sort(shown.begin(), shown.end(),
                     [&](std::size_t a, std::size_t b) { return weight(a) > weight(b); });
    shown.resize(most);
    std::sort(shown.begin(), shown.end());
  }
  return shown;
}

std::string answer_text(const Stretch& stretch, const StretchLimit& limit) {
  if (stretch.is_of_old_map) return "removed";
  if (stretch.is_new()) return "new";
  std::string text =
      concat(fixed(limit.mean_range_before_m, 1), " -> ", fixed(limit.mean_range_after_m, 1), " m");
  const std::string unmet = counts(limit.newly_unmet, limit.no_longer_unmet, 0);
  return unmet.empty() ? text : text + ", unmet " + unmet;
}

std::string sites_text(const Stretch& stretch) {
  if (stretch.sites_removed > 0) return fmt::format("-{}", stretch.sites_removed);
  return stretch.sites_added > 0 ? fmt::format("+{}", stretch.sites_added) : "";
}

std::vector<std::string> stretch_row(const Stretch& stretch, std::size_t limit_count) {
  const Eigen::Vector3d& middle_m = stretch.line_world_m[stretch.line_world_m.size() / 2];
  std::vector<std::string> row = {
      fmt::format("{}{}, {:.0f} - {:.0f} m", stretch.is_of_old_map ? "old run " : "run ",
                  stretch.run, stretch.begin_s_m, stretch.end_s_m),
      concat(fixed(middle_m.x(), 0), ", ", fixed(middle_m.y(), 0)),
      stretch.has_changed_place ? counts(stretch.nds_added, stretch.nds_removed, stretch.nds_moved)
                                : "",
      sites_text(stretch)};
  for (std::size_t i = 0; i < limit_count; ++i) {
    row.push_back(answer_text(stretch, stretch.limits[i]));
  }
  return row;
}

std::string stretches_legend(const MapDiff& diff, std::size_t hidden) {
  std::string text = concat(
      "NDs (cells of the map): + added, - removed, ~ moved by more than ",
      format_double(diff.options.tolerance_m), " m; none: only the ranges changed.\n",
      "sites (places with an answer): + new, - removed; unmet: + places without a sufficient "
      "range, - no longer.");
  if (hidden > 0) text += fmt::format("\n{} smaller changes are not listed.", hidden);
  if (diff.nds_scattered + diff.nds_off_route > 0) {
    text += fmt::format("\nFurther changed NDs: {} elsewhere along the route, {} far from it.",
                        diff.nds_scattered, diff.nds_off_route);
  }
  return text;
}

// Of the `most` stretches with the most changes, and of the tightest `limit_count` common limits.
Section stretches_section(const MapDiff& diff, std::size_t most, std::size_t limit_count) {
  Section section{"Stretches of route that changed", {}, ""};
  section.grid = {{"where", "around world x, y (m)", "NDs", "sites"}};
  const std::vector<double> limits_m = common_limits_m(diff);
  for (std::size_t i = 0; i < limit_count; ++i) {
    section.grid[0].push_back("mean range for " + limit_name(limits_m[i]));
  }
  const std::vector<std::size_t> shown = shown_stretches(diff, most);
  for (const std::size_t i : shown) {
    section.grid.push_back(stretch_row(diff.stretches[i], limit_count));
  }
  section.remark = stretches_legend(diff, diff.stretches.size() - shown.size());
  return section;
}

std::size_t width_of(const TextGrid& grid) {
  std::istringstream lines(aligned(grid));
  std::size_t width = 0;
  for (std::string line; std::getline(lines, line);) width = std::max(width, line.size());
  return width;
}

// As many limits as fit beside each other.
Section stretches_on_screen(const MapDiff& diff) {
  std::size_t limit_count = common_limits_m(diff).size();
  while (true) {
    Section section = stretches_section(diff, kScreenStretches, limit_count);
    if (limit_count == 0 || width_of(section.grid) <= kScreenWidth) return section;
    --limit_count;
  }
}

std::vector<std::string> quality_row(const std::string& name, const LimitDiff& limit, double scale,
                                     double LimitQuality::*value) {
  std::vector<std::string> row = {name, "-", "-", ""};
  if (limit.before) row[1] = fixed(scale * ((*limit.before).*value), 1);
  if (limit.after) row[2] = fixed(scale * ((*limit.after).*value), 1);
  if (limit.is_common()) {
    row[3] = signed_number(scale * ((*limit.after).*value - (*limit.before).*value), 1);
  }
  return row;
}

std::vector<std::string> unmet_row(const std::string& name, const LimitDiff& limit) {
  std::vector<std::string> row = {name, "-", "-", ""};
  if (limit.before) row[1] = std::to_string(limit.before->unmet_count);
  if (limit.after) row[2] = std::to_string(limit.after->unmet_count);
  if (limit.is_common()) {
    row[3] = signed_number(
        double{1} * limit.after->unmet_count - double{1} * limit.before->unmet_count, 0);
  }
  return row;
}

// The figures that matter most, for the tightest limits.
Section limits_on_screen(const MapDiff& diff) {
  Section section{"All sites", {{"", "before", "after", ""}}, ""};
  for (std::size_t i = 0; i < std::min(diff.limits.size(), kScreenLimits); ++i) {
    const LimitDiff& limit = diff.limits[i];
    const std::string name = limit_name(limit.limit_m);
    section.grid.push_back(
        quality_row("mean range for " + name + " (m)", limit, 1.0, &LimitQuality::mean_range_m));
    section.grid.push_back(quality_row("predicted within " + name + " (%)", limit, 100.0,
                                       &LimitQuality::expected_coverage));
    section.grid.push_back(unmet_row("sites without a sufficient range for " + name, limit));
  }
  return section;
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
  section.grid.push_back(unmet_row("sites unmet", limit));
  if (limit.is_common()) {
    section.remark =
        fmt::format("{} sites have a longer range, {} a shorter one; {} newly unmet, {} no longer.",
                    limit.rose, limit.fell, limit.newly_unmet, limit.no_longer_unmet);
  }
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

bool share_no_road(const MapDiff& diff) {
  return diff.before.site_count > 0 && diff.after.site_count > 0 &&
         diff.sites_removed == diff.before.site_count && diff.sites_added == diff.after.site_count;
}

// "5 of 121 sites have other answers, 2 are new; 3 of the old map's 122 are removed."
std::string answers_sentence(const MapDiff& diff) {
  std::string text =
      fmt::format("{} of {} sites have other answers",
                  diff.sites.size() - diff.sites_added - diff.sites_removed, diff.after.site_count);
  if (diff.sites_added > 0) text += fmt::format(", {} are new", diff.sites_added);
  if (diff.sites_removed > 0) {
    text += fmt::format("; {} of the old map's {} are removed", diff.sites_removed,
                        diff.before.site_count);
  }
  return text + ".";
}

std::string headline(const MapDiff& diff) {
  if (diff.is_same()) return "The maps are the same.";
  if (share_no_road(diff)) {
    return fmt::format(
        "The maps share no road: none of the old map's {} sites is near one of the new map's {}.",
        diff.before.site_count, diff.after.site_count);
  }
  if (diff.stretches.empty()) return "The maps differ, but not along the route.";
  double changed_m = 0.0;
  for (const Stretch& stretch : diff.stretches) {
    const bool is_street = stretch.has_changed_place || stretch.is_of_old_map;
    if (is_street) changed_m += stretch.end_s_m - stretch.begin_s_m;
  }
  return concat(
      changed_m > 0.0 ? fixed(changed_m, 0) + " m of street changed; " : "No street changed; ",
      answers_sentence(diff));
}

std::vector<Section> sections_of(const MapDiff& diff) {
  std::vector<Section> sections;
  if (!diff.stretches.empty()) {
    sections.push_back(stretches_section(diff, kMostStretches, common_limits_m(diff).size()));
  }
  if (!diff.is_same()) {
    for (const LimitDiff& limit : diff.limits) sections.push_back(limit_section(limit));
    sections.push_back(facts_section(diff));
    if (sections.back().grid.size() == 1) sections.pop_back();
  }
  sections.push_back(size_section(diff));
  return sections;
}

// "Also changed: map_id, model, promise." by the first word of each fact's name.
std::string changed_facts(const MapDiff& diff) {
  std::vector<std::string> names;
  for (const FactDiff& fact : diff.facts) {
    const std::string name = fact.name.substr(0, fact.name.find('.'));
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "Also changed: " : ", ") + name;
  return text.empty() ? text : wrapped(text + ".");
}

std::string change(std::uint64_t before, std::uint64_t after, const std::string& by) {
  const std::string text = concat(before, " -> ", after);
  return by.empty() ? text : concat(text, " (", by, ")");
}

std::string sizes_line(const MapDiff& diff) {
  const DiffedMap& before = diff.before;
  const DiffedMap& after = diff.after;
  return concat("Sites ", change(before.site_count, after.site_count, ""), "; NDs ",
                change(before.nd_count, after.nd_count,
                       counts(diff.nds_added, diff.nds_removed, diff.nds_moved)),
                "; bytes ", change(before.file_size, after.file_size, ""), "\n");
}

std::string text_of(const Section& section) {
  std::string text = concat("\n", section.title, "\n", aligned(section.grid));
  std::istringstream sentences(section.remark);
  for (std::string sentence; std::getline(sentences, sentence);) text += wrapped(sentence);
  return text;
}

std::string markdown_table(const TextGrid& grid) {
  std::string text;
  for (std::size_t row = 0; row < grid.size(); ++row) {
    text += "|";
    for (std::size_t i = 0; i < grid[0].size(); ++i) {
      text += concat(" ", (i < grid[row].size() ? markdown_text(grid[row][i]) : ""), " |");
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
  std::string text = wrapped(headline(diff));
  for (const Section& section : sections_of(diff)) text += text_of(section);
  return text;
}

std::string summary_text(const MapDiff& diff) {
  std::string text = wrapped(headline(diff));
  if (diff.is_same()) return text + sizes_line(diff);
  if (!share_no_road(diff)) {
    if (!diff.stretches.empty()) text += text_of(stretches_on_screen(diff));
    if (!diff.limits.empty()) text += text_of(limits_on_screen(diff));
    text += "\n" + changed_facts(diff);
  }
  return text + sizes_line(diff) + "More: --all prints 20 stretches, every limit and every fact\n";
}

std::string to_markdown(const MapDiff& diff) {
  std::string text = concat("### Map diff: ", headline(diff), "\n");
  for (const Section& section : sections_of(diff)) {
    text += concat("\n**", markdown_text(section.title), "**\n\n", markdown_table(section.grid));
    if (!section.remark.empty()) text += concat("\n", markdown_text(section.remark), "\n");
  }
  return text;
}

}  // namespace sightline
