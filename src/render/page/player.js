// Plays a scenario: the map at a moment, measures over time, and a table of both. Texts reach the page as text, never as markup.
(() => {
const data = JSON.parse(document.getElementById("data-scene").textContent);
const { dt, view, map, measures, reasons, moments, contacts } = data;
const [FIRST, LAST] = data.steps;
const COUNT = LAST - FIRST + 1;

// Lists hold the first number and then differences; lengths are centimetres.
const summed = (list, parts) => { let sum = 0; return list.map((d) => (sum += d) / parts); };
const points = (line) => {
  const found = [];
  for (let i = 0, x = 0, y = 0; i < line.length; i += 2) found.push([(x += line[i]) / 100, (y += line[i + 1]) / 100]);
  return found;
};
const trace = (path, spots, closed) => {
  spots.forEach(([x, y], i) => (i ? path.lineTo(x, y) : path.moveTo(x, y)));
  if (closed) path.closePath();
  return path;
};
const outline = (lines, closed) => lines.reduce((path, line) => trace(path, points(line), closed), new Path2D());
const grouped = (list) => {
  const groups = new Map();
  for (const [name, ...rest] of list) groups.set(name, [...(groups.get(name) ?? []), rest]);
  return groups;
};

const road = {
  surfaces: map.surfaces.map(([kind, ring]) => [kind, outline([ring], true)]),
  stripes: outline(map.stripes, true),
  borders: [...grouped(map.borders.map(([paint, width, line]) => [`${paint} ${width}`, line]))]
    .map(([key, lines]) => [key[0], Number(key.slice(2)), outline(lines.map(([line]) => line), false)]),
  stops: [true, false].map((dashed) => [dashed, outline(map.stops.filter((s) => s[0] === dashed).map((s) => s[1]), false)]),
  goals: outline(map.goals, true),
  regions: outline(map.regions, true),
  occupancies: map.occupancies.map(([id, from, to, rings]) => ({ id, from, to, path: outline(rings, true) })),
};
const bodies = data.bodies.map((body) => {
  const index = new Int32Array(COUNT).fill(body.stands ? 0 : -1);
  let place = 0;
  for (const [from, count] of body.runs) for (let i = 0; i < count; i++, place++) index[from - FIRST + i] = place;
  return {
    ...body, index,
    x: summed(body.x, 100), y: summed(body.y, 100), heading: summed(body.heading, 1000),
    speed: summed(body.speed, 100), acceleration: summed(body.acceleration, 100),
    shapes: body.shapes.map(([from, rings]) => {
      const corners = rings.map(points), all = corners.flat();
      const ahead = all.map((p) => p[0]), left = all.map((p) => p[1]);
      return { from, corners, path: outline(rings, true), front: Math.max(...ahead), rear: Math.min(...ahead), width: Math.max(...left) - Math.min(...left) };
    }),
  };
});
const ego = bodies.find((body) => body.id === null);
const named = new Map(bodies.filter((body) => body !== ego).map((body) => [body.id, body]));
const series = new Map(data.readings.map(([id, rows]) => [id, rows.map((row) => {
  const values = [], why = [];
  for (const part of row) {
    if (typeof part === "number") { values.push(part); why.push(null); continue; }
    for (let i = Number(part.slice(1)); i > 0; i--) { values.push(null); why.push(reasons[part.charCodeAt(0) - 97]); }
  }
  return { values, why };
})]));
const overlays = data.lines.map((line) => ({ ...line, path: outline([line.line], false) }));
const lights = map.lights.map(([x, y, changes]) => ({ x: x / 100, y: y / 100, changes }));

/** The pose of a body between two steps; nothing where it is not there. */
const pose = (body, time) => {
  const step = Math.min(Math.floor(time), LAST), part = time - step;
  const a = body.index[step - FIRST];
  if (!(a >= 0)) return null;
  const b = part > 0 ? body.index[step + 1 - FIRST] ?? -1 : -1;
  const shape = body.shapes.findLast((s) => s.from <= a);
  const at = { x: body.x[a], y: body.y[a], heading: body.heading[a], speed: body.speed[a], acceleration: body.acceleration[a], shape };
  if (b < 0) return at;
  const turn = Math.atan2(Math.sin(body.heading[b] - at.heading), Math.cos(body.heading[b] - at.heading));
  return { ...at, x: at.x + (body.x[b] - at.x) * part, y: at.y + (body.y[b] - at.y) * part, heading: at.heading + turn * part };
};

// State.
const state = { time: view.step, playing: false, speed: 1, picked: view.picked, follows: view.follows, turns: view.turns };
const step = () => Math.min(LAST, Math.max(FIRST, Math.floor(state.time + 1e-6)));
const seconds = (at, digits = 2) => `${(at * dt).toFixed(digits)} s`;
const DIGITS = dt >= 0.1 && Math.abs(dt * 10 - Math.round(dt * 10)) < 1e-9 ? 1 : 2;
const camera = { x: view.at[0] / 100, y: view.at[1] / 100, metres: view.width, up: view.up };
const START = { ...camera };

// The map.
const canvas = make("canvas", { id: "map", tabindex: "0", role: "img", "aria-label": "The scene from above; click a road user for its measures" });
const pen = canvas.getContext("2d");
const style = () => {
  const all = getComputedStyle(document.documentElement);
  return (name) => all.getPropertyValue(`--${name}`).trim();
};
let color = style();
const size = () => [canvas.clientWidth, canvas.clientHeight];
const frame = () => {
  const [width, height] = size(), scale = width / camera.metres;
  const [c, s] = [Math.cos(camera.up), Math.sin(camera.up)];
  const [a, b, d, e] = [scale * s, -scale * c, -scale * c, -scale * s];
  return { scale, a, b, c: d, d: e, e: width / 2 - a * camera.x - d * camera.y, f: height / 2 - b * camera.x - e * camera.y };
};
const onPage = (m, x, y) => [m.a * x + m.c * y + m.e, m.b * x + m.d * y + m.f];
const inWorld = (m, x, y) => {
  const det = m.a * m.d - m.b * m.c, [u, v] = [x - m.e, y - m.f];
  return [(m.d * u - m.c * v) / det, (m.a * v - m.b * u) / det];
};
const colorOf = (body) => color(body === ego ? "ego" : body.id === state.picked ? "picked" : body.stands ? "static" : "obstacle");

const draw = () => {
  const [width, height] = size(), ratio = devicePixelRatio || 1;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
  if (ego && (state.follows || state.turns)) {
    const at = pose(ego, state.time);
    if (at && state.follows) Object.assign(camera, { x: at.x, y: at.y });
    if (at && state.turns) camera.up = at.heading;
  }
  const m = frame(), px = 1 / m.scale, now = step();
  const world = () => pen.setTransform(ratio * m.a, ratio * m.b, ratio * m.c, ratio * m.d, ratio * m.e, ratio * m.f);
  const page = () => pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  const fill = (path, name, alpha = 1) => { pen.globalAlpha = alpha; pen.fillStyle = color(name); pen.fill(path); pen.globalAlpha = 1; };
  const line = (path, name, wide, alpha = 1, dashes = []) => {
    pen.globalAlpha = alpha; pen.strokeStyle = color(name); pen.lineWidth = wide; pen.setLineDash(dashes);
    pen.stroke(path); pen.setLineDash([]); pen.globalAlpha = 1;
  };
  page();
  pen.fillStyle = color("map");
  pen.fillRect(0, 0, width, height);
  world();
  pen.lineJoin = pen.lineCap = "round";
  for (const [, path] of road.surfaces.filter(([kind]) => kind === "a")) fill(path, "road", 0.5);
  for (const [kind, path] of road.surfaces.filter(([kind]) => kind !== "a" && kind !== "c")) {
    fill(path, kind === "p" ? "path" : "road");
    line(path, kind === "p" ? "path" : "road", px);
  }
  for (const [, path] of road.surfaces.filter(([kind]) => kind === "c")) { fill(path, "road"); fill(path, "lane", 0.35); }
  fill(road.stripes, "crosswalk");
  pen.lineCap = "butt";
  for (const [paint, wide, path] of road.borders) {
    const broad = Math.max(0.15 * wide, (wide + 0.1) * px * 0.8);
    if (paint === "d" && 3 * m.scale > 2) line(path, "lane-dashed", broad, 1, [3, 3]);
    else if (paint === "s") line(path, "lane", broad);
    else line(path, paint === "d" ? "lane-dashed" : "lane", paint === "n" || paint === "u" ? 0.7 * px : broad, { d: 0.5, n: 0.3, u: 0.6, l: 0.6 }[paint]);
  }
  for (const [dashed, path] of road.stops) line(path, "lane", Math.max(0.4, 1.2 * px), 1, dashed ? [0.6, 0.36] : []);
  fill(road.goals, "goal", 0.2);
  line(road.goals, "goal", px, 0.8, [4 * px, 3 * px]);
  fill(road.regions, "static", 0.6);
  for (const { path } of road.occupancies.filter(({ from, to }) => from <= now && now <= to)) {
    fill(path, "obstacle", 0.25);
    line(path, "obstacle", px, 1, [4 * px, 3 * px]);
  }
  // Where everybody was, and where the ego and who is picked go.
  for (const body of bodies) {
    const place = body.stands ? -1 : body.index[now - FIRST];
    const told = body === ego || body.id === state.picked;
    if (body.stands || (place < 0 && !told)) continue;
    const spots = (from, to) => {
      const path = new Path2D();
      let open = false;
      for (let at = Math.max(from, FIRST); at <= Math.min(to, LAST); at++) {
        const i = body.index[at - FIRST];
        if (i < 0) { open = false; continue; }
        path[open ? "lineTo" : "moveTo"](body.x[i], body.y[i]);
        open = true;
      }
      return path;
    };
    const name = body === ego ? "ego" : told ? "picked" : "obstacle";
    line(spots(told ? FIRST : now - Math.round(2 / dt), now), name, (told ? 1.8 : 1) * px, told ? 0.75 : 0.5);
    if (told) line(spots(now, LAST), name, 1.2 * px, 0.7, [5 * px, 4 * px]);
  }
  for (const { owner, dashed, opacity, path } of overlays) {
    const id = owner.obstacle;
    const name = owner === "ego" ? "ego" : owner === "recorded" ? "dim" : id === undefined || !named.has(id) ? "text" : id === state.picked ? "picked" : "obstacle";
    line(path, name, 1.3 * px, opacity, dashed ? [6 * px, 4 * px] : []);
  }
  const shown = [];
  const rank = (body) => (body === ego ? 2 : body.id === state.picked ? 1 : 0);
  for (const body of [...bodies].sort((a, b) => rank(a) - rank(b))) {
    const at = pose(body, state.time);
    if (!at?.shape) continue;
    const { shape } = at, [c, s] = [Math.cos(at.heading), Math.sin(at.heading)];
    pen.save();
    pen.transform(c, s, -s, c, at.x, at.y);
    pen.fillStyle = colorOf(body);
    pen.fill(shape.path);
    line(shape.path, "text", Math.max(px, 0.06), 0.45);
    const wide = shape.width, long = shape.front - shape.rear;
    if (body.has_front && long * m.scale > 9 && wide * m.scale > 4) {
      const deep = Math.min(0.62 * wide, 0.4 * long), tip = shape.front - 0.22 * deep;
      const head = trace(new Path2D(), [[tip, 0], [tip - deep, 0.33 * wide], [tip - 0.72 * deep, 0], [tip - deep, -0.33 * wide]], true);
      fill(head, "map", 0.9);
    }
    if (body.id === state.picked && long * m.scale < 9) line(trace(new Path2D(), [[0, 0]], false), "picked", 6 * px);
    pen.restore();
    shown.push({ body, at, long });
  }
  page();
  for (const light of lights) lamp(m, light, now);
  for (const [at, , x, y] of contacts) if (at === now) mark(...onPage(m, x / 100, y / 100));
  pen.font = "600 12px system-ui, sans-serif";
  pen.textAlign = "center";
  for (const { body, at, long } of shown) {
    const told = body === ego || body.id === state.picked;
    if (!told && (body.stands || long * m.scale < 16)) continue;
    const [x, y] = onPage(m, at.x, at.y);
    if (x < -20 || y < -20 || x > width + 20 || y > height + 20) continue;
    word(body === ego ? "ego" : body.id, x, y - Math.max(12, 0.5 * long * m.scale * Math.abs(Math.cos(at.heading - camera.up)) + 8), told ? color("text") : color("dim"));
  }
  scaleBar(m, height);
};
const word = (words, x, y, fill) => {
  Object.assign(pen, { strokeStyle: color("map"), lineWidth: 3, lineJoin: "round", fillStyle: fill });
  pen.strokeText(words, x, y);
  pen.fillText(words, x, y);
};
const lamp = (m, light, now) => {
  if (m.scale < 2) return;
  const lit = light.changes.findLast(([from]) => from <= now)?.[1] ?? "";
  const [x, y] = onPage(m, light.x, light.y);
  pen.fillStyle = "#222";
  pen.beginPath();
  pen.roundRect(x - 3.5, y - 9, 7, 18, 2);
  pen.fill();
  [["red", "#ff4030"], ["yellow", "#ffc400"], ["green", "#20d060"]].forEach(([name, shine], i) => {
    pen.fillStyle = lit.toLowerCase().includes(name) ? shine : "#4a4a4a";
    pen.beginPath();
    pen.arc(x, y + (i - 1) * 5.6, 2.2, 0, 7);
    pen.fill();
  });
};
const mark = (x, y) => {
  for (const [name, wide] of [["map", 5], ["danger", 2.2]]) {
    Object.assign(pen, { strokeStyle: color(name), lineWidth: wide });
    pen.beginPath();
    pen.arc(x, y, 9, 0, 7);
    for (let i = 0; i < 8; i++) {
      const [c, s] = [Math.cos((i + 0.5) * Math.PI / 4), Math.sin((i + 0.5) * Math.PI / 4)];
      pen.moveTo(x + 11 * c, y + 11 * s);
      pen.lineTo(x + 15 * c, y + 15 * s);
    }
    pen.stroke();
  }
};
const scaleBar = (m, height) => {
  const metres = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].findLast((n) => n * m.scale <= 120) ?? 1;
  const long = metres * m.scale, [x, y] = [14, height - 14];
  Object.assign(pen, { strokeStyle: color("text"), lineWidth: 1.5 });
  pen.beginPath();
  pen.moveTo(x, y - 4); pen.lineTo(x, y); pen.lineTo(x + long, y); pen.lineTo(x + long, y - 4);
  pen.stroke();
  pen.font = "12px system-ui, sans-serif";
  word(`${metres} m`, x + long / 2, y - 6, color("text"));
};

// Moving about on the map, and picking.
const zoom = (by, [x, y] = size().map((n) => n / 2)) => {
  const before = inWorld(frame(), x, y);
  camera.metres = Math.min(20000, Math.max(4, camera.metres * by));
  if (!state.follows) {
    const after = inWorld(frame(), x, y);
    camera.x += before[0] - after[0];
    camera.y += before[1] - after[1];
  }
  request();
};
const inside = (rings, x, y) => rings.some((ring) => ring.reduce((odd, [ax, ay], i) => {
  const [bx, by] = ring[(i + 1) % ring.length];
  return (ay > y) !== (by > y) && x < ((bx - ax) * (y - ay)) / (by - ay) + ax ? !odd : odd;
}, false));
const bodyAt = (x, y) => {
  const m = frame(), [wx, wy] = inWorld(m, x, y);
  let best = null, least = 14 / m.scale;
  for (const body of named.values()) {
    const at = pose(body, state.time);
    if (!at?.shape) continue;
    const [dx, dy, c, s] = [wx - at.x, wy - at.y, Math.cos(at.heading), Math.sin(at.heading)];
    if (inside(at.shape.corners, c * dx + s * dy, c * dy - s * dx)) return body;
    const far = Math.hypot(dx, dy);
    if (far < least) [best, least] = [body, far];
  }
  return best;
};
const fingers = new Map();
let dragged = 0;
const place = (event) => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.x, event.clientY - box.y]; };
canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); if (!fingers.size) dragged = 0; fingers.set(event.pointerId, place(event)); });
canvas.addEventListener("pointermove", (event) => {
  const to = place(event), from = fingers.get(event.pointerId);
  if (!from) { canvas.style.cursor = bodyAt(...to) ? "pointer" : "grab"; return; }
  const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
  if (other) {
    zoom(Math.hypot(from[0] - other[0], from[1] - other[1]) / Math.max(1, Math.hypot(to[0] - other[0], to[1] - other[1])), other);
    dragged = 99;
  } else {
    dragged += Math.hypot(to[0] - from[0], to[1] - from[1]);
    if (dragged > 4) {
      const m = frame(), [a, b] = [inWorld(m, ...from), inWorld(m, ...to)];
      follow(false);
      camera.x += a[0] - b[0];
      camera.y += a[1] - b[1];
      request();
    }
  }
  fingers.set(event.pointerId, to);
});
const lift = (event) => {
  const at = fingers.get(event.pointerId);
  fingers.delete(event.pointerId);
  if (at && dragged <= 4 && event.type === "pointerup") { const body = bodyAt(...at); if (body) pick(body.id); }
};
canvas.addEventListener("pointerup", lift);
canvas.addEventListener("pointercancel", lift);
canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(Math.exp(event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), place(event)); }, { passive: false });
const fit = () => {
  follow(false);
  const spots = bodies.flatMap((body) => [...body.index.keys()].map((i) => body.index[i]).filter((i) => i >= 0).map((i) => [body.x[i], body.y[i]]));
  if (!spots.length) return;
  const [c, s] = [Math.cos(camera.up), Math.sin(camera.up)], [width, height] = size();
  const range = (value) => spots.reduce(([low, high], p) => [Math.min(low, value(p)), Math.max(high, value(p))], [Infinity, -Infinity]);
  const right = range(([x, y]) => s * x - c * y), ahead = range(([x, y]) => c * x + s * y);
  const [r, a] = [(right[0] + right[1]) / 2, (ahead[0] + ahead[1]) / 2];
  camera.metres = Math.min(20000, Math.max(right[1] - right[0] + 24, ((ahead[1] - ahead[0] + 24) * width) / height));
  Object.assign(camera, { x: s * r + c * a, y: s * a - c * r });
  request();
};

