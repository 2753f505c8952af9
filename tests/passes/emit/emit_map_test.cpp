#include "passes/emit/emit_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "formats/base/random.h"
#include "formats/drive/unconstrained_stretches.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/reader/site_errors.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/handmade_model.h"
#include "tests/support/value_of.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// All that emit_map takes; the numbers mean nothing but where a test sets them.
struct Workshop {
  explicit Workshop(const RandomMapOptions& options) : made(random_map(options)) {
    mapping.name = "first drive";
    recordings.cards = {{"mapping", mapping.name, sha256(mapping.name)}};
    mapping.sensor = made.sensor;
    mapping.scans.resize(4);
    for (std::uint32_t i = 0; i < 4; ++i) mapping.scans[i].recording_index = i;
    measured.drive = "second drive";
    measured.reference = ErrorReference::kFullRangeMatch;
    measured.looks = made.ranges.looks;
    measured.offsets = {{0.1, 0.2, 0.0, 0.01}};
    measured.scan_of_site.assign(made.sites.sites.size(), 3);
    measured.rows.resize(made.sites.sites.size() * measured.looks.size());
    model = handmade_model({{{0.5, 0.9}, {0.2, 0.05}}, {{0.6, 0.8}, {0.1, 0.02}}}, 2);
  }
  Result<CompiledMap> emit(const EmitMapOptions& options = {}) {
    PassContext ctx;
    ctx.warning_sink = [this](const std::string& message) { warnings.push_back(message); };
    SIGHTLINE_ASSIGN(const PackedNds nds, pack_nds(made.ndt));
    SIGHTLINE_ASSIGN(const PackedModel packed_model, pack_model(record_of(model)));
    ByFamily<RangeTable> ranges = choice_of(made);
    if (chooses_no_looks) ranges.samples.reset();
    SIGHTLINE_ASSIGN(const MapFile map, emit_map(ctx, options,
                                                 {.nds = nds,
                                                  .sites = made.sites,
                                                  .predicted = predicted_of(made),
                                                  .ranges = ranges,
                                                  .measured = measured,
                                                  .model = packed_model,
                                                  .factors = factors_of(made),
                                                  .sensor = made.sensor,
                                                  .recordings = recordings,
                                                  .mapping = is_finished ? nullptr : &mapping,
                                                  .trajectory = trajectory ? &*trajectory : nullptr,
                                                  .columns = made.columns}));
    EXPECT_TRUE(validate(map));
    EXPECT_EQ(map.predicted_localizer, model.card.localizer);
    SIGHTLINE_ASSIGN(file, map.bytes.read(0, map.bytes.size()));
    return read_map(file);
  }

  CompiledMap made;
  Drive mapping;
  std::optional<Trajectory> trajectory;
  RecordingCards recordings;
  bool chooses_no_looks = false;  // though they are predicted
  bool is_finished = false;       // not of drives: a finished map was annotated
  MeasuredError measured;
  ErrorModel model;
  std::vector<std::string> warnings;
  std::vector<std::byte> file;  // that was emitted last
};

TEST(EmitMap, CarriesWhatThePassesBeforeItMade) {
  Workshop workshop({.seed = 1});
  EmitMapOptions options;
  options.version = "2026.2";
  options.release = 9;
  options.mapping_scans = ScanSelection::kEven;
  const CompiledMap map = value_of(workshop.emit(options));
  EXPECT_EQ(map.version, "2026.2");
  EXPECT_EQ(map.release, 9u);
  EXPECT_EQ(map.map_id.size(), 32u);
  EXPECT_EQ(map.measurement.mapping_drive, "first drive");
  EXPECT_EQ(map.measurement.mapping_scans, "even");
  EXPECT_EQ(map.measurement.localization_drive, "second drive");
  EXPECT_EQ(map.measurement.reference, ErrorReference::kFullRangeMatch);
  EXPECT_EQ(map.measurement.measured_site_count, 40u);
  const Result<CompiledMap> made = read_map(encode_map(workshop.made));  // NDs are rounded
  ASSERT_TRUE(made);
  for (const char* name : {"nds", "sites", "predicted", "ranges", "factors"}) {
    EXPECT_EQ(format_table(*dump(map, name), TableFormat::kCsv),
              format_table(*dump(*made, name), TableFormat::kCsv));
  }
  EXPECT_TRUE(workshop.warnings.empty());
}

