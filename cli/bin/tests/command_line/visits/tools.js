const wait = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));
const until = async (what) => { while (!what()) await wait(5); };
const idle = () => page.answer && page.scene && !runner.busy && !checker.busy && !page.again;
const type = (content) => { text.value = content; text.dispatchEvent(new Event("input")); };
const look = () => ({ status: element("status").value, result: page.answer.result, command: element("command").textContent,
  figures: document.querySelectorAll("#plots svg path").length, readings: page.answer.motion.readings.length, stage: document.querySelectorAll("#stage [data-body]").length,
  equations: document.querySelectorAll("#equations math").length });
