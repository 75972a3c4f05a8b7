// Runs the player of a page without a browser, on elements that only remember what is set, and prints what it draws at some times.
import { readFileSync } from "node:fs";

const page = readFileSync(process.argv[2], "utf8");
const frames = /<script type="application\/json" id="frames"[^>]*>(.*?)<\/script>/s.exec(page)[1];
const element = (name) => {
  const known = { name, attributes: {}, children: [], style: { setProperty() {} }, dataset: {}, clientWidth: 900, listeners: {} };
  known.setAttribute = (key, value) => { known.attributes[key] = String(value); };
  known.append = (...nodes) => known.children.push(...nodes);
  known.addEventListener = (kind, call) => { known.listeners[kind] = call; };
  known.dispatchEvent = () => true;
  known.click = () => known.listeners.click?.();
  return known;
};
const elements = { frames: Object.assign(element("script"), { textContent: frames, id: "frames" }) };
globalThis.document = {
  getElementById: (id) => (elements[id] ??= element(id)),
  createElement: element,
  createElementNS: (_, name) => element(name),
  querySelectorAll: () => [elements.frames],
  addEventListener() {},
};
globalThis.ResizeObserver = class { observe() {} };
globalThis.CustomEvent = class {};
globalThis.AbortController = class { abort() {} };
globalThis.matchMedia = () => ({ matches: true });
const scripts = [...page.matchAll(/<script>(.*?)<\/script>/gs)].map(([, script]) => script);
new Function(scripts.find((script) => script.includes("playFrames")))();
const drawn = () => elements.stage.children.filter(({ attributes }) => "data-contact" in attributes && attributes.d);
const lines = () => elements.stage.children.map(({ attributes }) => attributes.points).filter(Boolean).join(" ");
const report = [0, 0.5, 1].map((share) => {
  elements.scrub.value = Number(elements.scrub.max) * share;
  elements.scrub.listeners.input();
  const forces = drawn().map(({ attributes, children }) => [attributes["data-contact"], attributes["data-on"], children[0].textContent]);
  return { lines: lines(), forces };
});
console.log(JSON.stringify(report));