TEST(EmitMap, KeepsColumnsOfSitesInTheOrderOfTheirNames) {
  Workshop workshop({.seed = 1, .has_columns = true});
  std::ranges::reverse(workshop.made.columns);
  const CompiledMap map = value_of(workshop.emit());
  ASSERT_EQ(map.columns.size(), 2u);
  EXPECT_EQ(map.columns[0].name, "clearance_m");
  EXPECT_EQ(map.columns[0].values, workshop.made.columns[1].values);
  workshop.made.columns[0].values.pop_back();
  EXPECT_EQ(workshop.emit().error().code, ErrorCode::kMismatchedInputs);
}

// Poses at the first ten sites, of which those from the third on are not constrained.
Trajectory weak_trajectory(const Sites& sites) {
  Trajectory trajectory;
  trajectory.frame = sites.frame;
  for (std::uint32_t i = 0; i < 10; ++i) {
    TrajectoryPose pose{i, 100 * i, sites.sites[i].T_map_vehicle};
    PoseCovariance::Matrix covariance = PoseCovariance::Matrix::Zero();
    if (i >= 2) {
      pose.unconstrained = {true, true, false, Substitute::kConstantSpeed};
      covariance.diagonal().head<2>().setConstant(0.5 * i * i);
    }
    pose.covariance = covariance;
    trajectory.poses.push_back(pose);
  }
  return trajectory;
}

TEST(EmitMap, SaysWhichSitesScansDoNotConstrain) {
  Workshop workshop({.seed = 1});
  workshop.trajectory = weak_trajectory(workshop.made.sites);
  workshop.trajectory->notices = {{"given-poses-disagree", "they disagree", 2, 3, 4, 69.1, "m"}};
  const CompiledMap map = value_of(workshop.emit());
  ASSERT_EQ(map.columns.size(), 2U);
  EXPECT_EQ(map.columns[0].name, "pose_sigma_m");
  EXPECT_EQ(map.columns[1].name, "unconstrained");
  EXPECT_EQ(map.columns[1].values[1], 0.0F);
  EXPECT_EQ(map.columns[1].values[5], 3.0F);
  EXPECT_EQ(map.columns[0].values[1], -std::numeric_limits<float>::infinity());
  EXPECT_NEAR(map.columns[0].values[5], 5.0, 1e-6);
  ASSERT_EQ(map.trajectory->unconstrained.size(), 1U);
  EXPECT_EQ(map.trajectory->unconstrained[0], unconstrained_stretches(*workshop.trajectory)[0]);
  EXPECT_EQ(map.notices, workshop.trajectory->notices);
}

TEST(EmitMap, HasNoSuchColumnsWhereScansConstrainAll) {
  Workshop workshop({.seed = 1});
  workshop.trajectory = weak_trajectory(workshop.made.sites);
  for (TrajectoryPose& pose : workshop.trajectory->poses) pose.unconstrained = {};
  const CompiledMap map = value_of(workshop.emit());
  EXPECT_TRUE(map.columns.empty());
  EXPECT_TRUE(map.trajectory->unconstrained.empty());
}

TEST(EmitMap, KeepsTheErrorsByDirectionOfAVehicleThatTracks) {
  Workshop workshop({.seed = 1});
  MeasuredError& measured = workshop.measured;
  measured.matching.localizer = workshop.model.card.localizer;
  EXPECT_TRUE(value_of(workshop.emit()).columns.empty()) << "no tracking start was measured";
  measured.tracking_offsets = {{0.2, 0.0, 0.0, 0.01}, {-0.2, 0.0, 0.0, -0.01}};
  measured.tracking_ends.assign(measured.rows.size() * 2, {0.1F, 0.02F, 0.0F, 0.001F});
  const CompiledMap map = value_of(workshop.emit());
  EXPECT_EQ(map.measurement.tracking_offsets.size(), 2U);
  EXPECT_EQ(map.measurement.tracking_looks, std::vector<Look>{measured.looks.back()});
  ASSERT_EQ(map.columns.size(), 4U);
  for (const SiteColumn& column : map.columns) {
    const auto name = std::ranges::find(kTrackingRangeColumns, column.name);
    EXPECT_NE(name, kTrackingRangeColumns.end()) << column.name;
    if (column.name != "tracking_lateral_m") continue;
    EXPECT_NEAR(column.values[3], 0.02, 0.001);
  }
  measured.reference = ErrorReference::kSimulated;
  EXPECT_TRUE(value_of(workshop.emit()).columns.empty()) << "nothing was measured";
}

// The version in the heading of a definition: "## Sites (v2)"; 0 where there is no such heading.
std::uint32_t version_in_text(const std::string& heading) {
  std::ifstream file(SIGHTLINE_DEFINITIONS);
  const std::string begin = "## " + heading + " (v";
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(begin)) continue;
    return static_cast<std::uint32_t>(std::stoul(line.substr(begin.size())));
  }
  return 0;
}

