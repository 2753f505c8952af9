#include "passes/matching/covariance/protection.h"
#include "passes/vehicle/sightline_localizer.h"

using sightline::Integrity;

static_assert(SIGHTLINE_INTEGRITY_UNKNOWN == static_cast<unsigned>(Integrity::kUnknown));
static_assert(SIGHTLINE_INTEGRITY_OK == static_cast<unsigned>(Integrity::kOk));
static_assert(SIGHTLINE_INTEGRITY_DOUBTFUL == static_cast<unsigned>(Integrity::kDoubtful));
static_assert(SIGHTLINE_INTEGRITY_LOST == static_cast<unsigned>(Integrity::kLost));

extern "C" uint32_t sightline_monitor_add(sightline_monitor* monitor,
                                          const sightline_match* match) {
  if (monitor == nullptr || match == nullptr) return SIGHTLINE_INTEGRITY_UNKNOWN;
  sightline::IntegrityMonitor test{monitor->doubt, monitor->raised_points, monitor->raised_met};
  const Integrity all =
      test.add(static_cast<Integrity>(match->integrity), {match->raised_points, match->raised_met},
               sightline::protection_row(sightline::group_of_kind(match->place_kind)));
  monitor->doubt = test.doubt;
  monitor->raised_points = test.raised_count;
  monitor->raised_met = test.raised_met_count;
  return static_cast<uint32_t>(all);
}
