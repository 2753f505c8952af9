#pragma once

#include <string>

#include "compiler/views/report/page/report_sources.h"
#include "formats/base/result.h"

namespace sightline {

// One HTML file that needs nothing else, from no network: every table and a picture of every figure
// in plain HTML and SVG, then all numbers (compiler/views/report/page/page_data.h) and, where the
// program was built with them, the scripts that make figures and map answer to a mouse and a
// keyboard. Equal sources give equal bytes. Errors: mismatched-inputs where an artifact is of
// another map; malformed-text where the provenance is not JSON.
Result<std::string> report_html(const ReportSources& sources);

// Whether this program was built with the scripts (compiler/views/report/page/bundle).
bool has_page_scripts();

}  // namespace sightline
