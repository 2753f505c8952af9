#include "examples/town/bag/imu.h"

#include "formats/base/random.h"
#include "formats/geometry.h"

namespace sightline::town {

std::vector<TurnRate> imu_of(const DriveSimulator& drive, std::uint64_t seed) {
  constexpr std::uint64_t kImuKey = 0x696d75ULL;
  constexpr std::int64_t kStep_ns = 5'000'000;
  constexpr std::int64_t kBeyond_ns = 500'000'000;
  constexpr double kMostBias_radps = 0.01;
  constexpr double kSigma_radps = 0.003;
  constexpr double kAround_s = 1e-4;  // the true rate is taken from poses so far apart
  Random random(mix(seed, kImuKey));
  Eigen::Vector3d bias_radps;
  for (double& axis : bias_radps) axis = random.uniform(-kMostBias_radps, kMostBias_radps);
  std::vector<TurnRate> rates;
  const std::int64_t end_ns = drive.stamp_ns(drive.scan_count()) + kBeyond_ns;
  for (std::int64_t time_ns = -kBeyond_ns; time_ns <= end_ns; time_ns += kStep_ns) {
    const double time_s = 1e-9 * static_cast<double>(time_ns);
    const Pose before = drive.T_town_vehicle_at(time_s - 0.5 * kAround_s);
    const Pose after = drive.T_town_vehicle_at(time_s + 0.5 * kAround_s);
    const Eigen::Matrix3d turn = before.linear().transpose() * after.linear();
    Eigen::Vector3d rate_radps = rotation_vector(turn) / kAround_s + bias_radps;
    for (double& axis : rate_radps) axis += kSigma_radps * random.normal();
    rates.push_back({time_ns, rate_radps});
  }
  return rates;
}

Pose T_vehicle_imu() {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(0.3, 0.1, 0.5);
  pose.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return pose;
}

std::vector<Eigen::Vector3d> specific_forces(const DriveSimulator& drive, std::uint64_t seed,
                                             const std::vector<TurnRate>& rates) {
  constexpr std::uint64_t kForceKey = 0x666f726365ULL;
  constexpr double kMostBias_m_s2 = 0.05;
  constexpr double kSigma_m_s2 = 0.03;
  constexpr double kAround_s = 2e-3;
  const Eigen::Vector3d gravity_m_s2(0.0, 0.0, -9.80665);
  Random random(mix(seed, kForceKey));
  Eigen::Vector3d bias_m_s2;
  for (double& axis : bias_m_s2) axis = random.uniform(-kMostBias_m_s2, kMostBias_m_s2);
  std::vector<Eigen::Vector3d> forces;
  for (const TurnRate& rate : rates) {
    const double time_s = 1e-9 * static_cast<double>(rate.stamp_ns);
    const auto at = [&](double seconds) -> Pose {
      return drive.T_town_vehicle_at(seconds) * T_vehicle_imu();
    };
    const Pose here = at(time_s);
    const Eigen::Vector3d change_m = at(time_s + kAround_s).translation() -
                                     2.0 * here.translation() +
                                     at(time_s - kAround_s).translation();
    const Eigen::Vector3d force_m_s2 = change_m / (kAround_s * kAround_s) - gravity_m_s2;
    Eigen::Vector3d measured_m_s2 = here.linear().transpose() * force_m_s2 + bias_m_s2;
    for (double& axis : measured_m_s2) axis += kSigma_m_s2 * random.normal();
    forces.push_back(measured_m_s2);
  }
  return forces;
}

std::vector<WheelSpeed> wheel_speeds(const DriveSimulator& drive, std::uint64_t seed) {
  constexpr std::uint64_t kWheelKey = 0x776865656cULL;
  constexpr std::int64_t kStep_ns = 20'000'000;
  constexpr double kMostScale = 0.015;
  constexpr double kSigma_m_s = 0.02;
  constexpr double kSigma_rad_s = 0.02;
  constexpr double kAround_s = 2e-3;
  Random random(mix(seed, kWheelKey));
  const double scale = 1.0 + random.uniform(-kMostScale, kMostScale);
  std::vector<WheelSpeed> speeds;
  const std::int64_t end_ns = drive.stamp_ns(drive.scan_count());
  for (std::int64_t time_ns = 0; time_ns <= end_ns; time_ns += kStep_ns) {
    const double time_s = 1e-9 * static_cast<double>(time_ns);
    const Pose before = drive.T_town_vehicle_at(time_s - 0.5 * kAround_s);
    const Pose after = drive.T_town_vehicle_at(time_s + 0.5 * kAround_s);
    const Eigen::Vector3d step_m =
        before.linear().transpose() * (after.translation() - before.translation());
    const Eigen::Matrix3d turn = before.linear().transpose() * after.linear();
    WheelSpeed speed{time_ns, scale * step_m.x() / kAround_s,
                     rotation_vector(turn).z() / kAround_s};
    speed.speed_m_s += kSigma_m_s * random.normal();
    speed.yaw_rate_rad_s += kSigma_rad_s * random.normal();
    speeds.push_back(speed);
  }
  return speeds;
}

}  // namespace sightline::town
