// Heads that sort; for designs a filter, a scatter, parallel axes to brush, settings. Nothing is fetched.
"use strict";
(() => {
const make = (tag, props = {}, ...inside) => {
  const svg = ["svg", "g", "line", "path", "circle", "rect", "text", "polyline"].includes(tag);
  const e = svg ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
  for (const [k, v] of Object.entries(props)) k in e && !svg ? (e[k] = v) : e.setAttribute(k, v);
  e.append(...inside);
  return e;
};
const PREFIX = {p: 1e-12, n: 1e-9, u: 1e-6, "µ": 1e-6, m: 1e-3, k: 1e3, K: 1e3, M: 1e6, G: 1e9, T: 1e12,
  Ki: 1024, Mi: 1048576, Gi: 1073741824};
const number = text => {
  const found = /^[-+−]?\d[\d ,]*(\.\d+)?([eE][-+]?\d+)?/.exec(text.trim());
  if (!found) return NaN;
  const unit = text.trim().slice(found[0].length).trim();
  const prefix = /^(Ki|Mi|Gi|[pnuµmkKMGT])(?=[A-Za-z])/.exec(unit);
  return +found[0].replace(/[ ,]/g, "").replace("−", "-") * (prefix && !/^m(m|in)/.test(unit) ? PREFIX[prefix[1]] : 1);
};

const sortable = table => {
  const heads = table.tHead.rows[table.tHead.rows.length - 1].cells;
  [...heads].forEach((head, i) => {
    if (head.tagName !== "TH") return;
    const button = make("button", {type: "button", className: "sort"}, ...head.childNodes);
    head.append(button);
    button.onclick = () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      [...heads].forEach(h => h.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const key = row => row.cells[i]?.textContent ?? "";
      const order = (a, b) => {
        const [x, y] = [key(a), key(b)], [n, m] = [number(x), number(y)];
        return isNaN(n) || isNaN(m) ? isNaN(n) - isNaN(m) || x.localeCompare(y) : n - m;
      };
      const body = table.tBodies[0];
      body.append(...[...body.rows].sort((a, b) => (down ? -1 : 1) * order(a, b)));
    };
  });
};
document.querySelectorAll("table").forEach(sortable);
document.querySelectorAll(".before-after").forEach(box => {
  const bar = make("input", {type: "range", min: 0, max: 100, value: 50, ariaLabel: "how much of the picture is after"});
  const show = () => box.style.setProperty("--at", bar.value + "%");
  bar.oninput = show;
  box.classList.add("live");
  box.append(bar);
  show();
});

const data = document.getElementById("designs");
if (!data) return;
const D = JSON.parse(data.textContent), rows = D.rows, columns = D.columns;

// The language of --where.
const UNIT = {B: 1, Hz: 1, W: 1, J: 1, s: 1, V: 1, bit: 1}, OWN = {mm2: 1, um2: 1e-6, nm: 1};
const si = unit => {
  if (unit in OWN) return OWN[unit];
  const [, head, rest] = /^(Ki|Mi|Gi|[pnuµmkKMGT])?(.+)$/.exec(unit) ?? [];
  const base = (rest ?? "").split("/")[0];
  return unit.split("/")[0] in UNIT ? 1 : base in UNIT && head ? PREFIX[head] : null;
};
const BINDS = {"||": 1, "&&": 2, "==": 3, "!=": 3, "<": 3, "<=": 3, ">": 3, ">=": 3, "+": 4, "-": 4,
  "*": 5, "/": 5, "%": 5, "^": 7};
const CALL = {min: Math.min, max: Math.max, abs: Math.abs, ceil: Math.ceil, floor: Math.floor, round: Math.round,
  sqrt: Math.sqrt, log2: Math.log2, ceil_pow2: x => 2 ** Math.ceil(Math.log2(x)),
  floor_pow2: x => 2 ** Math.floor(Math.log2(x)), if: (c, a, b) => c ? a : b, mean: x => x};
const parsed = text => {
  const word = /\s*(?:(\d[\d_]*\.?\d*(?:[eE][-+]?\d+)?)\s*([A-Za-zµ%][A-Za-zµ0-9\/]*)?|'([^']*)'|"([^"]*)"|`([^`]*)`|([A-Za-z_][\w:]*(?:[.\-:][A-Za-z_0-9]+)*)|(\|\||&&|[=!<>]=|[-+*\/%^()<>!,]))/y;
  const tokens = [];
  for (let at = 0; text.slice(at).trim();) {
    word.lastIndex = at;
    const m = word.exec(text);
    if (!m) throw `cannot be read from "${text.slice(at).trim()}" on`;
    at = word.lastIndex;
    tokens.push(m[1] ? {n: +m[1].replace(/_/g, ""), unit: m[2]} : m[3] ?? m[4] != null ? {t: m[3] ?? m[4]}
      : m[5] ?? m[6] ? {name: m[5] ?? m[6]} : {op: m[7]});
  }
  let at = 0;
  const is = op => tokens[at]?.op === op && ++at;
  const need = op => { if (!is(op)) throw `"${op}" is missing`; };
  const one = () => {
    const t = tokens[at++];
    if (!t) throw "something is missing at the end";
    if (t.op === "(") { const e = expr(1); need(")"); return e; }
    if (t.op === "!" || t.op === "-") { const e = expr(6); return r => t.op === "!" ? !e(r).v ? {v: true} : {v: false} : {...e(r), v: -e(r).v}; }
    if (t.op) throw `"${t.op}" is in the wrong place`;
    if ("t" in t) return () => ({v: t.t});
    if ("n" in t) {
      const unit = t.unit == null ? null : t.unit === "%" ? .01 : si(t.unit);
      if (t.unit != null && unit == null) throw `"${t.unit}" is no unit`;
      return () => ({v: t.n * (unit ?? 1), si: unit != null});
    }
    if (t.name in CALL && is("(")) {
      const inside = [];
      do inside.push(expr(1)); while (is(","));
      need(")");
      return r => { const all = inside.map(e => e(r)); return {...all[all.length - 1], v: CALL[t.name](...all.map(a => a.v))}; };
    }
    if (t.name === "true" || t.name === "false") return () => ({v: t.name === "true"});
    const i = columns.findIndex(c => c.name === t.name || c.short === t.name);
    if (i < 0) throw `no column is called "${t.name}"`;
    return r => ({v: r[i], f: columns[i].si});
  };
  const expr = least => {
    let left = one();
    for (let op; (op = tokens[at]?.op) in BINDS && BINDS[op] >= least;) {
      at++;
      const a = left, b = expr(op === "^" ? 6 : BINDS[op] + 1);
      left = r => {
        let x = a(r), y = b(r);
        // A bare column has its own unit; a number with a unit becomes one of it.
        if (x.si && y.f) x = {v: x.v / y.f}; else if (y.si && x.f) y = {v: y.v / x.f};
        const [v, w] = [x.v, y.v], same = {f: x.f ?? y.f};
        switch (op) {
          case "||": return {v: v || w}; case "&&": return {v: v && w};
          case "==": return {v: v === w}; case "!=": return {v: v !== w};
          case "<": return {v: v < w}; case "<=": return {v: v <= w};
          case ">": return {v: v > w}; case ">=": return {v: v >= w};
          case "+": return {v: v + w, ...same}; case "-": return {v: v - w, ...same};
          case "*": return {v: v * w}; case "/": return {v: v / w};
          case "%": return {v: v % w}; default: return {v: v ** w};
        }
      };
    }
    return left;
  };
  const whole = expr(1);
  if (at < tokens.length) throw "an operator is missing";
  return r => whole(r).v === true;
};

const shown = (v, c) => v == null ? "-" : typeof v === "number" ? +v.toPrecision(4) + (c.unit ? " " + c.unit : "") : String(v);
const home = document.querySelector(".explorer");
const filter = make("input", {type: "text", placeholder: D.example, spellcheck: false, id: "where"});
const said = make("output", {htmlFor: "where"});
const choose = (label, at) => {
  const list = make("select", {}, ...columns.map((c, i) => make("option", {value: i}, c.title)));
  list.value = at;
  list.onchange = () => draw();
  return [make("label", {}, label + " ", list), list];
};
const [lx, sx] = choose("across", D.x), [ly, sy] = choose("up", D.y), [lc, sc] = choose("colour", D.colour);
const scatter = make("div", {className: "scatter"}), parallel = make("div", {className: "parallel"});
const tip = make("div", {className: "tip", role: "status"}), card = make("div", {className: "card"});
home.append(make("label", {htmlFor: "where"}, "filter, in the language of --where "), filter, said,
  make("p", {}, lx, " ", ly, " ", lc), scatter, parallel, card, tip);

let test = () => true, brushes = {}, chosen = null;
const kept = () => rows.filter(r => test(r) && Object.entries(brushes).every(([i, [lo, hi]]) => {
  const s = scale(i)(r[i]);
  return s >= lo && s <= hi;
}));
// 0 to 1 along a column; texts by their order.
const scales = {};
const scale = i => scales[i] ??= (() => {
  const all = rows.map(r => r[i]).filter(v => v != null);
  const words = all.some(v => typeof v !== "number");
  if (words) {
    const names = [...new Set(all.map(String))];
    const f = v => names.length > 1 ? names.indexOf(String(v)) / (names.length - 1) : .5;
    return Object.assign(f, {ends: [names[0], names[names.length - 1]]});
  }
  const lo = Math.min(...all), hi = Math.max(...all);
  return Object.assign(v => hi > lo ? (v - lo) / (hi - lo) : .5, {ends: [lo, hi]});
})();
const night = matchMedia("(prefers-color-scheme: dark)");
const colour = t => `hsl(${250 - 200 * t} 75% ${night.matches ? 65 : 35}%)`;
const mark = id => {
  home.querySelectorAll(".on").forEach(e => e.classList.remove("on"));
  if (id != null) home.querySelectorAll(`[data-design="${id}"]`).forEach(e => e.classList.add("on"));
};
const about = r => columns.map((c, i) => `${c.title}: ${D.written[i]?.[String(r[i])] ?? shown(r[i], c)}`);
// All words are made and quoted where the sweep is known; here they are put together.
const handed = r => {
  const offer = D.offers[r.id];
  if (!offer) return null;
  const {commands, comments} = D.replays[offer.replay], others = offer.others && " " + offer.others;
  return {command: commands.map(words => `${words} ${offer.words}`).join("\n"),
    file: comments.map(words => words + others + "\n").join("") + offer.file};
};
const choice = r => {
  chosen = r;
  mark(r.id);
  const copy = (text, what) => make("button", {type: "button", onclick: e => navigator.clipboard?.writeText(text)
    .then(() => (e.target.textContent = "copied"), () => (e.target.textContent = "cannot be copied here"))}, what);
  const offer = handed(r);
  card.replaceChildren(make("h3", {}, r.label), make("ul", {}, ...about(r).map(t => make("li", {}, t))),
    ...offer ? [make("pre", {}, offer.command), copy(offer.command, "copy the command of this design"),
      ...D.together ? [make("p", {}, D.together)] : [],
      make("p", {}, "It gives the numbers of this row, in the folder where the sweep ran: " +
        "--fps and --dram-model are those of the row. The machine file keeps the model of its base; " +
        "its first line says how it gives the row."),
      make("pre", {}, offer.file), copy(offer.file, "copy its machine file")] : []);
  const row = [...document.querySelectorAll("main > .scroll tbody tr")].find(t => t.cells[0].textContent.split(" ")[0] === r.label.split(" ")[0]);
  document.querySelectorAll("tr.on").forEach(t => t.classList.remove("on"));
  row?.classList.add("on");
};
const live = (e, r) => {
  e.dataset.design = r.id;
  e.onpointerenter = p => {
    mark(r.id);
    tip.replaceChildren(make("b", {}, r.label), ...about(r).map(t => make("div", {}, t)));
    tip.style.left = Math.min(p.clientX + 12, innerWidth - 260) + "px";
    tip.style.top = Math.min(p.clientY + 12, innerHeight - 24 * (columns.length + 2)) + "px";
    tip.classList.add("seen");
  };
  e.onpointerleave = () => (tip.classList.remove("seen"), mark(chosen?.id));
  e.onclick = () => choice(r);
  return e;
};
const draw = () => {
  const all = kept(), [ix, iy, ic] = [+sx.value, +sy.value, +sc.value];
  const w = Math.max(320, Math.min(home.clientWidth, 1000)), h = Math.min(420, w * .7), pad = 46;
  const [X, Y, C] = [scale(ix), scale(iy), scale(ic)];
  const svg = make("svg", {viewBox: `0 0 ${w} ${h}`, role: "img", "aria-label": `${columns[iy].title} over ${columns[ix].title}`});
  const text = (x, y, t, anchor) => make("text", {x, y, "text-anchor": anchor}, t);
  const ends = (f, c) => f.ends.map(v => shown(v, c));
  svg.append(make("path", {d: `M${pad} 10V${h - pad}H${w - 10}`, class: "axis"}),
    text(pad, h - pad + 16, ends(X, columns[ix])[0], "start"), text(w - 10, h - pad + 16, ends(X, columns[ix])[1], "end"),
    text(w / 2, h - 10, columns[ix].title, "middle"), text(pad + 4, 20, ends(Y, columns[iy])[1] + " " + columns[iy].title, "start"),
    text(pad - 4, h - pad - 2, ends(Y, columns[iy])[0].split(" ")[0], "end"));
  for (const r of [...all].sort((a, b) => a.front - b.front)) if (r[ix] != null && r[iy] != null) svg.append(live(make("circle", {
    cx: pad + 6 + X(r[ix]) * (w - pad - 26), cy: h - pad - 6 - Y(r[iy]) * (h - pad - 36), r: r.front ? 5 : 3,
    fill: colour(C(r[ic])), class: r.front ? "front" : ""}), r));
  scatter.replaceChildren(svg);
  lines(all, w);
  said.textContent = `${all.length} of ${rows.length} designs`;
};
const lines = (all, w) => {
  const axes = columns.map((_, i) => i).filter(i => columns[i].plot), n = axes.length, h = 240, ic = +sc.value;
  const at = k => 40 + k * (w - 80) / Math.max(n - 1, 1);
  const svg = make("svg", {viewBox: `0 0 ${w} ${h}`, role: "img", "aria-label": "all columns; drag along an axis to keep a part of it"});
  const place = (i, v) => h - 34 - scale(i)(v) * (h - 74);
  for (const r of all.slice(0, 2000)) svg.append(live(make("polyline", {points: axes.map((i, k) =>
    r[i] == null ? "" : `${at(k)},${place(i, r[i])}`).join(" "), stroke: colour(scale(ic)(r[ic])), class: "design"}), r));
  axes.forEach((i, k) => {
    const x = at(k), anchor = k ? k === n - 1 ? "end" : "middle" : "start", b = brushes[i];
    const text = (y, t, c = "end") => make("text", {x, y, "text-anchor": anchor, class: c}, t);
    const axis = make("line", {x1: x, x2: x, y1: 40, y2: h - 34, class: "axis"});
    const hit = make("rect", {x: x - 9, width: 18, y: 34, height: h - 62, class: "brush"});
    if (b) svg.append(make("rect", {x: x - 5, width: 10, y: h - 34 - b[1] * (h - 74), height: Math.max(2, (b[1] - b[0]) * (h - 74)), class: "kept"}));
    const value = e => Math.max(0, Math.min(1, (h - 34 - (e.clientY - svg.getBoundingClientRect().top) * h / svg.getBoundingClientRect().height) / (h - 74)));
    let from = null;
    hit.onpointerdown = e => { from = value(e); hit.setPointerCapture(e.pointerId); };
    hit.onpointerup = e => {
      const to = value(e);
      if (Math.abs(to - from) < .02) delete brushes[i]; else brushes[i] = [Math.min(from, to) - 1e-9, Math.max(from, to) + 1e-9];
      draw();
    };
    const [low, high] = scale(i).ends.map(v => shown(v, {}));
    svg.append(axis, text(k % 2 ? 24 : 10, columns[i].short, ""), text(h - 18, low), text(36, high), hit);
  });
  parallel.replaceChildren(svg);
};
filter.oninput = () => {
  try {
    test = filter.value.trim() ? parsed(filter.value) : () => true;
    rows.length && test(rows[0]);
    filter.removeAttribute("aria-invalid");
    draw();
  } catch (why) {
    filter.setAttribute("aria-invalid", "true");
    said.textContent = typeof why === "string" ? why : "this cannot be evaluated";
  }
};
rows.forEach((r, i) => { r.id = i; [r.label, r.front] = D.names[i]; });
home.hidden = false;
draw();
let width = home.clientWidth;
addEventListener("resize", () => home.clientWidth !== width && (width = home.clientWidth, draw()));
})();
