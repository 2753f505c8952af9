// The legends of the map, and the span of the values that they explain.

import { element } from "./elements.js";

export function legendOf(title, ...entries) {
  const place = element("span", {}, `${title} `);
  for (const [colour, words] of entries) {
    const key = element("i", {});
    key.style.background = colour;
    const entry = element("span", {}, key, words);
    entry.style.marginLeft = "0.8em";
    place.append(entry);
  }
  return place;
}

// colourOf: from a share in 0 to 1 to a colour.
export function rampBar(colourOf) {
  const bar = element("span", { className: "ramp" });
  bar.style.background = `linear-gradient(to right, ${Array.from({ length: 9 }, (_, i) => colourOf(i / 8)).join(",")})`;
  return bar;
}

export function rampLegend(title, from, to, colourOf, ...entries) {
  const place = legendOf(title);
  place.append(from, rampBar(colourOf), to, legendOf("", ...entries));
  return place;
}

// The least and greatest finite value over all sites; null where there is none.
export function spanOf(page, valueAt) {
  let [least, greatest] = [Infinity, -Infinity];
  for (let site = 0; site < page.sites.count; ++site) {
    const value = valueAt(site);
    if (!Number.isFinite(value)) continue;
    least = Math.min(least, value);
    greatest = Math.max(greatest, value);
  }
  return least <= greatest ? { least, greatest } : null;
}

// How far a value lies between two others, 0 to 1; NaN stays NaN.
export const shareOf = (value, from, to) => (Number.isNaN(value) ? NaN : to > from ? (value - from) / (to - from) : 0.5);
