"use strict";
const shipped = JSON.parse(element("shipped").textContent);
const original = (name) => shipped.find((scene) => scene.name === name);

// The module, compiled once, while it is decoded and unpacked; every worker runs its own copy.
const compiled = (async () => {
  const { body } = await unpacked("module");
  return WebAssembly.compileStreaming(new Response(body, { headers: { "Content-Type": "application/wasm" } }));
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
  pasts: new Map(),
  task: "simulate",
  // What to do when the run under way ends: nothing, or a task.
  again: null,
  // Whether the next motion is to play at once.
  arrives: true,
  answer: null,
  player: null,
  plots: null,
};

const say = (words, bad = false) => {
  element("status").value = words;
  element("status").title = words;
  element("status").classList.toggle("bad", bad);
};
const notice = (words, bad = false) => {
  element("kept").textContent = words;
  element("kept").classList.toggle("bad", bad);
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
      changed();
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
  const { coordinates, states, controls } = page.scene ?? { coordinates: [], states: [], controls: [] };
  const named = (list, name) => list.some((entry) => entry.name === name);
  const kind = (name) => {
    if (named(coordinates, name)) return "coordinates";
    if (coordinates.some((c) => name === `d${c.name}/dt`)) return "velocities";
    if (named(states, name)) return "states";
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

const still = matchMedia("(prefers-reduced-motion: reduce)");
const showMotion = (motion) => {
  const [time, playing] = page.arrives ? [0, !still.matches] : [page.player?.time() ?? 0, page.player?.playing() ?? false];
  page.arrives = false;
  page.player?.close();
  page.plots?.close();
  [page.player, page.plots] = [null, null];
  const drawn = motion?.bodies !== undefined;
  element("player").replaceChildren(...(drawn ? [element("player-elements").content.cloneNode(true)] : []));
  element("nothing").hidden = drawn;
  element("exports").hidden = !motion;
  for (const button of element("exports").querySelectorAll("button")) {
    const { export: what } = button.dataset;
    button.hidden = !drawn && (what === "film" || what.startsWith("motion"));
    if (what === "film") button.disabled = !exportsOf.kind();
  }
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

const took = (seconds) => (seconds < 1 ? `${Math.ceil(1000 * seconds)} ms` : `${seconds.toFixed(1)} s`);
const showAnswer = ({ answer, seconds }, warm) => {
  if (answer.refusal || answer.mistakes) {
    say(answer.refusal ?? "the scene has mistakes", true);
    return;
  }
  page.answer = answer;
  old(false);
  const { status, diagnosis, notes } = answer.result;
  const why = diagnosis?.message ?? diagnosis;
  const again = warm ? (answer.warm ? " again, from the plan before" : " again, from nothing") : "";
  const done = page.task === "solve" && status === "solved" ? `solved${again}, certificate ${answer.result.stationarity},` : `${status}${again}`;
  say(`${done} in ${took(seconds)}${why ? `: ${why}` : ""}`, status !== "solved");
  const rows = answer.facts.map((cells) => make("tr", {}, ...cells.map((cell) => make("td", { textContent: cell }))));
  element("facts").replaceChildren(...rows);
  element("notes").replaceChildren(...notes.map((note) => make("li", { textContent: note })));
  showMotion(answer.motion);
};

const showRun = (running) => {
  element("stop").disabled = !running;
  element("progress").hidden = !running;
  element("progress").removeAttribute("value");
};
// Runs a task; `warm`: from the plan before, where the module has one.
const run = async (task, warm = false) => {
  clearTimeout(resolving);
  page.task = task;
  page.again = null;
  showCommand();
  say(task === "simulate" ? "simulating" : warm ? "solving again" : "solving");
  showRun(true);
  const outcome = await runner.ask({ ...request(task, settings(task)), warm }, (share, doing) => {
    if (Number.isFinite(share)) element("progress").value = share;
    say(doing);
  });
  if (runner.busy) return;
  showRun(false);
  if (outcome) showAnswer(outcome, warm);
  else say("stopped", true);
  if (page.again) run(page.again, page.again === "solve");
};
const start = (task) => {
  page.arrives = true;
  run(task);
};
const soon = (task) => {
  if (!runner.busy) run(task, task === "solve");
  else page.again = task;
};
let resolving = 0;
// A pause of a slider that is long enough to solve again [ms].
const settled = 350;
// What was changed is computed anew, after the run under way: simulated, or solved from its plan where an optimum is shown.
const changed = () => {
  showCommand();
  if (page.scene === null) return;
  if (page.task === "solve" && page.scene.solvable) {
    old(true);
    if (!runner.busy) say("to be solved again");
    clearTimeout(resolving);
    resolving = setTimeout(() => soon("solve"), settled);
  } else {
    soon("simulate");
  }
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
// The page about a mistake, read beside the editor. It waits for a check under way.
const explain = async (code) => {
  while (checker.busy) await new Promise((resolve) => setTimeout(resolve, 20));
  const outcome = await checker.ask({ call: "page", name: code, text: "" });
  if (outcome?.answer.text) reading.page(code, outcome.answer.text);
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
  showMessages(answer, explain);
  if (answer.mistakes) {
    page.scene = null;
    old(true);
    say(`${answer.mistakes.filter(({ warning }) => !warning).length} to mend`, true);
    return;
  }
  showScene(answer.scene);
  if (thenRun) soon("simulate");
  else if (page.answer?.motion) showMotion(page.answer.motion);
};

// Names of scenes: those that are kept here, and those that came with the page, by groups.
const showNames = () => {
  const own = store.names().filter((name) => !original(name));
  const groups = new Map(own.length ? [["yours", own]] : []);
  for (const { name, group } of shipped) groups.set(group, [...(groups.get(group) ?? []), name]);
  const entries = [...groups].map(([label, names]) => make("optgroup", { label },
    ...names.map((name) => make("option", { value: name, textContent: original(name) && store.text(name) !== undefined ? `${name} (edited)` : name }))));
  element("scenes").replaceChildren(...entries);
  element("scenes").value = page.name;
};
const taken = (name) => original(name) !== undefined || store.text(name) !== undefined;
const present = (name) => store.text(name) ?? original(name)?.text;
const past = () => {
  if (!page.pasts.has(page.name)) page.pasts.set(page.name, new Past(text.value));
  return page.pasts.get(page.name);
};
const showTools = () => {
  const came = original(page.name);
  element("original").hidden = came === undefined || came.text === text.value;
  element("delete").hidden = came !== undefined;
  element("rename").hidden = false;
  element("rename").title = came ? "keep it under a name of its own" : "give it another name";
  element("undo").disabled = !past().has(-1);
  element("redo").disabled = !past().has(1);
};
// Keeps the text under its name; what came with the page needs no keeping.
const keep = () => {
  const known = store.text(page.name) !== undefined;
  const came = original(page.name)?.text === text.value;
  const kept = came ? store.remove(page.name) : store.set(page.name, text.value);
  if (known === came) showNames();
  if (!kept) notice("this browser keeps nothing after this visit: save the scene as a file", true);
  else notice(came ? "" : "kept in this browser");
};
let waiting = 0;
const edited = (noted = false) => {
  if (!noted) past().note(text.value);
  keep();
  showTools();
  paint();
  clearTimeout(waiting);
  waiting = setTimeout(() => check(true), 250);
};
const replaceText = (content, noted = false) => {
  const caret = text.selectionStart;
  text.value = content;
  text.setSelectionRange(Math.min(caret, content.length), Math.min(caret, content.length));
  edited(noted);
};
const travel = (by) => {
  past().note(text.value);
  const other = past().go(by);
  if (other !== null) replaceText(other, true);
};

// Shows a scene from its beginning; its first run has the scene that its check has derived.
const open = (name, content, values = {}) => {
  clearTimeout(waiting);
  clearTimeout(resolving);
  page.name = name;
  page.values = new Map(Object.entries(values));
  page.player?.close();
  [page.scene, page.player, page.task, page.arrives] = [null, null, "simulate", true];
  text.value = content;
  text.scrollTop = 0;
  text.setSelectionRange(0, 0);
  store.open(name);
  showNames();
  element("horizon").value = "";
  const { question, answer } = original(name) ?? {};
  element("asked").hidden = !question;
  if (question) element("asked").replaceChildren(make("summary", { textContent: question }), answer);
  past().note(content);
  showTools();
  paint();
  checker.stop();
  check(true, runner);
};
const choose = (name) => {
  notice(store.text(name) === undefined ? "" : "kept in this browser");
  open(name, present(name) ?? "");
};
// Opens a text that comes from elsewhere under its name, or, where another scene has that, under one that is free.
const bring = (wanted, content, values = {}) => {
  const name = present(wanted) === content ? wanted : freeName(wanted || "scene", taken);
  if (present(name) !== content) {
    page.pasts.delete(name);
    const kept = store.set(name, content);
    notice(kept ? "kept in this browser" : "this browser keeps nothing after this visit: save the scene as a file", !kept);
  }
  open(name, content, values);
};
const openLink = async () => {
  try {
    const linked = await unpackLink(location.hash);
    if (!linked) return false;
    // The scene is kept here now, and a visit to come shows what was made of it.
    history.replaceState(null, "", location.pathname + location.search);
    bring(linked.name, linked.text, linked.values);
    return true;
  } catch (error) {
    notice(`the link in the address shows no scene: ${error.message}`, true);
    return false;
  }
};

// The gallery: scenes by groups, with picture, question and answer.
const showGallery = async () => {
  const groups = new Map();
  for (const scene of shipped) groups.set(scene.group, [...(groups.get(scene.group) ?? []), scene]);
  const pictures = await (await unpacked("pictures")).json();
  const card = ({ name, title, about, question, answer }) => {
    const button = make("button", { type: "button", className: "card" });
    button.dataset.scene = name;
    const drawing = make("span", { className: "picture" });
    drawing.innerHTML = pictures[shipped.findIndex((scene) => scene.name === name)];
    drawing.setAttribute("aria-hidden", "true");
    const told = question ? [make("span", { className: "question", textContent: question }), make("span", { className: "quiet", textContent: answer })] : [];
    button.append(drawing, make("strong", { textContent: name }), make("span", { textContent: title }), make("span", { className: "about", textContent: about }), ...told);
    button.addEventListener("click", () => {
      element("gallery").close();
      choose(name);
    });
    return button;
  };
  if (!element("cards").firstChild) {
    element("cards").append(...[...groups].map(([group, scenes]) => make("section", {}, make("h3", { textContent: group }), make("div", { className: "cards" }, ...scenes.map(card)))));
  }
  element("gallery").showModal();
};

const save = (name, content, type) => {
  const blob = content instanceof Blob ? content : new Blob([content], { type });
  const link = make("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
};
let filming = false;
// What can be saved of a motion, by the names of the buttons: the ending of the file, and its content.
const saved = {
  "motion-svg": () => ["svg", exportsOf.standalone(element("stage"))],
  "motion-png": async () => ["png", await exportsOf.png(exportsOf.standalone(element("stage")))],
  "curves-svg": () => ["curves.svg", exportsOf.stacked(page.plots.figures())],
  "curves-png": async () => ["curves.png", await exportsOf.png(exportsOf.stacked(page.plots.figures()))],
  csv: () => ["csv", exportsOf.csv(page.answer.motion)],
  json: () => ["json", `${JSON.stringify(page.answer.result)}\n`],
  film: async () => {
    const { time } = page.answer.motion;
    const player = page.player;
    player.pause();
    filming = true;
    const film = await exportsOf.film(player, element("stage"), {
      first: time[0], last: time[time.length - 1], speed: Number(element("rate").value),
      tell: (share) => say(`filming, ${Math.round(100 * share)} % (press film once more to stop)`),
      stopped: () => !filming || page.player !== player,
    });
    filming = false;
    if (!film) return null;
    return [film.type === "video/mp4" ? "mp4" : "webm", film];
  },
};
const types = { svg: "image/svg+xml", csv: "text/csv", json: "application/json" };
const exportAs = async (what) => {
  if (what === "film" && filming) {
    filming = false;
    return null;
  }
  const made = await saved[what]();
  if (!made) {
    say("filming stopped", true);
    return null;
  }
  const [ending, content] = made;
  save(`${page.name}.${ending}`, content, types[ending.split(".").pop()]);
  say(`saved ${page.name}.${ending}`);
  return content;
};

text.addEventListener("input", () => edited());
text.addEventListener("scroll", scroll);
text.addEventListener("beforeinput", (event) => {
  const by = { historyUndo: -1, historyRedo: 1 }[event.inputType];
  if (by === undefined) return;
  event.preventDefault();
  travel(by);
});
text.addEventListener("keydown", (event) => {
  if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
  const key = event.key.toLowerCase();
  const by = key === "z" ? (event.shiftKey ? 1 : -1) : key === "y" ? 1 : 0;
  if (!by) return;
  event.preventDefault();
  travel(by);
});
element("undo").addEventListener("click", () => travel(-1));
element("redo").addEventListener("click", () => travel(1));
element("scenes").addEventListener("change", ({ target }) => choose(target.value));
element("choose").addEventListener("click", showGallery);
element("leave").addEventListener("click", () => element("gallery").close());
element("simulate").addEventListener("click", () => start("simulate"));
element("solve").addEventListener("click", () => start("solve"));
element("stop").addEventListener("click", () => runner.stop());
element("reset").addEventListener("click", () => {
  page.values.clear();
  if (page.scene) showParameters(page.scene.parameters);
  changed();
});
element("new").addEventListener("click", () => {
  const name = freeName("scene", taken);
  bring(name, JSON.parse(element("template").textContent).replaceAll("NAME", `${name}.hang`));
  text.focus();
});
element("rename").addEventListener("click", () => {
  const name = cleanName(prompt("name of the scene", freeName(page.name, taken)) ?? "");
  if (!name || name === page.name) return;
  if (taken(name)) {
    notice(`there is a scene ${name} already; choose another name`, true);
    return;
  }
  const [before, content, values] = [page.name, text.value, Object.fromEntries(page.values)];
  page.pasts.set(name, past());
  page.pasts.delete(before);
  store.set(name, content);
  store.remove(before);
  open(name, content, values);
  notice("kept in this browser");
});
element("delete").addEventListener("click", () => {
  if (!confirm(`Delete ${page.name}? Save it as a file first if you may want it back.`)) return;
  page.pasts.delete(page.name);
  store.remove(page.name);
  choose(shipped[0].name);
});
element("original").addEventListener("click", () => replaceText(original(page.name).text));
element("format").addEventListener("click", async () => {
  clearTimeout(waiting);
  const outcome = await checker.ask(request("fmt"));
  if (!outcome?.answer.text) check(true);
  else if (outcome.answer.text !== text.value) replaceText(outcome.answer.text);
});
for (const id of ["method", "horizon"]) element(id).addEventListener("change", () => {
  showCommand();
  if (page.scene) soon("simulate");
});
element("intervals").addEventListener("change", () => (page.task === "solve" ? changed() : showCommand()));
element("player").addEventListener("shown", ({ detail }) => page.plots?.show(detail));
element("exports").addEventListener("click", ({ target }) => {
  const what = target.dataset.export;
  if (what) exportAs(what).catch((error) => say(`this browser does not save it: ${error.message}`, true));
});
element("save").addEventListener("click", () => save(`${page.name}.hang`, text.value, "text/plain"));
element("open").addEventListener("click", () => element("file").click());
element("file").addEventListener("change", async ({ target }) => {
  const [file] = target.files;
  if (file) bring(cleanName(file.name), await file.text());
  target.value = "";
});
element("link").addEventListener("click", async () => {
  const hash = await packLink({ name: page.name, text: text.value, values: Object.fromEntries(page.values) });
  if (hash.length > mostPacked) {
    say("the scene is too long for a link; save it as a file", true);
    return;
  }
  history.replaceState(null, "", hash);
  const copied = await navigator.clipboard?.writeText(location.href).then(() => true, () => false);
  const where = location.protocol === "file:" ? "; others can open it once this page is on a web server" : "";
  say(`${copied ? "link copied" : "the address of this page now holds the scene"}${where}`);
});
reading.scenesGo((name, content) => {
  bring(name, content);
  text.scrollIntoView({ block: "nearest" });
});
addEventListener("hashchange", openLink);
// Another page has written.
addEventListener("storage", ({ key }) => { if (key === store.key) showNames(); });
document.addEventListener("keydown", (event) => {
  if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) {
    event.preventDefault();
    if (!event.shiftKey) start("simulate");
    else if (!element("solve").disabled) start("solve");
  } else if (event.key === "Escape" && runner.busy) {
    runner.stop();
  }
});

(async () => {
  say("loading");
  compiled.catch((error) => say(`this browser does not run the module: ${error}`, true));
  if (await openLink()) return;
  const last = store.last();
  const told = element("kept").textContent;
  choose(last !== null && present(last) !== undefined ? last : shipped[0].name);
  if (told) notice(told, true);
})();
