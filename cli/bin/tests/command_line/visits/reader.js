const bytes = async (content) => [...new Uint8Array(await (content instanceof Blob ? content : new Blob([content])).arrayBuffer())];
HTMLAnchorElement.prototype.click = () => {};
(async () => {
  await until(idle);
  report.plays = page.player.playing();
  element("choose").click();
  await until(() => element("gallery").open);
  const cards = [...document.querySelectorAll("#cards .card")];
  report.groups = [...document.querySelectorAll("#cards h3")].map(({ textContent }) => textContent);
  report.cards = cards.map((card) => [card.dataset.scene, card.querySelector("svg") !== null, card.textContent]);
  page.answer = null;
  cards.find(({ dataset }) => dataset.scene === "hop").click();
  await until(idle);
  report.chosen = [page.name, text.value, element("asked").textContent, element("gallery").open];

  await reading.open("first_scene.md");
  page.answer = null;
  element("sheet").querySelector("figure.scene button").click();
  await until(idle);
  report.tried = [page.name, element("status").value.split(" ")[0], document.body.classList.contains("reading")];
  element("find").value = "air drag";
  element("find").dispatchEvent(new Event("input"));
  report.found = element("sheet").querySelector("a").textContent;
  element("sheet").querySelector("a").dispatchEvent(new MouseEvent("click", { bubbles: true, cancelable: true }));
  await until(() => element("sheet").querySelector("math"));
  report.opened = [element("chapter").value, element("sheet").querySelectorAll("math").length];
  element("back").click();
  report.back = element("chapter").value;
  const ball = text.value;
  type(ball.replace("g*z", "gg*z"));
  await until(() => document.querySelector("#jumps .page"));
  report.report = element("report").textContent;
  document.querySelector("#jumps .page").click();
  await until(() => element("sheet").querySelector("h2")?.textContent.startsWith("E01"));
  report.page = element("sheet").querySelector("h2").textContent;
  page.answer = null;
  type(ball);
  await until(idle);
  element("close").click();
  report.closed = element("reading").hidden;

  // Curves are drawn anew where they get room.
  await until(() => page.plots.axes()[0][1] > 250);
  report.axes = page.plots.axes();
  const [first, second] = page.plots.figures().map(({ svg }) => svg);
  const box = first.getBoundingClientRect();
  first.dispatchEvent(new PointerEvent("pointermove", { clientX: box.left + 0.4 * box.width, clientY: box.top + 20, bubbles: true }));
  const cursors = () => [...document.querySelectorAll("#plots .cursor")].map((line) => [line.getAttribute("x1"), line.style.visibility]);
  report.cursors = cursors();
  report.read = [...document.querySelectorAll("#plots .read")].map(({ textContent }) => textContent);
  first.dispatchEvent(new PointerEvent("pointerleave"));
  report.left = cursors().map(([, seen]) => seen);

  report.svg = [];
  for (const what of ["motion-svg", "curves-svg"]) {
    const parsed = new DOMParser().parseFromString(await exportAs(what), "image/svg+xml");
    report.svg.push([parsed.querySelector("parsererror") === null, parsed.querySelectorAll("path, polyline, circle").length > 2, parsed.documentElement.outerHTML.includes("var(")]);
  }
  report.png = [];
  for (const what of ["motion-png", "curves-png"]) report.png.push((await bytes(await exportAs(what))).slice(0, 4));
  const csv = (await exportAs("csv")).trim().split("\n");
  report.csv = [csv[0], csv.length - 1, page.answer.motion.time.length];
  report.film = exportsOf.kind() ? null : "none";
  if (exportsOf.kind()) {
    element("rate").value = "2";
    const film = await exportAs("film");
    report.film = [film.type, (await bytes(film)).slice(0, 4), film.size > 2000];
  }

  page.answer = null;
  choose("pump-track");
  await until(idle);
  element("intervals").value = 6;
  page.answer = null;
  element("solve").click();
  await until(idle);
  report.solved = element("status").value;
  page.answer = null;
  page.values.set("speed", 16);
  changed();
  report.dim = element("motion").classList.contains("old");
  await until(idle);
  report.again = element("status").value;
  report.objective = page.answer.result.objective;
  send();
})();
