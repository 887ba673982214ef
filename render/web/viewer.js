// A run in three dimensions: turn with the mouse or a finger, wheel or pinch to come closer, shift or right button to move.
"use strict";
// An element with attributes, properties (text, on...) and children
function made(tag, attributes = {}, ...children) {
  const one = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) if (name === "text") one.textContent = value; else if (name.startsWith("on")) one[name] = value; else one.setAttribute(name, value);
  one.append(...children);
  return one;
}
async function showRun(root) {
  const part = name => root.querySelector(name), canvas = part("canvas"), said = part(".said");
  const head = JSON.parse(part("script[type='application/json']").textContent);
  const data = unpack(head.parts, await inflated(part(".data").textContent));
  const stance = new Stance(head.camera, () => [canvas.clientWidth, canvas.clientHeight], head.reach);
  stance.fit(head.keep);
  const marks = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  canvas.after(marks);
  const draw = await paint(canvas, head, data), measure = new Measure(head, data, stance, marks, said);
  const shown = {frame: head.start, field: head.field, layer: -1, range: [0, 1], layerRange: [0, 1], cut: null};
  let asked = false, playing = false, due = 0;

  const clock = made("span", {class: "clock"}), slider = made("input", {type: "range", min: 0, max: head.frames.length - 1, value: shown.frame, "aria-label": "time"});
  const play = made("button", {title: "play", text: "▶"});
  function now() { draw(stance, shown); measure.draw(); clock.textContent = "t = " + head.times[shown.frame].toFixed(2) + " s"; slider.value = shown.frame; }
  const redraw = () => { if (!asked) { asked = true; requestAnimationFrame(() => { asked = false; now(); }); } };
  function step(time) {
    if (!playing) return;
    if (time >= due) { shown.frame = (shown.frame + 1) % head.frames.length; due = time + (shown.frame === head.frames.length - 1 ? 1200 : head.pause); now(); }
    requestAnimationFrame(step);
  }
  play.onclick = () => { playing = !playing; play.textContent = playing ? "❚❚" : "▶"; if (playing) requestAnimationFrame(step); };
  slider.oninput = () => { shown.frame = +slider.value; redraw(); };

  // A scale with ends that can be set: `range` is the part of it, in shares, that the colours span
  function legend(scale, range) {
    const stops = []; for (let k = 0; k < 256; k += 15) stops.push(`rgb(${scale.table.slice(3 * k, 3 * k + 3)})`);
    const strip = made("div", {class: "strip"}), ends = made("div", {class: "ends"}); strip.style.background = `linear-gradient(90deg,${stops})`;
    const value = share => +(scale.low + share * (scale.high - scale.low)).toPrecision(4);
    if (scale.names.length) scale.names.forEach(name => ends.append(made("span", {text: name})));
    else [0, 1].forEach(k => {
      const end = made("input", {type: "number", step: "any", value: value(range[k]), "aria-label": (k ? "highest " : "lowest ") + scale.title});
      end.onchange = () => {
        const share = (+end.value - scale.low) / (scale.high - scale.low), other = range[1 - k];
        if (end.value !== "" && (k ? share > other : share < other)) range[k] = share; else end.value = value(range[k]);
        redraw();
      };
      ends.append(end);
    });
    return made("div", {class: "legend"}, scale.title, strip, ends);
  }
  function legends() {
    part(".legends").replaceChildren(...[[head.layers[shown.layer], shown.layerRange], [head.fields[shown.field], shown.range]].filter(([scale]) => scale).map(pair => legend(...pair)));
  }
  function choice(label, names, chosen, change) {
    const list = made("select", {"aria-label": label}); names.forEach((name, k) => list.append(made("option", {value: k, text: name})));
    list.selectedIndex = chosen; list.onchange = () => { change(list.selectedIndex); legends(); redraw(); };
    return list;
  }
  const controls = [choice("colour of the snow", [...head.fields.map(field => field.title), "plain snow"], head.field < 0 ? head.fields.length : head.field,
                           k => { shown.field = k < head.fields.length ? k : -1; shown.range = [0, 1]; })];
  if (head.layers.length) controls.push(choice("map on the ground", ["no map", ...head.layers.map(layer => layer.title)], 0, k => { shown.layer = k - 1; shown.layerRange = [0, 1]; }));
  // The plane that cuts: across an axis, at a share of the scene, and which side is left
  const axes = head.flat ? [0, 2] : [0, 1, 2], plane = {axis: -1, side: 1};
  const at = made("input", {type: "range", class: "plane", min: 0, max: 1000, value: 500, "aria-label": "place of the cut", hidden: ""}), side = made("button", {title: "other side of the cut", text: "⇄", hidden: ""});
  function cut() {
    at.hidden = side.hidden = plane.axis < 0; shown.cut = null;
    if (plane.axis >= 0) { const n = [0, 0, 0]; n[plane.axis] = plane.side; shown.cut = [...n, plane.side * (head.low[plane.axis] + head.span[plane.axis] * at.value / 1000)]; }
    redraw();
  }
  controls.push(choice("cut", ["no cut", ...axes.map(k => "cut across " + "xyz"[k])], 0, k => { plane.axis = k ? axes[k - 1] : -1; cut(); }), at, side);
  at.oninput = cut; side.onclick = () => { plane.side *= -1; cut(); };
  const ruler = made("button", {title: "measure: tap two places", text: "measure", "aria-pressed": "false"});
  ruler.onclick = () => { measure.active = !measure.active; ruler.setAttribute("aria-pressed", measure.active); measure.clear(); redraw(); };
  part(".bar").append(made("div", {class: "row"}, play, slider, clock), made("div", {class: "row"}, ...controls, ruler, made("button", {title: "first view", text: "⌂", onclick: () => { stance.restart(); redraw(); }})));

  const fingers = new Map(); let apart = 0, still = null;
  canvas.onpointerdown = e => { canvas.setPointerCapture(e.pointerId); fingers.set(e.pointerId, [e.clientX, e.clientY]); apart = 0; still = fingers.size === 1 ? [e.clientX, e.clientY] : null; };
  canvas.onpointerup = e => {
    if (still && measure.active && fingers.has(e.pointerId)) { const frame = canvas.getBoundingClientRect(); measure.tap(e.clientX - frame.left, e.clientY - frame.top, shown); redraw(); }
    fingers.delete(e.pointerId); apart = 0; still = null;
  };
  canvas.onpointercancel = e => { fingers.delete(e.pointerId); apart = 0; still = null; };
  canvas.onpointermove = e => {
    const before = fingers.get(e.pointerId); if (!before) return;
    // A finger that rests trembles a little
    if (still && Math.hypot(e.clientX - still[0], e.clientY - still[1]) < 6) return;
    still = null;
    const dx = e.clientX - before[0], dy = e.clientY - before[1]; fingers.set(e.pointerId, [e.clientX, e.clientY]);
    if (fingers.size === 2) {
      const [p, q] = [...fingers.values()], gap = Math.hypot(p[0] - q[0], p[1] - q[1]);
      if (apart) stance.nearer(apart / gap); apart = gap; stance.move(dx / 2, dy / 2);
    } else if (e.shiftKey || e.buttons === 2) stance.move(dx, dy);
    else stance.turn(dx, dy);
    redraw();
  };
  canvas.oncontextmenu = e => e.preventDefault();
  canvas.addEventListener("wheel", e => { e.preventDefault(); stance.nearer(Math.exp(0.001 * e.deltaY)); redraw(); }, {passive: false});
  canvas.ondblclick = () => { if (!measure.active) { stance.restart(); redraw(); } };
  new ResizeObserver(redraw).observe(canvas);
  legends(); now(); root.dataset.ready = "yes";
}
if (typeof document !== "undefined") document.querySelectorAll(".viewer").forEach(root => showRun(root).catch(error => { root.querySelector(".said").textContent = "Cannot be shown: " + error.message; }));
