// Runs the module of a page without the page; tests append what they ask it.
import { readFileSync } from "node:fs";
import { gunzipSync } from "node:zlib";

const page = readFileSync(process.argv[2], "utf8");
const packed = /<script type="text\/plain" id="module">([^<]*)</.exec(page)[1];
const module = new WebAssembly.Module(gunzipSync(Buffer.from(packed, "base64")));
const host = { seconds: () => performance.now() / 1000, progress: () => {} };
const fresh = () => new WebAssembly.Instance(module, { host }).exports;
let exports = fresh();

const call = (request) => {
  const bytes = Buffer.from(JSON.stringify(request));
  for (let at = 0; at < bytes.length; at += 8) {
    const part = Buffer.alloc(8);
    bytes.copy(part, 0, at);
    exports.put(part.readBigUInt64LE(), Math.min(8, bytes.length - at));
  }
  const answer = Buffer.alloc(8 * Math.ceil(exports.answer() / 8));
  for (let at = 0; at < answer.length; at += 8) answer.writeBigUInt64LE(BigInt.asUintN(64, exports.get(at / 8)), at);
  return JSON.parse(answer.toString().replace(/\0+$/, ""));
};

// Texts that lead deep into the derivation: the stack of the module is that of its host, a megabyte in browsers.
const deep = () => {
  const scene = (expression, before = "") => `${before} coordinates { z: m } lagrangian 1[kg]/2*dot(z)^2 + 1[N]*z*(${expression}) start { z: 1 }`;
  const functions = Array.from({ length: 290 }, (_, k) => `fn f${k}(x) = ${k ? `${"(".repeat(50)}f${k - 1}(-x)${")".repeat(50)}` : "x"}`);
  const texts = ["(".repeat(20000), "{".repeat(20000), "/*".repeat(20000), scene("-".repeat(50000)), scene(`${"cos(z/1[m])*".repeat(2000)}1`),
    scene(`${"cos(z/1[m])+".repeat(4000)}1`), scene(`${"1/".repeat(20000)}1`), scene(`${"sin(".repeat(60)}z/1[m]${")".repeat(60)}`),
    scene("f289(z/1[m])", functions.join("\n"))];
  for (const text of texts) {
    const answer = call({ call: "simulate", name: "deep", text, settings: ["--horizon", "20ms"] });
    console.log(JSON.stringify(answer.mistakes ? "mistaken" : answer.result.status));
  }
};

// Texts with random changes, each simulated for a short time; what broke off is told.
const mutate = (count, scenes) => {
  let seed = 1n;
  const random = (below) => {
    seed = BigInt.asUintN(64, seed * 6364136223846793005n + 1442695040888963407n);
    return Number((seed >> 33n) % BigInt(below));
  };
  const words = ["(", ")", "((((((((", "[m]", "^", "^-2", "*", "/0", "dot(", "'", "sin(", "sqrt(", "1e308", "-1", "{", "}", "z", "y", "let a = a",
    "//", "/*", "\u{1f600}", "\0", "surface s: y >= 0", "friction 1e9", "restitution 2", ",", "0", "pi", "horizon 0 [s]", "abs(y)", "time"];
  const change = (text) => {
    const at = random(text.length + 1);
    const length = random(12);
    switch (random(5)) {
      case 0: return text.slice(0, at) + text.slice(at + length);
      case 1: return text.slice(0, at) + words[random(words.length)] + text.slice(at);
      case 2: return text.slice(0, at) + words[random(words.length)] + text.slice(at + length);
      case 3: {
        const from = random(text.length + 1);
        return text.slice(0, at) + text.slice(from, from + 4 * length) + text.slice(at);
      }
      default: return text.replace(/\d/, () => String(random(10)));
    }
  };
  const summary = { mistaken: 0, refused: 0, done: 0, traps: [], longest: 0, megabytes: 0 };
  for (let k = 0; k < count; k++) {
    let [name, text] = scenes[random(scenes.length)];
    for (let changes = random(3); changes >= 0; changes--) text = change(text);
    const start = performance.now();
    try {
      const answer = call({ call: "simulate", name, text, settings: ["--horizon", "20ms"] });
      summary[answer.mistakes ? "mistaken" : answer.refusal ? "refused" : "done"]++;
    } catch (error) {
      summary.traps.push([String(error), text]);
      exports = fresh();
    }
    summary.longest = Math.max(summary.longest, (performance.now() - start) / 1000);
    summary.megabytes = Math.max(summary.megabytes, exports.memory.buffer.byteLength / 1e6);
  }
  console.log(JSON.stringify(summary));
};
