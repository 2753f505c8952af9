#include "passes/trajectory/following/follower.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "formats/base/units.h"

namespace sightline {
namespace {

// A scan with a smaller overlap than this, or than this share of the usual one, is searched for
// farther around: steps of a few metres still have 0.7.
constexpr double kPoorOverlap = 0.6;
constexpr double kPoorShare = 0.75;
// A smaller overlap may occur by chance: the place is rejected.
constexpr double kLeastOverlap = 0.35;
// A place from even motion alone with less than this share of the usual overlap is rejected.
constexpr double kLeastShareOfUsual = 0.5;
// How far the first step of a piece may lead; ends nearer to each other count as one.
constexpr double kFirstStep_m = 4.0;
constexpr double kSamePlace_m = 0.3;
// So many first steps are followed, those with the largest overlaps.
constexpr std::size_t kMostFirstSteps = 4;
// In a shorter piece walls are made of few scans, at the poses these were given: shorter last steps
// would follow what these have in common by chance.
constexpr double kShortestStepsFrom_m = 20.0;
// A match this far from the given step is compared with it by the last scan alone.
constexpr double kFarFromGiven_m = 0.5;

// Of road vehicles.
constexpr double kFastest_m_s = 50.0;

// How far from the predicted pose a scan is searched for: at the start, when the speed is not
// known, and where matching failed.
constexpr double kSearchReach_m = 3.0;

constexpr std::int64_t kShortestJump_ns = kSecond_ns;
constexpr double kNewShare = 0.1;
constexpr double kUsual = 0.85;

// Poses of a vehicle that turns or brakes harder than at constant velocity.
std::vector<Pose> bolder(const Pose& T_map_before, const Pose& T_map_start) {
  std::vector<Pose> starts;
  const Pose step = T_map_before.inverse() * T_map_start;
  for (const double turn_rad : {-0.12, -0.06, 0.06, 0.12}) {
    Pose start = T_map_start;
    start.linear() = T_map_start.linear() * rotation_matrix({Eigen::Vector3d::UnitZ(), turn_rad});
    starts.push_back(start);
  }
  for (const double share : {0.0, 0.5, 1.5}) {
    Pose part = step;
    part.translation() *= share;
    starts.push_back(T_map_before * part);
  }
  return starts;
}

// The best of `best` and the matches from these starts.
LocalMatch best_of(LocalSearch& search, const std::vector<Pose>& starts, LocalMatch best) {
  for (const Pose& start : starts) {
    const std::optional<LocalMatch> match = search.match(start);
    if (match && match->is_better_than(best)) best = *match;
  }
  return best;
}

// A longer step ends a piece: 1 s, and three times the median step.
std::int64_t longest_step_ns(const Drive& drive) {
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = 1; i < drive.scans.size(); ++i) {
    steps_ns.push_back(drive.scans[i].stamp_ns - drive.scans[i - 1].stamp_ns);
  }
  if (steps_ns.empty()) return kShortestJump_ns;
  const auto middle = steps_ns.begin() + static_cast<std::ptrdiff_t>(steps_ns.size() / 2);
  std::ranges::nth_element(steps_ns, middle);
  return std::max(kShortestJump_ns, 3 * *middle);
}

// The best match from the starts; where it is worse than usual, from harder turns and other speeds
// too, and where it is not good or the speed is not known yet, from all places within 3 m.
LocalMatch follow(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                  const std::vector<Pose>& starts, const Pose& T_map_before,
                  const RunningAverage& average) {
  LocalSearch search(grids, points_m);
  LocalMatch best = best_of(search, starts, {});
  if (!average.is_met_by(best)) {
    best = best_of(search, bolder(T_map_before, starts.front()), best);
  }
  if (average.likelihood == 0.0 || !best.is_good()) {
    for (const Pose& start : starts) {
      best = best_of(search, starts_around(start, kSearchReach_m), best);
    }
  }
  return best;
}

}  // namespace

