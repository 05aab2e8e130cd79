"use strict";
// The page's numbers: what notes/views/pack.py packed, unpacked a block at a time.

const DATA = JSON.parse(document.getElementById("data").textContent);
const KEPT = 6;  // blocks of a name that stay unpacked
const unpacked = new Map();

function bytes_of(base64) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; ++k) bytes[k] = text.charCodeAt(k);
  return bytes;
}

function numbers(base64, Kind) { return new Kind(bytes_of(base64).buffer); }

async function inflated(id) {
  const stream = new Blob([bytes_of(document.getElementById(id).textContent)]).stream()
    .pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// What `make` makes of the bytes of a block, kept while it is in use.
async function block(id, make) {
  let found = unpacked.get(id);
  if (found) {
    unpacked.delete(id);  // and put behind those that were used less lately
  } else {
    found = inflated(id).then(make);
    if (unpacked.size >= 4 * KEPT) unpacked.delete(unpacked.keys().next().value);
  }
  unpacked.set(id, found);
  return found;
}

const unfolded = (x) => (x >>> 1) ^ -(x & 1);

// Folded 16-bit numbers whose low bytes come first, from byte `first` on.
function differences(bytes, first, count) {
  const found = new Int32Array(count);
  for (let k = 0; k < count; ++k) found[k] = unfolded(bytes[first + k] | (bytes[first + count + k] << 8));
  return found;
}

// Frames of a block of fixed elements: a Uint16Array each, component by component.
function frames_of(bytes, before) {
  const count = DATA.elements * DATA.components, frames = bytes.length / 2 / count, found = [];
  const change = differences(bytes, 0, frames * count);
  for (let f = 0; f < frames; ++f) {
    const reference = before ? before[f] : found[f - 1], values = new Uint16Array(count);
    for (let k = 0; k < count; ++k) values[k] = (reference ? reference[k] : 0) + change[f * count + k];
    found.push(values);
  }
  return found;
}

const block_of = (frame) => Math.floor(frame / DATA.block);

async function steps_of(run, frame) {
  const k = block_of(frame), before = run ? await block(`run0-${k}`, frames_of) : undefined;
  const frames = await block(`run${run}-${k}`, (bytes) => frames_of(bytes, before));
  return frames[frame - k * DATA.block];
}

// Places of the elements, x y z after one another.
function places(steps) {
  const n = DATA.elements, found = new Float32Array(3 * n);
  for (let axis = 0; axis < 3; ++axis) {
    const low = DATA.low[axis], step = (DATA.high[axis] - low) / 65535;
    for (let k = 0; k < n; ++k) found[3 * k + axis] = low + step * steps[axis * n + k];
  }
  return found;
}

// A byte an element, 0 of the same place (pack.py's code_of), or undefined where runs do not differ.
async function apart_of(frame) {
  if (!document.getElementById("apart-0")) return undefined;
  const k = block_of(frame), all = await block(`apart-${k}`, (bytes) => bytes);
  const first = (frame - k * DATA.block) * DATA.elements;
  return all.subarray(first, first + DATA.elements);
}

// A frame's surface of a level set: places, corners of triangles, places of drops, codes of distance.
function surface_of(bytes) {
  const [points, triangles, drops, coded] = new Uint32Array(bytes.slice(0, 16).buffer);
  let at = 16;
  const codes = coded ? bytes.subarray(at, at += points) : undefined;
  const margin = DATA.slice.spacing;
  const take = (n) => {
    const found = new Float32Array(3 * n), change = differences(bytes, at, 3 * n);
    at += 6 * n;
    for (let axis = 0; axis < 3; ++axis) {
      const low = DATA.low[axis] - margin, step = (DATA.high[axis] + margin - low) / 65535;
      for (let k = 0, steps = 0; k < n; ++k) {
        steps = (steps + change[axis * n + k]) & 65535;
        found[3 * k + axis] = low + step * steps;
      }
    }
    return found;
  };
  const places = take(points), spray = take(drops), corners = new Uint32Array(3 * triangles), n = 3 * triangles;
  for (let k = 0, corner = 0; k < n; ++k) {
    const byte = (place) => bytes[at + place * n + k];
    corners[k] = corner += unfolded(byte(0) | (byte(1) << 8) | (byte(2) << 16) | (byte(3) << 24));
  }
  return { places, corners, spray, codes };
}
