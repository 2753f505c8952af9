#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/annotation/site_column.h"
#include "formats/annotation/sites.h"

// Errors by direction of a vehicle that tracks, as columns of sites; part of emit-map.

namespace sightline {

// The look whose errors are kept: the longest range, or the cheapest look that takes a sample of 64
// points or more, else the last. None where no tracking start was measured.
std::optional<std::size_t> tracking_look(const MeasuredError& measured);

// By the names of formats/reader/site_errors.h; +inf where no site within 5 m of the run was
// measured. `measured` has the sites' rows at a look that tracking_look() names.
std::vector<SiteColumn> tracking_columns(const MeasuredError& measured, std::size_t look,
                                         const Sites& sites,
                                         std::span<const std::string_view> names);

}  // namespace sightline