Result<ReadScan> read_scan(const Drive& drive, std::size_t index, Upright upright) {
  ReadScan scan;
  SIGHTLINE_ASSIGN(scan.thinned, read_thinned(drive, index));
  if (upright == Upright::kLeftOut) return scan;
  const Eigen::Matrix3d level = drive.sensor.T_vehicle_lidar.linear();
  scan.upright_m = upright_points(scan.thinned.to_match_m, level);
  scan.upright_to_map_m = upright_points(scan.thinned.to_map_m, level);
  return scan;
}

Follower::Follower(const Drive& drive, const GivenPoses& given, double local_map_m,
                   std::size_t first, const SpeedForecast& speed)
    : drive_(&drive),
      given_(&given),
      local_map_m_(local_map_m),
      first_(first),
      longest_step_ns_(longest_step_ns(drive)),
      map_(local_map_m),
      upright_(local_map_m),
      speed_(speed) {}

void Follower::take(const ReadScan& scan) {
  const std::size_t k = next_scan();
  if (k == first_) {
    append((*given_)[k].value_or(drive_->sensor.T_vehicle_lidar), false, {});
  } else if (has_given_step(k)) {
    follow_with_given(k, scan);
  } else {
    follow_alone(k, scan);
  }
  remember(scan);
}

void Follower::take_there(const ReadScan& scan, const LocalMatch& match) {
  Found found;
  found.match = match;
  found.overlap = upright_.overlap(scan.upright_m, match.T_map_lidar);
  step_to(next_scan(), scan, found);
  remember(scan);
}

void Follower::begin_with(const ReadScan& scan, const TimedStep& step) {
  const Pose start = tidied(T_map_before() * carried_on(step, step_ns(next_scan())));
  const LocalMatch match = match_locally(map_.grids(), scan.thinned.to_match_m, start);
  if (match.is_good()) {
    take_there(scan, match);
  } else {
    take(scan);
  }
}

TimedStep Follower::last_step() const { return steps_.empty() ? TimedStep{} : steps_.front(); }

bool Follower::is_at_first_step() const {
  const std::size_t k = next_scan();
  return k > first_ && k < drive_->scans.size() && steps_.empty() && !is_jump(k) &&
         !has_given_step(k);
}

std::vector<LocalMatch> Follower::first_steps(const ReadScan& scan) const {
  std::vector<std::pair<double, LocalMatch>> ends;  // by overlap
  LocalSearch search(map_.grids(), scan.thinned.to_match_m);
  for (const Pose& start : starts_around(T_map_before(), kFirstStep_m)) {
    const std::optional<LocalMatch> end = search.match(start);
    if (!end || !end->is_good()) continue;
    const std::optional<double> overlap = upright_.overlap(scan.upright_m, end->T_map_lidar);
    if (overlap) ends.emplace_back(*overlap, *end);
  }
  std::ranges::stable_sort(ends, std::greater<>(), [](const auto& end) { return end.first; });
  std::vector<LocalMatch> distinct;
  for (const std::pair<double, LocalMatch>& of_overlap : ends) {
    const LocalMatch& end = of_overlap.second;
    const bool is_known = std::ranges::any_of(distinct, [&](const LocalMatch& other) {
      return (other.T_map_lidar.translation() - end.T_map_lidar.translation()).norm() <
             kSamePlace_m;
    });
    if (!is_known) distinct.push_back(end);
    if (distinct.size() == kMostFirstSteps) break;
  }
  return distinct;
}

bool Follower::begins_part(std::size_t k) const {
  return drive_->scans[k].part != drive_->scans[k - 1].part;
}
bool Follower::has_given_step(std::size_t k) const {
  return (*given_)[k - 1] && (*given_)[k] && !begins_part(k);
}
std::int64_t Follower::step_ns(std::size_t k) const {
  return drive_->scans[k].stamp_ns - drive_->scans[k - 1].stamp_ns;
}
// Whether the last steps do not predict the motion.
bool Follower::is_jump(std::size_t k) const {
  return step_ns(k) > longest_step_ns_ || begins_part(k);
}

