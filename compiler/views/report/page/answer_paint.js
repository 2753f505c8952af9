// Colours of the route by what the map answers, by the kind of place and by how wrong a tracking vehicle may be.

import { answerAt, noAnswer, protectionOf } from "./answers.js";
import { css, ramp, rangeColours, scaleColours } from "./colours.js";
import { legendOf, rampLegend, shareOf, spanOf } from "./legends.js";

const percent = (count, all) => `${((100 * count) / all).toFixed(1)} %`;

// [key, count], the most frequent first; of equals the smaller key.
function countedBy(page, keyOf) {
  const counts = new Map();
  for (let site = 0; site < page.sites.count; ++site) {
    const key = keyOf(site);
    counts.set(key, (counts.get(key) ?? 0) + 1);
  }
  return [...counts].sort((a, b) => b[1] - a[1] || (a[0] < b[0] ? -1 : 1));
}

const keyOf = ({ kind, choice, text }) => (kind === "none" ? noAnswer : kind === "plan" ? "plan" : `${kind} ${choice} ${text}`);

function colourOfAnswer({ kind, choice }, page) {
  if (kind === "none") return css("bad");
  if (kind === "plan") return css("accent");
  return kind === "look" ? css(`look-${choice}`) : rangeColours(page.ranges_m.length)[choice];
}

export function byAnswer(page) {
  return {
    name: "answer",
    colours: (limit) => {
      const colours = new Map();
      return (site) => {
        const answer = answerAt(page, site, limit);
        const key = keyOf(answer);
        if (!colours.has(key)) colours.set(key, colourOfAnswer(answer, page));
        return colours.get(key);
      };
    },
    legend: (limit) => {
      const answers = new Map();
      const counts = countedBy(page, (site) => {
        const answer = answerAt(page, site, limit);
        answers.set(keyOf(answer), answer);
        return keyOf(answer);
      });
      return legendOf("answer:", ...counts.map(([key, count]) => {
        const answer = answers.get(key);
        const words = answer.kind === "plan" ? page.answers.plan : answer.kind === "none" ? noAnswer : answer.text;
        return [colourOfAnswer(answer, page), `${answer.kind === "plan" ? "plan: " : ""}${words} (${percent(count, page.sites.count)})`];
      }));
    },
  };
}

const kindPalette = ["blue", "orange", "green", "purple", "yellow", "grey"];

export function byKind(page) {
  const { kinds, kind } = page.places;
  const counts = countedBy(page, (site) => kind[site]);
  const colours = () => {
    const more = scaleColours();
    return new Map(counts.map(([each], i) => [each, i < kindPalette.length ? css(kindPalette[i]) : more[(2 * (i - kindPalette.length)) % more.length]]));
  };
  return {
    name: "kind of place",
    colours: () => {
      const ofKind = colours();
      return (site) => ofKind.get(kind[site]);
    },
    legend: () => {
      const ofKind = colours();
      return legendOf("kind of place:", ...counts.map(([each, count]) => [ofKind.get(each), `${kinds[each]} (${percent(count, page.sites.count)})`]));
    },
  };
}

export function byProtection(page) {
  const levelAt = (site) => protectionOf(page, site)?.[0] ?? NaN;
  const span = spanOf(page, levelAt);
  return {
    name: "protection level, forward (m)",
    colours: () => {
      const colour = ramp(scaleColours());
      return (site) => colour(shareOf(levelAt(site), span.least, span.greatest));
    },
    legend: () => rampLegend(`error forward that a tracking vehicle exceeds in at most ${100 * page.places.risk} % of stretches of 60 m: `,
      `${span.least.toFixed(2)} m`, `${span.greatest.toFixed(2)} m`, ramp(scaleColours()), [css("grey"), "not available"]),
  };
}
