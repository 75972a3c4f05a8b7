"use strict";
// Runs the module beside the page. It gets the compiled module once and then one request after the other.
let exports = null;
let id = null;
const encoder = new TextEncoder();
const decoder = new TextDecoder();

const read = (length) => {
  const words = new BigUint64Array(Math.ceil(length / 8));
  for (let i = 0; i < words.length; i++) words[i] = exports.get(i);
  return decoder.decode(new Uint8Array(words.buffer, 0, length));
};

const write = (text) => {
  const bytes = encoder.encode(text);
  const padded = new Uint8Array(8 * Math.ceil(bytes.length / 8));
  padded.set(bytes);
  new BigUint64Array(padded.buffer).forEach((word, i) => exports.put(word, Math.min(8, bytes.length - 8 * i)));
};

const host = {
  seconds: () => performance.now() / 1000,
  progress: (share, length) => postMessage({ id, share, doing: read(length) }),
};

onmessage = ({ data }) => {
  if (data.module) {
    exports = new WebAssembly.Instance(data.module, { host }).exports;
    return;
  }
  id = data.id;
  const start = performance.now();
  try {
    write(JSON.stringify(data.request));
    const answer = JSON.parse(read(exports.answer()));
    postMessage({ id, answer, seconds: (performance.now() - start) / 1000, bytes: exports.memory.buffer.byteLength });
  } catch (error) {
    postMessage({ id, trap: String(error) });
  }
};
