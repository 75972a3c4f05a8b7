"use strict";
// Sections in which all words occur, those with words in the heading first.
const sections = JSON.parse(document.getElementById("sections").textContent);
const words = document.getElementById("words");
const most = 40;
const score = ({ heading, text }, wanted) => {
  const [head, body] = [heading.toLowerCase(), text.toLowerCase()];
  if (!wanted.every((word) => head.includes(word) || body.includes(word))) return 0;
  return 1 + wanted.reduce((sum, word) => sum + (head.includes(word) ? 10 : 0) + Math.min(5, body.split(word).length - 1), 0);
};
const find = () => {
  const wanted = words.value.toLowerCase().split(/\s+/).filter(Boolean);
  const scored = wanted.length ? sections.map((section) => [score(section, wanted), section]).filter(([points]) => points > 0) : [];
  scored.sort(([a], [b]) => b - a);
  const entries = scored.slice(0, most).map(([, { address, chapter, heading, text }]) => {
    const entry = document.createElement("li");
    const link = document.createElement("a");
    link.href = address;
    link.textContent = heading === chapter ? chapter : `${chapter}: ${heading}`;
    const line = document.createElement("div");
    line.textContent = (text.split("\n").find((part) => wanted.some((word) => part.toLowerCase().includes(word))) ?? "").slice(0, 160);
    entry.append(link, line);
    return entry;
  });
  document.getElementById("found").replaceChildren(...entries);
  document.getElementById("count").value = wanted.length ? `${scored.length} places` : "";
};
words.value = new URLSearchParams(location.search).get("q") ?? "";
words.addEventListener("input", find);
find();
// Told by a script, since a browser that has been told to look elsewhere meanwhile complains of `autofocus`.
words.focus();
