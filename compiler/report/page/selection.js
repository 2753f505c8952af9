// Which site is looked at; everything that shows it listens.

export const selection = { site: null };
const listeners = [];

export function onSelect(listener) {
  listeners.push(listener);
}

export function select(site) {
  selection.site = site;
  history.replaceState(null, "", `#site=${site}`);
  for (const listener of listeners) listener(site);
}

// The site that the address names, or null.
export function siteOfAddress(count) {
  const named = /^#site=(\d+)$/.exec(location.hash);
  return named && Number(named[1]) < count ? Number(named[1]) : null;
}
