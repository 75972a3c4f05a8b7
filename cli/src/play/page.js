"use strict";
const element = (id) => document.getElementById(id);
const shipped = JSON.parse(element("shipped").textContent);
const make = (tag, properties = {}, ...children) => {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
};

// The module, compiled once, while it is decoded and unpacked; every worker runs its own copy.
const compiled = (async () => {
  const packed = await fetch(`data:application/octet-stream;base64,${element("module").textContent}`);
  const stream = packed.body.pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compileStreaming(new Response(stream, { headers: { "Content-Type": "application/wasm" } }));
})();
const workerAddress = URL.createObjectURL(new Blob([element("worker").textContent], { type: "text/javascript" }));
// A worker with more memory than this is replaced by a fresh one after its answer [bytes].
const mostBytes = 4e8;

// One worker, and the request that it works on.
class Caller {
  constructor() {
    this.start();
  }
  start() {
    this.worker = new Worker(workerAddress);
    this.pending = null;
    this.count = 0;
    const worker = this.worker;
    this.ready = compiled.then((module) => worker.postMessage({ module }));
    worker.onmessage = ({ data }) => {
      const pending = this.pending;
      if (!pending || data.id !== pending.id) return;
      if ("doing" in data) {
        pending.tell(data.share, data.doing);
        return;
      }
      this.pending = null;
      if (data.trap || data.bytes > mostBytes) this.replace();
      pending.settle(data.trap ? { refusal: `the run broke off: ${data.trap}` } : data.answer, data.seconds);
    };
  }
  replace() {
    this.worker.terminate();
    this.start();
  }
  get busy() {
    return this.pending !== null;
  }
  // The answer and its time in seconds; `null` if the request was stopped.
  ask(request, tell = () => {}) {
    this.stop();
    return new Promise((resolve) => {
      const id = ++this.count;
      this.pending = { id, tell, settle: (answer, seconds) => resolve(answer && { answer, seconds }) };
      this.ready.then(() => this.worker.postMessage({ id, request }));
    });
  }
  stop() {
    if (!this.pending) return;
    const { settle } = this.pending;
    this.replace();
    settle(null);
  }
}

const checker = new Caller();
const runner = new Caller();

// What is on the page: the scene, what was changed in it, and what is shown.
const page = {
  name: "",
  scene: null,
  values: new Map(),
  edits: new Map(),
  task: "simulate",
  answer: null,
  player: null,
  plots: null,
  again: false,
};
const text = element("text");

const say = (words, bad = false) => {
  element("status").value = words;
  element("status").classList.toggle("bad", bad);
};

// The editor: line numbers, colours and marks below a plain text field.
const words = new Set(("parameters coordinates controls fn let profile lagrangian dissipation forces surface impact friction constraint minimize " +
  "finally free measured within start horizon dry bound inelastic restitution along holding sliding outputs picture pub in point circle rectangle polygon " +
  "link spring curve at to over radius angle").split(" "));
const painted = /(\/\/[^\n]*|\/\*[\s\S]*?\*\/)|([\p{L}_][\p{L}\p{N}_]*)|(\d+\.?\d*(?:e[-+]?\d+)?)/gu;
const paint = () => {
  const parts = [];
  let at = 0;
  for (const match of text.value.matchAll(painted)) {
    const kind = match[1] ? "c" : match[3] ? "n" : words.has(match[2]) ? "w" : null;
    if (!kind) continue;
    parts.push(text.value.slice(at, match.index), make("span", { className: kind, textContent: match[0] }));
    at = match.index + match[0].length;
  }
  element("paint").replaceChildren(...parts, `${text.value.slice(at)}\n`);
  const lines = text.value.split("\n").length;
  element("lines").textContent = Array.from({ length: lines }, (_, k) => k + 1).join("\n");
  mark([]);
  scroll();
};
const mark = (mistakes) => {
  const parts = [];
  let at = 0;
  for (const { place: [from, to] } of mistakes) {
    if (from < at) continue;
    const end = Math.max(to, from + 1);
    parts.push(text.value.slice(at, from), make("mark", { textContent: text.value.slice(from, end) || " " }));
    at = end;
  }
  element("marks").replaceChildren(...parts, text.value.slice(at));
};
const scroll = () => {
  for (const layer of ["paint", "marks"]) element(layer).style.transform = `translate(${-text.scrollLeft}px,${-text.scrollTop}px)`;
  element("lines").scrollTop = text.scrollTop;
};
const jump = (mistake) => {
  text.focus();
  text.setSelectionRange(mistake.place[0], mistake.place[1]);
  const height = parseFloat(getComputedStyle(text).lineHeight);
  text.scrollTop = Math.max(0, (mistake.line - 4) * height);
};

