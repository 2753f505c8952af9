#include <algorithm>
#include <cmath>
#include <numbers>

#include "compiler/views/picture/charts/chart_svg.h"
#include "compiler/views/report/sections/sections.h"

// How the map was made: the trajectory, how sharp the map is, and what was taken out.

namespace sightline {
namespace {

std::string source_words(PoseSource source) {
  switch (source) {
    case PoseSource::kGiven:
      return "as given with the recording";
    case PoseSource::kRefined:
      return "given, and refined by the scans";
    case PoseSource::kEstimated:
      return "estimated from the scans";
  }
  return "";
}

// 0 between pieces, whose distance means nothing.
double step_m(const Trajectory& trajectory, std::size_t i) {
  if (i == 0 || trajectory.poses[i].piece != trajectory.poses[i - 1].piece) return 0.0;
  return (trajectory.poses[i].T_map_vehicle.translation() -
          trajectory.poses[i - 1].T_map_vehicle.translation())
      .norm();
}

std::string pieces_table(const TrajectoryQuality& quality) {
  if (quality.pieces.size() < 2) return "";
  TextGrid grid = {{"piece", "first scan", "time (s)", "scans", "way (m)", "begins at (m)"}};
  for (std::size_t i = 0; i < quality.pieces.size(); ++i) {
    const TrajectoryPiece& piece = quality.pieces[i];
    const Eigen::Vector3d& at_m = piece.begin_map_m;
    grid.push_back({std::to_string(i), std::to_string(piece.first_scan),
                    fixed(1e-9 * static_cast<double>(piece.stamp_ns), 3),
                    std::to_string(piece.scan_count), fixed(piece.way_m, 1),
                    fixed(at_m.x(), 1) + ", " + fixed(at_m.y(), 1) + ", " + fixed(at_m.z(), 1)});
  }
  return html_table(grid,
                    "Pieces of the trajectory. How they lie to each other is not known: they are "
                    "laid side by side, and distances between them mean nothing");
}

std::string trajectory_facts(const Trajectory& trajectory) {
  double way_m = 0.0;
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) way_m += step_m(trajectory, i);
  const TrajectoryQuality quality = quality_of(trajectory);
  const double to_deg = 180.0 / std::numbers::pi;
  std::vector<std::pair<std::string, std::string>> facts = {
      {"poses", std::to_string(trajectory.poses.size()) + ", " + source_words(trajectory.source)},
      {"way", fixed(way_m, 1) + " m"}};
  if (quality.overlap_count > 0) {
    facts.emplace_back("overlap with what was seen before",
                       "median " + fixed(100.0 * quality.median_overlap, 0) + " %, least " +
                           fixed(100.0 * quality.least_overlap, 0) + " %");
  }
  if (trajectory.odometry_edges > 0) {
    facts.emplace_back("pose graph", std::to_string(trajectory.odometry_edges) + " steps, " +
                                         std::to_string(trajectory.loop_edges) +
                                         " places seen again, " +
                                         std::to_string(trajectory.prior_edges) + " given poses");
    facts.emplace_back("residuals (RMS)",
                       in_centimetres(trajectory.rms_translation_residual_m) + " cm, " +
                           fixed(to_deg * trajectory.rms_rotation_residual_rad, 3) + "°");
  }
  return fact_table(facts) + pieces_table(quality);
}

std::string uncertainty_figure(const Trajectory& trajectory) {
  Chart chart;
  chart.title = "Standard deviation of the poses along the drive";
  chart.x_label = "way along the drive (m)";
  chart.y_label = "standard deviation (cm)";
  chart.width_px = 1080.0;
  chart.height_px = 200.0;
  chart.least_y = 0.0;
  ChartSeries level = {"horizontal", kBlue, Mark::kLine, {}, {}, {}, 1.6, false};
  ChartSeries height = {"vertical", kOrange, Mark::kLine, {}, {}, {}, 1.6, true};
  double way_m = 0.0;
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    const TrajectoryPose& pose = trajectory.poses[i];
    way_m += step_m(trajectory, i);
    level.x.push_back(way_m);
    level.y.push_back(100.0 * std::sqrt(pose.covariance(0, 0) + pose.covariance(1, 1)));
    height.x.push_back(way_m);
    height.y.push_back(100.0 * std::sqrt(pose.covariance(2, 2)));
  }
  chart.series = {level, height};
  return html_figure(
      {"trajectory", "Trajectory.",
       "How well the poses that made the map are known relative to the first of their "
       "piece, by the least squares that placed them.",
       chart_svg(chart), ""});
}

std::string sharpness_table(const Sharpness& sharpness) {
  TextGrid grid = {{"poses", "mean map entropy (nat)", "points", "mean plane deviation (cm)",
                    "points in planes"}};
  const auto append = [&](const std::string& name, const SharpnessFigures& figures) {
    grid.push_back({name, fixed(figures.mean_entropy_nat, 3),
                    std::to_string(figures.entropy_points),
                    in_centimetres(std::sqrt(figures.mean_plane_variance_m2)),
                    std::to_string(figures.plane_points)});
  };
  append("that made the map", sharpness.of_map);
  if (sharpness.of_given) append("given", *sharpness.of_given);
  return html_table(grid, "How sharp the scans lie on each other; smaller is sharper");
}

std::string moving_facts(const SurfacePoints& points) {
  if (points.voxel_m == 0.0) return paragraph("Nothing was looked for that moves.");
  const double all = static_cast<double>(points.standing_count + points.moving_count);
  return fact_table(
      {{"removed as moving",
        std::to_string(points.moving_count) + " returns (" +
            fixed(all > 0.0 ? 100.0 * static_cast<double>(points.moving_count) / all : 0.0, 2) +
            " %) in " + std::to_string(points.moved_voxels.size()) + " voxels of " +
            metres(points.voxel_m)},
       {"kept as standing", std::to_string(points.standing_count) + " returns"},
       {"out of the sensor's range", std::to_string(points.out_of_range_count) + " returns"}});
}

}  // namespace

Section making_section(const ReportSources& sources) {
  Section section = {"making", "How the map was made", ""};
  section.html = "<h3>Trajectory</h3>\n";
  if (sources.trajectory) {
    section.html += trajectory_facts(*sources.trajectory);
    const bool has_covariance =
        std::any_of(sources.trajectory->poses.begin(), sources.trajectory->poses.end(),
                    [](const TrajectoryPose& pose) { return pose.covariance(0, 0) > 0.0; });
    if (has_covariance) section.html += uncertainty_figure(*sources.trajectory);
  }
  if (sources.map->sharpness) section.html += sharpness_table(*sources.map->sharpness);
  section.html += "<h3>What was removed as moving</h3>\n";
  section.html += sources.points ? moving_facts(*sources.points)
                                 : paragraph("Not known: the points were not at hand.");
  return section;
}

}  // namespace sightline
