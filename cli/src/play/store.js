"use strict";
// What was written stays: scenes by name, in the storage of the browser, which pages from the same place share.
const store = (() => {
  const key = "hangtime.scenes";
  const empty = () => ({ scenes: {}, last: null });
  // Where the browser keeps nothing, the page does until it is closed.
  let memory = null;
  const read = () => {
    if (memory) return memory;
    try {
      const kept = JSON.parse(localStorage.getItem(key) ?? "{}");
      const scenes = Object.entries(kept.scenes ?? {}).filter(([, text]) => typeof text === "string");
      return { scenes: Object.fromEntries(scenes), last: typeof kept.last === "string" ? kept.last : null };
    } catch {
      return empty();
    }
  };
  // Whether it is kept beyond this visit. What another page has written meanwhile stays.
  const change = (how) => {
    const kept = read();
    how(kept);
    if (memory) return false;
    try {
      localStorage.setItem(key, JSON.stringify(kept));
      return true;
    } catch {
      memory = kept;
      return false;
    }
  };
  return {
    names: () => Object.keys(read().scenes).sort(),
    text: (name) => { const { scenes } = read(); return Object.hasOwn(scenes, name) ? scenes[name] : undefined; },
    last: () => read().last,
    set: (name, text) => change((kept) => { kept.scenes[name] = text; }),
    remove: (name) => change((kept) => { delete kept.scenes[name]; }),
    open: (name) => change((kept) => { kept.last = name; }),
    key,
  };
})();

// The texts of a scene, one behind the other: what is typed without a pause is one step.
class Past {
  // A pause that ends a step [ms], and how many steps are kept.
  static pause = 700;
  static most = 400;
  constructor(text) {
    this.steps = [text];
    this.place = 0;
    this.at = -Infinity;
  }
  note(text, now = performance.now()) {
    if (text === this.steps[this.place]) return;
    const goesOn = now - this.at < Past.pause && this.place > 0 && this.place === this.steps.length - 1;
    this.at = now;
    if (goesOn) {
      this.steps[this.place] = text;
      return;
    }
    this.steps.length = this.place + 1;
    this.steps.push(text);
    if (this.steps.length > Past.most) this.steps.shift();
    this.place = this.steps.length - 1;
  }
  // The text a step before (-1) or after (1); `null` at the end.
  go(by) {
    const place = this.place + by;
    if (place < 0 || place >= this.steps.length) return null;
    this.place = place;
    this.at = -Infinity;
    return this.steps[place];
  }
  has(by) {
    return this.steps[this.place + by] !== undefined;
  }
}

// A name that no scene has: `name`, `name-2`, ...
const freeName = (name, taken) => {
  let free = name;
  for (let k = 2; taken(free); k++) free = `${name}-${k}`;
  return free;
};
// What a file and the command line take as a name: letters, digits, `-` and `_`, a letter or digit first.
const cleanName = (name) => name.trim().replace(/\.hang$/, "").replaceAll(/[^A-Za-z0-9_-]+/g, "-").replace(/^[-_]+/, "").slice(0, 60);
