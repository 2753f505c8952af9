#pragma once

#include <string>
#include <vector>

#include "compiler/views/report/page/report_sources.h"

namespace sightline {

// The numbers of a page: one JSON object, for <script type="application/json" id="data">. Its
// members are in page_data.md.
std::string page_data_json(const ReportSources& sources);

// How far each site lies from the first, with all runs laid end to end, one spacing apart.
std::vector<double> route_of_sites_m(const Sites& sites);

}  // namespace sightline
