#include "tests/bench/integrity/protection_samples.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <tuple>

#include "passes/matching/covariance/protection.h"

namespace sightline {
namespace {

constexpr std::size_t kBlockScans = 60;
constexpr std::size_t kFullScans = 55;  // matched, of these
constexpr double kRisk = 0.01;
constexpr double kFalse = 0.005;  // of good matches
// Matches a metre off in streets have half of the likelihood of good ones.
constexpr double kLikelihoodMargin = 0.9;
constexpr double kShareMargin = 0.05;
constexpr double kRaisedMargin = 0.95;
// Wrong matches in streets have at most 0.4; real streets change more than generated ones.
constexpr double kMostRaisedShare = 0.5;

PoseEstimate returned_pose(const MatchSample& sample, double covariance_factor) {
  InformationScale scale = default_information_scale();
  scale.covariance_factor = covariance_factor;
  const Matrix6d information = match_information(sample.structure, scale);
  return pose_of_known_start(moved(Pose::Identity(), sample.found), information,
                             {moved(Pose::Identity(), sample.start), tracking_start_covariance()});
}

// Of forward, left and yaw together, by degree of freedom.
double mean_nees(const std::vector<const Block*>& blocks, double covariance_factor) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const Block* block : blocks) {
    for (const MatchSample& sample : block->samples) {
      const PoseEstimate pose = returned_pose(sample, covariance_factor);
      const Vector6d error = motion_between(Pose::Identity(), pose.T_map_vehicle);
      constexpr int kPlanar[] = {0, 1, 5};
      Eigen::Matrix3d covariance;
      Eigen::Vector3d off;
      for (int i = 0; i < 3; ++i) {
        off[i] = error[kPlanar[i]];
        for (int j = 0; j < 3; ++j) covariance(i, j) = pose.covariance(kPlanar[i], kPlanar[j]);
      }
      const Eigen::Vector3d pull = covariance.inverse() * off;
      sum += off.dot(pull) / 3.0;
      ++count;
    }
  }
  return count == 0 ? 1.0 : sum / static_cast<double>(count);
}

// By halves between 1/16 and 16: the mean falls as covariances grow.
double consistent_factor(const std::vector<const Block*>& blocks) {
  if (blocks.empty()) return 1.0;
  double low = -4.0;
  double high = 4.0;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (mean_nees(blocks, std::exp2(middle)) > 1.0 ? low : high) = middle;
  }
  return std::exp2(0.5 * (low + high));
}

// The value that another block exceeds with at most this risk (split conformal prediction: Vovk et
// al. 2005): the k-th largest, k = (n + 1) risk rounded down.
double conformal_bound(std::vector<double> maxima, double risk) {
  const auto k = static_cast<std::size_t>(static_cast<double>(maxima.size() + 1) * risk);
  if (k == 0) return kUnavailable;
  std::ranges::sort(maxima, std::greater<>());
  return maxima[k - 1];
}

double lowest_share(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size()))];
}

// `factor_of`: of a block.
template <class FactorOf>
void fit_bounds(const std::vector<const Block*>& blocks, const FactorOf& factor_of,
                ProtectionRow& row) {
  std::array<std::vector<double>, kProtectionAxes> ratios;
  std::array<std::vector<double>, kProtectionAxes> errors;
  for (const Block* block : blocks) {
    ProtectionFactors ratio{};
    ProtectionFactors error{};
    for (const MatchSample& sample : block->samples) {
      const AxisErrors found = returned_errors(sample, factor_of(*block));
      for (std::size_t axis = 0; axis < kProtectionAxes; ++axis) {
        const double off = std::abs(found.errors[axis]);
        ratio[axis] = std::max(ratio[axis], off / found.sigmas[axis]);
        error[axis] = std::max(error[axis], off);
      }
    }
    for (std::size_t axis = 0; axis < kProtectionAxes; ++axis) {
      ratios[axis].push_back(ratio[axis]);
      errors[axis].push_back(error[axis]);
    }
  }
  row.block_count = static_cast<std::uint32_t>(blocks.size());
  for (std::size_t axis = 0; axis < kProtectionAxes; ++axis) {
    row.percent_factors[axis] = conformal_bound(ratios[axis], kRisk);
    row.percent_errors[axis] = conformal_bound(errors[axis], kRisk);
  }
}

constexpr double kGood_m = 0.25;  // sideways

// Over the good matches of each block, one after the other.
double least_raised_share(const std::vector<const Block*>& blocks, const ProtectionRow& row) {
  double least = 1.0;
  for (const Block* block : blocks) {
    IntegrityMonitor monitor;
    for (const MatchSample& sample : block->samples) {
      const AxisErrors found = returned_errors(sample, row.covariance_factor);
      if (std::abs(found.errors[1]) > kGood_m) continue;
      monitor.add(Integrity::kOk, sample.structure.raised, row);
      least = std::min(least, monitor.raised_met_share());
    }
  }
  return std::min(kRaisedMargin * least, kMostRaisedShare);
}

