// The scene on a canvas by WebGL 2: ground, solids, snow as balls. What is drawn is told by draw(shown).
"use strict";
const LIT = `
  vec3 clip3(vec3 v) { vec3 e = max(v - 0.8, 0.0); return mix(v, 0.8 + 0.2 * e / (e + 0.2), step(0.8, v)); }
  vec3 lit(vec3 colour, vec3 n) {
    float up = 0.5 + 0.5 * n.z;
    float facing = max((dot(n, sun) + softness) / (1.0 + softness), 0.0);
    return colour * (facing * vec3(0.86, 0.826, 0.757) + up * vec3(0.248, 0.304, 0.4) + (1.0 - up) * vec3(0.1, 0.095, 0.088));
  }
  vec3 shown(vec3 light) { return pow(clip3(light), vec3(1.0 / 2.2)); }
  void keep(vec3 p) { if (dot(cut.xyz, p) > cut.w) discard; }`;
const SHADERS = {
  ground: [`
    in vec3 place; in vec3 colour; out vec3 tint, p;
    void main() { p = low + span * place; tint = colour; gl_Position = view * vec4(p, 1.0); }`, LIT + `
    in vec3 tint, p; uniform float interval, pictured, layered; uniform vec4 box, frame; uniform vec2 within;
    uniform sampler2D picture, layer, map; out vec4 result;
    void main() {
      keep(p);
      float n = p.z / interval, off = abs(n - round(n)) / max(fwidth(n), 1e-6);
      float fifth = abs(n / 5.0 - round(n / 5.0)) < 0.02 ? 1.0 : 0.5;
      float line = clamp(1.4 - off, 0.0, 1.0) * fifth * clamp(1.2 - 4.0 * fwidth(n), 0.0, 1.0);
      vec3 c = pictured > 0.0 ? texture(picture, vec2((p.x - box.x) / (box.z - box.x), (box.w - p.y) / (box.w - box.y))).rgb : tint;
      vec2 at = (p.xy - frame.xy) / (frame.zw - frame.xy);
      if (layered > 0.0 && all(greaterThan(at, vec2(0.0))) && all(lessThan(at, vec2(1.0)))) {
        float value = 255.0 * texture(layer, at).r;
        if (value > 0.5) {
          float share = clamp(((value - 1.0) / 254.0 - within.x) / (within.y - within.x), 0.0, 1.0);
          c = mix(c, texture(map, vec2((255.0 * share + 0.5) / 256.0, 0.5)).rgb, 0.8);
        }
      }
      result = vec4(c * (1.0 - 0.35 * line) * (gl_FrontFacing ? 1.0 : 0.55), 1.0);
    }`],
  snow: [`
    in vec3 place; in float colour; in vec3 normal; uniform float size, height; uniform vec2 within; uniform sampler2D map;
    out vec3 tint, facing, p;
    void main() {
      p = low + span * place; gl_Position = view * vec4(p, 1.0);
      gl_PointSize = max(size * height / gl_Position.w, 2.0);
      float share = clamp((colour - within.x) / (within.y - within.x), 0.0, 1.0);
      tint = pow(texture(map, vec2((255.0 * share + 0.5) / 256.0, 0.5)).rgb, vec3(2.2)); facing = normalize(normal + vec3(0.0, 0.0, 1e-4));
    }`, LIT + `
    in vec3 tint, facing, p; out vec4 result;
    void main() {
      keep(p);
      vec2 d = 2.0 * gl_PointCoord - 1.0; float r = dot(d, d); if (r > 1.0) discard;
      result = vec4(shown(0.9 * lit(tint, facing) * (1.0 - 0.10 * r)), 1.0);
    }`],
  solid: [`
    in vec3 place; out vec3 p;
    void main() { p = low + span * place; gl_Position = view * vec4(p, 1.0); }`, LIT + `
    in vec3 p; out vec4 result;
    void main() { keep(p); vec3 n = normalize(cross(dFdx(p), dFdy(p))); result = vec4(shown(lit(vec3(0.15, 0.22, 0.37), n)), 1.0); }`],
  sky: [`
    void main() { vec2 c = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0); gl_Position = vec4(c, 0.99999, 1.0); }`, `
    uniform float height; out vec4 result;
    void main() { result = vec4(mix(vec3(0.86, 0.89, 0.92), vec3(0.56, 0.66, 0.77), pow(gl_FragCoord.y / height, 1.3)), 1.0); }`],
};
async function paint(canvas, head, data) {
  const gl = canvas.getContext("webgl2", {antialias: true, preserveDrawingBuffer: true});
  if (!gl) throw new Error("this browser has no WebGL 2; the pictures and films do without");
  const programs = {};
  for (const [name, texts] of Object.entries(SHADERS)) {
    const made = programs[name] = gl.createProgram();
    texts.forEach((text, i) => {
      const shader = gl.createShader(i ? gl.FRAGMENT_SHADER : gl.VERTEX_SHADER);
      gl.shaderSource(shader, "#version 300 es\nprecision highp float;\nuniform mat4 view; uniform vec3 low, span, sun; uniform vec4 cut; uniform float softness;\n" + text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(name + ": " + gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    });
    ["place", "colour", "normal"].forEach((name, i) => gl.bindAttribLocation(made, i, name));
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(name + ": " + gl.getProgramInfoLog(made));
  }
  function buffer(values, kind = gl.ARRAY_BUFFER) { const b = gl.createBuffer(); gl.bindBuffer(kind, b); gl.bufferData(kind, values, gl.STATIC_DRAW); return b; }
  const TYPES = {Uint16Array: gl.UNSIGNED_SHORT, Uint8Array: gl.UNSIGNED_BYTE, Int8Array: gl.BYTE};
  function attribute(i, values, width) { buffer(values); gl.enableVertexAttribArray(i); gl.vertexAttribPointer(i, width, TYPES[values.constructor.name], true, 0, 0); }
  function array(fill) { const vao = gl.createVertexArray(); gl.bindVertexArray(vao); fill(); gl.bindVertexArray(null); return vao; }
  function texture(unit, filter, fill) {
    const made = gl.createTexture(); gl.activeTexture(gl.TEXTURE0 + unit); gl.bindTexture(gl.TEXTURE_2D, made); gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    fill();
    for (const [key, value] of [[gl.TEXTURE_MIN_FILTER, filter], [gl.TEXTURE_MAG_FILTER, filter], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, key, value);
    return made;
  }
  const table = colours => texture(0, gl.NEAREST, () => gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(colours)));
  const plain = table([].concat(...Array(256).fill(head.plain)));
  const fieldMaps = head.fields.map(field => table(field.table)), layerMaps = head.layers.map(layer => table(layer.table));
  const layers = head.layers.map((layer, k) => texture(2, gl.NEAREST, () => gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, layer.columns, layer.rows, 0, gl.RED, gl.UNSIGNED_BYTE, data["layer." + k])));
  let picture = null, ground = null;
  if (data["ground.picture"]) {
    const bitmap = await createImageBitmap(new Blob([data["ground.picture"]], {type: "image/jpeg"}));
    picture = texture(1, gl.LINEAR, () => gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, gl.RGB, gl.UNSIGNED_BYTE, bitmap));
  }
  if (head.ground) ground = {
    n: data["ground.facets"].length,
    vao: array(() => { attribute(0, data["ground.place"], 3); attribute(1, data["ground.colour"], 3); buffer(data["ground.facets"], gl.ELEMENT_ARRAY_BUFFER); }),
  };
  const frames = head.frames.map(([seen, all], k) => {
    // What lies within the snow is seen where a plane cuts it; it has no normal of its own
    const normals = new Int8Array(3 * all); normals.set(data[`snow.${k}.normal`]);
    for (let i = seen; i < all; i++) normals[3 * i + 2] = 127;
    const values = head.fields.map((_, j) => { const b = buffer(data[`snow.${k}.value.${j}`]); return b; });
    const vao = array(() => { attribute(0, data[`snow.${k}.place`], 3); attribute(2, normals, 3); });
    const solid = data[`solid.${k}.place`] ? array(() => { attribute(0, data[`solid.${k}.place`], 3); buffer(data["solid.facets"], gl.ELEMENT_ARRAY_BUFFER); }) : null;
    return {seen, all, vao, values, solid};
  });
  gl.enable(gl.DEPTH_TEST);
  const bind = (unit, made) => { gl.activeTexture(gl.TEXTURE0 + unit); gl.bindTexture(gl.TEXTURE_2D, made); };
  // shown: frame, field and layer (-1: none), ranges (within the scales, [low, high] as shares), cut [nx, ny, nz, d] or null
  return function draw(stance, shown) {
    // More pixels than that cost a phone its battery, and show nothing more
    const ratio = Math.min(window.devicePixelRatio || 1, 2), w = Math.round(canvas.clientWidth * ratio), h = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    gl.viewport(0, 0, w, h); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const view = stance.matrix(), now = frames[shown.frame], opening = stance.opening();
    const use = (name, values) => {
      const made = programs[name];
      gl.useProgram(made); gl.uniformMatrix4fv(gl.getUniformLocation(made, "view"), false, view);
      for (const [key, value] of Object.entries({low: head.low, span: head.span, sun: head.sun, cut: shown.cut || [0, 0, 0, 1], ...values})) {
        const place = gl.getUniformLocation(made, key);
        if (Array.isArray(value)) gl[`uniform${value.length}fv`](place, value); else if (["picture", "layer", "map"].includes(key)) gl.uniform1i(place, value); else gl.uniform1f(place, value);
      }
    };
    gl.depthMask(false); use("sky", {height: h}); gl.drawArrays(gl.TRIANGLES, 0, 3); gl.depthMask(true);
    if (ground) {
      const layer = head.layers[shown.layer], values = {interval: head.interval, box: head.ground.box, picture: 1, layer: 2, map: 0};
      bind(1, picture); bind(2, layer ? layers[shown.layer] : null); bind(0, layer ? layerMaps[shown.layer] : plain);
      gl.bindVertexArray(ground.vao);
      use("ground", {...values, pictured: picture ? 1 : 0, layered: layer ? 1 : 0, frame: layer ? [layer.x0, layer.y0, layer.x1, layer.y1] : [0, 0, 1, 1], within: shown.layerRange});
      gl.drawElements(gl.TRIANGLES, 3 * head.ground.facets, gl.UNSIGNED_INT, 0);
      use("ground", {...values, interval: 1e9, pictured: 0, layered: 0, frame: [0, 0, 1, 1], within: [0, 1]});
      gl.drawElements(gl.TRIANGLES, ground.n - 3 * head.ground.facets, gl.UNSIGNED_INT, 12 * head.ground.facets);
    }
    if (now.solid) { use("solid", {softness: 0.1}); gl.bindVertexArray(now.solid); gl.drawElements(gl.TRIANGLES, data["solid.facets"].length, gl.UNSIGNED_INT, 0); }
    gl.bindVertexArray(now.vao); bind(0, shown.field < 0 ? plain : fieldMaps[shown.field]);
    if (shown.field < 0) { gl.disableVertexAttribArray(1); gl.vertexAttrib1f(1, 0); }
    else { gl.bindBuffer(gl.ARRAY_BUFFER, now.values[shown.field]); gl.enableVertexAttribArray(1); gl.vertexAttribPointer(1, 1, gl.UNSIGNED_BYTE, true, 0, 0); }
    use("snow", {size: head.size / opening, height: 0.5 * h, softness: 0.4, map: 0, within: shown.field < 0 ? [0, 1] : shown.range});
    gl.drawArrays(gl.POINTS, 0, shown.cut ? now.all : now.seen);
    gl.bindVertexArray(null);
  };
}
