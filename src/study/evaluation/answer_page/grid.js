// The grid of a report's answers: filter, order, keys. Texts of models and files reach the page as text, never as markup.
(() => {
const ROW = 30; // pixels, as the style has it
const data = JSON.parse(document.getElementById("data-grid").textContent);
const { ways, rows, marks } = data;
const count = marks.row.length;

const number = (n) => n.toLocaleString("en");
const counted = (n, word) => `${number(n)} ${word}${n === 1 ? "" : "s"}`;
const LETTERS = { R: "right", W: "wrong", N: "no verdict", "?": "no truth known" };
const SAID = { y: "yes", n: "no", "-": "" };

// The answers of each question by way, in the order of their samples.
for (const row of rows) row.cells = new Map();
for (let at = 0; at < count; at++) {
  const { cells } = rows[marks.row[at]];
  const way = marks.way[at];
  if (!cells.has(way)) cells.set(way, []);
  cells.get(way).push(at);
}
for (const row of rows) {
  for (const answers of row.cells.values()) answers.sort((a, b) => marks.sample[a] - marks.sample[b]);
  row.key = [row.task, row.scenario, row.lead ?? "", row.window ? row.window.join("-") : ""].join("|");
}
const tally = ways.map(() => ({ R: 0, W: 0, N: 0, "?": 0 }));
for (let at = 0; at < count; at++) tally[marks.way[at]][marks.letter[at]]++;

const PARTS = ["model", "frame", "techniques", "settings", "template"];
const common = PARTS.filter((part) => ways.every((way) => way[part] === ways[0][part]));
const short = (way) => {
  const parts = PARTS.filter((part) => !common.includes(part) && way[part]).map((part) => way[part]);
  return parts.length ? parts : [way.model];
};

const state = { only: "", task: "", truth: "", model: "", frame: "", techniques: "", words: "", order: "asked", orderWay: null };
let hits = null; // answers whose text has the words; null without words
let shownRows = [], shownWays = [], row = 0, column = 0, sample = 0, open = false;

const truthOf = (row) => (row.truth === null ? "unknown" : row.truth ? "yes" : "no");
const fits = (at) => (!state.only || marks.letter[at] === state.only) && (hits === null || hits.has(at));
const named = (row) => state.words && row.scenario.toLowerCase().includes(state.words);
const passing = (of) => {
  const all = shownWays.flatMap((way) => of.cells.get(way) ?? []);
  if (named(of)) return all.filter((at) => !state.only || marks.letter[at] === state.only);
  return all.filter(fits);
};
const wrongs = (of) => shownWays.reduce((sum, way) => sum + (of.cells.get(way) ?? []).filter((at) => marks.letter[at] === "W").length, 0);
const discord = (of) => {
  const said = shownWays.flatMap((way) => of.cells.get(way) ?? []).map((at) => marks.said[at]).filter((s) => s !== "-");
  const yes = said.filter((s) => s === "y").length;
  return Math.min(yes, said.length - yes);
};
const worstOf = (of, way) => {
  const answers = of.cells.get(way) ?? [];
  return answers.length ? answers.reduce((sum, at) => sum + { W: 3, N: 2, "?": 1, R: 0 }[marks.letter[at]], 0) / answers.length : -1;
};

/** Chooses and orders questions and ways again, and keeps what is picked where it is still there. */
const update = () => {
  const pickedRow = shownRows[row], pickedWay = shownWays[column];
  shownWays = ways.map((_, way) => way).filter((way) => ["model", "frame", "techniques"].every((part) => !state[part] || ways[way][part] === state[part]));
  let matches = 0;
  shownRows = rows.filter((of) => {
    if ((state.task && of.task !== state.task) || (state.truth && truthOf(of) !== state.truth)) return false;
    const found = passing(of).length;
    matches += found;
    return found > 0;
  });
  const score = { wrong: wrongs, discord, way: (of) => worstOf(of, state.orderWay) }[state.order];
  if (score) {
    const scores = new Map(shownRows.map((of) => [of, score(of)]));
    shownRows.sort((a, b) => scores.get(b) - scores.get(a));
  } else if (state.order === "name") {
    shownRows.sort((a, b) => (a.scenario < b.scenario ? -1 : a.scenario > b.scenario ? 1 : 0));
  }
  row = Math.max(0, shownRows.indexOf(pickedRow));
  column = Math.max(0, shownWays.indexOf(pickedWay));
  status.firstChild.textContent = `${number(matches)} of ${counted(count, "answer")}, ${number(shownRows.length)} of ${counted(rows.length, "question")}`;
  drawHead();
  space.style.height = `${shownRows.length * ROW}px`;
  nothing.hidden = shownRows.length > 0;
  drawn = "";
  draw();
};

// Controls.
const control = (label, name, choices) =>
  make("label", {}, label, make("select", { id: `by-${name}`, onchange: (e) => { state[name] = e.target.value; update(); } },
    ...choices.map(([value, words]) => make("option", { value }, words))));
const kinds = (part) => [...new Set(ways.map((way) => way[part]).filter(Boolean))].sort();
const several = (label, part, values) => values.length > 1 ? control(label, part, [["", "all"], ...values.map((v) => [v, v])]) : null;
const only = control("Show", "only", [["", "all answers"], ["W", "wrong"], ["R", "right"], ["N", "without verdict"], ["?", "without truth"]]);
const order = control("Order", "order", [["asked", "as asked"], ["name", "by scenario"], ["wrong", "most wrong first"], ["discord", "most disagreement first"], ["way", "worst of a way first"]]);
const words = make("input", { id: "by-words", type: "search", placeholder: "scenario or answer text", "aria-label": "Filter by scenario or answer text", oninput: () => { clearTimeout(words.timer); words.timer = setTimeout(search, 120); } });
const status = make("div", { class: "status" }, make("span", { role: "status" }),
  ...Object.entries(LETTERS).filter(([letter]) => marks.letter.includes(letter)).map(([letter, meaning]) =>
    make("span", {}, make("b", { class: `key ${letter === "?" ? "U" : letter}` }, letter), ` ${meaning}`)),
  common.length && ways.length > 1 ? make("span", {}, `All: ${common.map((part) => ways[0][part]).filter(Boolean).join(" · ")}`) : null);
const tools = make("div", { class: "tools" }, words, only,
  several("Model", "model", kinds("model")), several("Frame", "frame", kinds("frame")), several("Techniques", "techniques", kinds("techniques")),
  several("Task", "task", [...new Set(rows.map((of) => of.task))]),
  control("Truth", "truth", [["", "all"], ["yes", "dangerous"], ["no", "safe"], ["unknown", "unknown"]]), order,
  make("button", { id: "help", title: "Keys (?)", onclick: () => help.showModal() }, "? Keys"));

// The grid: only the lines that are seen exist.
const head = make("div", { class: "line head", role: "row" });
const space = make("div", { role: "presentation" });
const nothing = make("p", { class: "nothing" }, "No answer matches. Escape clears the filter.");
const grid = make("div", { class: "grid", id: "grid", tabindex: 0, role: "grid", "aria-label": "Questions and ways", "aria-rowcount": rows.length + 1 }, head, space, nothing);
const panel = make("aside", { class: "panel", id: "panel", tabindex: 0, "aria-label": "Answer", hidden: true });
/** Every line has the same columns, in pixels. */
const layout = (line) => {
  const room = grid.clientWidth, ways = Math.max(1, shownWays.length);
  const name = room < 700 ? 170 : Math.min(420, Math.max(300, room - 110 * ways));
  const each = Math.min(220, Math.max(84, Math.floor((room - name) / ways)));
  line.style.gridTemplateColumns = `${name}px repeat(${ways}, ${each}px)`;
  line.style.width = `${Math.max(room, name + each * ways)}px`;
};
const drawHead = () => {
  layout(head);
  const of = (way) => {
    const { R, W, N } = tally[way];
    const title = `${ways[way].name}: ${R} right, ${W} wrong, ${N} without verdict; click for the worst first`;
    const pressed = state.order === "way" && state.orderWay === way;
    return make("button", { title, role: "columnheader", "aria-pressed": String(pressed), onclick: () => { by("order", "way"); state.orderWay = way; update(); grid.scrollTop = 0; } },
      ...short(ways[way]).flatMap((part, i) => (i ? [make("br"), part] : [part])), make("small", {}, `${R} R  ${W} W${N ? `  ${N} N` : ""}`));
  };
  head.replaceChildren(make("div", { class: "name", role: "columnheader" }, make("span", {}, "Question"), make("em", {}, "truth")), ...shownWays.map(of));
};
const about = (of) => [of.lead && `lead ${of.lead}`, !of.lead && of.window && `steps ${of.window.join("–")}`].filter(Boolean).join(", ");
const tasks = new Set(rows.map((of) => of.task)).size;
const cell = (of, way, place, at) => {
  const answers = of.cells.get(way) ?? [];
  const chosen = place === row && at === column;
  const id = chosen ? "chosen" : undefined;
  if (!answers.length) return make("div", { class: `cell empty${chosen ? " chosen" : ""}`, role: "gridcell", id }, "");
  const letters = answers.map((a) => marks.letter[a]);
  const kind = letters.every((l) => l === letters[0]) ? letters[0].replace("?", "U") : "M";
  const faint = !answers.some(named(of) ? (a) => !state.only || marks.letter[a] === state.only : fits);
  const tallied = () => ["R", "W", "N", "?"].map((l) => [letters.filter((x) => x === l).length, l]).filter(([n]) => n).map(([n, l]) => `${n}${l}`).join(" ");
  const label = letters.length > 5 ? tallied() : letters.join("");
  const said = letters.length === 1 ? SAID[marks.said[answers[0]]] : "";
  return make("div", { class: `cell ${kind}${faint ? " faint" : ""}${chosen ? " chosen" : ""}`, role: "gridcell", id, "data-way": at,
    title: `${ways[way].name}: ${letters.map((l, i) => [SAID[marks.said[answers[i]]], LETTERS[l]].filter(Boolean).join(", ")).join("; ")}` },
    make("b", {}, label), said ? make("i", {}, said) : null);
};
const line = (place) => {
  const of = shownRows[place];
  const facts = [tasks > 1 && of.task, about(of)].filter(Boolean).join(" · ");
  const element = make("div", { class: `line${place % 2 ? " even" : ""}`, role: "row", "aria-rowindex": place + 2, "data-row": place },
    make("div", { class: "name", role: "rowheader", title: `${of.scenario}${facts ? ` · ${facts}` : ""} · truth ${truthOf(of)}` },
      make("span", {}, of.scenario), facts ? make("em", {}, facts) : null, make("em", {}, truthOf(of) === "unknown" ? "?" : truthOf(of))),
    ...shownWays.map((way, at) => cell(of, way, place, at)));
  layout(element);
  element.style.top = `${head.offsetHeight + place * ROW}px`;
  return element;
};
const lines = new Map(); // the lines that exist, by place
let drawn = "", waiting = false; // an empty `drawn` draws everything anew
const draw = () => {
  const top = Math.max(0, Math.floor(grid.scrollTop / ROW) - 6);
  const end = Math.min(shownRows.length, Math.ceil((grid.scrollTop + grid.clientHeight) / ROW) + 6);
  const width = String(grid.clientWidth), now = `${width} ${row} ${column}`;
  const same = drawn === now, sameWidth = drawn.startsWith(`${width} `);
  for (const [place, element] of lines) {
    const seen = place >= top && place < end;
    // The line that was picked and the one that is look different now.
    if (seen && (same || (sameWidth && place !== row && !element.querySelector("#chosen")))) continue;
    element.remove();
    lines.delete(place);
  }
  drawn = now;
  const fresh = document.createDocumentFragment();
  for (let place = top; place < end; place++) {
    if (lines.has(place)) continue;
    lines.set(place, line(place));
    fresh.append(lines.get(place));
  }
  grid.append(fresh);
  grid.setAttribute("aria-activedescendant", "chosen");
};
grid.addEventListener("scroll", () => {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; draw(); });
});
const reveal = () => {
  const room = grid.clientHeight - head.offsetHeight;
  const above = row * ROW, first = 300;
  if (above < grid.scrollTop) grid.scrollTop = above;
  else if (above + ROW > grid.scrollTop + room) grid.scrollTop = above + ROW - room;
  const cells = head.children[column + 1];
  if (cells) {
    const left = cells.offsetLeft, name = head.firstChild.offsetWidth || first;
    if (left - name < grid.scrollLeft) grid.scrollLeft = left - name;
    else if (left + cells.offsetWidth > grid.scrollLeft + grid.clientWidth) grid.scrollLeft = left + cells.offsetWidth - grid.clientWidth;
  }
  draw();
};

