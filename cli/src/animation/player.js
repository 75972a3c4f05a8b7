"use strict";
// Plays the frames in the elements of the player, which are fresh. Several players on a page are told apart by what their names end
// with; one that plays by itself begins when it is seen, and begins again until somebody takes over.
const playFrames = (data, ending = "", itself = false) => {
  const element = (id) => document.getElementById(id + ending);
  const stage = element("stage");
  const [play, scrub, clock, rate] = ["play", "scrub", "clock", "rate"].map(element);
  const colours = ["#2f7ed8", "#d9601a", "#2a9d5c", "#9a63d8", "#d6409f", "#0e9aa7"];
  const grey = "#8a919e";
  const red = "#c2483d";
  const first = data.time[0];
  const last = data.time[data.time.length - 1];

  // From the plane to the drawing: equal scales, the vertical axis upwards.
  const [left, right, bottom, top] = data.frame;
  const width = 900;
  const scale = Math.min(width / (right - left), 560 / (top - bottom));
  const tall = (top - bottom) * scale;
  const longest = Math.max(40, Math.min(110, 0.4 * tall));
  // Contact forces mostly point upwards; the one at the top of the picture is to be seen, too.
  const room = data.largest_force > 0 || data.largest_torque > 0 ? 0.8 * longest : 0;
  const height = tall + room;
  const shift = (width - (right - left) * scale) / 2;
  const x = (y) => shift + (y - left) * scale;
  const y = (z) => room + (top - z) * scale;
  stage.setAttribute("viewBox", `0 0 ${width} ${height}`);

  const draw = (name, attributes, parent = stage) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    parent.append(node);
    return node;
  };
  const set = (node, attributes) => {
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  };
  // The corners of a spring between two points of the drawing.
  const coils = ([x0, y0], [x1, y1]) => {
    const [u, v, turns] = [x1 - x0, y1 - y0, 12];
    const across = 6 / Math.max(Math.hypot(u, v), 1);
    const turn = (_, k) => {
      const [share, side] = [(k + 1.5) / (turns + 2), k % 2 === 0 ? across : -across];
      return [x0 + share * u - side * v, y0 + share * v + side * u];
    };
    return [[x0, y0], ...Array.from({ length: turns }, turn), [x1, y1]];
  };
  // Letters have one size on the screen, however wide the stage is.
  const write = (text, attributes) => {
    const node = draw("text", { fill: "currentColor", class: "name", "aria-hidden": "true", ...attributes });
    node.textContent = text;
    return node;
  };
  const size = () => stage.style.setProperty("--letter", `${(13 * width) / Math.max(stage.clientWidth, 200)}px`);
  new ResizeObserver(size).observe(stage);
  size();
  const points = (list) => list.map(([a, b]) => `${x(a).toFixed(2)},${y(b).toFixed(2)}`).join(" ");

  data.ground.forEach((line) => {
    const ground = draw("polyline", { points: points(line.points), fill: "none", stroke: grey, "stroke-width": 2.5 });
    draw("title", {}, ground).textContent = line.name;
    // The name stands where the line is in the picture, at its right end.
    const seen = line.points.filter(([a, b]) => a > left && a < right - 0.06 * (right - left) && b > bottom && b < top);
    if (seen.length) {
      const [a, b] = seen[Math.floor(0.97 * (seen.length - 1))];
      write(line.name, { x: x(a), y: y(b), dy: "1.2em", "text-anchor": "end", opacity: 0.75 });
    }
  });
  // A length to compare with: the largest round one below a fifth of the picture.
  const unit = /\[(.*)\]/.exec(data.axes[0])?.[1] ?? "";
  const fifth = (right - left) / 5;
  const power = 10 ** Math.floor(Math.log10(fifth));
  const length = [5, 2, 1].map((k) => k * power).find((k) => k <= fifth);
  const ends = [[12, height - 18], [12, height - 10], [12 + length * scale, height - 10], [12 + length * scale, height - 18]];
  draw("polyline", { points: ends.join(" "), fill: "none", stroke: grey, "stroke-width": 2, "data-scale": length });
  write(`${Number(length.toPrecision(2))} ${unit}`, { x: 12, y: height - 24 });
  // What was published: a dot for every place that was plotted, and a ring that goes along them.
  const published = data.published ?? [];
  published.forEach(({ positions }) => positions.forEach(([a, b]) =>
    draw("circle", { cx: x(a), cy: y(b), r: 1.8, fill: "currentColor", opacity: 0.45, class: "published" })));
  const rings = (published[0]?.positions ?? []).map(() =>
    draw("circle", { r: 11, fill: "none", stroke: "currentColor", "stroke-width": 2, class: "published" }));
  const ring = (time) => {
    const next = published.findIndex((point) => point.time >= time);
    const [from, to] = [published[Math.max(next - 1, 0)], published[next]];
    rings.forEach((node, body) => {
      if (!to) return node.setAttribute("visibility", "hidden");
      const share = to.time > from.time ? (time - from.time) / (to.time - from.time) : 0;
      const [a, b] = [0, 1].map((axis) => from.positions[body][axis] + share * (to.positions[body][axis] - from.positions[body][axis]));
      return set(node, { cx: x(a), cy: y(b), visibility: "visible" });
    });
  };
  const trails = data.bodies.map((_, body) =>
    draw("polyline", { fill: "none", stroke: colours[body % colours.length], "stroke-width": 1.5, opacity: 0.6 }));
  const lines = data.springs.map((spring) =>
    draw("polyline", { fill: "none", stroke: grey, "stroke-width": spring ? 1.5 : 3, "stroke-linejoin": "round" }));
  // A point is a dot of a fixed size; a body with an outline is drawn to scale, with a line to its rim if it rolls.
  const bodies = data.bodies.map(({ name, outline, spoke }, body) => {
    const colour = colours[body % colours.length];
    const shape = outline.length === 0
      ? draw("circle", { r: 8, fill: colour, "data-body": name })
      : draw("polygon", { fill: colour, "fill-opacity": 0.35, stroke: colour, "stroke-width": 2, "data-body": name });
    draw("title", {}, shape).textContent = name;
    // One body needs no name.
    const label = data.bodies.length > 1 && data.bodies.length < 6 ? write(name, { "text-anchor": "middle" }) : null;
    return { shape, outline, label, spoke: spoke ? draw("line", { stroke: colour, "stroke-width": 2 }) : null };
  });
  const arrows = data.contacts.map((name) => {
    const arrow = draw("path", { fill: "none", stroke: red, "stroke-width": 3, "data-contact": name });
    const title = draw("title", {}, arrow);
    title.textContent = `force of ${name}`;
    return { arrow, title, name };
  });
  // What the longest arrow stands for.
  const largest = [["force", data.largest_force], ["torque", data.largest_torque]].map(([what, size], kind) =>
    size > 0 ? `largest ${what} ${Number(size.toPrecision(3))} ${data.units[kind]}`.trim() : "").filter(Boolean);
  if (largest.length) write(largest.join(", "), { x: width - 12, y: height - 24, "text-anchor": "end" });
  // Parts are bodies, then lines; one of a picture with lines alone has no name.
  const part = (on) => (data.bodies[on] ? ` on ${data.bodies[on].name}` : "");
  // A force is a straight arrow; a torque one around its place, by at most three quarters of a turn.
  const straight = ([x0, y0], force) => {
    const length = Math.hypot(...force);
    const pixels = (longest * length) / data.largest_force;
    const [u, v] = [force[0] / length, -force[1] / length];
    const [x1, y1] = [x0 + pixels * u, y0 + pixels * v];
    const head = Math.min(9, pixels / 2);
    const side = (turn) => `${x1 - head * (u + turn * v)} ${y1 - head * (v - turn * u)}`;
    return `M${x0} ${y0}L${x1} ${y1}M${side(0.6)}L${x1} ${y1}L${side(-0.6)}`;
  };
  const bent = ([x0, y0], torque) => {
    const [radius, sense] = [22, Math.sign(torque)];
    const angle = 1.5 * Math.PI * Math.min(1, Math.abs(torque) / data.largest_torque);
    const point = (at, r = radius) => [x0 + r * Math.cos(at), y0 - sense * r * Math.sin(at)];
    const head = Math.min(9, (radius * angle) / 2) / radius;
    const [from, to] = [point(0), point(angle)];
    const side = (r) => point(angle - head, r).join(" ");
    const large = angle > Math.PI ? 1 : 0;
    return `M${from.join(" ")}A${radius} ${radius} 0 ${large} ${sense > 0 ? 0 : 1} ${to.join(" ")}`
      + `M${side(radius * (1 + 0.6 * head))}L${to.join(" ")}L${side(radius * (1 - 0.6 * head))}`;
  };

  const readings = data.readings.map(({ name, unit, values }) => {
    const row = document.createElement("div");
    const [term, value] = ["dt", "dd"].map((tag) => document.createElement(tag));
    term.textContent = name;
    row.append(term, value);
    element("readings").append(row);
    return { value, unit, values };
  });

  // The last frame at or before a time.
  const frameAt = (time) => {
    let [low, high] = [0, data.time.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (data.time[middle] <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  };

  // For screen readers: what is shown, and each event when it is passed.
  const names = data.bodies.map(({ name }) => name).join(", ");
  stage.setAttribute("aria-label", `the motion of ${names} over ${last.toFixed(2)} s, with ${data.events.length} events`);
  const pass = (from, to) => {
    const passed = data.events.findLast(({ time }) => time > from && time <= to);
    if (passed) element("said").textContent = `${passed.label} at ${passed.time.toFixed(2)} s`;
  };

  let now = first;
  const show = (time) => {
    pass(now, time);
    now = Math.max(time, first);
    // A slider keeps fewer digits than the end has.
    if (now > last - 1e-9 * (last - first)) now = last;
    const k = frameAt(now);
    const next = Math.min(k + 1, data.time.length - 1);
    const share = next > k ? (now - data.time[k]) / (data.time[next] - data.time[k]) : 0;
    const between = (a, b) => a + share * (b - a);
    const positions = data.positions[k].map((position, body) =>
      position.map((value, axis) => between(value, data.positions[next][body][axis])));
    positions.forEach(([a, b], body) => {
      const { shape, outline, label, spoke } = bodies[body];
      if (label) set(label, { x: x(a), y: y(b) - 14 });
      const angle = between(data.angles[k][body], data.angles[next][body]);
      const [sine, cosine] = [Math.sin(angle), Math.cos(angle)];
      const place = ([u, v]) => [a + u * cosine - v * sine, b + u * sine + v * cosine];
      if (outline.length === 0) set(shape, { cx: x(a), cy: y(b) });
      else set(shape, { points: points(outline.map(place)) });
      if (spoke) {
        const [u, v] = place(outline[0]);
        set(spoke, { x1: x(a), y1: y(b), x2: x(u), y2: y(v) });
      }
      const trail = data.positions.slice(0, k + 1).map((row) => row[body]);
      trails[body].setAttribute("points", points([...trail, [a, b]]));
    });
    lines.forEach((line, index) => {
      const ends = [0, 1].map((end) => [0, 1].map((axis) =>
        between(data.ends[k][index][end][axis], data.ends[next][index][end][axis])));
      const [from, to] = ends.map(([a, b]) => [x(a), y(b)]);
      const corners = data.springs[index] ? coils(from, to) : [from, to];
      set(line, { points: corners.map(([a, b]) => `${a.toFixed(2)},${b.toFixed(2)}`).join(" ") });
    });
    data.forces[k].forEach((load, contact) => {
      const { arrow, title, name } = arrows[contact];
      if (!load) return arrow.setAttribute("d", "");
      // It goes with what it acts on until the next frame.
      const ahead = data.forces[next][contact] ?? load;
      const at = load.at.map((value, axis) => (ahead.on === load.on ? between(value, ahead.at[axis]) : value));
      const place = [x(at[0]), y(at[1])];
      const turns = load.torque !== 0;
      const size = turns ? Math.abs(load.torque) : Math.hypot(...load.force);
      const what = `${turns ? "torque" : "force"} of ${name}${part(load.on)}`;
      title.textContent = `${what}: ${size.toPrecision(4)} ${data.units[turns ? 1 : 0]}`.trim();
      return set(arrow, { d: turns ? bent(place, load.torque) : straight(place, load.force), "data-on": load.on });
    });
    readings.forEach(({ value, unit, values }) => {
      const reading = values[k];
      value.textContent = reading === undefined || reading === null ? "-" : `${(Math.abs(reading) < 5e-5 ? 0 : reading).toFixed(4)} ${unit}`;
    });
    ring(now);
    scrub.value = now;
    clock.value = `${now.toFixed(4)} s of ${last.toFixed(4)} s`;
    stage.dispatchEvent(new CustomEvent("shown", { bubbles: true, detail: now }));
  };

  // The rate at which the motion takes about five seconds is chosen first.
  const rates = [["1/16", 1 / 16], ["1/8", 1 / 8], ["1/4", 1 / 4], ["1/2", 1 / 2], ["1", 1], ["2", 2]];
  const distance = ([, value]) => Math.abs(Math.log((last - first) / value / 5));
  const chosen = rates.reduce((best, other) => (distance(other) < distance(best) ? other : best));
  rates.forEach(([name, value]) => {
    const option = document.createElement("option");
    option.value = value;
    option.textContent = `${name} x`;
    option.selected = value === chosen[1];
    rate.append(option);
  });

  let playing = false;
  let before = 0;
  const run = (on) => {
    playing = on;
    play.textContent = on ? "pause" : "play";
  };
  const step = (instant) => {
    if (!playing) return;
    show(now + ((instant - before) / 1000) * Number(rate.value));
    before = instant;
    if (now >= last) {
      run(false);
      if (itself) setTimeout(() => { if (itself && !playing) start(); }, 1200);
    } else requestAnimationFrame(step);
  };
  const start = () => {
    run(true);
    if (now >= last) show(first);
    before = performance.now();
    requestAnimationFrame(step);
  };
  play.addEventListener("click", () => {
    itself = false;
    if (playing) run(false);
    else start();
  });
  scrub.min = first;
  scrub.max = last;
  scrub.addEventListener("input", () => {
    itself = false;
    run(false);
    show(Number(scrub.value));
  });
  data.events.forEach(({ time, label }) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = `${label} ${time.toFixed(4)} s`;
    button.addEventListener("click", () => {
      itself = false;
      run(false);
      show(time);
    });
    element("events").append(button);
  });
  show(first);
  const pause = () => { if (playing) play.click(); };
  const toggle = () => play.click();

  // Keys work wherever the focus is, but in fields that take them.
  const moves = {
    " ": toggle,
    ArrowLeft: () => show(now - (last - first) / 200),
    ArrowRight: () => show(Math.min(last, now + (last - first) / 200)),
    Home: () => show(first),
    End: () => show(last),
    ",": () => show(data.events.findLast(({ time }) => time < now)?.time ?? first),
    ".": () => show(data.events.find(({ time }) => time > now)?.time ?? last),
  };
  const keys = new AbortController();
  document.addEventListener("keydown", (event) => {
    const taken = event.target.closest("input, select, textarea, button, summary, a, [contenteditable]");
    if (taken || event.ctrlKey || event.metaKey || event.altKey || !moves[event.key]) return;
    event.preventDefault();
    if (event.key !== " ") pause();
    moves[event.key]();
  }, { signal: keys.signal });
  if (itself) start();
  play.title = "space: play or pause; arrows: step; comma and full stop: events";
  const close = () => {
    pause();
    keys.abort();
  };
  return { show, time: () => now, playing: () => playing, pause, toggle, close };
};

{
  // Who asked for less motion presses the button.
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  document.querySelectorAll('script[id^="frames"]').forEach((frames) =>
    playFrames(JSON.parse(frames.textContent), frames.id.slice("frames".length), "plays" in frames.dataset && !still));
}
