
// One answer in full: its texts are read from the blocks of the page when they are asked for.
const blocks = new Map();
const block = (name) => {
  if (!blocks.has(name)) blocks.set(name, JSON.parse(document.getElementById(`data-${name}`).textContent));
  return blocks.get(name);
};
const textBlock = (place) => {
  let low = 0, high = data.texts.length - 1;
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (data.texts[middle] <= place) low = middle; else high = middle - 1;
  }
  return low;
};
const text = (place) => {
  const number = textBlock(place);
  return block(`texts-${number}`)[place - data.texts[number]];
};
const detail = (at) => block(`details-${Math.floor(at / data.details)}`)[at % data.details];

/** Looks for the words in the texts of all answers, in pieces, so that typing is never held up. */
const search = () => {
  const wanted = words.value.trim().toLowerCase();
  if (wanted === state.words) return;
  state.words = wanted;
  hits = wanted ? new Set() : null;
  if (!wanted) return update();
  let at = 0;
  const known = new Map();
  const piece = () => {
    if (state.words !== wanted) return;
    const until = performance.now() + 12;
    while (at < count && performance.now() < until) {
      const place = detail(at).text;
      if (place !== null) {
        if (!known.has(place)) known.set(place, text(place).toLowerCase().includes(wanted));
        if (known.get(place)) hits.add(at);
      }
      at++;
    }
    if (at < count) return setTimeout(piece);
    document.body.dataset.searched = wanted;
    update();
  };
  piece();
};

const percent = (p) => `${(100 * p).toFixed(0)} %`;
const section = (title, ...children) => [make("h3", {}, title), ...children];

/** The text of an answer with its claims marked. */
const marked = (whole, claims) => {
  const parts = [];
  let from = 0;
  claims.forEach((claim, i) => {
    if (claim.start < from) return;
    parts.push(whole.slice(from, claim.start));
    parts.push(make("mark", { class: claim.letter === "?" ? "U" : claim.letter, id: `claim-${i}`, title: claim.line }, whole.slice(claim.start, claim.end)));
    from = claim.end;
  });
  return make("pre", { id: "text" }, ...parts, whole.slice(from));
};
const claimList = (claims) => claims.map((claim, i) => claim.letter === "N" ? null :
  make("li", {}, make("b", { class: claim.letter === "?" ? "U" : claim.letter, title: { R: "right", W: "wrong", "?": "open" }[claim.letter] }, claim.letter),
    make("button", { title: "Show it in the answer", onclick: () => {
      for (const old of panel.querySelectorAll("mark.at")) old.classList.remove("at");
      const place = document.getElementById(`claim-${i}`);
      place?.classList.add("at");
      place?.scrollIntoView({ block: "center" });
    } }, claim.line))).filter(Boolean);

const verdict = (status) => {
  if (status.missing) return [make("p", { class: "facts" }, status.why)];
  const probability = [["stated probability", status.probability], ["probability by tokens", status.token_probability]]
    .filter(([, p]) => p !== null).map(([name, p]) => `${name} ${percent(p)}`);
  const critical = status.critical === null ? [] : [status.critical.length
    ? `critical: ${status.critical.map(([id, p]) => (p === null ? id : `${id} (${percent(p)})`)).join(", ")}` : "critical: none"];
  return [
    make("p", { class: "facts" }, [...critical, ...probability].join(" · ")),
    status.why ? make("p", { class: "facts" }, status.why) : null,
    status.obstacles.length ? make("ul", {}, ...status.obstacles.map(([id, risk, reason]) =>
      make("li", {}, make("b", { title: "risk score" }, String(risk)), `${id}${reason ? `: ${reason}` : ""}`))) : null,
  ];
};

/** A picture that a question was sent with, as it was; a click enlarges it. */
const sentPicture = ({ picture, size, missing }, of) => {
  if (missing) return make("p", { class: "facts" }, missing);
  const [width, height] = size;
  const alt = `Picture that the model was sent with the question about ${of.scenario}; how it is read stands in the prompt`;
  const shown = make("img", { class: "sent", alt, width, height, src: block(`sent-${picture}`) });
  return make("button", { class: "sent", title: `${width} × ${height} pixels; enlarge or fit`, onclick: () => shown.classList.toggle("full") }, shown);
};