// Predictions of scan k by its motion so far; the likeliest first.
std::vector<Pose> Follower::predictions(std::size_t k) const {
  std::vector<Pose> starts;
  if (was_found_widely_) starts.push_back(moved_on(k));
  for (const TimedStep& step : steps_) {
    starts.push_back(T_map_before() * carried_on(step, step_ns(k)));
  }
  if (steps_.empty()) starts.push_back(T_map_before());
  if (has_given_step(k)) {
    starts.push_back(T_map_before() * (*given_)[k - 1]->inverse() * *(*given_)[k]);
  }
  for (Pose& start : starts) start = tidied(start);
  return starts;
}

// The last step without its turn: a sensor that turns aside keeps moving in its direction.
Pose Follower::moved_on(std::size_t k) const {
  Pose start = T_map_before();
  if (steps_.empty()) return start;
  const Pose T_map_last_but_one = T_map_before() * steps_.front().T_before_after.inverse();
  const Pose straight = carried_on(
      {Eigen::Translation3d(T_map_before().translation() - T_map_last_but_one.translation()) *
           Pose::Identity(),
       steps_.front().time_ns},
      step_ns(k));
  start.translation() += straight.translation();
  return start;
}

Follower::Found Follower::follow_from(const std::vector<Pose>& starts, const ReadScan& scan) const {
  Found found;
  found.match = follow(map_.grids(), scan.thinned.to_match_m, starts, T_map_before(), average_);
  found.overlap = upright_.overlap(scan.upright_m, found.match.T_map_lidar);
  return found;
}

void Follower::follow_with_given(std::size_t k, const ReadScan& scan) {
  const std::vector<Pose> starts = predictions(k);
  Found found;
  // After a jump the given pose is used: earlier scans may be far from here, and a street that
  // looks like another one would contradict poses that are right.
  if (!is_jump(k)) found = follow_from(starts, scan);
  const Pose& T_map_given = starts.back();
  const bool is_matched = found.match.is_good();
  Placed to{T_map_given, {}, {}};
  if (is_matched && fits_given_better(scan, found.match.T_map_lidar, T_map_given)) {
    to.constraint = {kNoConstraint_m,
                     Eigen::Vector3d::Ones(),
                     Forecast::kGiven,
                     Eigen::Matrix3d::Identity(),
                     0.0,
                     Eigen::Vector3d::Ones()};
  } else if (is_matched) {
    average_.add(found.match, found.overlap);
    to = placed(k, scan, found.match.T_map_lidar);
  }
  steps_ = {{T_map_before().inverse() * to.T_map_lidar, step_ns(k)}};
  append(to.T_map_lidar, is_matched, found.overlap);
  odometry.constraint.back() = to.constraint;
}

// Whether a match far from the given step is contradicted by the last scan alone: it may meet a
// local map that earlier wrong matches made.
bool Follower::fits_given_better(const ReadScan& scan, const Pose& T_map_matched,
                                 const Pose& T_map_given) const {
  const double off_m = (T_map_matched.translation() - T_map_given.translation()).norm();
  if (off_m < kFarFromGiven_m || before_m_.empty()) return false;
  const Eigen::Matrix3d level = drive_->sensor.T_vehicle_lidar.linear();
  ScanBefore before;
  before.set(upright_points(before_m_, level), T_map_before());
  const std::vector<Eigen::Vector3d> upright_m = upright_points(scan.thinned.to_match_m, level);
  const std::optional<double> matched = before.overlap(upright_m, T_map_matched);
  const std::optional<double> given = before.overlap(upright_m, T_map_given);
  return matched && given && *given > *matched + kClearlyMoreOverlap;
}

void Follower::follow_alone(std::size_t k, const ReadScan& scan) {
  Found found;
  if (way_.is_known() && step_ns(k) > 0) way_.predict(step_s(k));
  if (!is_jump(k)) found = find(k, scan);
  if (found.is_believed) return step_to(k, scan, found);
  if (found.is_carried) {
    const Placed to = placed_or_carried(k, scan, found);
    speed_.take(step_to_scan(k, to.T_map_lidar), false);
    since_sound_ns_ += step_ns(k);
    steps_ = {{T_map_before().inverse() * to.T_map_lidar, step_ns(k)}};
    append(to.T_map_lidar, true, found.overlap);
    odometry.constraint.back() = to.constraint;
    // The scan contradicts the map there, so that its surfaces are no evidence.
    odometry.constraint.back().kept.setOnes();
    return;
  }
  begin_piece({static_cast<std::uint32_t>(k), is_jump(k),
               found.match.is_good() ? found.overlap.value_or(0.0) : 0.0, found.overlap_elsewhere});
}