TEST(EmitMap, SaysTheVersionsThatTheTextOfTheDefinitionsHas) {
  Workshop workshop({.seed = 1});
  const CompiledMap map = value_of(workshop.emit());
  const std::map<std::string, std::string> headings = {
      {"choice-of-range", "Error model and choice of range"},
      {"errors-by-direction", "Errors by direction"},
      {"factor-of-mapping-drive", "Factor from the mapping drive"},
      {"factors-of-the-paper", "Factors from the paper"},
      {"factors-of-virtual-scan", "Factors from a virtual scan"},
      {"localizers", "Localizers"},
      {"looks", "Looks"},
      {"measured-error", "Measured error"},
      {"ndt-map", "NDT map"},
      {"sites", "Sites"},
      {"surface", "Surface"},
      {"tracking-starts", "Tracking starts"}};
  EXPECT_EQ(map.definitions.size(), headings.size());
  for (const NamedVersion& definition : map.definitions) {
    ASSERT_TRUE(headings.contains(definition.name)) << definition.name;
    EXPECT_EQ(definition.version, version_in_text(headings.at(definition.name))) << definition.name;
  }
}

TEST(EmitMap, KeepsAModelThatCanBeTakenOutOfTheFileAgain) {
  Workshop workshop({.seed = 2});
  const CompiledMap map = value_of(workshop.emit());
  const CompiledMap read = value_of(read_map(encode_map(map)));
  const ErrorModel model = value_of(of_ranges(model_of(read.model)));
  EXPECT_EQ(to_bytes(model), to_bytes(workshop.model));
  EXPECT_FALSE(read.model.card.empty());
  for (const std::string& name : dump_names()) EXPECT_TRUE(dump(read, name)) << name;
  CompiledMap damaged = read;
  damaged.model.bytes.back() ^= std::byte{1};
  EXPECT_EQ(model_of(damaged.model).error().code, ErrorCode::kDigestMismatch);
  damaged = read;
  damaged.model.encoding_version += 1;
  EXPECT_EQ(model_of(damaged.model).error().code, ErrorCode::kFutureVersion);
}

// Four sites, ranges 10 and 20 m, one limit of 0.1 m; each number below is a quarter or a third.
TEST(EmitMap, OfAFinishedMapNamesThatAndCountsNoSimulatedSite) {
  Workshop workshop({.seed = 1});
  const std::string id_of_drive = workshop.emit()->map_id;
  workshop.is_finished = true;
  workshop.recordings.cards = {{"map", "harbour.pcd", sha256("harbour")}};
  workshop.measured.reference = ErrorReference::kSimulated;
  const Result<CompiledMap> map = workshop.emit();
  ASSERT_TRUE(map) << to_string(map.error());
  EXPECT_EQ(map->measurement.mapping_drive, "harbour.pcd");
  EXPECT_EQ(map->measurement.measured_site_count, 0u);
  EXPECT_EQ(map->definitions.front().name, "annotating-a-finished-map");
  EXPECT_NE(map->map_id, id_of_drive);
  workshop.recordings.cards.front().digest = sha256("another harbour");
  EXPECT_NE(workshop.emit()->map_id, map->map_id);
}

TEST(EmitMap, CountsQualityThatCanBeCheckedByHand) {
  Workshop workshop({.seed = 3, .site_count = 4, .ranges_m = {10.0, 20.0}, .limits_m = {0.1}});
  workshop.made.ranges.range_index = {0, 0, 1, 1};
  workshop.made.ranges.flags = {0, kExtrapolated, kUnmet | kExtrapolated, 0};
  workshop.made.predicted.within_probability = {0.5, 0.9, 0.7, 0.9, 0.1, 0.2, 0.3, 1.0};
  workshop.measured.scan_of_site = {5, -1, 6, 7};
  for (ErrorRow& row : workshop.measured.rows) row.mean_m = 0.2;
  workshop.measured.rows[0].mean_m = 0.1;   // site 0 at 10 m, which it takes: within, just so
  workshop.measured.rows[4].mean_m = 0.01;  // site 2 at 10 m, which it does not take
  const CompiledMap map = value_of(workshop.emit());
  const LimitQuality& quality = map.quality.at(0);
  EXPECT_EQ(quality.unmet_count, 1u);
  EXPECT_EQ(quality.extrapolated_count, 2u);
  EXPECT_DOUBLE_EQ(quality.mean_range_m, 15.0);
  EXPECT_DOUBLE_EQ(quality.expected_coverage, (0.5 + 0.7 + 0.2 + 1.0) / 4.0);
  EXPECT_DOUBLE_EQ(quality.measured_coverage, 1.0 / 3.0);
  EXPECT_EQ(map.measurement.measured_site_count, 3u);
  ASSERT_EQ(workshop.warnings.size(), 1u);
  EXPECT_THAT(workshop.warnings[0], HasSubstr("1 of 4 sites"));
}

