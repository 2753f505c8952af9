// What the route can be coloured by. A paint has a name, colours(limit), a function from site to colour, and
// legend(limit), an element that explains it.

import { css, ramp, rangeColours } from "./colours.js";
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
  const colourOf = () => ramp([...rangeColours(page.ranges_m.length)]);
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
  const colourOf = () => ramp([...rangeColours(page.ranges_m.length)]);
  return {
    name: "probability to be within the limit",
    colours: (limit) => {
      const colour = colourOf();
      return (site) => colour(probability(page, site, chosenRange(page, site, limit), limit));
    },
    legend: () => rampLegend("P(error within the limit) at the chosen range: ", "0", "1", colourOf()),
  };
}

function byFlag(page) {
  const words = [["blue", "good enough"], ["orange", "unmet: no range is good enough"], ["purple", "unlike what the model learnt"]];
  return {
    name: "flags",
    colours: (limit) => {
      const colours = words.map(([name]) => css(name));
      return (site) => {
        const flags = page.choice.flags[site * page.limits_m.length + limit];
        return flags & 2 ? colours[2] : colours[flags & 1];
      };
    },
    legend: () => legendOf("", ...words.map(([name, each]) => [css(name), each])),
  };
}

export function paintsOf(page) {
  const paints = [byRange(page), byError(page, "predicted error (cm)", (site, range) => predictedError(page, site, range))];
  if (page.judged) paints.push(byError(page, "measured error (cm)", (site, range) => measuredError(page, site, range)));
  return [...paints, byProbability(page), byFlag(page)];
}
