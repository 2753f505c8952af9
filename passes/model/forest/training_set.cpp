#include "passes/model/forest/training_set.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "passes/model/forest/same_street.h"

namespace sightline {
namespace {

// One drive's labels beside other drives' findings.
struct Case {
  std::size_t place = 0;
  std::size_t label_drive = 0;
  std::vector<std::size_t> history_drives;  // none: without history
};

// Those that follow `label` in a circle, as many as training_set.h says.
std::vector<std::size_t> told_to(std::size_t label, std::size_t drive_count) {
  std::vector<std::size_t> drives;
  const std::size_t told_count = 1 + label % (drive_count - 1);
  for (std::size_t i = 1; i <= told_count; ++i) drives.push_back((label + i) % drive_count);
  std::ranges::sort(drives);
  return drives;
}

std::vector<Case> cases_of(const DrivenPlaces& places) {
  std::vector<Case> cases;
  for (std::size_t place = 0; place < places.places.size(); ++place) {
    const std::size_t drive_count = places.places[place].drives.size();
    for (std::size_t label = 0; label < drive_count; ++label) {
      cases.push_back({place, label, {}});
      if (drive_count > 1) cases.push_back({place, label, told_to(label, drive_count)});
    }
  }
  return cases;
}

// What "all" means: every factor but a direction, which turns with the map's axes and contains
// nothing about the place, and but the map's evidence, which judges the model and cannot be learnt
// from where a drive both makes the map and is localized in it.
std::vector<std::string> chosen_factors(const TrainingSetOptions& options,
                                        const DrivenPlaces& places) {
  if (options.features == FeatureSet::kPaper) return paper_factors();
  std::vector<std::string> names = places.places.front().factors.factors;
  std::erase_if(names, [](const std::string& name) {
    return name.ends_with("_heading") || name == "own_error";
  });
  return names;
}

// Of the sites that were appended last, as many as the place has.
void append_labels(const DrivenPlace& place, const MeasuredError& measured,
                   TrainingSet& training_set) {
  const std::size_t first = training_set.sites.size() - place.sites.sites.size();
  for (std::size_t site = 0; site < measured.scan_of_site.size(); ++site) {
    const bool has_label = training_set.sites[first + site].has_label == 1;
    for (std::size_t range = 0; range < training_set.range_count; ++range) {
      training_set.labels.push_back(has_label ? measured.row(site, range).mean_m : 0.0);
    }
  }
}

// Whether all drives were measured from tracking starts too, by looks that take a sample.
bool have_tracking(const DrivenPlaces& places) {
  return std::ranges::all_of(places.places, [](const DrivenPlace& place) {
    return std::ranges::all_of(place.drives, [](const MeasuredError& drive) {
      return !drive.tracking_offsets.empty() && !takes_every_return(drive.looks.front());
    });
  });
}

// Of the sites that were appended last. In steps of 1/8192 m, which take half the space in a packed
// model.
void append_tracking_labels(const DrivenPlace& place, const MeasuredError& measured,
                            TrainingSet& training_set) {
  const std::size_t first = training_set.sites.size() - place.sites.sites.size();
  for (std::size_t site = 0; site < measured.scan_of_site.size(); ++site) {
    const bool has_label = training_set.sites[first + site].has_label == 1;
    for (std::size_t look = 0; look < training_set.range_count; ++look) {
      constexpr double kSteps = 8192.0;
      const double error_m = has_label ? tracking_error_m(measured, site, look) : 0.0;
      const double rounded_m = std::round(error_m * kSteps) / kSteps;
      training_set.tracking_labels_m.push_back(static_cast<float>(rounded_m));
    }
  }
}

void append_rows(FeatureRows rows, TrainingSet& training_set) {
  if (training_set.features.row_count == 0) {
    training_set.features = std::move(rows);
    return;
  }
  training_set.features.row_count += rows.row_count;
  training_set.features.values.insert(training_set.features.values.end(), rows.values.begin(),
                                      rows.values.end());
}

// How often a place's factors are still needed decides whether they are copied.
enum class MoreCases { kFollow, kNone };

// The sites of a case; `first_run` keeps runs of different cases apart.
void append_sites(const DrivenPlace& place, const Case& of, const History* history,
                  std::uint32_t first_run, TrainingSet& training_set) {
  const MeasuredError& measured = place.drives[of.label_drive];
  const std::vector<PlaceKind> kinds = smoothed(place.sites, place_kinds(place.factors));
  for (std::size_t i = 0; i < place.sites.sites.size(); ++i) {
    const Site& site = place.sites.sites[i];
    TrainedSite trained;
    trained.p_world_m = place.sites.frame.origin_world_m + site.p_map_m;
    trained.place = static_cast<std::uint32_t>(of.place);
    trained.drive = static_cast<std::uint32_t>(of.label_drive);
    trained.run = first_run + site.run;
    trained.s_m = site.s_m;
    trained.has_history = history != nullptr ? history->is_known[i] : std::uint8_t{0};
    // A case with history is about places that have one; elsewhere it would repeat the other case.
    const bool is_repeat = history != nullptr && trained.has_history == 0;
    trained.has_label = measured.scan_of_site[i] >= 0 && !is_repeat ? 1 : 0;
    trained.kind = kinds[i];
    training_set.sites.push_back(trained);
  }
}

void append_case(const DrivenPlaces& places, const Case& of, FeatureRows& factors, MoreCases more,
                 TrainingSet& training_set) {
  const DrivenPlace& place = places.places[of.place];
  const HistoryKind kind = training_set.history_kind;
  EarlierDrives earlier;
  for (const std::size_t drive : of.history_drives) earlier.push_back(&place.drives[drive]);
  History history;
  if (!earlier.empty()) history = history_of(place.sites, earlier, kind);
  const History* known = earlier.empty() ? nullptr : &history;
  if (training_set.knows_history) {
    append_rows(with_history(factors, kind, known), training_set);
  } else if (more == MoreCases::kNone) {
    append_rows(std::move(factors), training_set);
  } else {
    append_rows(factors, training_set);
  }
  const std::uint32_t first_run =
      training_set.sites.empty() ? 0 : training_set.sites.back().run + 1;
  append_sites(place, of, known, first_run, training_set);
  append_labels(place, place.drives[of.label_drive], training_set);
  if (have_tracking(places)) {
    append_tracking_labels(place, place.drives[of.label_drive], training_set);
  }
}

// Where the drive was measured, or a measured site stands for its neighbours of the same run.
void mark_measured(const Sites& sites, const MeasuredError& drive,
                   std::vector<std::uint8_t>& is_measured) {
  const std::size_t step = drive.matching.site_step;
  for (std::size_t i = 0; i < is_measured.size(); ++i) {
    if (drive.scan_of_site[i] < 0) continue;
    const std::size_t first = i - std::min(i, step / 2);
    const std::size_t last = std::min(i + (step - 1) / 2, is_measured.size() - 1);
    for (std::size_t near = first; near <= last; ++near) {
      if (sites.sites[near].run == sites.sites[i].run) is_measured[near] = 1;
    }
  }
}

Eigen::Vector3d centre_of(const Sites& sites) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  for (const Site& site : sites.sites) sum_m += site.p_map_m;
  const auto count = static_cast<double>(std::max<std::size_t>(1, sites.sites.size()));
  return sites.frame.origin_world_m + sum_m / count;
}

// Cuts each place into blocks, which all its cases share.
Result<void> append_blocks(const TrainingSetOptions& options, const DrivenPlaces& places,
                           const std::vector<Case>& cases, TrainingSet& training_set) {
  std::vector<std::vector<std::uint32_t>> block_of_site;  // [place][site]
  for (std::size_t p = 0; p < places.places.size(); ++p) {
    const DrivenPlace& place = places.places[p];
    std::vector<std::uint8_t> has_label(place.sites.sites.size(), 0);
    PlaceCard card;
    card.name = place.name;
    card.recordings = place.recordings;
    card.recording_numbers = training_set.origins.recordings[p];
    card.number = training_set.origins.places[p];
    card.centre_world_m = centre_of(place.sites);
    for (const MeasuredError& drive : place.drives) {
      card.drives.push_back(drive.drive);
      mark_measured(place.sites, drive, has_label);
    }
    const bool holds_out_places = training_set.held_out == HoldOut::kPlaces;
    const int least_blocks = holds_out_places ? 1 : 2;
    Result<RouteBlocks> cut = cut_route(place.sites, has_label, options.block_m, least_blocks);
    if (!cut) return Error{cut.error().code, cut.error().message, "", "place '" + place.name + "'"};
    RouteBlocks blocks = std::move(*cut);
    for (std::uint32_t& block : blocks.block_of_site) block += training_set.folds.block_count();
    card.labelled_route_m = blocks.labelled_route_m;
    card.block_count = blocks.block_count;
    const std::uint32_t place_fold = training_set.folds.group_of_place[p];
    for (std::uint32_t block = 0; block < blocks.block_count; ++block) {
      training_set.folds.fold_of_block.push_back(
          holds_out_places ? place_fold : training_set.folds.block_count());
    }
    training_set.folds.labelled_route_m += blocks.labelled_route_m;
    training_set.places.push_back(std::move(card));
    block_of_site.push_back(std::move(blocks.block_of_site));
  }
  std::size_t site = 0;
  for (const Case& of : cases) {
    for (const std::uint32_t block : block_of_site[of.place])
      training_set.sites[site++].block = block;
  }
  return {};
}

// Which places and drives are the same, and so what is held out.
Result<void> settle_hold_out(const TrainingSetOptions& options, const DrivenPlaces& places,
                             const std::vector<Case>& cases, TrainingSet& training_set) {
  training_set.origins = origins_of(places);
  training_set.folds.group_of_place = training_set.origins.places;
  const LearntDrives drives = learnt_drives(places);
  training_set.drive_count = drives.count;
  for (const Case& of : cases) {
    training_set.drive_of_site.insert(training_set.drive_of_site.end(),
                                      places.places[of.place].sites.sites.size(),
                                      drives.number[of.place][of.label_drive]);
  }
  SIGHTLINE_ASSIGN(training_set.held_out,
                   choose_hold_out(options.hold_out, training_set.folds.group_of_place, drives));
  return {};
}

// A model predicts the errors of one localizer.
Result<void> check_localizers(const DrivenPlaces& places) {
  const LocalizerProfile& first = places.places.front().drives.front().matching.localizer;
  for (const DrivenPlace& place : places.places) {
    for (const MeasuredError& drive : place.drives) {
      if (drive.matching.localizer == first) continue;
      return Error{ErrorCode::kMismatchedInputs,
                   concat("drive '", drive.drive, "' was localized by ",
                          to_text(drive.matching.localizer), ", expected ", to_text(first),
                          " as on every other: a model predicts the errors of one localizer"),
                   "", "place " + place.name};
    }
  }
  return {};
}

}  // namespace

