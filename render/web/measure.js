// Places that are tapped: what is there, and what lies between two of them.
"use strict";
class Measure {
  // marks: svg over the canvas; told: element for words
  constructor(head, data, stance, marks, told) {
    Object.assign(this, {head, stance, marks, told, data, active: false, places: [], words: []});
    this.ground = data["ground.place"] ? this.metres(data["ground.place"]) : new Float32Array(0);
  }
  metres(shares) { const {low, span} = this.head; return Float32Array.from(shares, (v, i) => low[i % 3] + span[i % 3] * v / 65535); }
  // What is seen at a place of the canvas: {place, words}, null for the sky
  probe(x, y, shown) {
    const ray = this.stance.ray(x, y), kept = p => !shown.cut || dot(shown.cut, p) <= shown.cut[3], {head, data} = this;
    const t = head.ground ? meetsFacets(ray, this.ground, data["ground.facets"], kept) : Infinity;
    const [seen, all] = head.frames[shown.frame], points = this.metres(data[`snow.${shown.frame}.place`]);
    const snow = meetsPoints(ray, points, shown.cut ? all : seen, head.size / 2, kept), first = Math.min(t, snow.t);
    if (first === Infinity) return null;
    const place = ray.from.map((v, i) => v + first * ray.along[i]), words = [];
    const where = place.map((v, i) => (v + (head.origin[i] || 0)).toFixed(1));
    words.push(head.flat ? `x ${where[0]} m, z ${where[2]} m` : `${where.join(", ")} m`);
    if (snow.k >= 0 && snow.t <= t && shown.field >= 0) {
      const field = head.fields[shown.field], value = field.low + data[`snow.${shown.frame}.value.${shown.field}`][snow.k] / 255 * (field.high - field.low);
      words.push(`${field.title}: ${field.names.length ? field.names[Math.round(value)] : value.toPrecision(3)}`);
    }
    if (shown.layer >= 0) {
      const layer = head.layers[shown.layer], value = layerValue(layer, data["layer." + shown.layer], place);
      words.push(`${layer.title}: ${value === null ? "none" : value.toPrecision(3)}`);
    }
    return {place, words: words.join(" · ")};
  }
  tap(x, y, shown) {
    const found = this.probe(x, y, shown);
    if (!found) return;
    if (this.places.length === 2) this.places = [];
    this.places.push(found.place);
    this.words = [found.words];
    if (this.places.length === 2) {
      const m = between(...this.places);
      this.words.push(`${m.length.toFixed(1)} m, ${m.plan.toFixed(1)} m in plan, ${m.rise.toFixed(1)} m up, slope ${m.slope.toFixed(1)}°` + (this.head.flat ? "" : `, bearing ${m.bearing.toFixed(0)}°`));
    }
  }
  clear() { this.places = []; this.words = []; }
  draw() {
    const seen = this.places.map(p => this.stance.project(p)).filter(Boolean), line = seen.length === 2 ? `<line x1="${seen[0][0]}" y1="${seen[0][1]}" x2="${seen[1][0]}" y2="${seen[1][1]}"/>` : "";
    this.marks.innerHTML = line + seen.map(([x, y]) => `<circle cx="${x}" cy="${y}" r="5"/>`).join("");
    this.told.textContent = this.words.join("\n") || (this.active ? "Tap two places." : "");
  }
}
