// What the map answers at a place: the kind of answer that the verdict recommends, or the range where no look is good
// enough.

import { limitCount } from "./data.js";

const kinds = ["plan", "look", "range", "none"];

export const noAnswer = "no good answer";

// {kind: "plan", "look", "range" or "none"; choice: index among ranges (isRange) or looks; text; mean_m: predicted error; probability}
export function answerAt(page, site, limit) {
  const { answers } = page;
  const at = site * limitCount(page) + limit;
  const kind = kinds[answers.kind[at]];
  const choice = answers.choice[at];
  const isRange = kind === "range" || answers.recommended[limit] === "range";
  const text = kind === "plan" ? "plan" : isRange ? `range ${page.ranges_m[choice]} m` : answers.looks[choice];
  return { kind, choice, isRange, text, mean_m: answers.mean_m[at], probability: answers.probability[at] };
}

// The words of an answer; what is taken where none is good enough stands behind it.
export function answerText(answer) {
  return answer.kind === "none" ? `${noAnswer}; best: ${answer.text}` : answer.text;
}

// A place whose answer and predicted error are those of the middle of all places.
export function typicalSite(page) {
  const limit = 0;
  const answers = Array.from({ length: page.sites.count }, (_, site) => ({ site, ...answerAt(page, site, limit) }));
  const rank = (answer) => kinds.indexOf(answer.kind) * 1000 + answer.choice;
  const byRank = [...answers].sort((a, b) => rank(a) - rank(b) || a.site - b.site);
  const middle = rank(byRank[Math.floor(byRank.length / 2)]);
  const alike = answers.filter((answer) => rank(answer) === middle).sort((a, b) => a.mean_m - b.mean_m || a.site - b.site);
  return alike[Math.floor(alike.length / 2)].site;
}

// "avenue", or null where the map has no kinds of place.
export const kindOfPlace = (page, site) => (page.places.kind ? page.places.kinds[page.places.kind[site]] : null);

// Of a vehicle that tracks: forward, left and up, m; null where the map has none there.
export function protectionOf(page, site) {
  if (!page.places.protection_m) return null;
  const levels_m = Array.from(page.places.protection_m.slice(3 * site, 3 * site + 3));
  return levels_m.every(Number.isFinite) ? levels_m : null;
}