// Of matches whose returned pose is within 25 cm sideways.
void fit_signs(const std::vector<const Block*>& blocks, ProtectionRow& row) {
  std::vector<double> likelihoods;
  std::vector<double> shares;
  for (const Block* block : blocks) {
    for (const MatchSample& sample : block->samples) {
      const AxisErrors found = returned_errors(sample, row.covariance_factor);
      if (std::abs(found.errors[1]) > kGood_m) continue;
      likelihoods.push_back(sample.likelihood);
      shares.push_back(static_cast<double>(sample.scored_points) /
                       std::max(1.0, static_cast<double>(sample.point_count)));
    }
  }
  row.least_raised_share = least_raised_share(blocks, row);
  row.least_likelihood = kLikelihoodMargin * lowest_share(likelihoods, kFalse);
  row.least_scored_share = lowest_share(shares, kFalse) - kShareMargin;
}

}  // namespace

AxisErrors returned_errors(const MatchSample& sample, double covariance_factor) {
  constexpr int kMotions[] = {0, 1, 2, 5};
  const PoseEstimate pose = returned_pose(sample, covariance_factor);
  const Vector6d error = motion_between(Pose::Identity(), pose.T_map_vehicle);
  AxisErrors result;
  for (std::size_t i = 0; i < kProtectionAxes; ++i) {
    result.errors[i] = error[kMotions[i]];
    result.sigmas[i] = std::sqrt(pose.covariance(kMotions[i], kMotions[i]));
  }
  return result;
}

std::vector<Block> blocks_of(const std::vector<KindSample>& samples) {
  std::map<std::tuple<std::string, std::uint64_t, std::size_t>, Block> blocks;
  for (const KindSample& sample : samples) {
    Block& block = blocks[{sample.kind, sample.seed, sample.scan / kBlockScans}];
    block.kind = sample.kind;
    block.samples.push_back(sample.sample);
  }
  std::vector<Block> full;
  for (auto& [key, block] : blocks) {
    if (block.samples.size() >= kFullScans) full.push_back(std::move(block));
  }
  return full;
}

PlaceGroup group_of_world(const std::string& kind) {
  if (kind == "town" || kind == "streets") return PlaceGroup::kStreet;
  if (kind == "tunnel" || kind == "noise-barrier") return PlaceGroup::kTunnel;
  if (kind == "field") return PlaceGroup::kField;
  const bool is_open = kind == "motorway" || kind == "bridge" || kind == "plaza" || kind == "hills";
  return is_open ? PlaceGroup::kOpenRoad : PlaceGroup::kAny;
}

std::array<ProtectionRow, kPlaceGroups> fitted_rows(const std::vector<Block>& blocks) {
  constexpr std::size_t kFewest = 99;
  std::array<ProtectionRow, kPlaceGroups> rows;
  std::array<std::vector<const Block*>, kPlaceGroups> of_group;
  std::vector<const Block*>& all = of_group[static_cast<std::size_t>(PlaceGroup::kAny)];
  for (const Block& block : blocks) {
    const auto group = static_cast<std::size_t>(group_of_world(block.kind));
    if (&of_group[group] != &all) of_group[group].push_back(&block);
    all.push_back(&block);
  }
  for (std::size_t g = 0; g < kPlaceGroups; ++g) {
    // At places of unknown kind matches are those that a compile measures.
    if (&of_group[g] != &all) rows[g].covariance_factor = consistent_factor(of_group[g]);
    fit_signs(of_group[g], rows[g]);
  }
  const auto factor_of = [&](const Block& block) {
    return rows[static_cast<std::size_t>(group_of_world(block.kind))].covariance_factor;
  };
  for (std::size_t g = 0; g < kPlaceGroups; ++g) {
    const bool is_by_itself = of_group[g].size() >= kFewest;
    fit_bounds(is_by_itself ? of_group[g] : all, factor_of, rows[g]);
    rows[g].place = protection_row(static_cast<PlaceGroup>(g)).place;
  }
  return rows;
}

Result<std::vector<KindSample>> read_samples(const std::string& path) {
  std::vector<KindSample> samples;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream in(line);
    KindSample& one = samples.emplace_back();
    MatchSample& s = one.sample;
    int constrained[2];
    in >> one.kind >> one.seed >> one.scan >> constrained[0] >> constrained[1];
    for (int i = 0; i < 6; ++i) in >> s.found[i];
    for (int i = 0; i < 6; ++i) in >> s.start[i];
    for (int i = 0; i < 6; ++i) in >> s.structure.descent[i];
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) {
        in >> s.structure.information(i, j);
        s.structure.information(j, i) = s.structure.information(i, j);
      }
    }
    RaisedPoints& raised = s.structure.raised;
    in >> s.likelihood >> s.point_count >> s.scored_points >> raised.met_count >> raised.count;
    if (!in) return Error{ErrorCode::kBadValue, "not a sample: " + line, path};
  }
  return samples;
}

}  // namespace sightline
