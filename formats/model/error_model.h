#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/annotation/by_family.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/predicted_error.h"
#include "formats/artifact.h"
#include "formats/drive/recording_cards.h"
#include "formats/model/place_kind.h"
#include "formats/model/regression_forest.h"
#include "formats/record/fields.h"

namespace sightline {

// A place that the model learnt from.
struct PlaceCard {
  std::string name;
  std::vector<std::string> drives;  // whose errors were learnt there
  double labelled_route_m = 0.0;    // of the place, however many drives measured it
  std::uint32_t block_count = 0;
  RecordingCards recordings;  // that its map and its errors were made from
  // [recording]: the same number in all places for recordings that have scans in common
  // (formats/drive/shared_scans.h). Empty: recordings are the same by their digests alone.
  std::vector<std::uint32_t> recording_numbers = {};
  // The same for places that have a recording in common or are one stretch of street.
  std::uint32_t number = 0;
  // Of the sites, world axes and origin: where the place is.
  Eigen::Vector3d centre_world_m = Eigen::Vector3d::Zero();
};
SIGHTLINE_FIELDS(PlaceCard, name, drives, labelled_route_m, block_count, recordings,
                 recording_numbers, number, centre_world_m)

// The recordings that the drives of a place are, as indices of its cards, in the order of the
// drives; none where the cards do not name it. A drive without a card of its own is the first of
// those that made the map.
std::vector<std::size_t> recordings_of_drives(const RecordingCards& recordings,
                                              std::size_t drive_count);

// Whether a recording of a place is one of those that its map was made from, or has scans in common
// with one.
bool made_the_map(const RecordingCards& recordings, std::span<const std::uint32_t> numbers,
                  std::size_t recording);

// What a share of labels within a limit is worth as a probability, in log odds: offset + slope
// times those of the share (schemas/definitions.md, "Error model and choice of range").
struct ProbabilityCurve {
  double offset = 0.0;
  double slope = 1.0;  // above 0
};
SIGHTLINE_FIELDS(ProbabilityCurve, offset, slope)

// How the model was trained, and on how much.
struct TrainingCard {
  std::vector<PlaceCard> places;
  ErrorReference reference = ErrorReference::kKnownPose;
  LocalizerProfile localizer;  // whose errors it learnt, and predicts
  std::string feature_set;     // "paper", "all"
  std::string hold_out;        // what a fold is made of: "blocks" of route, blocks of one of the
                               // "drives", or whole "places"
  std::uint64_t seed = 0;
  std::uint32_t tree_count = 0;
  std::uint32_t least_leaf_rows = 0;
  double feature_share = 0.0;  // of the features, tried at each split
  double block_m = 0.0;        // least route of a block
  double buffer_m = 0.0;       // nothing nearer than this to a held-out block trains its trees
  double labelled_route_m = 0.0;
  std::uint32_t block_count = 0;
  std::uint32_t fold_count = 0;
  bool knows_history =
      false;               // some place was driven twice: one drive is history, the other is judged
  ProbabilityCurve curve;  // of the probabilities, out of fold and of the forest
  std::string worlds = "recorded";  // or "generated": no vehicle has driven there

  [[nodiscard]] bool is_of_generated_worlds() const { return worlds == "generated"; }
};
SIGHTLINE_FIELDS(TrainingCard, places, reference, localizer, feature_set, hold_out, seed,
                 tree_count, least_leaf_rows, feature_share, block_m, buffer_m, labelled_route_m,
                 block_count, fold_count, knows_history, curve, worlds)

// One input of the forest.
struct FeatureCard {
  std::string name;  // a factor, or "range_m", which is the last
  // By how much the out-of-fold RMSE rises when held-out rows swap their values of it, m.
  double importance_m = 0.0;
  // [range]: least and greatest value that training saw.
  std::vector<double> support_min;
  std::vector<double> support_max;
};
SIGHTLINE_FIELDS(FeatureCard, name, importance_m, support_min, support_max)

// How well held-out places are predicted at one range.
struct RangeCard {
  double range_m = 0.0;
  double mean_error_m = 0.0;  // of the labels
  double r_squared =
      0.0;  // 1 - residual / total sum of squares, out of fold; 0 where all labels are one
  double rmse_m = 0.0;
  // The same over the cases whose place had been driven before; 0 where there are none.
  double history_r_squared = 0.0;
  double history_rmse_m = 0.0;
};
SIGHTLINE_FIELDS(RangeCard, range_m, mean_error_m, r_squared, rmse_m, history_r_squared,
                 history_rmse_m)

// What the paper's rule reached on held-out places in one kind of place: the shortest range whose
// predicted mean error is within the limit, over the labelled cases without history.
struct KindCard {
  double limit_m = 0.0;
  PlaceKind kind = PlaceKind::kUnknown;
  std::uint32_t case_count = 0;  // of a site and a drive
  double coverage = 0.0;         // share with a measured error within the limit there
  double mean_range_m = 0.0;
  double mean_error_m = 0.0;
};
SIGHTLINE_FIELDS(KindCard, limit_m, kind, case_count, coverage, mean_range_m, mean_error_m)

// A site of a map that the model was trained on, as one drive found it. Its forest knows the place,
// so what the model says here must come from trees that do not. A site comes once for each drive
// that measured it, and once more with what other drives measured.
struct TrainedSite {
  Eigen::Vector3d p_world_m = Eigen::Vector3d::Zero();  // sensor origin, world axes and origin
  std::uint32_t place = 0;                              // index into the card's places
  std::uint32_t drive = 0;  // that measured it, index into the place's drives
  std::uint32_t run = 0;    // a stretch of route of one place, one drive and one history
  double s_m = 0.0;
  std::uint32_t block = 0;          // the same for every case of a stretch of route
  std::uint8_t has_label = 0;       // 1 where a scan was matched
  std::uint8_t has_history = 0;     // 1 where an earlier drive's errors are among its features
  std::uint64_t factor_digest = 0;  // XXH3 of the features of this site
  PlaceKind kind = PlaceKind::kUnknown;
};
SIGHTLINE_FIELDS(TrainedSite, p_world_m, place, drive, run, s_m, block, has_label, has_history,
                 factor_digest, kind)

// Labels from tracking starts ("Tracking starts" in schemas/definitions.md) of looks that take a
// sample: the forest's leaves contain the same training rows with these labels. An error is the
// root mean square over the starts of a site. Empty where some drive of the training was not
// measured from such starts.
struct TrackingLabels {
  ProbabilityCurve curve;                 // of the probabilities, out of fold and of the forest
  std::vector<float> row_errors_m;        // [training row], in the order of the forest's labels
  std::vector<float> measured_m;          // [site][look]; 0 where there is no label
  std::vector<float> mean_m;              // [site][look]: predicted, out of fold
  std::vector<float> within_probability;  // [site][look][limit]: out of fold