TEST(EmitMap, NamesTheLocalizerOfTheModelAndNoCoverageOfAnother) {
  Workshop workshop({.seed = 3});
  for (ErrorRow& row : workshop.measured.rows) row.mean_m = 0.01;
  const Result<CompiledMap> same = workshop.emit();
  workshop.model.card.localizer = {"my-ndt", 2, {{"leaf_m", "0.5"}}};
  const Result<CompiledMap> other = workshop.emit();
  ASSERT_TRUE(same && other);
  EXPECT_EQ(same->model.localizer.name, "searching");
  EXPECT_EQ(same->quality[0].measured_coverage, 1.0);
  EXPECT_EQ(to_text(other->model.localizer), "my-ndt v2 (leaf_m=0.5)");
  EXPECT_EQ(other->measurement.localizer.name, "searching");
  EXPECT_EQ(other->measurement.measured_site_count, 0u);
  EXPECT_EQ(other->quality[0].measured_coverage, 0.0);
  ASSERT_EQ(workshop.warnings.size(), 1u);
  EXPECT_THAT(workshop.warnings[0], HasSubstr("predicts the errors of my-ndt v2"));
  CompiledMap lying = *other;
  lying.model.localizer.name = "pcl-ndt";
  EXPECT_EQ(model_of(lying.model).error().code, ErrorCode::kDigestMismatch);
}

TEST(EmitMap, NamesTheRecordingAndNotTheRelease) {
  Workshop workshop({.seed = 4});
  EmitMapOptions options;
  const std::string id = workshop.emit(options)->map_id;
  options.release = 2;
  options.version = "another";
  workshop.made.ranges.dilation_m += 1.0;
  EXPECT_EQ(workshop.emit(options)->map_id, id);
  workshop.mapping.scans[2].stamp_ns += 1;
  EXPECT_NE(workshop.emit(options)->map_id, id);
  options.map_id = "harbour";
  EXPECT_EQ(workshop.emit(options)->map_id, "harbour");
}

TEST(EmitMap, OfRandomArtifactsIsTheFileOfTheWholeMap) {
  Random random(7);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    RandomMapOptions options;
    options.seed = seed;
    options.site_count = 1 + static_cast<int>(random.below(60));
    options.run_count = 1;
    options.nd_count = static_cast<int>(random.below(60));
    options.tile_m = random.below(2) == 0 ? 32.0 : 64.0;
    options.limits_m =
        random.below(2) == 0 ? std::vector<double>{0.1} : std::vector<double>{0.05, 0.1, 0.3};
    Workshop workshop(options);
    const CompiledMap map = value_of(workshop.emit());
    EXPECT_EQ(encode_map(map), workshop.file);
  }
}

TEST(EmitMap, RefusesArtifactsThatDoNotBelongTogether) {
  const auto refuses = [](const std::function<void(Workshop&)>& spoil) {
    Workshop workshop({.seed = 5});
    spoil(workshop);
    const Result<CompiledMap> map = workshop.emit();
    EXPECT_FALSE(map.has_value());
    if (map) return;
    EXPECT_EQ(map.error().code, ErrorCode::kMismatchedInputs) << to_string(map.error());
  };
  refuses([](Workshop& w) { w.made.sites.sites.pop_back(); });
  refuses([](Workshop& w) { w.made.sites.frame.origin_world_m.y() += 64.0; });
  refuses([](Workshop& w) { w.made.ranges.looks[0].range_m += 1.0; });
  refuses([](Workshop& w) { w.made.predicted.limits_m[1] += 0.01; });
  refuses([](Workshop& w) {
    w.measured.scan_of_site.pop_back();
    w.measured.rows.resize(w.measured.shape().size(w.measured.scan_of_site.size()));
  });
  refuses([](Workshop& w) { w.measured.looks[0].range_m += 1.0; });
  refuses([](Workshop& w) { w.chooses_no_looks = true; });
}

TEST(EmitMap, RefusesAVersionThatCannotBePrinted) {
  Workshop workshop({.seed = 6});
  EmitMapOptions options;
  for (const char* bad : {"", "two words", "\x01"}) {
    options.version = bad;
    EXPECT_EQ(failure_of(workshop.emit(options)).code, ErrorCode::kBadValue);
  }
}

}  // namespace
}  // namespace sightline