let prompts = false; // whether prompts are unfolded, kept from one answer to the next
const SHOWN = { R: "Right", W: "Wrong", N: "No verdict", "?": "Truth unknown" };
const showAnswer = () => {
  const of = shownRows[row], way = shownWays[column], at = current();
  panel.hidden = false;
  document.body.classList.add("open");
  if (at === undefined) {
    panel.replaceChildren(make("p", { class: "facts" }, "This question was not asked in this way."));
    return;
  }
  const { status, messages, sent, text: place, claims, returned, finish, used } = detail(at);
  const letter = marks.letter[at], answers = of.cells.get(way);
  const button = (label, title, onclick) => make("button", { title, onclick }, label);
  const badge = `${letter} ${SHOWN[letter]}: ${status.missing ?? `says ${SAID[marks.said[at]]} (${status.word})`}`;
  const truth = `truth ${truthOf(of)}${of.critical.length ? `, critical ${of.critical.join(", ")}` : ""}`;
  const facts = [
    returned && (returned === ways[way].model.replace(/^[^/]*\//, "") ? `model returned ${returned}` : `model returned ${returned}, asked for ${ways[way].model}`),
    finish && `ended: ${finish}`, used.duration_ms !== null && `${(used.duration_ms / 1000).toFixed(1)} s`,
    used.input_tokens !== null && `${number(used.input_tokens)} tokens in`, used.output_tokens !== null && `${number(used.output_tokens)} out`,
    used.cost_usd !== null && `$${used.cost_usd.toPrecision(3)}`].filter(Boolean).join(" · ");
  const picture = of.picture === null
    ? make("p", { class: "facts" }, "No picture: the scenario was not at hand.")
    : make("img", { id: "picture", alt: `Map of ${of.scenario} at the last step of the window`, src: `data:image/svg+xml;charset=utf-8,${encodeURIComponent(block(`picture-${of.picture}`))}` });
  const whole = place === null ? null : text(place);
  const count = (letter) => (claims ?? []).filter((claim) => claim.letter === letter).length;
  const outcomes = [["R", LETTERS.R], ["W", LETTERS.W], ["?", "open"]].map(([l, word]) => `${count(l)} ${word}`).join(", ");
  const told = claims?.length ? `Claims: ${outcomes}; sentences not understood: ${count("N")}` : "Claims";
  panel.replaceChildren(...[
    make("header", {},
      make("div", {}, make("h2", {}, of.scenario), make("p", {}, [of.task, about(of), truth].filter(Boolean).join(" · ")), make("p", {}, ways[way].name)),
      answers.length > 1 ? button(`sample ${sample + 1} of ${answers.length}`, "Next sample (s)", () => { sample = (sample + 1) % answers.length; showAnswer(); }) : null,
      messages.length ? button("Prompt", "Unfold the prompt (p)", () => keys.p()) : null,
      button("‹", "Previous wrong answer (b)", () => next(-1)), button("›", "Next wrong answer (n)", () => next(1)), button("Close", "Close (Escape)", close)),
    make("span", { class: `badge ${letter === "?" ? "U" : letter}`, id: "badge" }, badge),
    ...verdict(status),
    picture,
    ...(sent.length ? section("Picture that the model was sent", ...sent.map((one) => sentPicture(one, of))) : []),
    ...(whole === null ? [] : section("Answer", facts ? make("p", { class: "facts" }, facts) : null, marked(whole, claims ?? []))),
    ...section(told, claims === null ? make("p", { class: "facts" }, "Not checked: the scenario was not at hand.")
      : claims.length > count("N") ? make("ul", { id: "claims" }, ...claimList(claims)) : make("p", { class: "facts" }, "No claim about an obstacle was found.")),
    ...(messages.length ? section("Prompt", ...messages.map(([role, place]) => {
      const fold = make("details", { class: "prompt", open: prompts }, make("summary", {}, `${role} · ${number(text(place).length)} characters`));
      fold.addEventListener("toggle", () => { if (fold.open && !fold.querySelector("pre")) fold.append(make("pre", {}, text(place))); });
      return fold;
    })) : []),
  ].filter((child) => child !== null && child !== undefined));
  panel.scrollTop = 0;
  clearTimeout(panel.timer);
  panel.timer = setTimeout(() => history.replaceState(null, "", `#${[of.key, ways[way].name, sample].map(encodeURIComponent).join("/")}`), 300);
};
const close = () => {
  open = false;
  clearTimeout(panel.timer);
  panel.hidden = true;
  document.body.classList.remove("open");
  history.replaceState(null, "", "#");
  grid.focus({ preventScroll: true });
  draw();
};
const clear = () => {
  words.value = "";
  hits = null;
  Object.assign(state, { words: "" });
  for (const name of ["only", "task", "truth", "model", "frame", "techniques"]) by(name, "");
  update();
};

// Keys.
const KEYS = [["← ↑ → ↓", "Move; the open answer follows"], ["Home End PgUp PgDn", "Move far"], ["Enter", "Open the answer"], ["Escape", "Close, or clear the filter"],
  ["/", "Filter by scenario or answer text"], ["w", "Only wrong answers, or all"], ["n b", "Next, previous wrong answer"], ["s", "Next sample"], ["p", "Unfold the prompt"],
  ["t", "Tables or answers"], ["?", "These keys"]];
const help = make("dialog", { id: "keys", "aria-label": "Keys" }, make("strong", {}, "Keys"),
  make("dl", {}, ...KEYS.flatMap(([key, what]) => [make("dt", {}, ...key.split(" ").flatMap((k) => [make("kbd", {}, k), " "])), make("dd", {}, what)])),
  make("button", { onclick: () => help.close() }, "Close"));
const page = () => Math.max(1, Math.floor((grid.clientHeight - head.offsetHeight) / ROW) - 1);
const moves = {
  ArrowUp: () => pick(row - 1, column), ArrowDown: () => pick(row + 1, column), ArrowLeft: () => pick(row, column - 1), ArrowRight: () => pick(row, column + 1),
  PageUp: () => pick(row - page(), column), PageDown: () => pick(row + page(), column), Home: () => pick(0, column), End: () => pick(shownRows.length - 1, column),
};
const keys = {
  ...moves,
  Enter: () => { open = true; pick(row, column); },
  "/": () => { words.focus(); words.select(); },
  "?": () => help.showModal(),
  w: () => { by("only", state.only === "W" ? "" : "W"); update(); if (open) showAnswer(); },
  n: () => next(1),
  b: () => next(-1),
  s: () => { const answers = shownRows[row]?.cells.get(shownWays[column]); if (open && answers) { sample = (sample + 1) % answers.length; showAnswer(); } },
  p: () => { prompts = !prompts; for (const fold of panel.querySelectorAll("details.prompt")) fold.open = prompts; panel.querySelector("details.prompt")?.scrollIntoView(); },
  t: () => tab(reading ? "tables" : "answers"),
};
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || help.open) return;
  const typing = event.target.closest?.("input, select");
  if (event.key === "Escape" && reading) {
    if (typing) { if (typing === words && words.value) { words.value = ""; search(); } grid.focus({ preventScroll: true }); }
    else if (open) close();
    else clear();
    event.preventDefault();
    return;
  }
  if (typing === words && (event.key === "Enter" || event.key === "ArrowDown")) { grid.focus({ preventScroll: true }); event.preventDefault(); return; }
  const inPanel = panel.contains(event.target);
  const onButton = event.target.closest?.("button, summary");
  if (typing || !(event.key in keys) || (!reading && event.key !== "t") || (inPanel && event.key in moves) || (onButton && event.key === "Enter")) return;
  event.preventDefault();
  keys[event.key]();
});

