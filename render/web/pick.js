// What a ray meets first, and lengths between two places.
"use strict";
// Distance along the ray to the nearest of the triangles (vertices: flat, facets: flat), Infinity for none.
// Moeller and Trumbore (1997), doi:10.1080/10867651.1997.10487468
function meetsFacets({from, along}, vertices, facets, shown) {
  let best = Infinity;
  const at = k => [vertices[3 * k], vertices[3 * k + 1], vertices[3 * k + 2]];
  for (let k = 0; k < facets.length; k += 3) {
    const a = at(facets[k]), b = at(facets[k + 1]), c = at(facets[k + 2]);
    const e = b.map((x, i) => x - a[i]), f = c.map((x, i) => x - a[i]), p = cross(along, f), det = dot(e, p);
    if (Math.abs(det) < 1e-12) continue;
    const s = from.map((x, i) => x - a[i]), u = dot(s, p) / det;
    if (u < 0 || u > 1) continue;
    const q = cross(s, e), v = dot(along, q) / det;
    if (v < 0 || u + v > 1) continue;
    const t = dot(f, q) / det;
    if (t > 0 && t < best && shown(from.map((x, i) => x + t * along[i]))) best = t;
  }
  return best;
}
// The same for balls around the first n points: {t, k}, k their number, -1 for none
function meetsPoints({from, along}, points, n, radius, shown) {
  let t = Infinity, k = -1;
  for (let i = 0; i < n; i++) {
    const p = [points[3 * i], points[3 * i + 1], points[3 * i + 2]], d = p.map((x, j) => x - from[j]), there = dot(d, along);
    if (there <= 0 || there - radius > t || dot(d, d) - there * there > radius * radius || !shown(p)) continue;
    const first = there - Math.sqrt(radius * radius - (dot(d, d) - there * there));
    if (first < t) { t = first; k = i; }
  }
  return {t, k};
}
// From one place to another: length, the same in plan, rise, slope in degrees, bearing clockwise from the y axis (north)
function between(p, q) {
  const d = q.map((x, i) => x - p[i]), plan = Math.hypot(d[0], d[1]);
  return {length: Math.hypot(...d), plan, rise: d[2], slope: Math.atan2(d[2], plan) * 180 / Math.PI,
          bearing: (Math.atan2(d[0], d[1]) * 180 / Math.PI + 360) % 360};
}
// Value of a layer at a place; null where it has none
function layerValue(layer, values, p) {
  const column = Math.floor((p[0] - layer.x0) / (layer.x1 - layer.x0) * layer.columns), row = Math.floor((p[1] - layer.y0) / (layer.y1 - layer.y0) * layer.rows);
  if (column < 0 || row < 0 || column >= layer.columns || row >= layer.rows) return null;
  const byte = values[row * layer.columns + column];
  return byte ? layer.low + (byte - 1) / 254 * (layer.high - layer.low) : null;
}
