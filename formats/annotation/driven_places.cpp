#include "formats/annotation/driven_places.h"

#include <algorithm>

namespace sightline {
namespace {

Error mismatched(const DrivenPlace& place, const std::string& message) {
  return {ErrorCode::kMismatchedInputs, message, "", concat("place '", place.name, "'")};
}

Result<void> validate_drive(const DrivenPlace& place, const MeasuredError& drive) {
  if (drive.scan_of_site.size() != place.sites.sites.size()) {
    return mismatched(place, concat("found errors of ", drive.scan_of_site.size(),
                                    " sites, expected ", place.sites.sites.size()));
  }
  if (drive.looks != place.factors.looks) {
    return mismatched(place, "factors and errors are of different ranges");
  }
  return validate(drive);
}

Result<void> validate_place(const DrivenPlace& place) {
  if (place.factors.site_count != place.sites.sites.size()) {
    return mismatched(place, concat("found factors of ", place.factors.site_count,
                                    " sites, expected ", place.sites.sites.size()));
  }
  if (place.drives.empty()) return mismatched(place, "no drive was measured there");
  Result<void> valid = validate(place.sites);
  if (valid) valid = validate(place.factors);
  if (valid) valid = validate(place.recordings);
  for (const MeasuredError& drive : place.drives) {
    if (valid) valid = validate_drive(place, drive);
  }
  return valid;
}

std::int64_t measured_count(const MeasuredError& drive) {
  return std::ranges::count_if(drive.scan_of_site, [](std::int64_t scan) { return scan >= 0; });
}

}  // namespace

Result<void> validate(const DrivenPlaces& places) {
  if (places.places.empty()) {
    return Error{ErrorCode::kNoTrainingRows, "no place to train on"};
  }
  for (const DrivenPlace& place : places.places) {
    SIGHTLINE_TRY(validate_place(place));
    if (place.factors.looks != places.places.front().factors.looks ||
        place.factors.factors != places.places.front().factors.factors) {
      return mismatched(place, concat("its ranges or factors differ from those of place '",
                                      places.places.front().name, "'"));
    }
  }
  return {};
}

Table dump(const DrivenPlaces& places) {
  Table table{"driven-places", {"place", "drive", "sites", "measured_sites"}, {}, {}};
  for (const DrivenPlace& place : places.places) {
    for (const MeasuredError& drive : place.drives) {
      table.rows.push_back({place.name, drive.drive,
                            static_cast<std::int64_t>(place.sites.sites.size()),
                            measured_count(drive)});
    }
  }
  return table;
}

Table dump(const ByFamily<DrivenPlaces>& places) { return dump(places.ranges); }

}  // namespace sightline