// Controls.
const SVG = "http://www.w3.org/2000/svg";
const shape = (tag, attributes, ...children) => {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
};
const icon = (d) => shape("svg", { viewBox: "0 0 16 16", width: 16, height: 16, "aria-hidden": "true" }, shape("path", { d, fill: "currentColor" }));
const PLAY = "M4 2.5v11l9.5-5.5z", PAUSE = "M4 2.5h3v11H4zM9.5 2.5h3v11h-3z";
const button = (title, onclick, ...content) => make("button", { type: "button", title, "aria-label": title, onclick }, ...content);
const play = button("Play or pause (space)", () => toggle(), icon(PLAY));
play.id = "play";
const moment = moments[0];
const jump = moment && button("To the moment that matters (m)", () => seek(moment.step), "Moment");
const speeds = [0.1, 0.25, 0.5, 1, 2, 4];
const speed = make("select", { "aria-label": "Speed", title: "Speed ([ and ])", onchange: () => { state.speed = Number(speed.value); } },
  ...speeds.map((n) => make("option", { value: n, selected: n === 1 }, `${n}×`)));
const slider = make("input", { type: "range", id: "slider", min: FIRST, max: LAST, step: 1, "aria-label": "Time step", oninput: () => seek(Number(slider.value)) });
const clock = make("output", { id: "clock" });
const toFollow = ego && button("Keep the ego in the middle (f)", () => { follow(!state.follows); request(); }, "Follow");
const toTurn = ego && button("Let the ego drive upwards (r)", () => turn(), "Turn");
const marks = make("div", { class: "marks", "aria-hidden": "true" });
const along = (at) => (COUNT > 1 ? (at - FIRST) / (LAST - FIRST) : 0);
const flag = (at, name, title) => {
  const mark = make("i", { class: name, title });
  mark.style.left = `calc(8px + (100% - 16px) * ${along(at)})`;
  marks.append(mark);
};
const touched = [...new Set(contacts.map(([at]) => at))].sort((a, b) => a - b);
if (touched.length) flag(touched[0], "contact", `First contact, ${seconds(touched[0], DIGITS)}`);
if (moment) flag(moment.step, "moment", `The moment that matters, ${seconds(moment.step, DIGITS)}`);
const controls = make("div", { class: "controls" },
  button("One step back (←)", () => go(-1), icon("M11.5 2.5v11L4.5 8zM2.5 2.5h2v11h-2z")), play, button("One step on (→)", () => go(1), icon("M4.5 2.5v11l7-5.5zM11.5 2.5h2v11h-2z")),
  jump, speed, make("div", { class: "track" }, slider, marks), clock, toFollow, toTurn, button("Show everybody (a)", fit, "All"));

