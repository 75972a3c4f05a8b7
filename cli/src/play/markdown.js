"use strict";
// Typesets the Markdown of the book and of the pages about mistakes: headings, paragraphs, lists, tables, code, formulas, details.
const typeset = (() => {
  const make = (tag, properties = {}, ...children) => {
    const node = Object.assign(document.createElement(tag), properties);
    node.append(...children);
    return node;
  };
  // The anchor of a heading: its words in lower case, joined by `-`.
  const anchorOf = (heading) => heading.replace(/[^\p{L}\p{N}\-_ ]/gu, "").replaceAll(" ", "-").toLowerCase();

  // A formula, which the book has set in MathML.
  const set = (formula) => {
    const template = document.createElement("template");
    template.innerHTML = formula;
    return template.content;
  };
  // Code, links, strong words, emphasis, formulas. `go` follows a link.
  const inline = (text, go) => {
    const parts = [];
    let at = 0;
    const pattern = /`([^`]+)`|!\[([^\]]*)\]\([^)]*\)|\[([^\]]+)\]\(([^)]+)\)|\*\*([^*]+)\*\*|\*([^*\s][^*]*)\*|(<math.*?<\/math>)/g;
    for (const match of text.matchAll(pattern)) {
      parts.push(text.slice(at, match.index));
      at = match.index + match[0].length;
      const [whole, code, image, words, target, strong, emphasis, formula] = match;
      if (code !== undefined) parts.push(make("code", { textContent: code }));
      else if (image !== undefined) parts.push(make("em", { textContent: `(picture in the book: ${image})` }));
      else if (words !== undefined) parts.push(linked(inline(words, go), target, go));
      else if (strong !== undefined) parts.push(make("strong", {}, ...inline(strong, go)));
      else if (emphasis !== undefined) parts.push(make("em", {}, ...inline(emphasis, go)));
      else if (formula !== undefined) parts.push(set(formula));
      else parts.push(whole);
    }
    parts.push(text.slice(at));
    return parts;
  };
  const linked = (words, target, go) => {
    if (!/^[\w-]*\.md(#.*)?$|^#/.test(target)) return make("span", {}, ...words);
    const link = make("a", { href: "#" }, ...words);
    link.addEventListener("click", (event) => {
      event.preventDefault();
      go(target);
    });
    return link;
  };

  const cells = (line) => line.trim().replace(/^\||\|$/g, "").split("|").map((cell) => cell.trim());
  const table = (lines, go) => {
    const row = (line, tag) => make("tr", {}, ...cells(line).map((cell) => make(tag, {}, ...inline(cell, go))));
    const body = lines.slice(2).map((line) => row(line, "td"));
    return make("div", { className: "wide" }, make("table", {}, make("thead", {}, row(lines[0], "th")), make("tbody", {}, ...body)));
  };

  const item = /^(\s*)(-|\d+\.)\s+(.*)$/;
  const list = (lines, go) => {
    const first = item.exec(lines[0]);
    const entries = [];
    for (const line of lines) {
      const begins = item.exec(line);
      if (begins && begins[1].length === first[1].length) entries.push([begins[3]]);
      else entries[entries.length - 1].push(line.trim());
    }
    return make(first[2] === "-" ? "ul" : "ol", {}, ...entries.map((parts) => make("li", {}, ...inline(parts.join(" "), go))));
  };

  // `block(info, text)` gives what stands for a fenced block; null for plain code.
  return (markdown, { go = () => {}, block = () => null } = {}) => {
    const lines = markdown.split("\n");
    const root = make("div");
    const open = [root];
    const put = (node) => open[open.length - 1].append(node);
    let at = 0;
    const take = (goes) => {
      const taken = [];
      while (at < lines.length && goes(lines[at])) taken.push(lines[at++]);
      return taken;
    };
    while (at < lines.length) {
      const line = lines[at];
      const heading = /^(#{1,4})\s+(.*)$/.exec(line);
      const summary = /^<details><summary>(.*)<\/summary>$/.exec(line);
      if (line.startsWith("```")) {
        const info = line.slice(3).trim();
        at++;
        const code = take((inner) => !inner.startsWith("```"));
        at++;
        put(block(info, code.map((inner) => `${inner}\n`).join("")) ?? make("pre", { tabIndex: 0 }, make("code", { textContent: code.join("\n") })));
      } else if (heading) {
        at++;
        const node = make(`h${Math.min(heading[1].length + 1, 5)}`, {}, ...inline(heading[2], go));
        node.dataset.anchor = anchorOf(node.textContent);
        put(node);
      } else if (summary) {
        at++;
        const details = make("details", {}, make("summary", {}, ...inline(summary[1], go)));
        put(details);
        open.push(details);
      } else if (line.trim() === "</details>") {
        at++;
        if (open.length > 1) open.pop();
      } else if (line.startsWith("|")) {
        put(table(take((inner) => inner.startsWith("|")), go));
      } else if (item.test(line)) {
        put(list(take((inner) => item.test(inner) || /^\s+\S/.test(inner)), go));
      } else if (line.trim() === "") {
        at++;
      } else {
        const ends = (inner) => inner.trim() === "" || /^(#|```|\||<details|<\/details)/.test(inner) || item.test(inner);
        const words = [lines[at++], ...take((inner) => !ends(inner))];
        put(make("p", {}, ...inline(words.join(" "), go)));
      }
    }
    return root;
  };
})();
