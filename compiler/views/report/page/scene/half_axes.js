// The ellipsoid of an ND from its numbers in the page.

const least_m = 0.01;  // half a thickness that is still seen
const sweeps = 4;      // each squares the cosines that are left between the axes

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

// Turns a pair of columns in their plane until they are perpendicular (one-sided Jacobi: Hestenes 1958, doi:10.1137/0106005).
function turnPair(columns, p, q) {
  const [a, b] = [columns[p], columns[q]];
  const shared = dot(a, b);
  if (shared === 0) return;
  const zeta = (dot(b, b) - dot(a, a)) / (2 * shared);
  const tangent = (zeta < 0 ? -1 : 1) / (Math.abs(zeta) + Math.hypot(1, zeta));
  const cosine = 1 / Math.hypot(1, tangent);
  const sine = cosine * tangent;
  columns[p] = a.map((value, i) => cosine * value - sine * b[i]);
  columns[q] = a.map((value, i) => sine * value + cosine * b[i]);
}

// Three perpendicular half axes (m) of the surface at two standard deviations. The columns that they are turned from are a
// Cholesky factor of the covariance, times 2, along the longer and shorter axis from above.
export function halfAxes({ radius_m, turn_rad, rise_m, tilt }) {
  const [cosine, sine] = [Math.cos(turn_rad), Math.sin(turn_rad)];
  const left = Math.sqrt(Math.max(0, 1 - tilt[0] ** 2 - tilt[1] ** 2));
  const [long_m, short_m] = radius_m.map((value) => Math.max(value, least_m));
  const columns = [[long_m * cosine, long_m * sine, rise_m * tilt[0]], [-short_m * sine, short_m * cosine, rise_m * tilt[1]],
    [0, 0, Math.max(rise_m * left, least_m)]];
  for (let sweep = 0; sweep < sweeps; ++sweep) for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) turnPair(columns, p, q);
  return columns;
}
