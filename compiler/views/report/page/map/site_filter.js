// Which sites of the route stand out; the others are drawn faintly.

import { button, element, switchOf } from "../elements.js";
import { chosenRange, limitCount, measuredError } from "../data.js";
import { select, selection } from "../selection.js";

// Each has a name and test(limit), a function from site to yes or no.
function filtersOf(page) {
  const hasFlag = (bit) => (limit) => (site) => (page.choice.flags[site * limitCount(page) + limit] & bit) !== 0;
  const filters = [{ name: "all sites", test: () => () => true },
    { name: "unmet: no range is good enough", test: hasFlag(1) }, { name: "unlike the training data", test: hasFlag(2) }];
  if (page.judged) {
    filters.push({ name: "error above the limit on the judging drive",
      test: (limit) => (site) => measuredError(page, site, chosenRange(page, site, limit)) > page.limits_m[limit] });
  }
  if (page.diff) {
    const changed = new Set(page.diff.sites.site);
    filters.push({ name: "changed from the older map", test: () => (site) => changed.has(site) });
  }
  const occurring = [...new Set(page.choice.range_index)].sort((a, b) => a - b);
  for (const range of occurring) {
    filters.push({ name: `range ${page.ranges_m[range]} m`, test: (limit) => (site) => chosenRange(page, site, limit) === range });
  }
  return filters;
}

// A switch, how many sites it leaves, and buttons from one to the next. isWanted is set by limit(i).
export function siteFilter(page, onChange) {
  const filters = filtersOf(page);
  const state = { filter: 0, limit: 0 };
  const words = element("output", {});
  const made = { isWanted: () => true, isOn: () => state.filter > 0 };
  const apply = () => {
    made.isWanted = filters[state.filter].test(state.limit);
    let count = 0;
    for (let site = 0; site < page.sites.count; ++site) count += made.isWanted(site);
    words.textContent = state.filter === 0 ? "" : `${count} of ${page.sites.count} sites`;
    steps.hidden = state.filter === 0;
    onChange();
  };
  const step = (by) => {
    for (let site = (selection.site ?? 0) + by; site >= 0 && site < page.sites.count; site += by) {
      if (made.isWanted(site)) return select(site);
    }
  };
  const steps = element("span", { hidden: true }, button("◀", "Previous of these sites", () => step(-1)),
    button("▶", "Next of these sites", () => step(1)));
  made.bar = element("span", { className: "filter" },
    switchOf("Show", filters.map((filter, i) => [i, filter.name]), (value) => { state.filter = Number(value); apply(); }), steps, words);
  made.limit = (limit) => { state.limit = limit; apply(); };
  return made;
}
