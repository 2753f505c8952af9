#include "tests/bench/looks/look_tables.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include "formats/evaluation/look_evaluation.h"

namespace sightline {
namespace {

using Kind = MeasuredRule::Kind;
constexpr std::array<double, 2> kLimits_m = {0.10, 0.25};

// Of one rule in one town.
struct Figures {
  std::array<double, 2> coverage{};
  double median_m = 0.0;
  double points = 0.0, evaluations = 0.0;          // means
  double work = 0.0, time_ms = 0.0, cut_ms = 0.0;  // sums
};

Figures figures_of(RuleFigures places) {
  Figures figures;
  const auto count = static_cast<double>(places.size());
  for (const PlaceFigures& place : places) {
    for (std::size_t l = 0; l < kLimits_m.size(); ++l) {
      figures.coverage[l] += (place.error_m <= kLimits_m[l] ? 1.0 : 0.0) / count;
    }
    figures.points += place.points / count;
    figures.evaluations += place.evaluations / count;
    figures.work += place.work;
    figures.time_ms += place.time_ms;
    figures.cut_ms += place.cut_ms;
  }
  std::ranges::sort(places, {}, &PlaceFigures::error_m);
  figures.median_m = places[places.size() / 2].error_m;
  return figures;
}

// Mean over the towns; work, time and cut over the reference's.
struct Row {
  std::string name;
  Figures mean;
  std::array<double, 2> worst = {1.0, 1.0};
};

Row row_of(const std::string& name, const std::vector<RuleFigures>& of_town,
           const TownsFigures& all) {
  Row row{.name = name, .mean = {}};
  const auto count = static_cast<double>(of_town.size());
  for (std::size_t town = 0; town < of_town.size(); ++town) {
    const Figures figures = figures_of(of_town[town]);
    const Figures reference = figures_of(all[town].front());
    for (std::size_t l = 0; l < row.worst.size(); ++l) {
      row.mean.coverage[l] += figures.coverage[l] / count;
      row.worst[l] = std::min(row.worst[l], figures.coverage[l]);
    }
    row.mean.median_m += figures.median_m / count;
    row.mean.points += figures.points / count;
    row.mean.evaluations += figures.evaluations / count;
    row.mean.work += figures.work / reference.work / count;
    row.mean.time_ms += figures.time_ms / reference.time_ms / count;
    row.mean.cut_ms += figures.cut_ms / reference.time_ms / count;
  }
  return row;
}

// The rules', then the oracles'.
std::vector<Row> rows_of(std::span<const MeasuredRule> rules, const TownsFigures& all) {
  std::vector<Row> rows;
  std::vector<RuleFigures> of_town(all.size());
  for (std::size_t i = 0; i < rules.size(); ++i) {
    for (std::size_t town = 0; town < all.size(); ++town) of_town[town] = all[town][i];
    rows.push_back(row_of(to_text(rules[i]), of_town, all));
  }
  for (const double limit_m : kLimits_m) {
    for (std::size_t town = 0; town < all.size(); ++town) {
      of_town[town] = oracle_of_looks(rules, all[town], limit_m);
    }
    const std::string limit = std::to_string(static_cast<int>(100.0 * limit_m)) + " cm";
    rows.push_back(row_of("oracle of these looks, " + limit, of_town, all));
  }
  return rows;
}

std::string text_of(const CostAtCoverage& found) {
  std::array<char, 32> text{};
  if (found.is_reached) {
    std::snprintf(text.data(), text.size(), "%.3f         ", found.cost);
  } else {
    std::snprintf(text.data(), text.size(), "%.3f (%5.1f %%)", found.cost, 100.0 * found.coverage);
  }
  return text.data();
}

bool is_within(const PlaceFigures& place, double limit_m) { return place.error_m <= limit_m; }

}  // namespace

RuleFigures oracle_of_looks(std::span<const MeasuredRule> rules,
                            std::span<const RuleFigures> figures, double limit_m) {
  RuleFigures oracle(figures.front().size());
  for (std::size_t place = 0; place < oracle.size(); ++place) {
    const PlaceFigures* best = nullptr;
    for (std::size_t i = 0; i < rules.size(); ++i) {
      if (rules[i].kind != Kind::kLook) continue;
      const PlaceFigures& look = figures[i][place];
      const bool is_good = is_within(look, limit_m);
      const bool is_better =
          best == nullptr || (is_good && !is_within(*best, limit_m)) ||
          (is_good && is_within(*best, limit_m) && look.work < best->work) ||
          (!is_good && !is_within(*best, limit_m) && look.error_m < best->error_m);
      if (is_better) best = &look;
    }
    if (best != nullptr) oracle[place] = *best;
  }
  return oracle;
}

void print_looks(std::span<const MeasuredRule> rules, const TownsFigures& figures) {
  std::printf("10 cm (worst)   25 cm (worst)  median  points  runs   work   time   cut  look\n");
  for (const Row& row : rows_of(rules, figures)) {
    const Figures& mean = row.mean;
    std::printf("%5.1f (%5.1f)  %5.1f (%5.1f)  %3.1f cm  %5.0f  %5.1f  %.3f  %.3f  %.3f  %s\n",
                100.0 * mean.coverage[0], 100.0 * row.worst[0], 100.0 * mean.coverage[1],
                100.0 * row.worst[1], 100.0 * mean.median_m, mean.points, mean.evaluations,
                mean.work, mean.time_ms, mean.cut_ms, row.name.c_str());
  }
}

void print_equal_coverage(std::span<const MeasuredRule> rules, const TownsFigures& figures) {
  const std::vector<Row> rows = rows_of(rules, figures);
  for (std::size_t l = 0; l < kLimits_m.size(); ++l) {
    std::vector<CoveredCost> without_map, any;
    for (std::size_t i = 0; i < rules.size(); ++i) {
      const CoveredCost answer = {rows[i].mean.coverage[l], rows[i].mean.time_ms};
      any.push_back(answer);
      if (!needs_normals(rules[i])) without_map.push_back(answer);
    }
    std::printf("\n%2.0f cm   time   best static look of equal coverage: no map; any\n",
                100.0 * kLimits_m[l]);
    for (const Row& row : rows) {
      const double coverage = row.mean.coverage[l];
      const CostAtCoverage no_map = cost_at_coverage(without_map, coverage);
      const bool is_dearer = no_map.is_reached && row.mean.time_ms > 1.001 * no_map.cost;
      std::printf("%5.1f  %.3f   %s %s  %s%s\n", 100.0 * coverage, row.mean.time_ms,
                  text_of(no_map).c_str(), text_of(cost_at_coverage(any, coverage)).c_str(),
                  row.name.c_str(), is_dearer ? " (dearer than without a map)" : "");
    }
  }
}

}  // namespace sightline