Result<TrainingSet> make_training_set(const TrainingSetOptions& options,
                                      const DrivenPlaces& places) {
  SIGHTLINE_TRY(validate(places));
  SIGHTLINE_TRY(check_localizers(places));
  TrainingSet training_set;
  training_set.range_count = places.places.front().factors.looks.size();
  std::size_t most_drives = 0;
  for (const DrivenPlace& place : places.places) {
    most_drives = std::max(most_drives, place.drives.size());
  }
  training_set.knows_history = most_drives > 1;
  if (most_drives > 2) training_set.history_kind = HistoryKind::kOfSeveral;
  const std::vector<Case> cases = cases_of(places);
  SIGHTLINE_TRY(settle_hold_out(options, places, cases, training_set));
  std::vector<FeatureRows> factors;
  for (const DrivenPlace& place : places.places) {
    SIGHTLINE_ASSIGN(FeatureRows rows,
                     gather_features(place.factors, chosen_factors(options, places)));
    factors.push_back(std::move(rows));
  }
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const bool is_last = i + 1 == cases.size() || cases[i + 1].place != cases[i].place;
    append_case(places, cases[i], factors[cases[i].place],
                is_last ? MoreCases::kNone : MoreCases::kFollow, training_set);
  }
  SIGHTLINE_TRY(append_blocks(options, places, cases, training_set));
  deal_blocks(static_cast<std::uint32_t>(options.fold_count), training_set.folds);
  return training_set;
}

LabelledRows labelled_rows(const TrainingSet& training_set,
                           const std::vector<std::uint8_t>& leave_out, std::size_t most_rows) {
  std::vector<std::size_t> sites;
  for (std::size_t site = 0; site < training_set.sites.size(); ++site) {
    if (training_set.sites[site].has_label == 1 && leave_out[site] == 0) sites.push_back(site);
  }
  const std::size_t row_count = training_set.shape().size(sites.size());
  const std::size_t stride = std::max<std::size_t>(1, (row_count + most_rows - 1) / most_rows);
  LabelledRows training;
  for (std::size_t i = 0; i < sites.size(); i += stride) {
    for (std::size_t range = 0; range < training_set.range_count; ++range) {
      const std::size_t row = training_set.shape().index(sites[i], range);
      training.rows.push_back(static_cast<std::uint32_t>(row));
      training.labels.push_back(training_set.labels[row]);
    }
  }
  return training;
}

}  // namespace sightline
