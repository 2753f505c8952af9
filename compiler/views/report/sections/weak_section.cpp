#include <cmath>

#include "compiler/views/report/sections/sections.h"
#include "compiler/views/text/weakness_text.h"

// Where the map is weak, which way, why, and what would help.

namespace sightline {
namespace {

std::string advice_text(const ExplainedStretch& one, const Sites& sites) {
  if (one.advice.empty()) return "no place found";
  const TargetAdvice& best = one.advice.front();
  const Eigen::Vector3d p_m = best.target.foot_map_m + sites.frame.origin_world_m;
  return "at (" + fixed(p_m.x(), 1) + ", " + fixed(p_m.y(), 1) + "), facing " +
         fixed(facing_deg(best.target), 0) + " degrees: " + percent(best.gain) + " less";
}

std::string stretches_table(const Weakness& weakness, const Sites& sites) {
  TextGrid grid = {{"worst site", "run", "from (m)", "to (m)", "error (cm)", "left over (%)",
                    "loose", "cause", "a board would help most"}};
  for (const ExplainedStretch& one : weakness.stretches) {
    const WeakStretch& stretch = one.stretch;
    grid.push_back({std::to_string(stretch.worst_site), std::to_string(stretch.run),
                    fixed(stretch.from_m, 0), fixed(stretch.to_m, 0),
                    in_centimetres(stretch.worst.error_m), in_percent(stretch.worst.margin),
                    std::string(name_of_way(one.loose.off_road_deg)),
                    std::string(name_of(one.cause)), advice_text(one, sites)});
  }
  return html_table(grid, "The weakest stretches; positions in the recordings' world, m");
}

}  // namespace

Section weak_section(const Weakness& weakness, const Sites& sites) {
  std::string html = paragraph(summary_sentence(weakness));
  if (weakness.stretches.empty()) return {"weak", "Where it is weak", html};
  html += stretches_table(weakness, sites);
  for (const ExplainedStretch& one : weakness.stretches) {
    html +=
        paragraph("Site " + std::to_string(one.stretch.worst_site) + ": " + cause_sentence(one));
  }
  return {"weak", "Where it is weak", html};
}

}  // namespace sightline