void Follower::step_to(std::size_t k, const ReadScan& scan, const Found& found) {
  average_.add(found.match, found.overlap);
  const bool is_long = odometry.driven_m.back() - piece_began_m_ >= kShortestStepsFrom_m;
  const Pose T_map_matched = sharpened(map_.grids(), scan.thinned.to_match_m, found.match,
                                       is_long ? LastStep::kShortest : LastStep::kShort);
  Placed to = placed(k, scan, T_map_matched);
  const Pose& T_map_lidar = to.T_map_lidar;
  const TimedStep step{T_map_before().inverse() * T_map_lidar, step_ns(k)};
  Eigen::Vector2d leap = leap_m(k, to, found);
  if (const std::optional<double> off_m = rival_m(k, scan, T_map_lidar)) leap.x() = *off_m;
  since_sound_ns_ += step_ns(k);
  if (to.constraint.weak.isZero() && leap.isZero(0.0)) {
    steady_.add(step);
    last_sound_ = step;
    since_sound_ns_ = 0;
  }
  take_way(k, to);
  speed_.take(step_to_scan(k, T_map_lidar), to.constraint.weak[0] == 0.0);
  if (to.off_measured_m) way_check_.take(*to.off_measured_m);
  was_found_widely_ = found.is_wide;
  if (found.is_wide && !steps_.empty()) {
    // The recording may lack scans and the speed be as before, or the vehicle be as fast as this
    // step.
    steps_ = {step, steps_.front()};
  } else {
    steps_ = {step};
  }
  append(T_map_lidar, true, found.overlap);
  odometry.is_far.back() = found.is_far;
  odometry.constraint.back() = to.constraint;
  odometry.constraint.back().leap_m = leap;
}

bool Follower::is_poor(const Found& found) const {
  if (!found.match.is_good()) return true;
  const double least = std::max(kPoorOverlap, kPoorShare * average_.overlap);
  return found.overlap && *found.overlap < least;
}

Eigen::Vector3d Follower::along_road(const Pose& T_map_lidar) const {
  return (T_map_lidar * drive_->sensor.T_vehicle_lidar.inverse()).linear().col(0);
}

std::optional<double> Follower::rival_m(std::size_t k, const ReadScan& scan,
                                        const Pose& T_map_lidar) const {
  return before_.rival_m(scan.upright_m, T_map_lidar, along_road(T_map_lidar),
                         kFastest_m_s * step_s(k));
}

// Where the scan before shows the next one elsewhere along the road, the match there if it is clear
// by these two scans: a local map of scans in wrong places holds the next ones there.
Follower::Found Follower::followed(std::size_t k, const ReadScan& scan) const {
  Found found = follow_from(predictions(k), scan);
  const Pose& T_map_found = found.match.T_map_lidar;
  const std::optional<double> off_m = rival_m(k, scan, T_map_found);
  if (!off_m) return found;
  const Pose T_map_rival = Eigen::Translation3d(*off_m * along_road(T_map_found)) * T_map_found;
  Found rival;
  rival.match = match_locally(map_.grids(), scan.thinned.to_match_m, T_map_rival);
  rival.overlap = upright_.overlap(scan.upright_m, rival.match.T_map_lidar);
  const double here = before_.overlap(scan.upright_m, T_map_found).value_or(0.0);
  const double there = before_.overlap(scan.upright_m, rival.match.T_map_lidar).value_or(0.0);
  if (!rival.match.is_good() || there < here + kClearlyMoreOverlap) return found;
  rival.is_wide = rival.is_far = true;
  return rival;
}

