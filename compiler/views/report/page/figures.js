// The figures along the route answer. The page's pictures are the only ones; here the site that is pointed at and
// the site that is shown get a line each, and the numbers at a place stand below.

import { chosenByRule, rangeCount } from "./data.js";
import { button, limitText } from "./elements.js";
import { onSelect, pointAt, select, selection } from "./selection.js";

const narrowest = 1;
const widest = 32;  // times as wide as the page
const timeOf = (page, i, range) => page.judged.time_ms[i * rangeCount(page) + range];
const errorOf = (page, i, range) => page.judged.error_m[i * rangeCount(page) + range];
const ms = (value) => `${value.toFixed(2)} ms`;
const cm = (value_m) => `${(100 * value_m).toFixed(1)} cm`;

// What each figure says of the i-th judged site.
const readings = {
  "error-along": (page, i) => page.ranges_m.map((range_m, range) => `${range_m} m: ${cm(errorOf(page, i, range))}`),
  "ideal-range": (page, i) => page.limits_m.map((limit_m, limit) =>
    `within ${limitText(limit_m)}: ${page.ranges_m[chosenByRule(page, "oracle", limit, i)]} m`),
  "ideal-time": (page, i) => [`static: ${ms(timeOf(page, i, rangeCount(page) - 1))}`, ...page.limits_m.map((limit_m, limit) =>
    `dynamic, ${limitText(limit_m)}: ${ms(timeOf(page, i, chosenByRule(page, "oracle", limit, i)))}`)],
};

function choiceReading(page, i, limit) {
  const range = chosenByRule(page, "map", limit, i);
  return [`static: ${ms(timeOf(page, i, rangeCount(page) - 1))}`, `this map: ${ms(timeOf(page, i, range))}`,
    `${page.ranges_m[range]} m`, `error ${cm(errorOf(page, i, range))}`];
}

function readingOf(name) {
  const limit = /^choice-(\d+)$/.exec(name);
  return limit ? (page, i) => choiceReading(page, i, Number(limit[1])) : readings[name];
}

// The judged site nearest to a way along the route.
function judgedAt(page, route_m) {
  const distance = (i) => Math.abs(page.sites.route_m[page.judged.site[i]] - route_m);
  let nearest = 0;
  for (let i = 1; i < page.judged.site.length; ++i) if (distance(i) < distance(nearest)) nearest = i;
  return nearest;
}

// One picture: where its numbers lie, and two upright lines in it.
function pictureOf(svg) {
  const [left, right, top, bottom, from_m, to_m] = svg.dataset.plot.split(" ").map(Number);
  const lineOf = (name) => {
    const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
    line.setAttribute("class", name);
    svg.append(line);
    return line;
  };
  const lines = { pointed: lineOf("pointed"), shown: lineOf("shown") };
  const xOf = (route_m) => left + ((route_m - from_m) / (to_m - from_m)) * (right - left);
  return {
    svg,
    mark(name, route_m) {
      lines[name].setAttribute("d", route_m === null ? "" : `M${xOf(route_m).toFixed(1)} ${top}V${bottom}`);
    },
    routeAt(clientX) {
      const box = svg.getBoundingClientRect();
      const x = ((clientX - box.left) / box.width) * svg.viewBox.baseVal.width;
      return from_m + ((x - left) / (right - left)) * (to_m - from_m);
    },
    // Puts a place into the middle of what is seen of a wide picture.
    bringIntoView(route_m) {
      const frame = svg.parentElement;
      frame.scrollLeft = (xOf(route_m) / svg.viewBox.baseVal.width) * frame.scrollWidth - frame.clientWidth / 2;
    },
    // As wide as `times` pages and as high as before; words keep their shape.
    widen(times) {
      svg.style.height = times === narrowest ? "" : `${svg.getBoundingClientRect().height}px`;
      svg.style.width = svg.style.maxWidth = times === narrowest ? "" : `${100 * times}%`;
      svg.setAttribute("preserveAspectRatio", times === narrowest ? "xMidYMid" : "none");
      svg.style.setProperty("--narrow", 1 / times);
    },
  };
}

function answer(page, figure, reading) {
  const still = figure.querySelector(".still");
  const pictures = [...still.querySelectorAll("svg[data-plot]")].map(pictureOf);
  const words = Object.assign(document.createElement("span"), { className: "reading" });
  const help = "Point at the chart to read values, click to show the site on the map; keyboard: left, right, Enter.";
  let at = null;
  let times = narrowest;
  const markAll = (name, route_m) => pictures.forEach((picture) => picture.mark(name, route_m));
  const point = (i) => {
    at = i;
    pointAt(i === null ? null : page.judged.site[i]);
    markAll("pointed", i === null ? null : page.sites.route_m[page.judged.site[i]]);
    words.textContent = i === null ? help : `site ${page.judged.site[i]}, ${page.sites.route_m[page.judged.site[i]].toFixed(1)} m: ${reading(page, i).join(" · ")}`;
  };
  const widen = (by) => {
    times = Math.min(Math.max(times * by, narrowest), widest);
    pictures.forEach((picture) => picture.widen(times));
    still.classList.toggle("is-wide", times > narrowest);
    pictures[0]?.bringIntoView(page.sites.route_m[selection.site]);
  };
  for (const picture of pictures) {
    picture.svg.addEventListener("mousemove", (event) => point(judgedAt(page, picture.routeAt(event.clientX))));
    picture.svg.addEventListener("mouseleave", () => point(null));
    picture.svg.addEventListener("click", (event) => {
      point(judgedAt(page, picture.routeAt(event.clientX)));
      select(page.judged.site[at]);
    });
  }
  still.tabIndex = 0;
  still.addEventListener("blur", () => point(null));
  still.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step !== undefined) {
      const next = (at ?? 0) + step * (event.shiftKey ? 20 : 1);
      point(Math.min(Math.max(next, 0), page.judged.site.length - 1));
      event.preventDefault();
    } else if (event.key === "Enter" && at !== null) {
      select(page.judged.site[at]);
    }
  });
  figure.querySelector(".live").append(button("−", "Zoom out", () => widen(0.5)),
    button("+", "Zoom in", () => widen(2)), words);
  figure.classList.add("is-answering");
  point(null);
  onSelect(() => markAll("shown", page.sites.route_m[selection.site]));
}

export function letFiguresAnswer(page) {
  if (!page.judged) return;
  for (const place of document.querySelectorAll(".live[data-drawing]")) {
    const reading = readingOf(place.dataset.drawing);
    if (reading) answer(page, place.closest("figure"), reading);
  }
}
