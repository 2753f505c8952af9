#include "tests/bench/driving/learn_plan.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "formats/base/parallel.h"

namespace sightline {
namespace {

constexpr auto kSize = static_cast<Eigen::Index>(kLookSigns);
using Weights = Eigen::Matrix<double, kSize + 1, 1>;
using Information = Eigen::Matrix<double, kSize + 1, kSize + 1>;

// A sign that hardly varies in these towns must not be decisive elsewhere.
constexpr double kLeastSpread = 0.05;
constexpr double kPenalty = 1.0;
constexpr double kHeld = 0.998;  // of the scans that teach

struct Scale {
  LookSigns mean{}, spread{};
};

Scale scale_of(std::span<const LookExample> examples) {
  const auto count = static_cast<double>(examples.size());
  Scale scale;
  for (std::size_t i = 0; i < kLookSigns; ++i) {
    for (const LookExample& example : examples) scale.mean[i] += example.signs[i] / count;
    double variance = 0.0;
    for (const LookExample& example : examples) {
      const double off = example.signs[i] - scale.mean[i];
      variance += off * off / count;
    }
    scale.spread[i] = std::max(std::sqrt(variance), kLeastSpread);
  }
  return scale;
}

Weights scaled(const LookSigns& signs, const Scale& scale) {
  Weights row;
  for (std::size_t i = 0; i < kLookSigns; ++i) {
    row(static_cast<Eigen::Index>(i)) = (signs[i] - scale.mean[i]) / scale.spread[i];
  }
  row(kSize) = 1.0;
  return row;
}

double coverage(const std::vector<std::vector<DriveStep>>& drives, std::size_t& lost) {
  double within = 0.0, count = 0.0;
  lost = 0;
  for (const std::vector<DriveStep>& steps : drives) {
    for (const DriveStep& step : steps) {
      within += step.error_m <= kLimit_m ? 1.0 : 0.0;
      lost += step.is_lost ? 1 : 0;
    }
    count += static_cast<double>(steps.size());
  }
  return within / count;
}

// Both drives of all towns but one.
std::vector<std::vector<DriveStep>> drive_others(const DrivenTowns& towns, const LookPlan& plan,
                                                 std::size_t left_out, int threads) {
  std::vector<std::vector<DriveStep>> drives(2 * towns.size());
  parallel_for(drives.size(), threads, [&](std::size_t i) {
    if (i / 2 == left_out) return;
    const std::unique_ptr<Vehicle> vehicle = make_planned_vehicle(*towns[i / 2], plan);
    drives[i] = drive_whole(towns[i / 2]->drives[i % 2], *vehicle);
  });
  return drives;
}

}  // namespace

std::vector<std::vector<LookExample>> examples_of(const DrivenTowns& towns, const LookPlan& plan,
                                                  int threads) {
  LookPlan always = plan;
  always.doubt_above = -std::numeric_limits<double>::infinity();
  const std::vector<std::vector<DriveStep>> drives =
      drive_others(towns, always, towns.size(), threads);
  std::vector<std::vector<LookExample>> examples(towns.size());
  for (std::size_t i = 0; i < drives.size(); ++i) {
    for (const DriveStep& step : drives[i]) {
      if (!step.is_tracking) continue;
      examples[i / 2].push_back(
          {step.found.signs, step.first_error_m > kDoubted_m, step.first_error_m > kLimit_m});
    }
  }
  return examples;
}

LookTest learn_look_test(std::span<const LookExample> examples) {
  const Scale scale = scale_of(examples);
  Weights weights = Weights::Zero();
  for (int iteration = 0; iteration < 50; ++iteration) {
    Weights gradient = -kPenalty * weights;
    Information information = kPenalty * Information::Identity();
    gradient(kSize) = 0.0;
    information(kSize, kSize) = 1e-6;
    for (const LookExample& example : examples) {
      const Weights row = scaled(example.signs, scale);
      const double p = 1.0 / (1.0 + std::exp(-row.dot(weights)));
      gradient += ((example.is_off ? 1.0 : 0.0) - p) * row;
      information += p * (1.0 - p) * row * row.transpose();
    }
    Weights step = information.ldlt().solve(gradient);
    if (step.norm() > 2.0) step *= 2.0 / step.norm();
    weights += step;
  }
  LookTest test;
  test.constant = weights(kSize);
  for (std::size_t i = 0; i < kLookSigns; ++i) {
    test.weights[i] = weights(static_cast<Eigen::Index>(i)) / scale.spread[i];
    test.constant -= test.weights[i] * scale.mean[i];
  }
  return test;
}

double area_under_curve(std::span<const LookExample> examples, const LookTest& test) {
  std::vector<std::pair<double, bool>> doubts;
  for (const LookExample& example : examples) {
    doubts.emplace_back(doubt_of(test, example.signs), example.is_beyond_limit);
  }
  std::ranges::sort(doubts);
  double beyond = 0.0, within = 0.0, pairs = 0.0;
  for (std::size_t i = 0; i < doubts.size();) {
    double beyond_here = 0.0, within_here = 0.0;
    for (const double doubt = doubts[i].first; i < doubts.size() && doubts[i].first == doubt; ++i) {
      (doubts[i].second ? beyond_here : within_here) += 1.0;
    }
    pairs += beyond_here * (within + 0.5 * within_here);
    beyond += beyond_here;
    within += within_here;
  }
  return pairs / (beyond * within);
}

LookPlan learn_plan(const DrivenTowns& towns, const std::vector<std::vector<LookExample>>& examples,
                    const LookPlan& looks, std::size_t left_out, int threads) {
  std::vector<LookExample> others;
  for (std::size_t town = 0; town < towns.size(); ++town) {
    if (town != left_out) others.insert(others.end(), examples[town].begin(), examples[town].end());
  }
  LookPlan plan = looks;
  plan.test = learn_look_test(others);
  std::vector<double> doubts;
  for (const LookExample& example : others) doubts.push_back(doubt_of(plan.test, example.signs));
  std::ranges::sort(doubts, std::greater<>());
  LookPlan best = plan;
  double best_coverage = -1.0;
  for (const double share : {0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.20}) {
    plan.doubt_above = doubts[static_cast<std::size_t>(share * static_cast<double>(doubts.size()))];
    std::size_t lost = 0;
    const double covered = coverage(drive_others(towns, plan, left_out, threads), lost);
    if (lost == 0 && covered >= kHeld) return plan;
    if (covered > best_coverage) best = plan;
    best_coverage = std::max(best_coverage, covered);
  }
  return best;
}

}  // namespace sightline