const follow = (on) => { state.follows = on && Boolean(ego); toFollow?.setAttribute("aria-pressed", String(state.follows)); };
const turn = () => {
  state.turns = !state.turns;
  if (!state.turns) camera.up = START.up;
  toTurn?.setAttribute("aria-pressed", String(state.turns));
  request();
};
const toggle = (on = !state.playing) => {
  if (on && step() >= LAST) state.time = FIRST;
  if (!on) state.time = step();
  state.playing = on && COUNT > 1;
  last = null;
  play.replaceChildren(icon(state.playing ? PAUSE : PLAY));
  play.setAttribute("aria-pressed", String(state.playing));
  if (!state.playing) remember();
  request();
};
const seek = (to) => {
  state.time = Math.min(LAST, Math.max(FIRST, Math.round(to)));
  if (state.playing) toggle(false);
  remember();
  request();
};
const go = (by) => seek(step() + by);
const pick = (id) => {
  state.picked = id;
  remember();
  panel();
  plots();
  request();
};
const remember = () => {
  clearTimeout(remember.timer);
  remember.timer = setTimeout(() => history.replaceState(null, "", `#${step()}${state.picked === null ? "" : `/${state.picked}`}`), 250);
};

// Measures.
const shownValue = (value, digits) => (value === null || value === undefined ? "–" : value.toFixed(digits));
const digitsOf = (measure) => (measure.levels ? 0 : 2);
const valueOf = (id, m, at) => series.get(id)?.[m].values[at - FIRST] ?? null;
const reached = (measure, value) => value !== null && measure.high !== null
  && measure.thresholds.some(([, limit, strict]) => (measure.high ? value >= limit : value <= limit) && !(strict && value === limit));
