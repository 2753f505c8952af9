#pragma once

#include "compiler/views/report/page/report_sources.h"
#include "compiler/views/report/sections/html.h"
#include "compiler/views/text/factor_report.h"

// The sections of the page, in their order. Each is plain HTML with pictures as SVG; where its
// sources are not known it says so.

namespace sightline {

Section summary_section(const ReportSources& sources);
Section map_section(const ReportSources& sources);
// Of a map that has looks which take a sample.
Section looks_section(const ReportSources& sources);
// Where there is a diff.
Section diff_section(const ReportSources& sources);
Section ranges_section(const Evaluation& evaluation, const Sites& sites);
Section ideal_section(const Evaluation& evaluation, const Sites& sites);
Section choice_section(const Evaluation& evaluation, const Sites& sites);
Section tracks_section(const DriveTracks& tracks);
Section trust_section(const ReportSources& sources);
Section factors_section(const FactorReport& factors, const CompiledMap& map);
// Where `weak` was asked.
Section weak_section(const Weakness& weakness, const Sites& sites);
Section making_section(const ReportSources& sources);
// Errors: malformed-text where the provenance is not JSON.
Result<Section> passes_section(const ReportSources& sources);
Result<Section> provenance_section(const ReportSources& sources);

}  // namespace sightline
