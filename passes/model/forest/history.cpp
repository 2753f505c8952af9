#include "passes/model/forest/history.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "formats/base/check.h"
#include "formats/base/level.h"
#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"

namespace sightline {
namespace {

constexpr double kReach_m = 6.0;         // farther measurements say little of a place
constexpr double kLeastError_m = 0.001;  // below this the logarithm would magnify noise

double log_error(double error_m) { return portable_log(std::max(error_m, kLeastError_m)); }

// Of each site, those on its level that the drive measured within kReach_m, the nearest first, the
// lower index on a tie.
std::vector<std::vector<std::size_t>> measured_near(const Sites& sites,
                                                    const MeasuredError& measured) {
  const MeasuredPlaces places = places_measured_by(measured, sites);
  std::vector<std::vector<std::size_t>> near(sites.sites.size());
  for (std::size_t site = 0; site < sites.sites.size(); ++site) {
    const Eigen::Vector3d& p_m = sites.sites[site].p_map_m;
    for (const NearPoint& point : places.grid.within(p_m, kReach_m)) {
      const std::size_t other = places.sites[point.index];
      if (is_same_level(p_m.z(), sites.sites[other].p_map_m.z())) near[site].push_back(other);
    }
  }
  return near;
}

// In the order of the features of one drive. `near` is not empty.
std::vector<double> describe_one(const MeasuredError& measured,
                                 const std::vector<std::size_t>& near, std::size_t range) {
  const std::size_t nearest = near.front();
  const std::size_t longest = measured.looks.size() - 1;
  const ErrorRow& own = measured.row(nearest, range);
  std::vector<double> logs;
  double worst = -std::numeric_limits<double>::infinity();
  double lost_share = 0.0;
  for (const std::size_t site : near) {
    const ErrorRow& row = measured.row(site, range);
    logs.push_back(log_error(row.mean_m));
    worst = std::max(worst, logs.back());
    lost_share = std::max(lost_share, row.lost_share);
  }
  const double mean = ordered_sum(logs) / static_cast<double>(logs.size());
  return {1.0,
          log_error(own.mean_m),
          log_error(measured.row(nearest, range == 0 ? 0 : range - 1).mean_m),
          log_error(measured.row(nearest, std::min(range + 1, longest)).mean_m),
          mean,
          worst,
          log_error(own.p90_m),
          lost_share};
}

// What one drive measured near one site.
struct Earlier {
  const MeasuredError& measured;
  const std::vector<std::size_t>& near;  // not empty
};

// How the drives differ: how many they are; the worst of their errors at the nearest site; of their
// errors at all near sites the worst, and what nine of ten do not exceed.
std::vector<double> describe_spread(const std::vector<Earlier>& drives, std::size_t range) {
  constexpr double kShare = 0.9;
  double worst = -std::numeric_limits<double>::infinity();
  std::vector<double> logs;
  for (const Earlier& drive : drives) {
    worst = std::max(worst, log_error(drive.measured.row(drive.near.front(), range).mean_m));
    for (const std::size_t site : drive.near) {
      logs.push_back(log_error(drive.measured.row(site, range).mean_m));
    }
  }
  std::ranges::sort(logs);
  const auto place = static_cast<std::size_t>(kShare * static_cast<double>(logs.size() - 1));
  return {static_cast<double>(drives.size()), worst, logs.back(), logs[place]};
}

// In the order of history_features(kind): each feature of one drive is the mean over the drives.
std::vector<double> describe(const std::vector<Earlier>& drives, HistoryKind kind,
                             std::size_t range) {
  std::vector<std::vector<double>> of_drives;
  for (const Earlier& drive : drives) {
    of_drives.push_back(describe_one(drive.measured, drive.near, range));
  }
  std::vector<double> values = of_drives.front();
  for (std::size_t i = 0; of_drives.size() > 1 && i < values.size(); ++i) {
    std::vector<double> same;
    for (const std::vector<double>& of_drive : of_drives) same.push_back(of_drive[i]);
    values[i] = ordered_sum(same) / static_cast<double>(same.size());
  }
  if (kind == HistoryKind::kOfOneDrive) return values;
  const std::vector<double> spread = describe_spread(drives, range);
  values.insert(values.end(), spread.begin(), spread.end());
  return values;
}

const std::vector<std::string>& all_features() {
  static const std::vector<std::string> kNames = {
      "history_known",           "history_log_mean",       "history_log_mean_shorter",
      "history_log_mean_longer", "history_log_mean_near",  "history_log_max_near",
      "history_log_p90",         "history_lost_near",      "history_drives",
      "history_log_worst",       "history_log_worst_near", "history_log_most_near"};
  return kNames;
}
constexpr std::size_t kFeaturesOfOneDrive = 8;

}  // namespace

MeasuredPlaces places_measured_by(const MeasuredError& drive, const Sites& sites) {
  std::vector<std::size_t> measured;
  std::vector<Eigen::Vector3d> places_m;
  for (std::size_t site = 0; site < sites.sites.size(); ++site) {
    if (drive.scan_of_site[site] < 0) continue;
    measured.push_back(site);
    places_m.push_back(sites.sites[site].p_map_m);
  }
  return {std::move(measured), PointGrid(places_m)};
}

const std::vector<std::string>& history_features(HistoryKind kind) {
  static const std::vector<std::string> kOfOne(
      all_features().begin(), all_features().begin() + std::ptrdiff_t{kFeaturesOfOneDrive});
  return kind == HistoryKind::kOfOneDrive ? kOfOne : all_features();
}

bool is_history_feature(const std::string& name) {
  return std::ranges::find(all_features(), name) != all_features().end();
}

HistoryKind history_kind_of(const std::vector<std::string>& names) {
  const std::string& of_several = all_features()[kFeaturesOfOneDrive];
  const bool knows = std::ranges::find(names, of_several) != names.end();
  return knows ? HistoryKind::kOfSeveral : HistoryKind::kOfOneDrive;
}

History history_of(const Sites& sites, const EarlierDrives& drives, HistoryKind kind) {
  SIGHTLINE_CHECK(!drives.empty());
  std::vector<std::vector<std::vector<std::size_t>>> near_of;  // [drive][site]
  for (const MeasuredError* drive : drives) {
    SIGHTLINE_CHECK(drive->scan_of_site.size() == sites.sites.size());
    near_of.push_back(measured_near(sites, *drive));
  }
  const std::size_t range_count = drives.front()->looks.size();
  const SiteShape shape{range_count, history_features(kind).size()};
  History history;
  history.kind = kind;
  history.is_known.assign(sites.sites.size(), 0);
  history.values.assign(shape.size(sites.sites.size()), 0.0F);
  for (std::size_t site = 0; site < sites.sites.size(); ++site) {
    std::vector<Earlier> there;
    for (std::size_t i = 0; i < drives.size(); ++i) {
      if (!near_of[i][site].empty()) there.push_back({*drives[i], near_of[i][site]});
    }
    if (there.empty()) continue;
    history.is_known[site] = 1;
    for (std::size_t range = 0; range < range_count; ++range) {
      const std::vector<double> values = describe(there, kind, range);
      std::transform(values.begin(), values.end(),
                     history.values.begin() + static_cast<std::ptrdiff_t>(shape.index(site, range)),
                     [](double value) { return static_cast<float>(value); });
    }
  }
  return history;
}

FeatureRows with_history(const FeatureRows& rows, HistoryKind kind, const History* history) {
  const std::vector<std::string>& added = history_features(kind);
  SIGHTLINE_CHECK(history == nullptr || history->kind == kind);
  SIGHTLINE_CHECK(history == nullptr || history->values.size() == rows.row_count * added.size());
  FeatureRows out;
  out.names = rows.names;
  out.names.insert(out.names.end() - 1, added.begin(), added.end());
  out.row_count = rows.row_count;
  out.values.reserve(out.row_count * out.names.size());
  const std::size_t before = rows.names.size() - 1;  // range_m comes last
  for (std::size_t i = 0; i < rows.row_count; ++i) {
    const float* row = rows.row(i);
    out.values.insert(out.values.end(), row, row + before);
    for (std::size_t f = 0; f < added.size(); ++f) {
      out.values.push_back(history == nullptr ? 0.0F : history->values[i * added.size() + f]);
    }
    out.values.push_back(row[before]);
  }
  return out;
}

}  // namespace sightline