const worse = (measure, a, b) => (measure.high ? a > b : a < b);
const extremes = new Map([...series].map(([id, rows]) => [id, rows.map(({ values }, m) => values.reduce((best, value, i) =>
  (value !== null && (best === null || worse(measures[m], value, best[0])) ? [value, i + FIRST] : best), null))]));
const all = measures.map((measure, m) => Array.from({ length: COUNT }, (_, i) => [...series.values()].reduce((best, rows) => {
  const value = rows[m].values[i];
  return value !== null && (best === null || worse(measure, value, best)) ? value : best;
}, null)));
const order = [...moments.map((one) => one.obstacle), ...[...series.keys()].filter((id) => !moments.some((one) => one.obstacle === id))];
const momentOf = (id) => moments.find((one) => one.obstacle === id);
const toStep = (at, words = seconds(at, DIGITS)) => make("button", { type: "button", class: "time", title: "Go there", onclick: () => seek(at) }, words);
const cell = (element, measure, value, why) => {
  element.textContent = shownValue(value, digitsOf(measure));
  element.title = value === null ? why ?? "" : measure.unit;
  element.classList.toggle("hot", reached(measure, value));
};

const card = make("section", { id: "picked", "aria-live": "off" });
let live = [];
const panel = () => {
  live = [];
  const body = named.get(state.picked), found = momentOf(state.picked);
  const number = (title, unit, value) => {
    const shown = make("td", { class: "n" });
    live.push(() => { shown.textContent = value(); });
    return make("tr", {}, make("th", { scope: "row" }, title), shown, make("td", { class: "unit" }, unit), make("td", {}));
  };
  const motion = (of, title) => [
    number(`speed of ${title}`, "m/s", () => shownValue(pose(of, step())?.speed ?? null, 2)),
    number(`acceleration of ${title}`, "m/s²", () => shownValue(pose(of, step())?.acceleration ?? null, 2)),
  ];
  const rows = measures.map((measure, m) => {
    const shown = make("td", { class: "n" }), best = extremes.get(state.picked)?.[m];
    live.push(() => cell(shown, measure, valueOf(state.picked, m, step()), series.get(state.picked)?.[m].why[step() - FIRST]));
    return make("tr", {}, make("th", { scope: "row", title: measure.id }, measure.name), shown, make("td", { class: "unit" }, measure.unit),
      make("td", { class: "n" }, ...(best ? [`${measure.extreme} ${best[0].toFixed(digitsOf(measure))} at `, toStep(best[1])] : [])));
  });
  card.replaceChildren(...[
    make("h2", {}, body ? make("i", { class: "swatch" }) : null, body ? `${body.id}, ${body.kind}` : "No road user is picked"),
    found ? make("p", {}, make("b", {}, found.severity), `: ${found.words}, at `, toStep(found.step)) : body ? null : make("p", {}, "Click one on the map or in the table."),
    make("table", {}, make("tbody", {}, ...(body && series.has(body.id) ? rows : []), ...(body && !body.stands ? motion(body, "it") : []), ...(ego ? motion(ego, "the ego") : []))),
  ].filter(Boolean));
  for (const row of table.querySelectorAll("tbody tr")) row.setAttribute("aria-selected", String(row.dataset.id === state.picked));
};

