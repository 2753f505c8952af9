// Reads the numbers of the page: one JSON object (compiler/views/report/page/page_data.h). Arrays are unpacked
// when they are first asked for.

const kinds = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array, f64: Float64Array };

export function bytesOfBase64(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

export async function inflate(text) {
  const stream = new Blob([bytesOfBase64(text)]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Bytes by planes back to elements.
async function unpack({ type, count, data }) {
  const numbers = new kinds[type](count);
  const planes = await inflate(data);
  const bytes = new Uint8Array(numbers.buffer);
  const size = numbers.BYTES_PER_ELEMENT;
  for (let plane = 0; plane < size; ++plane) {
    for (let i = 0; i < count; ++i) bytes[i * size + plane] = planes[plane * count + i];
  }
  return numbers;
}

const unpacked = new WeakMap();

// A packed array's numbers, unpacked once.
export function numbers(packed) {
  if (!unpacked.has(packed)) unpacked.set(packed, unpack(packed));
  return unpacked.get(packed);
}

// An object with its packed members replaced by numbers.
async function unpackedMembers(object) {
  const result = {};
  for (const [name, value] of Object.entries(object)) {
    result[name] = value && value.data !== undefined ? await numbers(value) : value;
  }
  return result;
}

// Everything but what only one site or one piece of map needs.
export async function readPage() {
  const page = JSON.parse(document.getElementById("data").textContent);
  const [sites, predicted, choice, answers, places] = await Promise.all(
    [page.sites, page.predicted, page.choice, page.answers, page.places].map(unpackedMembers));
  const judged = page.judged ? await unpackedMembers(page.judged) : null;
  const diff = page.diff ? { ...page.diff, sites: await unpackedMembers(page.diff.sites), nds: await unpackedMembers(page.diff.nds) } : null;
  const judgedOfSite = new Int32Array(sites.count).fill(-1);
  if (judged) judged.site.forEach((site, i) => { judgedOfSite[site] = i; });
  return { ...page, sites, predicted, choice, places, answers, judged, judgedOfSite, diff };
}

export const rangeCount = (page) => page.ranges_m.length;
export const limitCount = (page) => page.limits_m.length;

export function chosenRange(page, site, limit) {
  return page.choice.range_index[site * limitCount(page) + limit];
}

export function predictedError(page, site, range) {
  return page.predicted.mean_m[site * rangeCount(page) + range];
}

export function probability(page, site, range, limit) {
  return page.predicted.probability[(site * rangeCount(page) + range) * limitCount(page) + limit];
}

// NaN where the drive has no scan.
export function measuredError(page, site, range) {
  const judged = page.judgedOfSite[site];
  return judged < 0 ? NaN : page.judged.error_m[judged * rangeCount(page) + range];
}

// The range index that a rule takes at the i-th judged site.
export function chosenByRule(page, rule, limit, i) {
  const row = limit * page.judged.rules.length + page.judged.rules.indexOf(rule);
  return page.judged.chosen[row * page.judged.site.length + i];
}

// What `inspect --site` says.
export async function textOfSite(page, site) {
  const block = await inflate(page.texts.blocks[Math.floor(site / page.texts.sites_per_block)]);
  return new TextDecoder().decode(block).split("\0")[site % page.texts.sites_per_block];
}

// The image of the site nearest in number that has one: {site, grey, width, height}.
export async function depthOfSite(page, site) {
  const sites = await numbers(page.depth.site);
  let nearest = 0;
  for (let i = 1; i < sites.length; ++i) {
    if (Math.abs(sites[i] - site) < Math.abs(sites[nearest] - site)) nearest = i;
  }
  return { site: sites[nearest], ...(await greysOf(page.depth.images[nearest])) };
}

// From an image's column and row to the direction, degrees.
export function directionAt(depth, column, row) {
  const degrees = 180 / Math.PI;
  const turn = 360 / depth.columns;
  return {
    azimuth_deg: 180 - turn * (column + 0.5),
    elevation_deg: degrees * (depth.first_elevation_rad + depth.elevation_step_rad * (depth.rows - 1 - row)),
  };
}

// The pixels of a PNG of greys.
export async function greysOf(base64) {
  const bitmap = await createImageBitmap(new Blob([bytesOfBase64(base64)], { type: "image/png" }));
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(bitmap, 0, 0);
  const rgba = context.getImageData(0, 0, bitmap.width, bitmap.height).data;
  const grey = new Uint8Array(bitmap.width * bitmap.height);
  for (let i = 0; i < grey.length; ++i) grey[i] = rgba[4 * i];
  return { grey, width: bitmap.width, height: bitmap.height };
}
