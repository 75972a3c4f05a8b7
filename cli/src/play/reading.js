"use strict";
// What the page holds compressed.
const unpacked = async (id) => {
  const packed = await fetch(`data:application/octet-stream;base64,${element(id).textContent}`);
  return new Response(packed.body.pipeThrough(new DecompressionStream("gzip")));
};

// What is read beside the editor: the chapters of the book, and the pages about mistakes.
const reading = (() => {
  // Filled once, as `loaded` tells.
  const chapters = [];
  const sections = [];
  const panel = element("reading");
  const sheet = element("sheet");
  const choice = element("chapter");
  // Where one was before, to come back.
  const before = [];
  let place = null;
  let tryScene = () => {};

  // A scene block holds the file so far where statements are added to it.
  const withScenes = (markdown) => {
    const files = new Map();
    return typeset(markdown, {
      go: (target) => open(target),
      block: (info, code) => {
        const [language, file, kind] = info.split(",");
        if (language !== "hang") return null;
        const whole = kind === "more" ? (files.get(file) ?? "") + code : code;
        files.set(file, whole);
        const button = make("button", { type: "button", textContent: "open in the editor" });
        button.addEventListener("click", () => tryScene(cleanName(file), whole));
        const caption = make("figcaption", {}, make("span", { textContent: kind === "more" ? `${file}, at its end` : file }), button);
        return make("figure", { className: "scene" }, caption, make("pre", { tabIndex: 0 }, make("code", {}, ...coloured(code))));
      },
    });
  };
  const show = (nodes, title) => {
    panel.hidden = false;
    document.body.classList.add("reading");
    sheet.replaceChildren(...nodes);
    sheet.scrollTop = 0;
    // On narrow screens it is below the editor.
    if (panel.getBoundingClientRect().top > innerHeight) panel.scrollIntoView({ block: "start" });
    panel.setAttribute("aria-label", title);
    element("back").disabled = before.length === 0;
  };
  const turn = (next) => {
    if (place) before.push({ ...place, scrolled: sheet.scrollTop });
    place = next;
    next.draw();
  };
  const drawn = (file, anchor) => () => {
    const chapter = chapters.find((known) => known.file === file);
    choice.value = file;
    show([withScenes(chapter.text)], chapter.title);
    sheet.querySelector(`[data-anchor="${CSS.escape(anchor)}"]`)?.scrollIntoView({ block: "start" });
  };
  // Opens a chapter, `contacts.md`, or a place in one, `contacts.md#friction`.
  const open = async (target) => {
    await loaded;
    const [file, anchor = ""] = target.split("#");
    const name = file || place?.file || chapters[0].file;
    if (!chapters.some((chapter) => chapter.file === name)) return;
    turn({ file: name, draw: drawn(name, anchor) });
  };
  // Shows a page in Markdown that is no chapter.
  const page = (title, markdown) => turn({ draw: () => {
    choice.value = "";
    show([withScenes(markdown)], title);
  } });

  const sectionsOf = ({ file, title, text: markdown }) => {
    let fenced = false;
    const parts = [{ file, title, heading: title, lines: [] }];
    for (const line of markdown.split("\n")) {
      if (line.startsWith("```")) fenced = !fenced;
      const heading = !fenced && /^##+ (.*)$/.exec(line);
      if (heading) parts.push({ file, title, heading: heading[1].replaceAll("`", ""), lines: [] });
      else parts[parts.length - 1].lines.push(line);
    }
    return parts;
  };
  // The sections in which all words occur, those with a word in the heading first.
  const find = (asked) => {
    const wanted = asked.toLowerCase().split(/\s+/).filter(Boolean);
    const scored = sections.map((section) => {
      const heading = section.heading.toLowerCase();
      const body = section.lines.join("\n").toLowerCase();
      const all = wanted.every((word) => heading.includes(word) || body.includes(word));
      return { section, score: all ? 1 + 10 * wanted.filter((word) => heading.includes(word)).length + wanted.reduce((sum, word) => sum + Math.min(5, body.split(word).length - 1), 0) : 0 };
    });
    const found = scored.filter(({ score }) => score > 0).sort((a, b) => b.score - a.score).slice(0, 20);
    const entries = found.map(({ section: { file, title, heading, lines } }) => {
      const link = make("a", { href: "#", textContent: heading === title ? title : `${title}: ${heading}` });
      link.addEventListener("click", (event) => {
        event.preventDefault();
        element("find").value = "";
        open(heading === title ? file : `${file}#${heading.replace(/[^\p{L}\p{N}\-_ ]/gu, "").replaceAll(" ", "-").toLowerCase()}`);
      });
      const line = lines.find((words) => wanted.some((word) => words.toLowerCase().includes(word))) ?? "";
      return make("li", {}, link, make("div", { className: "quiet", textContent: line.trim().slice(0, 140) }));
    });
    show([make("h3", { textContent: found.length ? `${found.length} places` : "nothing found" }), make("ul", { className: "found" }, ...entries)], "search");
  };

  const loaded = unpacked("chapters").then((packed) => packed.json()).then((read) => {
    chapters.push(...read);
    sections.push(...chapters.flatMap(sectionsOf));
    choice.append(...chapters.map(({ file, title }) => make("option", { value: file, textContent: title })));
  });
  choice.addEventListener("change", () => open(choice.value));
  element("find").addEventListener("input", ({ target }) => {
    if (target.value.trim().length > 1) find(target.value);
    else place?.draw();
  });
  element("back").addEventListener("click", () => {
    const last = before.pop();
    if (!last) return;
    place = last;
    last.draw();
    sheet.scrollTop = last.scrolled;
    element("back").disabled = before.length === 0;
  });
  const close = () => {
    panel.hidden = true;
    document.body.classList.remove("reading");
    element("read").focus();
  };
  element("close").addEventListener("click", close);
  element("read").addEventListener("click", () => {
    if (!panel.hidden) close();
    else if (place) place.draw();
    else open("");
  });
  return { open, page, close, chapters, scenesGo: (go) => { tryScene = go; } };
})();
