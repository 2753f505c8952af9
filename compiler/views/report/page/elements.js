// Elements of the page that several parts make.

export function element(kind, members, ...children) {
  const made = Object.assign(document.createElement(kind), members);
  made.append(...children);
  return made;
}

// A button that says in words, for those who cannot see its sign, what it does.
export function button(sign, words, act) {
  const made = element("button", { type: "button", textContent: sign, title: words });
  made.setAttribute("aria-label", words);
  made.addEventListener("click", act);
  return made;
}

// choices: [value, words] each.
export function switchOf(label, choices, onChange) {
  const choice = element("select", {}, ...choices.map(([value, words]) => element("option", { value, textContent: words })));
  choice.addEventListener("change", () => onChange(choice.value));
  return element("label", { textContent: `${label} ` }, choice);
}

export function checkOf(label, isOn, onChange) {
  const box = element("input", { type: "checkbox", checked: isOn });
  box.addEventListener("change", () => onChange(box.checked));
  return element("label", {}, box, ` ${label}`);
}

export const limitText = (limit_m) => `${+(100 * limit_m).toPrecision(6)} cm`;
