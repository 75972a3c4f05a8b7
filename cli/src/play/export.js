"use strict";
// Pictures, tables and films of what is shown, made in the page.
const exportsOf = (() => {
  const styled = ["fill", "fill-opacity", "stroke", "stroke-opacity", "stroke-width", "stroke-dasharray", "stroke-linejoin", "opacity", "font-size", "font-family", "text-anchor"];
  // Pictures are drawn this many times as fine as they are shown, films this wide at most [px].
  const fine = 2;
  const widest = 1280;
  // Frames of a film [1/s].
  const rate = 30;

  const paper = () => getComputedStyle(document.body).backgroundColor;
  const sizeOf = (svg) => {
    const [, , width, height] = svg.getAttribute("viewBox").split(" ").map(Number);
    return [width, height];
  };
  // A drawing that looks alike without the style of the page.
  const standalone = (svg) => {
    const [width, height] = sizeOf(svg);
    const copy = svg.cloneNode(true);
    const shown = [svg, ...svg.querySelectorAll("*")];
    [copy, ...copy.querySelectorAll("*")].forEach((node, k) => {
      const style = getComputedStyle(shown[k]);
      for (const name of styled) {
        const value = style.getPropertyValue(name);
        if (value) node.setAttribute(name, value);
      }
      node.removeAttribute("class");
      node.removeAttribute("style");
    });
    const sheet = document.createElementNS("http://www.w3.org/2000/svg", "rect");
    for (const [name, value] of Object.entries({ width, height, fill: paper() })) sheet.setAttribute(name, value);
    copy.prepend(sheet);
    for (const name of ["id", "fill", "style"]) copy.removeAttribute(name);
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    copy.setAttribute("width", width);
    copy.setAttribute("height", height);
    return new XMLSerializer().serializeToString(copy);
  };
  // One drawing below the other.
  const stacked = (figures) => {
    const space = 26;
    const sizes = figures.map(({ svg }) => sizeOf(svg));
    const width = Math.max(...sizes.map(([w]) => w));
    let y = 0;
    const ink = getComputedStyle(document.body).color;
    const parts = figures.map(({ svg, title }, k) => {
      const place = y;
      y += sizes[k][1] + space;
      const words = title.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
      return `<text x="8" y="${place + 17}" font-family="sans-serif" font-size="14" fill="${ink}">${words}</text><g transform="translate(0 ${place + space})">${standalone(svg)}</g>`;
    });
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${y}" viewBox="0 0 ${width} ${y}"><rect width="${width}" height="${y}" fill="${paper()}"/>${parts.join("")}</svg>`;
  };
  const imageOf = async (text) => {
    const address = URL.createObjectURL(new Blob([text], { type: "image/svg+xml" }));
    const image = new Image();
    image.src = address;
    try {
      await image.decode();
    } finally {
      URL.revokeObjectURL(address);
    }
    return image;
  };
  const png = async (text) => {
    const image = await imageOf(text);
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [fine * image.width, fine * image.height];
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
    return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
  };
  // Every quantity that is drawn, with its unit in the heading.
  const csv = ({ time, readings }) => {
    const cell = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const heading = ["time [s]", ...readings.map(({ name, unit }) => cell(unit ? `${name} [${unit}]` : name))];
    const rows = time.map((t, k) => [t, ...readings.map(({ values }) => values[k] ?? "")].join(","));
    return `${[heading.join(","), ...rows].join("\n")}\n`;
  };

  const kinds = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];
  const kind = () => (typeof MediaRecorder === "undefined" ? undefined : kinds.find((type) => MediaRecorder.isTypeSupported(type)));
  // A film of the motion as it plays, taken while it plays; `null` if it was stopped. `speed` is that of the motion.
  const film = async (player, svg, { first, last, speed, tell = () => {}, stopped = () => false }) => {
    const [width, height] = sizeOf(svg);
    const scale = Math.min(2, widest / width);
    const canvas = document.createElement("canvas");
    // Codecs want even numbers.
    [canvas.width, canvas.height] = [width, height].map((size) => 2 * Math.round((scale * size) / 2));
    const context = canvas.getContext("2d");
    const draw = async (t) => {
      player.show(t);
      context.drawImage(await imageOf(standalone(svg)), 0, 0, canvas.width, canvas.height);
    };
    await draw(first);
    const recorder = new MediaRecorder(canvas.captureStream(rate), { mimeType: kind(), videoBitsPerSecond: 6e6 });
    const parts = [];
    recorder.ondataavailable = ({ data }) => parts.push(data);
    const ended = new Promise((resolve) => { recorder.onstop = resolve; });
    recorder.start();
    const start = performance.now();
    const length = (last - first) / speed;
    for (let gone = 0; gone < length && !stopped(); gone = (performance.now() - start) / 1000) {
      await draw(Math.min(last, first + speed * gone));
      tell(Math.min(1, gone / length));
      await new Promise((resolve) => setTimeout(resolve, 500 / rate));
    }
    await draw(last);
    await new Promise((resolve) => setTimeout(resolve, 200));
    recorder.stop();
    await ended;
    return stopped() ? null : new Blob(parts, { type: kind().split(";")[0] });
  };
  return { standalone, stacked, png, csv, film, kind };
})();