// By even motion; where that is poor, turned or farther around.
Follower::Found Follower::find(std::size_t k, const ReadScan& scan) const {
  Found found = followed(k, scan);
  found.is_believed = found.match.is_good();
  if (!is_poor(found)) return found;
  if (is_sparse(k)) {
    found.is_believed = false;
    found.is_carried = true;
    return found;
  }
  const double least = std::max(kLeastOverlap, kLeastShareOfUsual * average_.overlap);
  const double overlap = found.match.is_good() ? found.overlap.value_or(1.0) : 0.0;
  found.is_believed = found.is_believed && overlap >= least;
  const LocalSurroundings there{map_.grids(), upright_};
  const SoughtScan sought{scan.thinned.to_match_m, scan.upright_m};
  const std::optional<WidePlacement> turned =
      place_turned(there, sought, {moved_on(k), T_map_before()});
  if (turned && turned->overlap >= std::max(least, overlap + kClearlyMoreOverlap)) {
    const Found near{turned->match, turned->overlap, 0.0, true, true};
    if (!is_poor(near)) return near;
  }
  return find_widely(there, sought, found);
}

Follower::Found Follower::find_widely(const LocalSurroundings& there, const SoughtScan& sought,
                                      const Found& followed) const {
  const std::optional<WidePlacement> wide = place_widely(there, sought, T_map_before(), {});
  const double overlap = followed.match.is_good() ? followed.overlap.value_or(1.0) : 0.0;
  if (!wide || wide->overlap < overlap + kClearlyMoreOverlap) return followed;
  const bool is_other = are_elsewhere(wide->match.T_map_lidar, followed.match.T_map_lidar);
  const double elsewhere =
      is_other ? std::max(overlap, wide->overlap_elsewhere) : wide->overlap_elsewhere;
  const bool is_believed =
      wide->overlap >= kLeastOverlap && wide->overlap >= elsewhere + kClearlyMoreOverlap;
  return {wide->match, wide->overlap, elsewhere, is_believed, true, true};
}

// Begins a piece with an empty map and an unknown speed.
void Follower::begin_piece(const PieceStart& start) {
  odometry.piece_starts.push_back(start);
  was_found_widely_ = false;
  map_ = LocalMap(local_map_m_);
  upright_ = UprightMap(local_map_m_);
  average_ = {};
  steps_.clear();
  steady_ = {};
  last_sound_.reset();
  since_sound_ns_ = 0;
  way_ = {};
  speed_.begin_piece();
  way_check_ = {};
  is_map_empty_ = true;
  append(T_map_before(), false, {});
  piece_began_m_ = odometry.driven_m.back();
}

void Follower::append(const Pose& T_map_lidar, bool is_matched, std::optional<double> overlap) {
  const bool is_first = odometry.T_map_lidar.empty();
  const double step_m =
      is_first ? 0.0 : (T_map_lidar.translation() - T_map_before().translation()).norm();
  odometry.append(T_map_lidar, step_m, is_matched || is_first, overlap);
}

void Follower::remember(const ReadScan& scan) {
  const Pose& T_map_lidar = odometry.T_map_lidar.back();
  if ((*given_)[next_scan() - 1]) before_m_ = scan.thinned.to_map_m;
  before_.set(scan.upright_to_map_m, T_map_lidar);
  if (!is_map_empty_ && !map_.needs(T_map_lidar)) return;
  is_map_empty_ = false;
  map_.add(scan.thinned.to_map_m, T_map_lidar, odometry.driven_m.back());
  upright_.add(scan.upright_to_map_m, T_map_lidar, odometry.driven_m.back());
}

void RunningAverage::add(const LocalMatch& match, std::optional<double> scan_overlap) {
  if (likelihood == 0.0) *this = {match.likelihood, match.scored_share, 0.0};
  likelihood += kNewShare * (match.likelihood - likelihood);
  scored_share += kNewShare * (match.scored_share - scored_share);
  if (!scan_overlap) return;
  if (overlap == 0.0) overlap = *scan_overlap;
  overlap += kNewShare * (*scan_overlap - overlap);
}

bool RunningAverage::is_met_by(const LocalMatch& match) const {
  return match.likelihood >= kUsual * likelihood && match.scored_share >= kUsual * scored_share;
}

}  // namespace sightline
