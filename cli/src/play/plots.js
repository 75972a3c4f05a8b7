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

  const plot = (figure, { series }, motion, go) => {
    const svg = figure.querySelector("svg");
    const { time, events } = motion;
    const [first, last] = [time[0], time[time.length - 1]];
    const width = Math.max(220, svg.clientWidth);
    const height = Math.max(120, svg.clientHeight);
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.replaceChildren();
    const longest = Math.max(...series.map(({ name }) => name.length));
    const right = Math.min(0.3 * width, 10 + 7 * longest);
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
      if (end !== undefined) labels.push({ name, at: y(end), colour });
    });
    labels.sort((a, b) => a.at - b.at);
    labels.forEach((label, k) => { if (k) label.at = Math.max(label.at, labels[k - 1].at + 13); });
    const over = labels.length ? labels[labels.length - 1].at - (height - bottom) : 0;
    labels.forEach(({ name, at, colour }) => {
      const place = { x: width - right + 5, y: at - Math.max(over, 0) + 4, style: `fill:var(--c${colour % 6})` };
      draw("text", place, svg).textContent = name;
    });
    const now = draw("line", { class: "now", y1: top, y2: height - bottom }, svg);
    const show = (t) => {
      now.setAttribute("x1", x(t));
      now.setAttribute("x2", x(t));
    };
    show(first);
    const pointed = (event) => {
      if (event.type === "pointermove" && event.buttons !== 1) return;
      const box = svg.getBoundingClientRect();
      const share = ((event.clientX - box.left) * (width / box.width) - left) / (width - left - right);
      go(first + Math.min(1, Math.max(0, share)) * (last - first));
    };
    svg.onpointerdown = pointed;
    svg.onpointermove = pointed;
    return show;
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
    const redraw = () => figures.map((figure, k) => plot(figure, groups[k], motion, go));
    let shows = redraw();
    let present = motion.time[0];
    const widths = () => figures.map((figure) => figure.clientWidth).join();
    let known = widths();
    const observer = new ResizeObserver(() => {
      if (widths() === known) return;
      known = widths();
      shows = redraw();
      shows.forEach((show) => show(present));
    });
    observer.observe(parent);
    return {
      show: (t) => { present = t; shows.forEach((show) => show(t)); },
      close: () => observer.disconnect(),
    };
  };
})();
