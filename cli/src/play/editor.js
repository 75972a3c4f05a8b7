"use strict";
// The editor: line numbers, colours and marks below a plain text field.
const element = (id) => document.getElementById(id);
const make = (tag, properties = {}, ...children) => {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
};
const text = element("text");
const words = new Set([...JSON.parse(element("words").textContent), "inelastic", "pub", "in", "at", "to", "over", "radius", "angle", "within", "horizon"]);
const painted = /(\/\/[^\n]*|\/\*[\s\S]*?\*\/)|([\p{L}_][\p{L}\p{N}_]*)|(\d+\.?\d*(?:e[-+]?\d+)?)/gu;
// A scene in colours.
const coloured = (scene) => {
  const parts = [];
  let at = 0;
  for (const match of scene.matchAll(painted)) {
    const kind = match[1] ? "c" : match[3] ? "n" : words.has(match[2]) ? "w" : null;
    if (!kind) continue;
    parts.push(scene.slice(at, match.index), make("span", { className: kind, textContent: match[0] }));
    at = match.index + match[0].length;
  }
  return [...parts, scene.slice(at)];
};
const paint = () => {
  element("paint").replaceChildren(...coloured(text.value), "\n");
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
// The mistakes of a text: where they are, what they are, and a button to the page about each.
const showMessages = ({ mistakes = [], report = "", warnings = "" }, explain) => {
  // The report of the command names commands to run; the page has buttons for them.
  const shown = (report || warnings).replaceAll(/^ *= help: `hangtime explain \S+` tells more\n?/gm, "").trimEnd();
  element("messages").hidden = shown === "";
  element("messages").classList.toggle("warn", report === "");
  element("report").textContent = shown;
  const buttons = mistakes.map((mistake) => {
    const button = make("button", { type: "button", textContent: `line ${mistake.line}, column ${mistake.column}` });
    button.addEventListener("click", () => jump(mistake));
    return button;
  });
  const codes = new Set(mistakes.filter(({ warning }) => !warning).map(({ code }) => code ?? "syntax"));
  const pages = [...codes].map((code) => {
    const button = make("button", { type: "button", className: "page", textContent: code === "syntax" ? "what the syntax is" : `what ${code} means` });
    button.dataset.code = code;
    button.addEventListener("click", () => explain(code));
    return button;
  });
  element("jumps").replaceChildren(...buttons, ...pages);
  mark([...mistakes].sort((a, b) => a.place[0] - b.place[0]));
};
