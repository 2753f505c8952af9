// What the route can be coloured by. A paint has a name, colours(limit), a function from site to colour, and
// legend(limit), an element that explains it.

import { byAnswer, byKind, byProtection } from "./answer_paint.js";
import { css, ramp, rangeColours, scaleColours } from "./colours.js";
import { chosenRange, measuredError, predictedError, probability } from "./data.js";
import { legendOf, rampBar, rampLegend, shareOf, spanOf } from "./legends.js";

function byRange(page) {
  return {
    name: "range (m)",
    colours: (limit) => {
      const colours = rangeColours(page.ranges_m.length);
      return (site) => colours[chosenRange(page, site, limit)];
    },
    legend: (limit) => {
      const colours = rangeColours(page.ranges_m.length);
      const occurring = new Set(Array.from({ length: page.sites.count }, (_, site) => chosenRange(page, site, limit)));
      return legendOf("range (m):", ...page.ranges_m.flatMap((range_m, i) => (occurring.has(i) ? [[colours[i], String(range_m)]] : [])));
    },
  };
}

// From the limit on the hue is another one.
const withinLimit = () => ramp([css("within-from"), css("within-to")]);
const aboveLimit = () => ramp([css("above-from"), css("above-to")]);

const cm = (error_m) => `${+(100 * error_m).toPrecision(3)} cm`;

// Errors at the chosen range, over those that occur.
function byError(page, name, errorAt) {
  const at = (limit) => (site) => errorAt(site, chosenRange(page, site, limit));
  return {
    name,
    colours: (limit) => {
      const [within, above] = [withinLimit(), aboveLimit()];
      const span = spanOf(page, at(limit));
      const limit_m = page.limits_m[limit];
      return (site) => {
        const error_m = at(limit)(site);
        if (error_m > limit_m) return above(shareOf(error_m, limit_m, span.greatest));
        return within(shareOf(error_m, span?.least ?? 0, limit_m));
      };
    },
    legend: (limit) => {
      const span = spanOf(page, at(limit));
      const limit_m = page.limits_m[limit];
      const place = legendOf(`${name} at the chosen range: `);
      if (span && span.least <= limit_m) place.append(cm(span.least), rampBar(withinLimit()));
      place.append(`${cm(limit_m)}, the limit`);
      if (span && span.greatest > limit_m) place.append(rampBar(aboveLimit()), cm(span.greatest));
      place.append(legendOf("", [css("grey"), "not measured"]));
      return place;
    },
  };
}

function byProbability(page) {
  const at = (limit) => (site) => probability(page, site, chosenRange(page, site, limit), limit);
  return {
    name: "probability of an error within the limit",
    colours: (limit) => {
      const colour = ramp(scaleColours());
      const { least, greatest } = spanOf(page, at(limit));
      return (site) => colour(shareOf(at(limit)(site), least, greatest));
    },
    legend: (limit) => {
      const { least, greatest } = spanOf(page, at(limit));
      return rampLegend("P(error within the limit) at the chosen range: ", least.toFixed(2), greatest.toFixed(2), ramp(scaleColours()));
    },
  };
}

function byFlag(page) {
  const words = [["blue", "good enough"], ["yellow", "unmet: no range is good enough"], ["purple", "unlike the training data"],
    ["grey", "one range for the whole map"]];
  return {
    name: "status",
    colours: (limit) => {
      const colours = words.map(([name]) => css(name));
      return (site) => {
        const flags = page.choice.flags[site * page.limits_m.length + limit];
        if (flags & 2) return colours[2];
        return flags & 1 ? colours[1] : colours[flags & 16 ? 3 : 0];
      };
    },
    legend: () => legendOf("", ...words.map(([name, each]) => [css(name), each])),
  };
}

// Whether scans constrain the poses of the map, without which no answer is known to be right.
function byPose(page) {
  return {
    name: "poses",
    colours: () => {
      const [constrained, open] = [css("blue"), css("orange")];
      return (site) => (page.sites.unconstrained[site] > 0 ? open : constrained);
    },
    legend: () => legendOf("poses of the map:", [css("blue"), "constrained by the scans"],
      [css("orange"), "not constrained by the scans"]),
  };
}

// Change of the range from the older map.
function byChange(page) {
  const places = new Map();
  page.diff.sites.site.forEach((site, i) => places.set(site, i));
  const colours = () => ({ farther: ramp([css("line"), css("orange")]), nearer: ramp([css("line"), css("blue")]) });
  return {
    name: "change from the older map",
    isOfChange: true,
    colours: (limit) => {
      const { farther, nearer } = colours();
      const common = page.diff.limits_m.indexOf(page.limits_m[limit]);
      const most_m = page.ranges_m.at(-1) - page.ranges_m[0] || 1;
      return (site) => {
        const i = places.get(site);
        if (i === undefined || common < 0) return css("grey");
        if (page.diff.sites.change[i] === 0) return css("purple");
        const at = i * page.diff.limits_m.length + common;
        const rise_m = (page.diff.sites.after_dm[at] - page.diff.sites.before_dm[at]) / 10;
        if (rise_m === 0) return css("grey");
        return (rise_m > 0 ? farther : nearer)(0.35 + (0.65 * Math.abs(rise_m)) / most_m);
      };
    },
    legend: () => legendOf("change from the older map:", [css("orange"), "longer range"], [css("blue"), "shorter range"], [css("purple"), "new site"], [css("grey"), "unchanged"]),
  };
}

// With an older map, the change is shown first.
export function firstPaint(page, paints) {
  return page.diff ? paints.findIndex((paint) => paint.isOfChange) : 0;
}

export function paintsOf(page) {
  const paints = [byAnswer(page), byRange(page), byError(page, "predicted error (cm)", (site, range) => predictedError(page, site, range))];
  if (page.judged) paints.push(byError(page, "measured error (cm)", (site, range) => measuredError(page, site, range)));
  paints.push(byProbability(page), byFlag(page));
  if (page.places.kind) paints.push(byKind(page));
  if (page.places.protection_m) paints.push(byProtection(page));
  if (page.sites.unconstrained) paints.push(byPose(page));
  if (page.diff) paints.push(byChange(page));
  return paints;
}
