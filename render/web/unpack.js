// Named arrays from the data of a page, as render/viewer/packing.py writes them.
"use strict";
const KINDS = {u1: Uint8Array, i1: Int8Array, u2: Uint16Array, u4: Uint32Array};
function unpack(table, bytes) {
  const found = {};
  let at = 0;
  for (const {name, type, rows, width} of table) {
    if (type === "raw") { found[name] = bytes.slice(at, at + rows); at += rows; continue; }
    const size = +type[1], n = rows * width, summed = new ({1: Uint8Array, 2: Uint16Array, 4: Uint32Array}[size])(n);
    for (let j = 0; j < width; j++) {
      let value = 0;
      for (let i = 0; i < rows; i++) {
        let step = 0;
        for (let byte = 0; byte < size; byte++) step |= bytes[at + byte * n + j * rows + i] << (8 * byte);
        // The sum runs over the range of the type: its array cuts it
        summed[i * width + j] = value = value + step;
        value = summed[i * width + j];
      }
    }
    at += n * size;
    found[name] = new KINDS[type](summed.buffer);
  }
  if (at !== bytes.length) throw new Error("the data of the page are not whole");
  return found;
}
async function inflated(text) {
  const packed = Uint8Array.from(atob(text.trim()), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
