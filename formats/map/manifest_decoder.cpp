#include <cmath>

#include "formats/map/container/packed_block.h"
#include "formats/map/manifest.h"
#include "formats/reader/map_checks.h"
#include "map_generated.h"

namespace sightline {
namespace {

Pose from_schema(const schema::Rigid& rigid) {
  Pose pose = Pose::Identity();
  for (int i = 0; i < 12; ++i) {
    pose(i / 4, i % 4) = rigid.row_major()->Get(static_cast<flatbuffers::uoffset_t>(i));
  }
  return pose;
}

SensorProfile decode_sensor(const schema::Sensor& sensor) {
  SensorProfile profile;
  profile.name = sensor.name()->str();
  profile.beam_elevations_deg.assign(sensor.beam_elevations_deg()->begin(),
                                     sensor.beam_elevations_deg()->end());
  profile.azimuth_step_deg = sensor.azimuth_step_deg();
  profile.azimuth_view_deg = sensor.azimuth_view_deg();
  profile.min_range_m = sensor.min_range_m();
  profile.max_range_m = sensor.max_range_m();
  profile.height_m = sensor.height_m();
  profile.T_vehicle_lidar = from_schema(*sensor.vehicle_from_lidar());
  return profile;
}

LocalizerProfile decode_localizer(const schema::LocalizerProfile& from) {
  LocalizerProfile profile{from.name()->str(), from.version(), {}};
  for (const schema::Fact* fact : *from.parameters()) {
    profile.parameters.emplace_back(fact->name()->str(), fact->value()->str());
  }
  return profile;
}

Look decode_look(const schema::Look& look) {
  return {look.range_m(),     look.return_count(),  look.even_beyond_m(),
          look.point_count(), look.is_by_normals(), static_cast<LookMode>(look.mode())};
}

std::vector<InitialOffset> decode_offsets(
    const flatbuffers::Vector<const schema::Offset*>& encoded) {
  std::vector<InitialOffset> offsets;
  for (const schema::Offset* offset : encoded) {
    offsets.push_back({offset->x_m(), offset->y_m(), offset->z_m(), offset->yaw_rad()});
  }
  return offsets;
}

MeasurementCard decode_measurement(const schema::Measurement& measurement) {
  MeasurementCard card;
  card.mapping_drive = measurement.mapping_drive()->str();
  card.mapping_scans = measurement.mapping_scans()->str();
  card.localization_drive = measurement.localization_drive()->str();
  card.localization_scans = measurement.localization_scans()->str();
  card.reference = static_cast<ErrorReference>(measurement.reference());
  card.offsets = decode_offsets(*measurement.offsets());
  card.measured_site_count = measurement.measured_site_count();
  card.localizer = decode_localizer(*measurement.localizer());
  card.coarse_cells = measurement.coarse_cells();
  card.leaf_m = measurement.leaf_m();
  if (measurement.tracking_offsets() != nullptr) {
    card.tracking_offsets = decode_offsets(*measurement.tracking_offsets());
  }
  if (measurement.tracking_looks() != nullptr) {
    for (const schema::Look* look : *measurement.tracking_looks()) {
      card.tracking_looks.push_back(decode_look(*look));
    }
  }
  return card;
}

LimitPromise decode_promise(const schema::Promise& from) {
  LimitPromise promise;
  promise.limit_m = from.limit_m();
  promise.probability_threshold = from.probability_threshold();
  promise.history_threshold = from.history_threshold();
  promise.alpha = from.alpha();
  promise.delta = from.delta();
  promise.block_count = from.block_count();
  promise.is_earned = from.is_earned();
  promise.calibration_miss_share = from.calibration_miss_share();
  promise.method = from.method()->str();
  promise.statement = from.statement()->str();
  promise.place_count = from.place_count();
  promise.drive_count = from.drive_count();
  promise.scope = static_cast<PromiseScope>(from.scope());
  promise.answered_share = from.answered_share();
  return promise;
}

std::vector<Look> decode_looks(const schema::Manifest& manifest) {
  std::vector<Look> looks;
  for (const schema::Look* look : *manifest.looks()) looks.push_back(decode_look(*look));
  return looks;
}

LookPlan decode_plan(const schema::LookPlan& from) {
  LookPlan plan;
  plan.limit_m = from.limit_m();
  plan.first = decode_look(*from.first());
  std::ranges::copy(*from.weights(), plan.test.weights.begin());
  plan.test.constant = from.constant();
  plan.doubt_above = from.doubt_above();
  plan.second = decode_look(*from.second());
  return plan;
}

std::vector<LimitQuality> decode_quality(
    const flatbuffers::Vector<flatbuffers::Offset<schema::LimitQuality>>& from) {
  std::vector<LimitQuality> quality;
  for (const schema::LimitQuality* limit : from) {
    quality.push_back({limit->unmet_count(), limit->extrapolated_count(), limit->mean_range_m(),
                       limit->expected_coverage(), limit->measured_coverage()});
  }
  return quality;
}

SharpnessFigures decode_figures(const schema::SharpnessFigures& figures) {
  return {figures.mean_entropy_nat(), figures.entropy_points(), figures.mean_plane_variance_m2(),
          figures.plane_points()};
}

Eigen::Vector3d from_schema(const schema::Vector3& point_m) {
  return {point_m.x(), point_m.y(), point_m.z()};
}

UnconstrainedStretch decode_stretch(const schema::UnconstrainedStretch& from) {
  UnconstrainedStretch stretch;
  stretch.first_scan = from.first_scan();
  stretch.last_scan = from.last_scan();
  stretch.way_m = from.way_m();
  stretch.directions = {from.along(), from.across(), from.heading(),
                        static_cast<Substitute>(from.substitute())};
  if (from.sigma_m() >= 0.0) stretch.sigma_m = from.sigma_m();
  stretch.begin_map_m = from_schema(*from.begin_map_m());
  stretch.end_map_m = from_schema(*from.end_map_m());
  return stretch;
}

std::optional<TrajectoryQuality> decode_trajectory(const schema::TrajectoryQuality* from) {
  if (from == nullptr) return std::nullopt;
  TrajectoryQuality quality{static_cast<PoseSource>(from->source()),
                            from->odometry_edges(),
                            from->loop_edges(),
                            from->prior_edges(),
                            from->rms_translation_residual_m(),
                            from->rms_rotation_residual_rad()};
  if (from->pieces() != nullptr) {
    for (const schema::TrajectoryPiece* piece : *from->pieces()) {
      quality.pieces.push_back({piece->first_scan(), piece->stamp_ns(), piece->scan_count(),
                                piece->way_m(), from_schema(*piece->begin_map_m())});
    }
  }
  if (from->unconstrained() != nullptr) {
    for (const schema::UnconstrainedStretch* stretch : *from->unconstrained()) {
      quality.unconstrained.push_back(decode_stretch(*stretch));
    }
  }
  quality.overlap_count = from->overlap_count();
  quality.median_overlap = from->median_overlap();
  quality.least_overlap = from->least_overlap();
  return quality;
}

std::vector<Notice> decode_notices(
    const flatbuffers::Vector<flatbuffers::Offset<schema::Notice>>* from) {
  std::vector<Notice> notices;
  if (from == nullptr) return notices;
  for (const schema::Notice* notice : *from) {
    notices.push_back({notice->code()->str(), notice->text()->str(), notice->count(),
                       notice->first_scan(), notice->last_scan(), notice->amount(),
                       notice->unit()->str()});
  }
  return notices;
}

// An unknown direction or substitute could not be named.
bool has_known_stretches(const schema::TrajectoryQuality* trajectory) {
  if (trajectory == nullptr || trajectory->unconstrained() == nullptr) return true;
  const auto is_known = [](const schema::UnconstrainedStretch* stretch) {
    return stretch->substitute() <= schema::Substitute::MAX &&
           (stretch->along() || stretch->across() || stretch->heading()) &&
           std::isfinite(stretch->way_m()) && std::isfinite(stretch->sigma_m());
  };
  return std::all_of(trajectory->unconstrained()->begin(), trajectory->unconstrained()->end(),
                     is_known);
}

std::optional<Sharpness> decode_sharpness(const schema::Sharpness* from) {
  if (from == nullptr) return std::nullopt;
  Sharpness sharpness;
  sharpness.of_map = decode_figures(*from->of_map());
  if (from->of_given() != nullptr) sharpness.of_given = decode_figures(*from->of_given());
  return sharpness;
}

ModelRecord decode_model(const schema::Model& model) {
  ModelRecord record;
  record.encoding_version = model.encoding_version();
  record.digest = to_digest(*model.digest());
  for (const schema::Fact* fact : *model.card()) {
    record.card.emplace_back(fact->name()->str(), fact->value()->str());
  }
  if (model.figures() != nullptr) {
    for (const schema::CardFigure* figure : *model.figures()) {
      record.figures.push_back({figure->fact(), static_cast<CardFigureKind>(figure->kind()),
                                figure->of()->str(), figure->value()});
    }
  }
  record.mean_r_squared = model.mean_r_squared();
  record.localizer = decode_localizer(*model.localizer());
  return record;
}

void decode_choices(const schema::Manifest& manifest, CompiledMap& map) {
  const std::vector<double> ranges_m(manifest.ranges_m()->begin(), manifest.ranges_m()->end());
  map.ranges.looks = every_return_at(ranges_m);
  map.predicted.looks = map.ranges.looks;
  map.ranges.selection = static_cast<Selection>(manifest.rule());
  map.ranges.dilation_m = manifest.dilation_m();
  for (const schema::Promise* promise : *manifest.promises()) {
    map.ranges.promises.push_back(decode_promise(*promise));
    map.predicted.limits_m.push_back(promise->limit_m());
  }
  map.quality = decode_quality(*manifest.quality());
  if (answer_shape(manifest).looks == 0) return;
  auto& [predicted, ranges, quality, factors] = map.looks.emplace();
  ranges.looks = predicted.looks = decode_looks(manifest);
  ranges.selection = map.ranges.selection;
  ranges.dilation_m = map.ranges.dilation_m;
  for (const schema::Promise* promise : *manifest.look_promises()) {
    ranges.promises.push_back(decode_promise(*promise));
  }
  if (manifest.look_plan() != nullptr) ranges.plan = decode_plan(*manifest.look_plan());
  predicted.limits_m = map.predicted.limits_m;
  quality = decode_quality(*manifest.look_quality());
}

}  // namespace

Result<void> decode_manifest(const schema::Manifest& manifest, CompiledMap& map) {
  const auto has_unknown_scope = [](const schema::Promise* promise) {
    return promise->scope() > schema::Scope::MAX;
  };
  const auto is_unknown_figure = [](const schema::CardFigure* figure) {
    return figure->kind() > schema::CardFigureKind::MAX;
  };
  const auto* figures = manifest.model()->figures();
  if (!is_tiling(manifest.cell_m(), manifest.tile_m()) || manifest.rule() > schema::Rule::MAX ||
      std::any_of(manifest.promises()->begin(), manifest.promises()->end(), has_unknown_scope) ||
      manifest.measurement()->reference() > schema::Reference::MAX ||
      (figures != nullptr && std::any_of(figures->begin(), figures->end(), is_unknown_figure)) ||
      (manifest.trajectory() != nullptr &&
       manifest.trajectory()->source() > schema::PoseSource::MAX) ||
      !has_known_stretches(manifest.trajectory())) {
    return Error{ErrorCode::kBadManifest,
                 "the tile edge is not a multiple of the cell, or a choice is unknown", "",
                 "manifest"};
  }
  map.map_id = manifest.map_id()->str();
  map.version = manifest.version()->str();
  map.release = manifest.release();
  map.writer = manifest.writer()->str();
  if (manifest.world() != nullptr) map.world = manifest.world()->str();
  map.ndt.frame.origin_world_m = from_schema(*manifest.origin_world_m());
  map.sites.frame = map.ndt.frame;
  map.ndt.cell_m = manifest.cell_m();
  map.ndt.tile_m = manifest.tile_m();
  map.sites.spacing_m = manifest.site_spacing_m();
  map.reach_m = manifest.reach_m();
  map.ndt.sparse_cell_count = manifest.sparse_cell_count();
  map.ndt.degenerate_cell_count = manifest.degenerate_cell_count();
  map.ndt.point_count = manifest.point_count();
  decode_choices(manifest, map);
  map.sensor = decode_sensor(*manifest.sensor());
  map.measurement = decode_measurement(*manifest.measurement());
  for (const schema::NamedVersion* definition : *manifest.definitions()) {
    map.definitions.push_back({definition->name()->str(), definition->version()});
  }
  map.model = decode_model(*manifest.model());
  map.sharpness = decode_sharpness(manifest.sharpness());
  map.trajectory = decode_trajectory(manifest.trajectory());
  if (manifest.columns() != nullptr) {
    for (const schema::SiteColumn* column : *manifest.columns()) {
      SiteColumn& card = map.columns.emplace_back();
      card.name = column->name()->str();
      card.unit = column->unit()->str();
      if (column->steps() != nullptr) {
        card.steps.assign(column->steps()->begin(), column->steps()->end());
      }
    }
  }
  map.notices = decode_notices(manifest.notices());
  map.size = static_cast<MapSize>(manifest.size());
  map.predicted.support_margin = manifest.support_margin();
  map.ranges.extrapolated_takes_static = manifest.extrapolated_takes_static();
  if (!map.looks) return {};
  map.looks->predicted.support_margin = map.predicted.support_margin;
  map.looks->ranges.extrapolated_takes_static = map.ranges.extrapolated_takes_static;
  return {};
}

}  // namespace sightline
