// Where the eye stands, and what that makes of places in space. Lengths in metres, angles in radians.
"use strict";
const VIEW = 0.6;  // opening of the view, upright
const MARGIN = 0.06;  // of the picture, around what it has to show
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
class Stance {
  // start: azimuth, elevation, distance, target; size(): width and height of the picture; reach: extent of the scene
  constructor(start, size, reach) { this.start = start; this.size = size; this.reach = reach; this.restart(); }
  // Stand, from now on at first, as near as shows all of these places within the margins of the picture
  fit(places) {
    const inside = p => { const at = this.project(p); return at && at.every((v, i) => Math.abs(v / this.size()[i] - 0.5) < 0.5 - MARGIN); };
    let near = 1e-3 * this.reach, far = 8 * this.reach;
    for (let k = 0; k < 40; k++) { this.distance = 0.5 * (near + far); if (places.every(inside)) far = this.distance; else near = this.distance; }
    this.start = {...this.start, distance: far}; this.restart();
  }
  restart() { Object.assign(this, this.start, {target: [...this.start.target]}); }
  axes() {
    const a = this.azimuth, e = this.elevation;
    const out = [Math.sin(a) * Math.cos(e), Math.cos(a) * Math.cos(e), Math.sin(e)], right = [-Math.cos(a), Math.sin(a), 0];
    return {out, right, up: cross(out, right)};
  }
  eye() { const {out} = this.axes(); return this.target.map((t, i) => t + this.distance * out[i]); }
  // Tangent of half the view upright: wider on a picture so narrow that the sides would be cut off
  opening() { const [w, h] = this.size(); return Math.tan(VIEW / 2) * Math.max(1, 1.3 * h / w); }
  matrix() {
    const {out, right, up} = this.axes(), eye = this.eye(), [w, h] = this.size();
    const f = 1 / this.opening(), aspect = w / h, near = 0.01 * this.distance, far = 10 * this.distance + 4 * this.reach;
    const rows = [right.map(x => x * f / aspect), up.map(x => x * f), out], shift = [-dot(rows[0], eye), -dot(rows[1], eye), -dot(out, eye)];
    const a = (far + near) / (near - far), b = 2 * far * near / (near - far);
    return new Float32Array([0, 1, 2].flatMap(i => [rows[0][i], rows[1][i], a * out[i], -out[i]]).concat([shift[0], shift[1], a * shift[2] + b, -shift[2]]));
  }
  // Place in the picture, from its upper left corner; null behind the eye
  project(p) {
    const {out, right, up} = this.axes(), eye = this.eye(), d = p.map((x, i) => x - eye[i]), depth = -dot(d, out), [w, h] = this.size();
    if (depth <= 0) return null;
    const scale = h / (2 * this.opening() * depth);
    return [w / 2 + scale * dot(d, right), h / 2 - scale * dot(d, up)];
  }
  // What is seen at a place of the picture lies along this: from, and a direction of length 1
  ray(x, y) {
    const {out, right, up} = this.axes(), [w, h] = this.size(), scale = 2 * this.opening() / h;
    const d = right.map((r, i) => -out[i] + scale * ((x - w / 2) * r + (h / 2 - y) * up[i])), length = Math.hypot(...d);
    return {from: this.eye(), along: d.map(v => v / length)};
  }
  turn(dx, dy) { this.azimuth += 0.006 * dx; this.elevation = Math.min(1.55, Math.max(-0.2, this.elevation + 0.006 * dy)); }
  move(dx, dy) {
    const metres = 2 * this.distance * this.opening() / this.size()[1], {right, up} = this.axes();
    for (let i = 0; i < 3; i++) this.target[i] -= metres * (dx * right[i] - dy * up[i]);
  }
  nearer(factor) { this.distance *= factor; }
}