  [[nodiscard]] bool is_empty() const { return row_errors_m.empty(); }
};
SIGHTLINE_FIELDS(TrackingLabels, curve, row_errors_m, measured_m, mean_m, within_probability)

// What is known about the error of a family's looks before a vehicle drives: a forest over map
// factors and range, and all that choosing ranges with a promise needs: out-of-fold predictions
// beside the errors measured.
struct ErrorModel {
  TrainingCard card;
  std::vector<FeatureCard> features;    // in the order of the forest's feature indices
  std::vector<RangeCard> ranges;        // ascending range_m
  std::vector<KindCard> kinds;          // by limit, then type; types without a case are left out
  RegressionForest forest;              // labels: mean error, m
  std::vector<TrainedSite> sites;       // ascending (run, s_m); with a label or without
  PredictedError out_of_fold;           // of these sites, by trees that never saw the place
  std::vector<double> measured_mean_m;  // [site][range]; 0 where there is no label
  TrackingLabels tracking;

  [[nodiscard]] SiteShape shape() const { return {ranges.size()}; }

  [[nodiscard]] double measured(std::size_t site, std::size_t range) const {
    return measured_mean_m[shape().index(site, range)];
  }
};

template <>
struct ArtifactTraits<ErrorModel> {
  static constexpr std::string_view kName = "error-model";
  static constexpr std::uint32_t kVersion = 9;
};

Result<void> validate(const ErrorModel& model);
// Facts: the model card. Rows: out-of-fold prediction beside the label, per site and range.
Table dump(const ErrorModel& model);
Table dump(const ByFamily<ErrorModel>& model);  // of the ranges
// A number among the facts of a card, for those who show it otherwise than a dump does.
enum class CardFigureKind : std::uint8_t { kRSquared, kRmse_m, kImportance_m };
template <>
inline constexpr auto kNamesOf<CardFigureKind> = enum_names("r-squared", "rmse_m", "importance_m");
struct CardFigure {
  std::uint32_t fact = 0;  // index among the facts
  CardFigureKind kind = CardFigureKind::kRSquared;
  std::string of;  // the range in metres, or the factor
  double value = 0.0;

  bool operator==(const CardFigure&) const = default;
};
SIGHTLINE_FIELDS(CardFigure, fact, kind, of, value)

struct CardFacts {
  std::vector<std::pair<std::string, Cell>> facts;
  std::vector<CardFigure> figures;  // by their facts

  bool operator==(const CardFacts&) const = default;
};
// The facts of the dump alone: a model has many rows. `head`: at least what encode_head writes.
CardFacts card_facts(const ErrorModel& head, std::size_t training_row_count);
// The card's tables (ranges; features with support; recordings) and every node of every tree.
std::vector<Table> tables(const ErrorModel& model);
// Role, name and digest of every recording that the model was trained on, by place.
Table recordings_table(const ErrorModel& model);
// For people: places, recordings, quality of prediction per range, importances.
std::string to_text(const ByFamily<ErrorModel>& model);
void encode(const ErrorModel& model, ByteWriter& writer);
void decode(ByteReader& reader, ErrorModel& model);
// The same bytes piece by piece: of a long street they are not in memory twice.
std::uint64_t payload_size(const ErrorModel& model);
Result<void> visit_payload(const ErrorModel& model, const ByteSink& sink);
Result<void> open_payload(const StoredBytes& payload, ErrorModel& model);
Result<void> open_payload(const StoredBytes& payload, ByFamily<ErrorModel>& model);
// What stands first, of no length that a street has: the card, features, ranges, kinds and the
// forest's feature_count. The number of training rows comes next, as 64 bits.
void encode_head(const ErrorModel& model, ByteWriter& writer);
void decode_head(ByteReader& reader, ErrorModel& model);

}  // namespace sightline