// Plots.
const charts = make("section", { id: "plots" });
const HEIGHT = 118, LEFT = 40, RIGHT = 10, TOP = 20, BOTTOM = 16;
let cursors = [];
const ticks = (low, high, parts) => {
  const rough = (high - low) / parts, base = 10 ** Math.floor(Math.log10(rough));
  const every = [1, 2, 5, 10].map((n) => n * base).find((n) => n >= rough) ?? rough;
  const found = [];
  for (let n = Math.ceil(low / every - 1e-9); n * every <= high + 1e-9 * every; n++) found.push(n * every);
  return [found, Math.max(0, -Math.floor(Math.log10(every) + 1e-9))];
};
const plots = () => {
  cursors = [];
  const width = Math.max(220, charts.clientWidth);
  charts.replaceChildren(...measures.map((measure, m) => plot(measure, m, width)));
};
const plot = (measure, m, width) => {
  const own = series.get(state.picked)?.[m].values ?? [];
  const values = [...all[m], ...own].filter((value) => value !== null);
  let [low, high] = [Math.min(...values), Math.max(...values)];
  if (!values.length) [low, high] = [0, 1];
  if (measure.levels) [low, high] = [0, Math.max(5, high)];
  const span = high - low || 1;
  for (const [, limit] of measure.thresholds) if (limit > low - span / 2 && limit < high + span / 2) [low, high] = [Math.min(low, limit), Math.max(high, limit)];
  if (low > 0 && low < span) low = 0;
  if (low === high) [low, high] = [low - 0.5, high + 0.5];
  const x = (at) => LEFT + along(at) * (width - LEFT - RIGHT), y = (value) => HEIGHT - BOTTOM - ((value - low) / (high - low)) * (HEIGHT - TOP - BOTTOM);
  const chart = shape("svg", { class: "plot", width, height: HEIGHT, viewBox: `0 0 ${width} ${HEIGHT}`, role: "img", "aria-label": `${measure.name} over time` });
  const text = (words, at, name, anchor = "start") => shape("text", { x: at[0], y: at[1], class: name, "text-anchor": anchor }, words);
  const [levels, decimals] = ticks(low, high, 3);
  for (const level of levels) chart.append(shape("line", { x1: LEFT, x2: width - RIGHT, y1: y(level), y2: y(level), class: "grid" }), text(level.toFixed(decimals), [LEFT - 6, y(level) + 4], "soft", "end"));
  const [times, places] = ticks(FIRST * dt, Math.max(LAST * dt, FIRST * dt + dt), 6);
  for (const time of times) chart.append(text(`${time.toFixed(places)} s`, [x(time / dt), HEIGHT - 2], "soft", "middle"));
  for (const [name, limit] of measure.thresholds) if (limit >= low && limit <= high) {
    chart.append(shape("line", { x1: LEFT, x2: width - RIGHT, y1: y(limit), y2: y(limit), class: "limit" }), text(name, [LEFT + 3, y(limit) - 3], "soft halo"));
  }
  const curve = (row, name) => {
    let d = "", before = null;
    row.forEach((value, i) => {
      if (value === null) { before = null; return; }
      const [px, py] = [x(i + FIRST).toFixed(1), y(value).toFixed(1)];
      d += before === null ? `M${px} ${py}h0.01` : measure.levels ? `H${px}V${py}` : `L${px} ${py}`;
      before = value;
    });
    if (d) chart.append(shape("path", { d, class: name }));
  };
  const upright = (at, name, ...title) => { const line = shape("line", { x1: x(at), x2: x(at), y1: TOP, y2: HEIGHT - BOTTOM, class: name }, ...title); chart.append(line); return line; };
  if (moment) upright(moment.step, "moment", shape("title", {}, "the moment that matters"));
  curve(all[m], "everybody");
  curve(own, "picked");
  const cursor = upright(FIRST, "cursor"), dot = shape("circle", { r: 3.5, class: "dot" });
  chart.append(dot, text(measure.axis, [LEFT, 12], "name"));
  const now = text("", [width - RIGHT, 12], "now", "end");
  chart.append(now);
  cursors.push(() => {
    const at = state.playing ? state.time : step(), value = own[step() - FIRST] ?? null;
    cursor.setAttribute("x1", x(at));
    cursor.setAttribute("x2", x(at));
    dot.setAttribute("visibility", value === null ? "hidden" : "visible");
    if (value !== null) { dot.setAttribute("cx", x(step())); dot.setAttribute("cy", y(value)); }
    now.textContent = state.picked === null ? "" : `${state.picked}: ${shownValue(value, digitsOf(measure))}${value === null ? "" : ` ${measure.unit}`}`;
  });
  const read = (event) => { const box = chart.getBoundingClientRect(); seek(FIRST + ((event.clientX - box.x - LEFT) / (width - LEFT - RIGHT)) * (LAST - FIRST)); };
  chart.addEventListener("pointerdown", (event) => { chart.setPointerCapture(event.pointerId); read(event); });
  chart.addEventListener("pointermove", (event) => { if (event.buttons) read(event); });
  return chart;
};

