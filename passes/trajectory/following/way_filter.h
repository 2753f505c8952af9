#pragma once

namespace sightline {

// The speed of a vehicle where scans hold little of its way: a Kalman filter of the place along the
// road relative to the local map, m, and of the speed, m/s ("Constraints of a match" in
// schemas/definitions.md). A speed that stayed as it was would be off by all that a driver changes
// it, and surfaces that are mapped at a wrong speed are blurred until none of them holds a scan.
class WayFilter {
 public:
  [[nodiscard]] bool is_known() const { return is_known_; }
  void begin(double speed_m_s);

  // To the next scan. Only where it is known, like all below.
  void predict(double time_s);
  [[nodiscard]] double way_m(double time_s) const { return speed_m_s_ * time_s; }
  // Standard deviation of the predicted place.
  [[nodiscard]] double sigma_m() const;
  // Whether a place that is estimated from the prediction and from surfaces of this standard
  // deviation, so far ahead of the prediction, contradicts it.
  [[nodiscard]] bool is_contradicted(double off_m, double surfaces_sigma_m) const;

  // The place was estimated `off_m` ahead of the prediction, by it and by surfaces. The speed stays
  // within 10 % of the last one that was measured; returns whether surfaces would change it by
  // more.
  bool take_estimate(double off_m, double surfaces_sigma_m);
  // The place was measured `off_m` ahead of the prediction, by many surfaces.
  void take_measurement(double off_m, double sigma_m);

 private:
  void change(double off_m, double surfaces_sigma_m);

  bool is_known_ = false;
  double speed_m_s_ = 0.0;
  double measured_m_s_ = 0.0;  // mean speed of the latest measured places
  double place_m2_ = 0.0;      // covariance
  double place_speed_m2_s_ = 0.0;
  double speed_m2_s2_ = 0.0;
};

}  // namespace sightline
