#include "compiler/views/replay/tuning_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "formats/text/json_text.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

std::string limit_text(double limit_m) { return fmt::format("{:g} cm", 100.0 * limit_m); }

std::string judged_limit(const NdtTuning& tuning) {
  return limit_text(tuning.limits_m[tuning.limit]);
}

std::string numbers_text(const AutowareFilters& filters) {
  return fmt::format("a box of {:g} m, voxels of {:g} m, {} points", filters.box_m, filters.voxel_m,
                     filters.most_points);
}

std::vector<std::string> heading(const NdtTuning& tuning) {
  std::vector<std::string> row = {"", "box", "voxel", "points"};
  for (const double limit_m : tuning.limits_m) row.push_back("within " + limit_text(limit_m));
  for (const char* name : {"lost", "mean error", "matched points", "work", "time"}) {
    row.emplace_back(name);
  }
  return row;
}

std::vector<std::string> row_of(const NdtTuning& tuning, const std::string& name,
                                const TriedFilters& tried) {
  const NdtFigures& figures = tried.figures;
  std::vector<std::string> row = {name, fmt::format("{:g} m", tried.filters.box_m),
                                  fmt::format("{:g} m", tried.filters.voxel_m),
                                  std::to_string(tried.filters.most_points)};
  for (const double share : figures.within_share) row.push_back(percent(share));
  row.push_back(percent(figures.lost_share));
  row.push_back(in_centimetres(figures.error_m) + " cm");
  row.push_back(fixed(figures.point_count, 0));
  const double work = tuning.defaults.figures.work;
  row.push_back(work > 0.0 ? whole_percent(figures.work / work) : "-");
  row.push_back(fixed(figures.time_ms, 1) + " ms");
  return row;
}

std::string table_text(const NdtTuning& tuning) {
  return aligned({heading(tuning), row_of(tuning, "Autoware's numbers", tuning.defaults),
                  row_of(tuning, "least work", tuning.cheapest),
                  row_of(tuning, "most within " + judged_limit(tuning), tuning.best)});
}

// Where Autoware keeps these numbers.
std::string parameters_text(const AutowareFilters& filters) {
  return fmt::format(
      "  crop_box_filter_measurement_range: min_x, min_y -{0:g}, max_x, max_y {0:g}\n"
      "  voxel_grid_downsample_filter: voxel_size_x, voxel_size_y, voxel_size_z {1:g}\n"
      "  random_downsample_filter: sample_num {2}\n",
      filters.box_m, filters.voxel_m, filters.most_points);
}

std::string recommendation(const NdtTuning& tuning, const TriedFilters& tried) {
  return fmt::format(
      "{}; within {} at {} of the matches instead of {}\n{}", numbers_text(tried.filters),
      judged_limit(tuning), percent(tried.figures.within_share[tuning.limit]),
      percent(tuning.defaults.figures.within_share[tuning.limit]), parameters_text(tried.filters));
}

std::string advice_text(const NdtTuning& tuning) {
  std::string text;
  if (tuning.is_cheaper()) {
    text += fmt::format("Cheaper, {} of the work: {}",
                        whole_percent(tuning.cheapest.figures.work / tuning.defaults.figures.work),
                        recommendation(tuning, tuning.cheapest));
  }
  if (tuning.is_better()) {
    text += "Better: " + recommendation(tuning, tuning.best);
  }
  if (!text.empty()) return text;
  return fmt::format(
      "Nothing helps: none of {} combinations is within {} as often for a tenth less work, or a "
      "point "
      "more often. Keep Autoware's numbers\n",
      tuning.tried.size(), judged_limit(tuning));
}

Json json_of(const TriedFilters& tried) {
  const NdtFigures& figures = tried.figures;
  return {{"box_m", tried.filters.box_m},
          {"voxel_m", tried.filters.voxel_m},
          {"most_points", tried.filters.most_points},
          {"within_share", figures.within_share},
          {"lost_share", figures.lost_share},
          {"error_m", figures.error_m},
          {"points", figures.point_count},
          {"work", figures.work},
          {"time_ms", figures.time_ms}};
}

}  // namespace

std::string to_text(const NdtTuning& tuning) {
  return fmt::format(
             "PCL's NDT on {} scans of {}: {} chose the numbers, {} others judge them, from {} "
             "tracking starts each; resolution {:g} m\n\n",
             tuning.choosing_scan_count + tuning.judging_scan_count, tuning.drive,
             tuning.choosing_scan_count, tuning.judging_scan_count, tuning.start_count,
             tuning.cell_m) +
         table_text(tuning) + "\n" + advice_text(tuning);
}

std::string to_json(const NdtTuning& tuning) {
  Json tried = Json::array();
  for (const TriedFilters& one : tuning.tried) tried.push_back(json_of(one));
  return json_text(Json{{"format", "sightline-tune"},
                        {"version", 1},
                        {"localizer", "pcl-ndt"},
                        {"drive", tuning.drive},
                        {"resolution_m", tuning.cell_m},
                        {"reference", std::string(name_of(tuning.reference))},
                        {"limits_m", tuning.limits_m},
                        {"limit_m", tuning.limits_m[tuning.limit]},
                        {"starts", tuning.start_count},
                        {"choosing_scans", tuning.choosing_scan_count},
                        {"judging_scans", tuning.judging_scan_count},
                        {"is_cheaper", tuning.is_cheaper()},
                        {"is_better", tuning.is_better()},
                        {"defaults", json_of(tuning.defaults)},
                        {"cheapest", json_of(tuning.cheapest)},
                        {"best", json_of(tuning.best)},
                        {"tried", tried}});
}

}  // namespace sightline
