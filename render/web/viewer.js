// A run in three dimensions: turn with the mouse or a finger, wheel or pinch to come closer, shift or right button to move.
"use strict";
async function showRun(root) {
  const canvas = root.querySelector("canvas"), slider = root.querySelector("input[type=range]");
  const button = root.querySelector("button"), clock = root.querySelector(".clock"), said = root.querySelector(".said");
  const head = JSON.parse(root.querySelector("script[type='application/json']").textContent);
  const gl = canvas.getContext("webgl2", {antialias: true, preserveDrawingBuffer: true});
  if (!gl) { said.textContent = "This browser shows no WebGL 2; the pictures and films do without."; return; }
  const packed = Uint8Array.from(atob(root.querySelector(".data").textContent.trim()), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const data = await new Response(stream).arrayBuffer();
  let at = 0;
  const take = (Type, n) => { const size = n * Type.BYTES_PER_ELEMENT, part = data.slice(at, at + size); at += size; return new Type(part); };

  const LIT = `
    vec3 lit(vec3 colour, vec3 n, float sunShare) {
      float up = 0.5 + 0.5 * n.z;
      float facing = max((dot(n, sun) + softness) / (1.0 + softness), 0.0) * sunShare;
      return colour * (facing * vec3(0.86, 0.826, 0.757) + up * vec3(0.248, 0.304, 0.4) + (1.0 - up) * vec3(0.1, 0.095, 0.088));
    }
    vec3 shown(vec3 light) { return pow(clip3(light), vec3(1.0 / 2.2)); }`;
  const CLIP = `vec3 clip3(vec3 v) { vec3 e = max(v - 0.8, 0.0); return mix(v, 0.8 + 0.2 * e / (e + 0.2), step(0.8, v)); }`;
  function program(vertex, fragment) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, "#version 300 es\nprecision highp float;\nuniform mat4 view; uniform vec3 low, span, sun; uniform float softness;\n" + text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    ["place", "colour", "normal"].forEach((name, i) => gl.bindAttribLocation(made, i, name));
    gl.linkProgram(made);
    return made;
  }
  const ground = program(`
    in vec3 place; in vec3 colour; out vec3 tint; out float height;
    void main() { vec3 p = low + span * place; height = p.z; tint = colour; gl_Position = view * vec4(p, 1.0); }`, `
    in vec3 tint; in float height; uniform float interval; out vec4 result;
    void main() {
      float n = height / interval, off = abs(n - round(n)) / max(fwidth(n), 1e-6);
      float fifth = abs(n / 5.0 - round(n / 5.0)) < 0.02 ? 1.0 : 0.5;
      float line = clamp(1.4 - off, 0.0, 1.0) * fifth * clamp(1.2 - 4.0 * fwidth(n), 0.0, 1.0);
      result = vec4(tint * (1.0 - 0.35 * line), 1.0);
    }`);
  const snow = program(`
    in vec3 place; in float colour; in vec3 normal; uniform float size, height; uniform sampler2D map; out vec3 tint; out vec3 facing;
    void main() {
      vec3 p = low + span * place; gl_Position = view * vec4(p, 1.0);
      gl_PointSize = max(size * height / gl_Position.w, 2.0);
      tint = pow(texture(map, vec2((255.0 * colour + 0.5) / 256.0, 0.5)).rgb, vec3(2.2)); facing = normalize(normal + vec3(0.0, 0.0, 1e-4));
    }`, CLIP + LIT + `
    in vec3 tint; in vec3 facing; out vec4 result;
    void main() {
      vec2 d = 2.0 * gl_PointCoord - 1.0; float r = dot(d, d); if (r > 1.0) discard;
      result = vec4(shown(0.9 * lit(tint, facing, 1.0) * (1.0 - 0.10 * r)), 1.0);
    }`);
  const solid = program(`
    in vec3 place; out vec3 p;
    void main() { p = low + span * place; gl_Position = view * vec4(p, 1.0); }`, CLIP + LIT + `
    in vec3 p; out vec4 result;
    void main() { vec3 n = normalize(cross(dFdx(p), dFdy(p))); result = vec4(shown(lit(vec3(0.15, 0.22, 0.37), n, 1.0)), 1.0); }`);
  const sky = program(`
    void main() { vec2 c = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0); gl_Position = vec4(c, 0.99999, 1.0); }`, `
    uniform float height; out vec4 result;
    void main() { result = vec4(mix(vec3(0.86, 0.89, 0.92), vec3(0.56, 0.66, 0.77), pow(gl_FragCoord.y / height, 1.3)), 1.0); }`);

  function buffer(values, kind = gl.ARRAY_BUFFER) { const b = gl.createBuffer(); gl.bindBuffer(kind, b); gl.bufferData(kind, values, gl.STATIC_DRAW); return b; }
  function array(parts, facets) {
    const vao = gl.createVertexArray(); gl.bindVertexArray(vao);
    parts.forEach(([values, width, type], i) => { if (!values) return; buffer(values); gl.enableVertexAttribArray(i); gl.vertexAttribPointer(i, width, type, true, 0, 0); });
    if (facets) buffer(facets, gl.ELEMENT_ARRAY_BUFFER);
    gl.bindVertexArray(null); return vao;
  }
  let terrain = null;
  if (head.terrain) {
    const p = take(Uint16Array, 3 * head.terrain.vertices), c = take(Uint8Array, 3 * head.terrain.vertices), f = take(Uint32Array, 3 * head.terrain.facets);
    terrain = {vao: array([[p, 3, gl.UNSIGNED_SHORT], [c, 3, gl.UNSIGNED_BYTE]], f), n: f.length};
  }
  const solidFacets = head.solids ? take(Uint32Array, 3 * head.solids.facets) : null;
  const frames = head.frames.map(n => {
    const p = take(Uint16Array, 3 * n), v = take(Int8Array, 3 * n), c = take(Uint8Array, n);
    const s = head.solids ? array([[take(Uint16Array, 3 * head.solids.vertices), 3, gl.UNSIGNED_SHORT]], solidFacets) : null;
    return {n, vao: array([[p, 3, gl.UNSIGNED_SHORT], [c, 1, gl.UNSIGNED_BYTE], [v, 3, gl.BYTE]]), solid: s};
  });
  const texture = gl.createTexture(); gl.bindTexture(gl.TEXTURE_2D, texture); gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(head.table));
  for (const [key, value] of [[gl.TEXTURE_MIN_FILTER, gl.NEAREST], [gl.TEXTURE_MAG_FILTER, gl.NEAREST], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, key, value);
  gl.enable(gl.DEPTH_TEST);

  const camera = {...head.camera, target: [...head.camera.target]};
  const VIEW = 0.6;  // rad, upright
  let frame = head.start, playing = false, due = 0;
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  function axes() {
    const a = camera.azimuth, e = camera.elevation;
    const out = [Math.sin(a) * Math.cos(e), Math.cos(a) * Math.cos(e), Math.sin(e)], right = [-Math.cos(a), Math.sin(a), 0];
    return {out, right, up: cross(out, right)};
  }
  // Tangent of half the view upright: wider on a canvas so narrow that the sides would be cut off
  const opening = () => Math.tan(VIEW / 2) * Math.max(1, 1.3 * canvas.clientHeight / canvas.clientWidth);
  function matrix() {
    const {out, right, up} = axes(), eye = camera.target.map((t, i) => t + camera.distance * out[i]);
    const f = 1 / opening(), aspect = canvas.width / canvas.height, near = 0.01 * camera.distance, far = 10 * camera.distance + 4 * head.reach;
    const rows = [right.map(x => x * f / aspect), up.map(x => x * f), out], shift = [-dot(rows[0], eye), -dot(rows[1], eye), -dot(out, eye)];
    const a = (far + near) / (near - far), b = 2 * far * near / (near - far);
    return new Float32Array([0, 1, 2].flatMap(i => [rows[0][i], rows[1][i], a * out[i], -out[i]]).concat([shift[0], shift[1], a * shift[2] + b, -shift[2]]));
  }
  function draw() {
    const ratio = window.devicePixelRatio || 1, w = Math.round(canvas.clientWidth * ratio), h = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    gl.viewport(0, 0, w, h); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const view = matrix(), now = frames[frame];
    const use = (made, values) => {
      gl.useProgram(made); gl.uniformMatrix4fv(gl.getUniformLocation(made, "view"), false, view);
      for (const [name, value] of Object.entries({low: head.low, span: head.span, sun: head.sun, ...values})) {
        const place = gl.getUniformLocation(made, name);
        if (Array.isArray(value)) gl.uniform3fv(place, value); else gl.uniform1f(place, value);
      }
    };
    gl.depthMask(false); use(sky, {height: h}); gl.drawArrays(gl.TRIANGLES, 0, 3); gl.depthMask(true);
    if (terrain) { use(ground, {interval: head.interval}); gl.bindVertexArray(terrain.vao); gl.drawElements(gl.TRIANGLES, terrain.n, gl.UNSIGNED_INT, 0); }
    if (now.solid) { use(solid, {softness: 0.1}); gl.bindVertexArray(now.solid); gl.drawElements(gl.TRIANGLES, 3 * head.solids.facets, gl.UNSIGNED_INT, 0); }
    use(snow, {size: head.size / opening(), height: 0.5 * h, softness: 0.4}); gl.bindVertexArray(now.vao); gl.drawArrays(gl.POINTS, 0, now.n);
    gl.bindVertexArray(null);
    clock.textContent = "t = " + head.times[frame].toFixed(2) + " s"; slider.value = frame;
  }
  let asked = false;
  const redraw = () => { if (!asked) { asked = true; requestAnimationFrame(() => { asked = false; draw(); }); } };
  function play(now) {
    if (!playing) return;
    if (now >= due) { frame = (frame + 1) % frames.length; due = now + (frame === frames.length - 1 ? 1200 : head.pause); draw(); }
    requestAnimationFrame(play);
  }
  button.onclick = () => { playing = !playing; button.textContent = playing ? "❚❚" : "▶"; if (playing) requestAnimationFrame(play); };
  slider.max = frames.length - 1; slider.oninput = () => { frame = +slider.value; redraw(); };
  const fingers = new Map(); let apart = 0;
  canvas.onpointerdown = e => { canvas.setPointerCapture(e.pointerId); fingers.set(e.pointerId, [e.clientX, e.clientY]); apart = 0; };
  canvas.onpointerup = canvas.onpointercancel = e => { fingers.delete(e.pointerId); apart = 0; };
  canvas.onpointermove = e => {
    const before = fingers.get(e.pointerId); if (!before) return;
    const dx = e.clientX - before[0], dy = e.clientY - before[1]; fingers.set(e.pointerId, [e.clientX, e.clientY]);
    const metres = 2 * camera.distance * opening() / canvas.clientHeight, {right, up} = axes();
    const move = (x, y) => { for (let i = 0; i < 3; i++) camera.target[i] -= metres * (x * right[i] - y * up[i]); };
    if (fingers.size === 2) {
      const [p, q] = [...fingers.values()], now = Math.hypot(p[0] - q[0], p[1] - q[1]);
      if (apart) camera.distance *= apart / now; apart = now; move(dx / 2, dy / 2);
    } else if (e.shiftKey || e.buttons === 2) move(dx, dy);
    else { camera.azimuth += 0.006 * dx; camera.elevation = Math.min(1.55, Math.max(-0.2, camera.elevation + 0.006 * dy)); }
    redraw();
  };
  canvas.oncontextmenu = e => e.preventDefault();
  canvas.addEventListener("wheel", e => { e.preventDefault(); camera.distance *= Math.exp(0.001 * e.deltaY); redraw(); }, {passive: false});
  canvas.ondblclick = () => { Object.assign(camera, head.camera, {target: [...head.camera.target]}); redraw(); };
  new ResizeObserver(redraw).observe(canvas);
  draw(); root.dataset.ready = "yes";
}
document.querySelectorAll(".viewer").forEach(root => showRun(root).catch(error => { root.querySelector(".said").textContent = "Cannot be shown: " + error.message; }));