// The page: answers and tables as two tabs.
const main = document.querySelector("main"), answers = document.getElementById("answers");
let reading = false;
const tab = (name) => {
  reading = name === "answers";
  main.hidden = reading;
  answers.hidden = !reading;
  document.body.classList.toggle("reading", reading);
  for (const button of tabs.querySelectorAll("button")) button.setAttribute("aria-selected", String(button.dataset.tab === name));
  if (reading) { drawn = ""; drawHead(); draw(); grid.focus({ preventScroll: true }); } else scrollTo(0, 0);
};
const tabs = make("nav", { class: "tabs", role: "tablist" }, make("strong", {}, document.title),
  ...[["answers", `Answers (${number(count)})`], ["tables", "Tables"]].map(([name, label]) => make("button", { role: "tab", "data-tab": name, onclick: () => tab(name) }, label)));
answers.append(tools, status, make("div", { class: "panes" }, grid, panel), help);
document.body.prepend(tabs);
document.querySelector("h1").hidden = true;
const go = () => {
  const [key, name, number] = location.hash.slice(1).split("/").map((part) => { try { return decodeURIComponent(part); } catch { return part; } });
  const toRow = shownRows.findIndex((of) => of.key === key), toColumn = shownWays.findIndex((way) => ways[way].name === name);
  if (toRow < 0 || toColumn < 0) return;
  open = true;
  pick(toRow, toColumn);
  sample = Number(number) || 0;
  showAnswer();
};
addEventListener("resize", () => { drawn = ""; drawHead(); draw(); });
new ResizeObserver(() => { drawn = ""; layout(head); draw(); }).observe(grid);
addEventListener("hashchange", go);
tab(location.hash === "#tables" ? "tables" : "answers");
update();
go();
})();