const showMessages = ({ mistakes = [], report = "", warnings = "" }) => {
  const shown = report || warnings;
  element("messages").hidden = shown === "";
  element("messages").classList.toggle("warn", report === "");
  element("report").textContent = shown;
  const buttons = mistakes.map((mistake) => {
    const button = make("button", { type: "button", textContent: `line ${mistake.line}, column ${mistake.column}` });
    button.addEventListener("click", () => jump(mistake));
    return button;
  });
  element("jumps").replaceChildren(...buttons);
  mark([...mistakes].sort((a, b) => a.place[0] - b.place[0]));
};

// Parameters as sliders, in their declared units.
const sliderRange = ({ default: value, positive }) => {
  if (value > 0) return positive ? [value / 10, 3 * value] : [0, 2 * value];
  return value < 0 ? [2 * value, 0] : [-1, 1];
};
const showParameters = (parameters) => {
  const rows = parameters.map((parameter) => {
    const { name, unit, documentation } = parameter;
    const label = make("label", { textContent: name, title: documentation.trim(), htmlFor: `p-${name}` });
    const spoken = `${name}${unit && ` in ${unit}`}`;
    const slider = make("input", { type: "range", id: `p-${name}`, step: "any" });
    slider.setAttribute("aria-label", `${spoken}: ${documentation.trim() || "parameter"}`);
    const number = make("input", { type: "number", step: "any" });
    number.setAttribute("aria-label", spoken);
    const row = make("div", { className: "parameter" }, label, slider, number, make("span", { className: "unit", textContent: unit }));
    const show = () => {
      const value = page.values.get(name) ?? parameter.default;
      const [low, high] = sliderRange(parameter);
      [slider.min, slider.max] = [Math.min(low, value), Math.max(high, value)];
      slider.value = value;
      slider.setAttribute("aria-valuetext", `${value} ${unit}`);
      if (Number(number.value) !== value || number.value === "") number.value = value;
      row.classList.toggle("changed", value !== parameter.default);
      element("reset").hidden = page.values.size === 0;
    };
    const set = (value) => {
      if (!Number.isFinite(value)) return;
      if (value === parameter.default) page.values.delete(name);
      else page.values.set(name, value);
      show();
      simulateSoon();
    };
    slider.addEventListener("input", () => set(Number(Number(slider.value).toPrecision(4))));
    number.addEventListener("input", () => number.value !== "" && set(Number(number.value)));
    number.addEventListener("change", show);
    show();
    return row;
  });
  element("parameters").replaceChildren(...rows);
};

// What stands behind the scene on the command line.
const settings = (task) => {
  const declared = new Set((page.scene?.parameters ?? []).map(({ name }) => name));
  const list = [];
  for (const [name, value] of page.values) {
    if (declared.has(name)) list.push("--set", `${name}=${value}`);
  }
  if (task === "solve") {
    const intervals = element("intervals").value;
    if (intervals) list.push("--intervals", intervals);
    return list;
  }
  const [method, horizon] = [element("method").value, element("horizon").value.replaceAll(/\s/g, "")];
  if (method !== "fesd") list.push("--method", method);
  if (horizon) list.push("--horizon", horizon);
  return list;
};
const request = (call, list = []) => ({ call, name: page.name, text: text.value, settings: list });
const showCommand = () => {
  element("command").textContent = ["hangtime", page.task, `${page.name}.hang`, ...settings(page.task)].join(" ");
};

const old = (is) => ["motion", "curves", "result"].forEach((id) => element(id).classList.toggle("old", is));

// Curves of one kind and unit share a figure.
const groupsOf = ({ readings }) => {
  const { coordinates, controls } = page.scene ?? { coordinates: [], controls: [] };
  const named = (list, name) => list.some((entry) => entry.name === name);
  const kind = (name) => {
    if (named(coordinates, name)) return "coordinates";
    if (coordinates.some((c) => name === `d${c.name}/dt`)) return "velocities";
    if (named(controls, name)) return "controls";
    return /force /.test(name) ? "contact forces" : "outputs";
  };
  const groups = new Map();
  for (const { name, unit, values } of readings) {
    const title = `${kind(name)}${unit && ` [${unit}]`}`;
    if (!groups.has(title)) groups.set(title, []);
    const series = groups.get(title);
    series.push({ name: name.replace(/^force /, ""), values, colour: series.length });
  }
  return [...groups].map(([title, series]) => ({ title, series }));
};