// Everybody.
const table = make("table", { id: "everybody" });
const cells = [];
const fillTable = () => {
  const head = measures.flatMap((measure) => [make("th", { class: "n", scope: "col", title: measure.axis }, `${measure.id} now`), make("th", { class: "n", scope: "col" }, measure.extreme), make("th", { class: "n", scope: "col" }, "at")]);
  table.append(make("thead", {}, make("tr", {}, make("th", { scope: "col" }, "road user"), make("th", { scope: "col" }, "type"), make("th", { scope: "col" }, "severity"), ...head)),
    make("tbody", {}, ...order.map((id) => {
      const row = make("tr", { "data-id": id, onclick: () => pick(id) }, make("td", {}, make("button", { type: "button", class: "time" }, id)), make("td", {}, named.get(id)?.kind ?? ""), make("td", {}, momentOf(id)?.severity ?? ""));
      measures.forEach((measure, m) => {
        const now = make("td", { class: "n" }), best = extremes.get(id)[m];
        const extreme = make("td", { class: "n" });
        cell(extreme, measure, best?.[0] ?? null);
        cells.push(() => cell(now, measure, valueOf(id, m, step()), series.get(id)[m].why[step() - FIRST]));
        row.append(now, extreme, make("td", { class: "n" }, best ? toStep(best[1]) : ""));
      });
      return row;
    })));
};

