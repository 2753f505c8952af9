// Finds a site by its number or by a coordinate.

import { element, switchOf } from "../elements.js";
import { select } from "../selection.js";

const frames = [["world", "world"], ["map", "map"]];

// Numbers of "12", "12.5, -3" or "12.5 -3 1.8"; null where it is something else.
function numbersOf(text) {
  const numbers = text.trim().split(/[\s,;]+/).map(Number);
  return numbers.length <= 3 && numbers.every(Number.isFinite) && text.trim() !== "" ? numbers : null;
}

// onFound(site) is called before the site is shown.
export function siteSearch(page, finder, onFound) {
  const input = element("input", { type: "search", placeholder: "site, or x, y", size: 14 });
  const words = element("output", {});
  let isOfWorld = true;
  const show = (site, text) => {
    words.textContent = text;
    onFound(site);
    select(site);
  };
  const find = () => {
    const numbers = numbersOf(input.value);
    if (!numbers) {
      words.textContent = "enter a site number, or x and y in metres";
    } else if (numbers.length === 1) {
      const [site] = numbers;
      if (Number.isInteger(site) && site >= 0 && site < page.sites.count) show(site, `site ${site}`);
      else words.textContent = `site numbers are 0 to ${page.sites.count - 1}`;
    } else {
      const origin = isOfWorld ? page.origin_world_m : [0, 0];
      const { site, apart_m } = finder.nearest(numbers[0] - origin[0], numbers[1] - origin[1]);
      show(site, `site ${site}, ${apart_m.toFixed(1)} m away`);
    }
  };
  const form = element("form", { className: "search" }, element("label", { textContent: "Find " }, input),
    switchOf("", frames, (value) => { isOfWorld = value === "world"; }), element("button", { type: "submit", textContent: "Go" }), words);
  form.querySelector("select").setAttribute("aria-label", "Frame of the coordinates");
  form.addEventListener("submit", (event) => { event.preventDefault(); find(); });
  return form;
}