const showMotion = (motion) => {
  const [time, playing] = [page.player?.time() ?? 0, page.player?.playing() ?? false];
  page.player?.close();
  page.plots?.close();
  [page.player, page.plots] = [null, null];
  const drawn = motion?.bodies !== undefined;
  element("player").replaceChildren(...(drawn ? [element("player-elements").content.cloneNode(true)] : []));
  element("nothing").hidden = drawn;
  if (!motion) {
    element("plots").replaceChildren();
    return;
  }
  if (drawn) page.player = playFrames(motion);
  page.plots = drawPlots(element("plots"), groupsOf(motion), motion, (t) => {
    page.player?.pause();
    if (page.player) page.player.show(t);
    else page.plots.show(t);
  });
  page.player?.show(Math.min(time, motion.time[motion.time.length - 1]));
  if (playing) page.player?.toggle();
};

const showAnswer = ({ answer, seconds }) => {
  if (answer.refusal || answer.mistakes) {
    say(answer.refusal ?? "the scene has mistakes", true);
    return;
  }
  page.answer = answer;
  old(false);
  const { status, diagnosis, notes } = answer.result;
  const why = diagnosis?.message ?? diagnosis;
  const took = seconds < 1 ? `${Math.ceil(1000 * seconds)} ms` : `${seconds.toFixed(1)} s`;
  const done = page.task === "solve" && status === "solved" ? `solved, certificate ${answer.result.stationarity}` : status;
  say(`${done} in ${took}${why ? `: ${why}` : ""}`, status !== "solved");
  const rows = answer.facts.map((cells) => make("tr", {}, ...cells.map((cell) => make("td", { textContent: cell }))));
  element("facts").replaceChildren(...rows);
  element("notes").replaceChildren(...notes.map((note) => make("li", { textContent: note })));
  element("json").hidden = false;
  showMotion(answer.motion);
};

const showRun = (running) => {
  element("stop").disabled = !running;
  element("progress").hidden = !running;
  element("progress").removeAttribute("value");
};
const run = async (task) => {
  page.task = task;
  page.again = false;
  showCommand();
  say(task === "solve" ? "solving" : "simulating");
  showRun(true);
  const outcome = await runner.ask(request(task, settings(task)), (share, doing) => {
    if (Number.isFinite(share)) element("progress").value = share;
    say(doing);
  });
  if (runner.busy) return;
  showRun(false);
  if (outcome) showAnswer(outcome);
  else say("stopped", true);
  if (page.again) run("simulate");
};
// Simulates what was changed, after the run under way.
const simulateSoon = () => {
  showCommand();
  if (page.scene === null) return;
  if (!runner.busy) run("simulate");
  else if (page.task === "simulate") page.again = true;
};

const showScene = (scene) => {
  page.scene = scene;
  element("verdict").textContent = scene.title === "a scene from a file" ? "" : scene.title;
  element("solve").disabled = !scene.solvable;
  element("solve").title = scene.solvable ? "Ctrl+Shift+Enter" : "the scene declares no objective";
  showParameters(scene.parameters);
  element("equations").replaceChildren(...scene.equations.map(mathOf));
  showCommand();
};
// Checks the text; without mistakes the motion follows. Where the check is stopped by a run, another one follows it.
const check = async (thenRun, caller = checker) => {
  const asked = request("check");
  const outcome = await caller.ask(asked);
  // Another check follows an edit.
  if (asked.text !== text.value) return;
  if (!outcome) {
    if (caller === runner) check(false);
    return;
  }
  const { answer } = outcome;
  if (answer.refusal) {
    say(answer.refusal, true);
    return;
  }
  showMessages(answer);
  if (answer.mistakes) {
    page.scene = null;
    old(true);
    say(`${answer.mistakes.filter(({ warning }) => !warning).length} to mend`, true);
    return;
  }
  showScene(answer.scene);
  if (thenRun) simulateSoon();
  else if (page.answer?.motion) showMotion(page.answer.motion);
};

let waiting = 0;
const edited = () => {
  page.edits.set(page.name, text.value);
  element("original").hidden = !shipped.some(({ name, text: own }) => name === page.name && own !== text.value);
  paint();
  clearTimeout(waiting);
  waiting = setTimeout(() => check(true), 250);
};

// Shows a scene from its beginning; its first run has the scene that its check has derived.
const open = (name, content, values = {}) => {
  clearTimeout(waiting);
  page.name = name;
  page.values = new Map(Object.entries(values));
  page.player?.close();
  [page.scene, page.player] = [null, null];
  text.value = content;
  text.scrollTop = 0;
  text.setSelectionRange(0, 0);
  const scenes = element("scenes");
  if (![...scenes.options].some((option) => option.value === name)) scenes.append(make("option", { value: name, textContent: name }));
  scenes.value = name;
  element("horizon").value = "";
  element("original").hidden = !shipped.some((scene) => scene.name === name && scene.text !== content);
  paint();
  checker.stop();
  check(true, runner);
};
const choose = (name) => {
  const original = shipped.find((scene) => scene.name === name)?.text ?? "";
  open(name, page.edits.get(name) ?? original);
};