// The page.
let last = null, asked = false, told = null;
const request = () => { if (!asked) { asked = true; requestAnimationFrame(tick); } };
const tick = (now) => {
  asked = false;
  if (state.playing) {
    if (last !== null) state.time += (Math.min(now - last, 250) / 1000 / dt) * state.speed;
    last = now;
    if (state.time >= LAST) { state.time = LAST; toggle(false); }
    request();
  }
  draw();
  for (const move of cursors) move();
  const at = step(), key = `${at}/${state.picked}`;
  if (told === key) return;
  told = key;
  slider.value = at;
  slider.setAttribute("aria-valuetext", seconds(at, DIGITS));
  clock.textContent = `${seconds(at, DIGITS)} · step ${at}`;
  document.body.dataset.step = at;
  for (const tell of [...live, ...cells]) tell();
};
const keys = {
  " ": () => toggle(), ArrowLeft: (e) => go(e.shiftKey ? -Math.round(1 / dt) : -1), ArrowRight: (e) => go(e.shiftKey ? Math.round(1 / dt) : 1),
  Home: () => seek(FIRST), End: () => seek(LAST), m: () => moment && seek(moment.step), f: () => { follow(!state.follows); request(); }, r: () => ego && turn(), a: fit,
  "+": () => zoom(0.8), "=": () => zoom(0.8), "-": () => zoom(1.25), "[": () => faster(-1), "]": () => faster(1),
};
const faster = (by) => {
  const to = speeds[Math.min(speeds.length - 1, Math.max(0, speeds.indexOf(state.speed) + by))];
  state.speed = to;
  speed.value = String(to);
};
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target === speed) return;
  if (event.key === " " && event.target.closest?.("button")) return;
  const act = keys[event.key] ?? keys[event.key.toLowerCase()];
  if (!act) return;
  event.preventDefault();
  act(event);
});
const hints = [["space", "play"], ["← →", "step"], ["Shift ← →", "second"], ["m", "moment"], ["f", "follow"], ["r", "turn"], ["a", "all"], ["+ −", "zoom"], ["[ ]", "speed"]];
fillTable();
document.getElementById("player").append(
  make("div", { class: "stage" },
    make("div", { class: "map" }, canvas, controls, make("p", { class: "hints" }, ...hints.flatMap(([key, what]) => [make("kbd", {}, key), ` ${what} `]))),
    make("aside", {}, card, charts)),
  measures.length ? make("div", { class: "wide" }, table) : "");
const toHash = () => {
  const [at, who] = location.hash.slice(1).split("/"), start = Number(at);
  if (location.hash && Number.isInteger(start)) state.time = Math.min(LAST, Math.max(FIRST, start));
  if (who !== undefined && named.has(who)) state.picked = who;
};
toHash();
addEventListener("hashchange", () => { toHash(); panel(); plots(); request(); });
follow(state.follows);
toTurn?.setAttribute("aria-pressed", String(state.turns));
panel();
plots();
new ResizeObserver(() => { request(); }).observe(canvas);
new ResizeObserver(() => { if (Math.abs((charts.firstChild?.width.baseVal.value ?? 0) - charts.clientWidth) > 1) { plots(); request(); } }).observe(charts);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { color = style(); request(); });
request();
})();
