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

}  // namespace sightline::town
