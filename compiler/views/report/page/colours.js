// The page's colours, as its style sheet says, for what is drawn on canvases.

export function css(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

export const isDark = () => matchMedia("(prefers-color-scheme: dark)").matches;

function rgbOf(hex) {
  return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
}

export function rangeColours(count) {
  return Array.from({ length: count }, (_, i) => css(`range-${i}`));
}

// The whole row of colours, whatever ranges occur.
export function scaleColours() {
  return Array.from({ length: 9 }, (_, i) => css(`scale-${i}`));
}

// Lengths to colours: those of the ranges at the ranges, and between them what lies between.
export function lengthColours(ranges_m) {
  const lengths_m = [0, ...ranges_m];
  const colourOf = ramp([css("range-zero"), ...rangeColours(ranges_m.length)]);
  return (length_m) => {
    let above = 1;
    while (above < lengths_m.length - 1 && lengths_m[above] < length_m) ++above;
    const part = (length_m - lengths_m[above - 1]) / (lengths_m[above] - lengths_m[above - 1]);
    return colourOf((above - 1 + Math.min(Math.max(part, 0), 1)) / (lengths_m.length - 1));
  };
}

// Shares from 0 to 1 to colours between stops; NaN is the page's grey.
export function ramp(stops) {
  const colours = stops.map(rgbOf);
  const grey = css("grey");
  return (share) => {
    if (Number.isNaN(share)) return grey;
    const place = Math.min(Math.max(share, 0), 1) * (colours.length - 1);
    const below = Math.min(Math.floor(place), colours.length - 2);
    const part = place - below;
    const mixed = colours[below].map((from, i) => Math.round(from + part * (colours[below + 1][i] - from)));
    return `rgb(${mixed.join(",")})`;
  };
}

// Runs `draw` now and whenever the page turns dark or light.
export function onTheme(draw) {
  draw();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
}