// A link that holds the scene: name, text and changed parameters, compressed. A short link unpacks to gigabytes if it was made to [bytes].
const mostUnpacked = 4e6;
const through = async (bytes, stream) => {
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  const parts = [];
  let length = 0;
  for (let read = await reader.read(); !read.done; read = await reader.read()) {
    length += read.value.length;
    if (length > mostUnpacked) {
      reader.cancel().catch(() => {});
      throw new RangeError(`a link holds at most ${mostUnpacked} bytes`);
    }
    parts.push(read.value);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
};
const packLink = async () => {
  const content = JSON.stringify({ name: page.name, text: text.value, values: Object.fromEntries(page.values) });
  const packed = await through(new TextEncoder().encode(content), new CompressionStream("deflate-raw"));
  const base64 = btoa(Array.from(packed, (byte) => String.fromCharCode(byte)).join(""));
  return `#scene=${base64.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "")}`;
};
const unpackLink = async (hash) => {
  const packed = /^#scene=([\w-]+)$/.exec(hash);
  if (!packed) return null;
  const bytes = Uint8Array.from(atob(packed[1].replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
  const { name, text: content, values } = JSON.parse(new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate-raw"))));
  if (typeof name !== "string" || typeof content !== "string") return null;
  const numbers = Object.entries(values ?? {}).filter(([, value]) => typeof value === "number");
  return { name: name.replaceAll(/[^\w-]/g, "-"), content, values: Object.fromEntries(numbers) };
};
const save = (name, content, type) => {
  const link = make("a", { href: URL.createObjectURL(new Blob([content], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
};

text.addEventListener("input", edited);
text.addEventListener("scroll", scroll);
element("scenes").addEventListener("change", ({ target }) => choose(target.value));
element("simulate").addEventListener("click", () => run("simulate"));
element("solve").addEventListener("click", () => run("solve"));
element("stop").addEventListener("click", () => runner.stop());
element("reset").addEventListener("click", () => {
  page.values.clear();
  if (page.scene) showParameters(page.scene.parameters);
  simulateSoon();
});
element("original").addEventListener("click", () => {
  page.edits.delete(page.name);
  choose(page.name);
});
element("format").addEventListener("click", async () => {
  clearTimeout(waiting);
  const outcome = await checker.ask(request("fmt"));
  if (!outcome?.answer.text) {
    check(true);
    return;
  }
  if (outcome.answer.text === text.value) return;
  // As if it were typed, so that it can be undone.
  text.focus();
  text.select();
  if (!document.execCommand("insertText", false, outcome.answer.text)) {
    text.value = outcome.answer.text;
    edited();
  }
});
for (const id of ["method", "horizon"]) element(id).addEventListener("change", simulateSoon);
element("intervals").addEventListener("change", showCommand);
element("player").addEventListener("shown", ({ detail }) => page.plots?.show(detail));
element("json").addEventListener("click", () => {
  save(`${page.name}.json`, `${JSON.stringify(page.answer.result)}\n`, "application/json");
});
element("save").addEventListener("click", () => save(`${page.name}.hang`, text.value, "text/plain"));
element("open").addEventListener("click", () => element("file").click());
element("file").addEventListener("change", async ({ target }) => {
  const [file] = target.files;
  if (file) open(file.name.replace(/\.hang$/, "").replaceAll(/[^\w-]/g, "-"), await file.text());
  target.value = "";
});
element("link").addEventListener("click", async () => {
  history.replaceState(null, "", await packLink());
  const copied = await navigator.clipboard?.writeText(location.href).then(() => true, () => false);
  say(copied ? "link copied" : "the address of this page now holds the scene");
});
addEventListener("hashchange", async () => {
  const linked = await unpackLink(location.hash).catch(() => null);
  if (linked) open(linked.name, linked.content, linked.values);
});
document.addEventListener("keydown", (event) => {
  if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) {
    event.preventDefault();
    if (!event.shiftKey) run("simulate");
    else if (!element("solve").disabled) run("solve");
  } else if (event.key === "Escape" && runner.busy) {
    runner.stop();
  }
});

(async () => {
  element("scenes").append(...shipped.map(({ name }) => make("option", { value: name, textContent: name })));
  say("loading");
  compiled.catch((error) => say(`this browser does not run the module: ${error}`, true));
  const linked = await unpackLink(location.hash).catch(() => null);
  if (linked) open(linked.name, linked.content, linked.values);
  else choose(shipped[0].name);
})();
