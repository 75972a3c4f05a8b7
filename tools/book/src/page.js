// Contents stand beside the text where there is room. Arrow keys turn pages, `c` leads to the contents, `/` to the search.
const contents = document.getElementById("contents");
const wide = matchMedia("(min-width: 1000px)");
const place = () => { contents.open = wide.matches; };
place();
wide.addEventListener("change", place);
contents.addEventListener("click", (event) => {
  if (event.target.closest("a") && !wide.matches) contents.open = false;
});
document.addEventListener("keydown", (event) => {
  if (event.altKey || event.ctrlKey || event.metaKey || event.shiftKey) return;
  if (event.target.closest("input")) return;
  const scrolls = event.target.closest("pre, .table");
  const turn = { ArrowLeft: "prev", ArrowRight: "next" }[event.key];
  if (turn && !scrolls) document.querySelector(`.turn [rel="${turn}"]`)?.click();
  if (event.key === "c") {
    contents.open = true;
    (contents.querySelector("[aria-current]") ?? contents.querySelector("a")).focus();
  }
  if (event.key === "/") {
    event.preventDefault();
    contents.open = true;
    document.getElementById("asked").focus();
  }
});