/** Sets a control and what it stands for. */
const by = (name, value) => {
  state[name] = value;
  const select = document.getElementById(`by-${name}`);
  if (select) select.value = value;
};
const current = () => (shownRows[row]?.cells.get(shownWays[column]) ?? [])[sample];
const pick = (toRow, toColumn) => {
  row = Math.min(Math.max(0, toRow), Math.max(0, shownRows.length - 1));
  column = Math.min(Math.max(0, toColumn), Math.max(0, shownWays.length - 1));
  sample = 0;
  reveal();
  if (open) showAnswer();
};
grid.addEventListener("click", (event) => {
  const place = event.target.closest(".line:not(.head)"), at = event.target.closest(".cell");
  if (!place || !at || at.dataset.way === undefined) return;
  open = true;
  pick(Number(place.dataset.row), Number(at.dataset.way));
});
/** Picks the next answer, in a direction, that the filter or else a wrong verdict marks. */
const next = (step) => {
  const total = shownRows.length * shownWays.length;
  const from = row * shownWays.length + column;
  for (let k = 1; k <= total; k++) {
    const at = (from + step * k + total * k) % total;
    const of = shownRows[Math.floor(at / shownWays.length)], answers = of.cells.get(shownWays[at % shownWays.length]) ?? [];
    const found = answers.findIndex((a) => (state.only ? marks.letter[a] === state.only : marks.letter[a] === "W") && (named(of) || hits === null || hits.has(a)));
    if (found < 0) continue;
    pick(Math.floor(at / shownWays.length), at % shownWays.length);
    sample = found;
    if (open) showAnswer();
    return;
  }
};
