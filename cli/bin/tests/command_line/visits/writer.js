(async () => {
  await until(idle);
  const visits = JSON.parse(sessionStorage.getItem("visits") ?? "[]");
  const own = () => [...document.querySelectorAll("#scenes optgroup")].find(({ label }) => label === "yours")?.querySelectorAll("option") ?? [];
  const seen = { name: page.name, text: text.value, own: [...own()].map(({ value }) => value), kept: element("kept").textContent, hash: location.hash };
  visits.push(seen);
  const original = text.value;
  const control = (key, shiftKey = false) => text.dispatchEvent(new KeyboardEvent("keydown", { key, ctrlKey: true, shiftKey, cancelable: true }));
  const choose = async (name) => {
    page.answer = null;
    element("scenes").value = name;
    element("scenes").dispatchEvent(new Event("change"));
    await until(idle);
  };
  if (visits.length === 1) {
    type(`${original}// one\n`);
    await wait(1.2 * Past.pause);
    type(`${original}// one\n// two\n`);
    control("z");
    seen.undone = text.value;
    control("z");
    seen.first = text.value;
    control("z");
    control("z", true);
    control("y");
    seen.redone = text.value;
    seen.edited = element("scenes").selectedOptions[0].textContent;
    await until(idle);
    element("new").click();
    seen.begun = [page.name, text.value.split("\n")[0]];
    page.answer = null;
    await until(idle);
    window.prompt = () => "my sledge.hang";
    element("rename").click();
    seen.renamed = page.name;
    type(text.value.replace("hill: m = 1", "hill: m = 2"));
    await until(idle);
    await choose("ski-jump");
    control("z");
    seen.other = text.value;
    control("z", true);
    await choose("my-sledge");
    seen.named = own().length;
  } else if (visits.length === 2) {
    // A link to a scene whose name is taken by another text.
    location.hash = await packLink({ name: "my-sledge", text: "// another\ncoordinates { z: m }\nhorizon 1 [s]\nlagrangian 1[kg]/2*dot(z)^2\n" });
    page.answer = null;
    await until(idle);
    seen.linked = [page.name, location.hash];
    window.confirm = () => true;
    element("delete").click();
    seen.deleted = [page.name, [...own()].map(({ value }) => value)];
    location.hash = "#scene=broken!";
    await until(() => element("kept").classList.contains("bad"));
    seen.broken = element("kept").textContent;
    await choose("ski-jump");
    element("original").click();
    seen.original = [text.value === JSON.parse(element("shipped").textContent)[0].text, store.text("ski-jump") === undefined];
    store.open("my-sledge");
  }
  sessionStorage.setItem("visits", JSON.stringify(visits));
  if (visits.length < 3) {
    history.replaceState(null, "", location.pathname);
    location.reload();
    return;
  }
  report.visits = visits;
  send();
})();
