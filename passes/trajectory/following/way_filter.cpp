#include "passes/trajectory/following/way_filter.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

// Of the first speed, a mean of few steps, and the most that a speed becomes unknown: drivers
// change it by a few percent within half a minute.
constexpr double kSpeedShare = 0.05;
// How much of itself a speed changes in a second: a lower share follows brakes too slowly.
constexpr double kChangePerRootS = 0.02;
// Slower vehicles change their speed by as much as at this one.
constexpr double kLeastSpeed_m_s = 10.0;
constexpr double kFirstPlace_m = 0.01;
// What the road adds at each step.
constexpr double kRoad_m = 0.001;
// A place farther off than this would meet other surfaces.
constexpr double kFarthest_m = 0.15;
constexpr double kContradicts = 3.0;

// The speed that shares are of.
double speed_for_shares_m_s(double speed_m_s) {
  return std::max(std::abs(speed_m_s), kLeastSpeed_m_s);
}

// Few surfaces that drift with the map would carry the speed away without a bound.
constexpr double kMostChange = 0.1;
// Of a mean over ten measured steps.
constexpr double kNewMeasured = 0.1;

double square(double value) { return value * value; }

// What keeps a variance at most that.
double root_share(double most, double variance) {
  return variance > most ? std::sqrt(most / variance) : 1.0;
}

}  // namespace

void WayFilter::begin(double speed_m_s) {
  is_known_ = true;
  speed_m_s_ = measured_m_s_ = speed_m_s;
  place_m2_ = square(kFirstPlace_m);
  place_speed_m2_s_ = 0.0;
  speed_m2_s2_ = square(kSpeedShare * speed_for_shares_m_s(speed_m_s));
}

void WayFilter::predict(double time_s) {
  const double speed_m_s = speed_for_shares_m_s(speed_m_s_);
  place_m2_ += 2.0 * time_s * place_speed_m2_s_ + square(time_s) * speed_m2_s2_ + square(kRoad_m);
  place_speed_m2_s_ += time_s * speed_m2_s2_;
  speed_m2_s2_ += square(kChangePerRootS * speed_m_s) * time_s;
  const double of_place = root_share(square(kFarthest_m), place_m2_);
  const double of_speed = root_share(square(kSpeedShare * speed_m_s), speed_m2_s2_);
  place_m2_ *= square(of_place);
  place_speed_m2_s_ *= of_place * of_speed;
  speed_m2_s2_ *= square(of_speed);
}

double WayFilter::sigma_m() const { return std::sqrt(place_m2_); }

// The estimate is this share of the surfaces' own place: place^2 / (place^2 + sigma^2).
bool WayFilter::is_contradicted(double off_m, double surfaces_sigma_m) const {
  return std::abs(off_m) >
         kContradicts * place_m2_ / std::sqrt(place_m2_ + square(surfaces_sigma_m));
}

bool WayFilter::take_estimate(double off_m, double surfaces_sigma_m) {
  change(off_m, surfaces_sigma_m);
  const double most_m_s = kMostChange * speed_for_shares_m_s(measured_m_s_);
  const double by_surfaces_m_s = speed_m_s_;
  speed_m_s_ = std::clamp(speed_m_s_, measured_m_s_ - most_m_s, measured_m_s_ + most_m_s);
  return speed_m_s_ != by_surfaces_m_s;
}

void WayFilter::take_measurement(double off_m, double sigma_m) {
  change(off_m * place_m2_ / (place_m2_ + square(sigma_m)), sigma_m);
  measured_m_s_ += kNewMeasured * (speed_m_s_ - measured_m_s_);
}

void WayFilter::change(double off_m, double surfaces_sigma_m) {
  const double all_m2 = place_m2_ + square(surfaces_sigma_m);
  speed_m_s_ += place_speed_m2_s_ / place_m2_ * off_m;
  speed_m2_s2_ -= square(place_speed_m2_s_) / all_m2;
  place_speed_m2_s_ -= place_speed_m2_s_ * place_m2_ / all_m2;
  place_m2_ -= square(place_m2_) / all_m2;
}

}  // namespace sightline
