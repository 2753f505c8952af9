#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "passes/replay/find_place.h"
#include "passes/replay/replayed_scan.h"

namespace sightline {

// A match, and the look that it is by.
struct Matched {
  sightline_match match{};
  MapLook look;
};

// Where a scan was found without one before it, and how much of it the map shows there.
struct FoundHere {
  ReplayedScan scan;
  double met_share = -1.0;
};

// The vehicle between two scans.
class ReplayedVehicle {
 public:
  ReplayedVehicle(const ReplayOptions& options, const ReplayInputs& inputs, int threads)
      : options_(options), inputs_(inputs), threads_(threads) {}

  // The next scan. Errors: those of MapReader::look_plan and sites, and of JoinedMaps::go_to.
  Result<ReplayedScan> take(std::size_t number, Scan scan);

  [[nodiscard]] bool has_started() const { return has_started_; }
  [[nodiscard]] std::uint32_t lost_count() const { return lost_count_; }

 private:
  [[nodiscard]] bool tracks() const { return result_count_ > 0; }
  [[nodiscard]] const MapReader& reader() const {
    return inputs_.maps.reader(inputs_.maps.present());
  }
  [[nodiscard]] double limit_m() const;
  [[nodiscard]] std::optional<double> met_share(const std::vector<Eigen::Vector3d>& upright_m,
                                                const Pose& T_world_vehicle) const;
  Result<void> choose_map(std::size_t number);
  [[nodiscard]] std::optional<Pose> given(std::size_t number) const;
  [[nodiscard]] Pose predicted(std::int64_t step_ns) const;
  [[nodiscard]] std::optional<Pose> start_of(std::size_t number) const;
  Result<Matched> match(const Scan& scan, const Pose& T_world_start, bool is_tracking) const;
  [[nodiscard]] std::vector<Pose> second_starts(std::size_t number) const;
  Result<Matched> match_next(std::size_t number, const Scan& scan) const;
  Result<ReplayedScan> follow(std::size_t number, const Scan& scan);
  Result<FoundHere> found_near(const Scan& scan, const std::vector<Eigen::Vector3d>& upright_m,
                               const Pose& T_world_start) const;
  [[nodiscard]] MapLook look_of_search() const;
  Result<std::optional<FoundPlace>> place_in_map(
      const Scan& scan, const std::vector<Eigen::Vector3d>& upright_m) const;
  Result<FoundHere> found_anywhere(const Scan& scan,
                                   const std::vector<Eigen::Vector3d>& upright_m) const;
  [[nodiscard]] bool searches(std::size_t number);
  Result<ReplayedScan> begin(std::size_t number, const Scan& scan);
  void found(const Pose& T_world_vehicle, bool follows);
  [[nodiscard]] double usual_met() const;
  [[nodiscard]] double least_met() const;
  void shown(double met_share);
  void lose();

  const ReplayOptions& options_;
  const ReplayInputs& inputs_;
  int threads_;
  int search_count_ = 0;  // of scans in a row that were searched for
  bool has_started_ = false;
  std::uint32_t lost_count_ = 0;
  int result_count_ = 0;  // in a row since the track began; 0: not on track
  int contradiction_count_ = 0;
  std::size_t until_check_ = 0;
  double usual_met_ = 0.0;  // of the scans that showed the map usual_map_; 0: none yet
  std::size_t usual_map_ = 0;
  std::optional<Pose> T_world_last_;  // as found
  Pose T_before_last_ = Pose::Identity();
  std::int64_t last_ns_ = 0;       // of T_world_last_
  std::int64_t last_step_ns_ = 0;  // how long T_before_last_ took; 0: not known
};

}  // namespace sightline
