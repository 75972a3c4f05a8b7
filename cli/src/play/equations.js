"use strict";
// Typesets expressions of the language: text to MathML.
const mathOf = (() => {
  const space = "http://www.w3.org/1998/Math/MathML";
  const node = (name, ...children) => {
    const made = document.createElementNS(space, name);
    made.append(...children);
    return made;
  };
  const operator = (text) => node("mo", text);
  const gap = () => {
    const space = node("mspace");
    space.setAttribute("width", "0.17em");
    return space;
  };
  const greek = { alpha: "α", beta: "β", gamma: "γ", delta: "δ", epsilon: "ε", zeta: "ζ", eta: "η", theta: "θ", kappa: "κ",
    lambda: "λ", mu: "μ", nu: "ν", xi: "ξ", pi: "π", rho: "ρ", sigma: "σ", tau: "τ", phi: "φ", chi: "χ", psi: "ψ", omega: "ω" };
  const part = (text) => (/^\d/.test(text) ? node("mn", text) : node("mi", greek[text] ?? text));
  const name = (text) => {
    const [first, ...rest] = text.split("_");
    if (rest.length === 0 || first === "") return part(text);
    return node("msub", part(first), node("mrow", ...rest.flatMap((word, i) => (i ? [operator(","), part(word)] : [part(word)]))));
  };
  const tokens = (text) => text.match(/\d+\.?\d*(?:e[-+]?\d+)?|\.\d+|[\p{L}_][\p{L}\p{N}_]*'*|[-+*/^(),[\]|=]|\S/gu) ?? [];

  // A parsed part: its node, and whether it needs brackets as a base or a factor.
  const parse = (text) => {
    const list = tokens(text);
    let at = 0;
    const fail = () => { throw new Error("not understood"); };
    const take = (wanted) => (list[at] === wanted ? list[at++] : fail());
    const bracketed = (inner) => node("mrow", operator("("), inner, operator(")"));
    const wrap = ({ made, sum }) => (sum ? bracketed(made) : made);
    const atom = () => {
      const token = list[at++];
      if (token === undefined) fail();
      if (token === "(") {
        const first = sum();
        if (list[at] !== ",") {
          take(")");
          return { made: first.made, sum: first.sum };
        }
        const parts = [first.made];
        while (list[at] === ",") { at++; parts.push(operator(","), sum().made); }
        take(")");
        return { made: bracketed(node("mrow", ...parts)) };
      }
      if (/^[\d.]/.test(token)) {
        const [digits, exponent] = token.split("e");
        if (exponent === undefined) return { made: node("mn", token) };
        const power = node("msup", node("mn", "10"), node("mn", String(Number(exponent))));
        return { made: node("mrow", node("mn", digits), operator("·"), power), product: true };
      }
      if (!/^[\p{L}_]/u.test(token)) fail();
      if (list[at] === "(") {
        at++;
        const inner = sum();
        const parts = [inner.made];
        while (list[at] === ",") { at++; parts.push(operator(","), sum().made); }
        take(")");
        if (parts.length === 1 && token === "sqrt") return { made: node("msqrt", inner.made) };
        if (parts.length === 1 && token === "dot") return { made: node("mover", wrap(inner), operator("˙")) };
        if (parts.length === 1 && token === "exp") return { made: node("msup", node("mi", "e"), inner.made) };
        return { made: node("mrow", name(token), operator("\u2061"), bracketed(node("mrow", ...parts))) };
      }
      return { made: name(token) };
    };
    const power = () => {
      const base = atom();
      if (list[at] !== "^") return base;
      at++;
      const negative = list[at] === "-" ? list[at++] : "";
      const exponent = power();
      const raised = negative ? node("mrow", operator("−"), wrap(exponent)) : exponent.made;
      return { made: node("msup", base.sum || base.product ? bracketed(base.made) : base.made, raised) };
    };
    const product = () => {
      let left = power();
      while (list[at] === "*" || list[at] === "/") {
        if (list[at++] === "/") {
          left = { made: node("mfrac", left.made, power().made) };
        } else {
          left = { made: node("mrow", wrap(left), gap(), wrap(power())), product: true };
        }
      }
      return left;
    };
    const sum = () => {
      const parts = [];
      let negative = false;
      if (list[at] === "-") { at++; parts.push(operator("−")); negative = true; }
      const first = product();
      parts.push(negative ? wrap(first) : first.made);
      if (parts.length === 1 && list[at] !== "+" && list[at] !== "-") return first;
      while (list[at] === "+" || list[at] === "-") {
        const minus = list[at++] === "-";
        const next = product();
        parts.push(operator(minus ? "−" : "+"), minus ? wrap(next) : next.made);
      }
      return { made: node("mrow", ...parts), sum: true };
    };
    const made = sum().made;
    return at === list.length ? made : fail();
  };

  const side = (text) => {
    try {
      return parse(text);
    } catch {
      return node("mtext", text);
    }
  };
  // An equation; what is no expression of the language stays as it is written.
  return ([left, right]) => {
    const math = node("math", node("mrow", side(left), operator("="), side(right)));
    math.setAttribute("display", "block");
    math.setAttribute("aria-label", `${left} = ${right}`);
    return math;
  };
})();
