"use strict";
// Curves over time, as wide as there is room, with letters of one size.
const drawPlots = (() => {
  const left = 52;
  const top = 8;
  const bottom = 22;
  const draw = (name, attributes, parent) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    parent.append(node);
    return node;
  };

  // Round numbers between two others, about `count` of them.
  const ticks = (low, high, count) => {
    const raw = (high - low) / count;
    const size = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((k) => k * size).find((k) => k >= raw);
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const list = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) list.push(k * step);
    const far = Math.max(Math.abs(low), Math.abs(high));
    const text = (x) => (x === 0 ? "0" : far >= 1e5 || far < 1e-3 ? x.toExponential(1) : x.toFixed(Math.min(digits, 8)));
    return list.map((x) => [x, text(x)]);
  };

  const range = (series) => {
    let [low, high] = [Infinity, -Infinity];
    for (const { values } of series) {
      for (const value of values) {
        if (value === null) continue;
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }
    if (low > high) return [0, 1];
    const middle = Math.max(Math.abs(low), Math.abs(high));
    if (high - low <= 1e-12 * middle || high === low) {
      const room = middle > 0 ? 0.1 * middle : 1;
      return [low - room, high + room];
    }
    const room = 0.06 * (high - low);
    return [low - room, high + room];
  };

  // The value of a curve at a time: on the line between its points, after a jump that is right there.
  const valueAt = (time, values, t) => {
    let [low, high] = [0, time.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (time[middle] <= t) low = middle;
      else high = middle - 1;
    }
    const [a, b] = [values[low], values[low + 1]];
    if (a === null || a === undefined) return null;
    if (b === null || b === undefined || t <= time[low]) return a;
    return a + ((t - time[low]) / (time[low + 1] - time[low])) * (b - a);
  };
  const digits = (value) => {
    if (value === null) return "";
    const size = Math.abs(value);
    return size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(2) : value.toPrecision(4).replace(/^(-?\d+\.\d*?)0+$/, "$1").replace(/\.$/, "");
  };
  // Room for names and values at the right, the same for all, so that their axes are aligned.
  const roomFor = (groups, width) => {
    const longest = Math.max(...groups.flatMap(({ series }) => series.map(({ name }) => name.length)));
    return Math.min(0.4 * width, 12 + 6.6 * (longest + 8));
  };

  // One figure; `hover` is told where the pointer is, `go` where it is pressed.
  const plot = (figure, { series }, motion, room, { go, hover }) => {
    const svg = figure.querySelector("svg");
    const { time, events } = motion;
    const [first, last] = [time[0], time[time.length - 1]];
    const width = Math.max(220, svg.clientWidth);
    const height = Math.max(120, svg.clientHeight);
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.replaceChildren();
    const right = room(width);
    const [low, high] = range(series);
    const x = (t) => left + ((t - first) / (last - first)) * (width - left - right);
    const y = (v) => top + ((high - v) / (high - low)) * (height - top - bottom);
    for (const [value, text] of ticks(low, high, Math.max(2, (height - top - bottom) / 30))) {
      draw("line", { class: "grid", x1: left, x2: width - right, y1: y(value), y2: y(value) }, svg);
      draw("text", { x: left - 5, y: y(value) + 4, "text-anchor": "end" }, svg).textContent = text;
    }
    for (const [value, text] of ticks(first, last, Math.max(2, (width - left - right) / 80))) {
      draw("line", { class: "grid", x1: x(value), x2: x(value), y1: top, y2: height - bottom }, svg);
      draw("text", { x: x(value), y: height - 6, "text-anchor": "middle" }, svg).textContent = text;
    }
    for (const event of events) {
      draw("line", { class: "event", x1: x(event.time), x2: x(event.time), y1: top, y2: height - bottom }, svg);
    }
    const labels = [];
    series.forEach(({ name, values, colour }) => {
      let path = "";
      let pen = "M";
      values.forEach((value, k) => {
        if (value === null) {
          pen = "M";
          return;
        }
        path += `${pen}${x(time[k]).toFixed(1)} ${y(value).toFixed(1)}`;
        pen = "L";
      });
      draw("path", { d: path, stroke: `var(--c${colour % 6})` }, svg);
      const end = values.findLast((value) => value !== null);
      if (end !== undefined) labels.push({ name, values, at: y(end), colour });
    });
    labels.sort((a, b) => a.at - b.at);
    labels.forEach((label, k) => { if (k) label.at = Math.max(label.at, labels[k - 1].at + 13); });
    const over = labels.length ? labels[labels.length - 1].at - (height - bottom) : 0;
    for (const label of labels) {
      const place = { x: width - right + 5, y: label.at - Math.max(over, 0) + 4, style: `fill:var(--c${label.colour % 6})` };
      label.node = draw("text", place, svg);
    }
    const [now, cursor] = ["now", "cursor"].map((name) => draw("line", { class: name, y1: top, y2: height - bottom }, svg));
    const read = draw("text", { class: "read", y: top + 10 }, svg);
    const put = (line, t) => {
      line.setAttribute("x1", x(t));
      line.setAttribute("x2", x(t));
    };
    let present = first;
    let pointed = null;
    const tell = () => {
      const t = pointed ?? present;
      for (const { node, name, values } of labels) node.textContent = `${name} ${digits(valueAt(time, values, t))}`;
      cursor.style.visibility = pointed === null ? "hidden" : "visible";
      read.textContent = pointed === null ? "" : `t = ${digits(pointed)} s`;
      if (pointed === null) return;
      put(cursor, pointed);
      const late = x(pointed) > left + 0.75 * (width - left - right);
      read.setAttribute("x", x(pointed) + (late ? -5 : 5));
      read.setAttribute("text-anchor", late ? "end" : "start");
    };
    const timeAt = (event) => {
      const box = svg.getBoundingClientRect();
      const share = ((event.clientX - box.left) * (width / box.width) - left) / (width - left - right);
      return first + Math.min(1, Math.max(0, share)) * (last - first);
    };
    svg.onpointerdown = (event) => go(timeAt(event));
    svg.onpointermove = (event) => (event.buttons === 1 ? go(timeAt(event)) : hover(timeAt(event)));
    svg.onpointerleave = () => hover(null);
    return {
      show: (t) => { present = t; put(now, t); tell(); },
      point: (t) => { pointed = t; tell(); },
      // Where the time axis begins and ends, for whoever looks whether axes are aligned.
      axis: [left, width - right],
    };
  };

  // Draws groups of curves, `{ title, series }`, and gives a function that moves the mark of the present.
  return (parent, groups, motion, go) => {
    const figures = groups.map(({ title, series }) => {
      const figure = document.createElement("figure");
      const caption = document.createElement("figcaption");
      caption.textContent = `${title} over t [s]`;
      const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
      svg.setAttribute("class", "plot");
      svg.setAttribute("role", "img");
      svg.setAttribute("aria-label", `${title} over time: ${series.map(({ name }) => name).join(", ")}`);
      figure.append(caption, svg);
      return figure;
    });
    parent.replaceChildren(...figures);
    const room = (width) => roomFor(groups, width);
    const hover = (t) => drawn.forEach(({ point }) => point(t));
    const redraw = () => figures.map((figure, k) => plot(figure, groups[k], motion, room, { go, hover }));
    let drawn = redraw();
    let present = motion.time[0];
    const show = (t) => {
      present = t;
      drawn.forEach((figure) => figure.show(t));
    };
    show(present);
    const widths = () => figures.map((figure) => figure.clientWidth).join();
    let known = widths();
    const observer = new ResizeObserver(() => {
      if (widths() === known) return;
      known = widths();
      drawn = redraw();
      show(present);
    });
    observer.observe(parent);
    return {
      show,
      hover,
      axes: () => drawn.map(({ axis }) => axis),
      figures: () => figures.map((figure, k) => ({ svg: figure.querySelector("svg"), title: `${groups[k].title} over t [s]` })),
      close: () => observer.disconnect(),
    };
  };
})();
