// What the route can be coloured by. A paint has a name, colours(limit), a function from site to colour, and
// legend(limit), an element that explains it.

import { css, ramp, rangeColours, scaleColours } from "./colours.js";
import { chosenRange, measuredError, predictedError, probability } from "./data.js";

function legendOf(title, ...entries) {
  const place = document.createElement("span");
  place.append(`${title} `);
  for (const [colour, words] of entries) {
    const key = document.createElement("i");
    key.style.background = colour;
    const entry = document.createElement("span");
    entry.style.marginLeft = "0.8em";
    entry.append(key, words);
    place.append(entry);
  }
  return place;
}

function rampLegend(title, from, to, colourOf, ...entries) {
  const place = legendOf(title);
  const bar = document.createElement("span");
  bar.className = "ramp";
  bar.style.background = `linear-gradient(to right, ${Array.from({ length: 9 }, (_, i) => colourOf(i / 8)).join(",")})`;
  place.append(from, bar, to, legendOf("", ...entries));
  return place;
}

function byRange(page) {
  return {
    name: "range (m)",
    colours: (limit) => {
      const colours = rangeColours(page.ranges_m.length);
      return (site) => colours[chosenRange(page, site, limit)];
    },
    legend: () => {
      const colours = rangeColours(page.ranges_m.length);
      return legendOf("range (m):", ...page.ranges_m.map((range_m, i) => [colours[i], String(range_m)]));
    },
  };
}

// Errors at the chosen range, the brighter the greater, up to twice the limit.
function byError(page, name, errorAt) {
  const colourOf = () => ramp(scaleColours());
  return {
    name,
    colours: (limit) => {
      const colour = colourOf();
      return (site) => colour(errorAt(site, chosenRange(page, site, limit)) / (2 * page.limits_m[limit]));
    },
    legend: (limit) => rampLegend(`${name} at the chosen range: `, "0 cm", `${+(200 * page.limits_m[limit]).toPrecision(4)} cm or more`, colourOf(),
      [css("grey"), "not measured"]),
  };
}

function byProbability(page) {
  const colourOf = () => ramp(scaleColours());
  return {
    name: "probability of an error within the limit",
    colours: (limit) => {
      const colour = colourOf();
      return (site) => colour(probability(page, site, chosenRange(page, site, limit), limit));
    },
    legend: () => rampLegend("P(error within the limit) at the chosen range: ", "0", "1", colourOf()),
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
  const paints = [byRange(page), byError(page, "predicted error (cm)", (site, range) => predictedError(page, site, range))];
  if (page.judged) paints.push(byError(page, "measured error (cm)", (site, range) => measuredError(page, site, range)));
  paints.push(byProbability(page), byFlag(page));
  if (page.sites.unconstrained) paints.push(byPose(page));
  if (page.diff) paints.push(byChange(page));
  return paints;
}
