"use strict";
// A link that holds the scene: name, text and changed parameters, compressed, behind the `#` of the address, which no server sees.
// A short link unpacks to gigabytes if it was made to: most letters of a link, most bytes of what is in it.
const mostPacked = 1e6;
const mostUnpacked = 4e6;
const through = async (bytes, stream) => {
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  const parts = [];
  let length = 0;
  for (let read = await reader.read(); !read.done; read = await reader.read()) {
    length += read.value.length;
    if (length > mostUnpacked) {
      reader.cancel().catch(() => {});
      throw new RangeError(`it unpacks to more than ${mostUnpacked} bytes`);
    }
    parts.push(read.value);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
};
const packLink = async ({ name, text, values = {} }) => {
  const content = JSON.stringify({ name, text, values });
  const packed = await through(new TextEncoder().encode(content), new CompressionStream("deflate-raw"));
  const base64 = btoa(Array.from(packed, (byte) => String.fromCharCode(byte)).join(""));
  return `#scene=${base64.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "")}`;
};
// The scene behind `#`; `null` if there is none. Fails with the reason where it cannot be read.
const unpackLink = async (hash) => {
  const packed = /^#scene=(.*)$/.exec(hash)?.[1];
  if (packed === undefined) return null;
  if (packed.length > mostPacked) throw new RangeError(`it has more than ${mostPacked} letters`);
  if (!/^[\w-]+$/.test(packed)) throw new SyntaxError("a part of it is lost or was changed");
  let content;
  try {
    const bytes = Uint8Array.from(atob(packed.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
    content = JSON.parse(new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate-raw"))));
  } catch (error) {
    if (error instanceof RangeError) throw error;
    throw new SyntaxError("a part of it is lost or was changed");
  }
  const { name, text, values } = content ?? {};
  if (typeof name !== "string" || typeof text !== "string") throw new SyntaxError("there is no scene in it");
  const numbers = Object.entries(values ?? {}).filter(([, value]) => typeof value === "number");
  return { name: cleanName(name) || "scene", text, values: Object.fromEntries(numbers) };
};
