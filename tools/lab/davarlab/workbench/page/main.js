// The page: what the server says is drawn, what a person does is sent. The page computes nothing that a terminal would say.
import { act, ask, download, drop, listen } from "/page/api.js";
import * as charts from "/page/charts.js";
import * as landing from "/page/landing.js";
import * as stack from "/page/stack.js";
import { element, fill, number } from "/page/words.js";

let all = null, view = null, found = null, drawn = 0, busy = 0, missed = false;
const at = (id) => document.getElementById(id);

function say(text) { at("status").textContent = text; }

// Runs what a person asked for; what goes wrong is said in one line and nothing is lost. A change of another tab meanwhile is looked at behind it.
async function doing(text, work) {
  say(text);
  at("error").hidden = true;
  busy += 1;
  try {
    await work();
    say("");
  } catch (why) {
    at("error").textContent = why.message;
    at("error").hidden = false;
    say("");
  }
  busy -= 1;
  if (missed && !busy) { missed = false; await doing("", refresh); }
}

// An action; refused or not, the page then shows what is so.
const change = (text, what, given) => doing(text, async () => { try { await act(what, given); } finally { await refresh(); } });
const acting = (text, what, given = {}) => change(text, what, { ...given, number: view.number });

// Asks for what is wanted last; what is not wanted any more is neither asked nor drawn.
function newest(work) {
  let wanted = null, running = false;
  return async (given) => {
    wanted = given;
    if (running) return;
    running = true;
    while (wanted) {
      const now = wanted;
      wanted = null;
      try { await work(now, () => wanted === null); } catch { /* a picture less */ }
    }
    running = false;
  };
}

async function refresh() {
  const turn = ++drawn;
  all = await ask("all");
  at("landing").hidden = Boolean(all.recording);
  at("bench").hidden = !all.recording;
  for (const id of ["refit", "save", "save-h"]) at(id).disabled = !all.recording;
  at("close").hidden = !all.recording;
  at("axis-label").hidden = !all.recording;
  if (!all.recording) for (const id of ["undo", "redo"]) at(id).disabled = true;
  at("recording").textContent = all.recording ? `${all.recording.split("/").at(-1)}: ${all.samples} samples, ${number(all.rate_hz, 6)} Hz, ${all.gaps} gaps` : "";
  if (!all.recording) {
    view = found = null;
    const actions = { drop: (file) => doing(`reading ${file.name}`, async () => { await drop(file); await refresh(); }),
      tutorial: () => change("opening the tutorial's sensor", "tutorial"), close: () => change("", "close"),
      read: (columns, rate_hz) => change("reading the recording and fitting a first model", "read", { columns, rate_hz }) };
    if (all.log) landing.columns(all, actions); else landing.first(all, actions);
    return;
  }
  fill("axis", ...all.gyros.map((name) => element("option", { value: name, selected: name === all.column }, name)));
  const next = await ask("step", { number: all.current });
  if (turn !== drawn) return;
  view = next;
  found = null;
  await show(turn);
}

// What a person waits for first; the other charts follow, and stop where another step is wanted.
async function show(turn) {
  verdict();
  stack.draw(view, cards);
  timeline();
  charts.stopMoving();
  await charts.deviation(view);
  rank(turn);
  rest(turn);
}

async function rest(turn) {
  for (const draw of [falling, sights, () => charts.residual(view), () => charts.map(view, look), () => charts.spectrum(view, peak), record, closer]) {
    await new Promise((done) => setTimeout(done));
    if (turn !== drawn) return;
    await draw();
  }
}

let sheet = null, axes = null;

// What is left beside a column, and the axes of the sensor beside each other.
async function closer() {
  const chosen = at("against-column").value;
  fill("against-column", ...all.columns.map((name) => element("option", { value: name, selected: name === (chosen || "temp_degC") }, name)));
  await beside({});
  fill("over", ...["time_s", ...all.columns].map((name) => element("option", { value: name, selected: name === at("over").dataset.chosen }, name)));
  await charts.spectrogram(await ask("spectrogram", { column: at("over").value }));
  if (axes?.of !== all.recording) axes = { of: all.recording, all: (await ask("axes")).axes };
  await charts.axes(axes.all, sheet);
}

// A lag from nothing to a tenth of the record, in equal ratios.
const lag = () => (Number(at("lag").value) ? 0.1 * all.duration_s * 1000 ** (Number(at("lag").value) / 100 - 1) : 0);

const beside = newest(async () => {
  at("lag-s").textContent = number(lag(), 2);
  if (at("against-column").value) await charts.against(await ask("against", { column: at("against-column").value, lag_s: lag() }));
});

// Seconds of what is shown as seconds of the whole recording.
const whole = (edges) => edges.map((edge) => edge + (all.alone[0] || 0));

function sights() {
  const said = (one) => one.column + (one.alone.length ? `, ${number(one.alone[0], 6)} to ${number(one.alone[1], 6)} s alone` : "")
    + one.cut.map(([a, b]) => `, without ${number(a, 6)} to ${number(b, 6)} s`).join("");
  fill("sights", ...all.sights.map((one, place) => element("option", { value: place, selected: one.here }, said(one))));
  at("cut").disabled = all.alone.length > 0;
}

function peak(point) {
  if (confirm(`Add a line at ${number(point.x, 6)} Hz?`)) acting(`adding a line at ${number(point.x, 6)} Hz`, "line", { f_hz: point.x });
}

async function record() {
  const stretch = await ask("stretch", { start_s: 0, stop_s: all.duration_s });
  const marks = view.observations.flatMap((one) => (one.stretches || []).map(([start_s, stop_s]) => ({ start_s, stop_s })));
  await charts.envelope("record", stretch.envelopes[0], marks);
}

function verdict() {
  const place = fill("verdict",
    element("div", { class: "figure" }, "error ", element("b", { id: "error-value" }, number(view.error)), ` (floor ${number(view.floor)})`),
    element("div", { class: "said", id: "said" }, view.said),
    element("div", { class: "figure" }, view.p_value === null ? "" : view.p_value < 1e-6 ? "p < 1e-6" : `p ${number(view.p_value, 2)}`),
    ...view.observations.map((one) => element("div", { class: "observation" }, one.said)), ...view.notes.map((note) => element("div", {}, note)));
  place.className = view.adequacy;
}

// A shape has no sum to add: the server says the curve.
const follow = newest(async (given, still) => {
  const answer = await ask("preview", given);
  if (still() && document.activeElement?.type === "range") charts.moving(answer.tau_s, answer.model);
});

const cards = {
  moved: (card, parameter, value) => {
    const model = stack.withSize(view, card, parameter, value);
    if (model) charts.moving(view.deviation.tau_s, model); else follow({ place: card.place, name: parameter.name, value });
  },
  released: (card, parameter, value) => acting(`judging ${parameter.name} = ${value}`, "set", { place: card.place, parameters: { [parameter.name]: value } }),
  off: (card) => acting(`fitting without ${card.name}`, "remove", { place: card.place }),
  on: (place) => acting("fitting with it again", "restore", { place }),
};

// The candidates beside the fitted model; asked once a step is drawn, so that the curve is there first.
async function rank(turn) {
  found = null;
  if (!view.fitted) {
    fill("candidates", element("h2", {}, "What may be missing"), element("p", { class: "hint" }, "Values were set by hand: fit first."));
    return;
  }
  fill("candidates", element("h2", {}, "What may be missing"), element("p", { class: "hint" }, "Trying every effect …"));
  try {
    const answer = await ask("candidates", { number: view.number });
    if (turn !== drawn) return;
    if (answer.superseded) { setTimeout(() => turn === drawn && rank(turn), 500); return; }
    found = answer.candidates;
    fill("candidates", element("h2", {}, "What may be missing"),
      found.some((one) => one.beyond_chance) ? null : element("p", { id: "nothing" }, "Nothing beyond chance: of the effects in the table none is missing."),
      ...found.slice(0, 9).map(candidate));
    say("");
  } catch (why) {
    at("error").textContent = why.message;
    at("error").hidden = false;
  }
}

// What was found so far, while the rest is tried: to read, not yet to add.
function partly(event) {
  if (found || !view || event.ranking !== view.number) return;
  fill("candidates", element("h2", {}, "What may be missing"), element("p", { class: "hint" }, `Trying ${event.trying} …`),
    ...event.candidates.slice(0, 9).map((one) => element("div", { class: "candidate early" }, one.name, element("small", {}, one.why))));
}

function candidate(one) {
  const note = element("small", {}, one.why), confirm = one.place === 0 && one.beyond_chance ? element("small", {}, `To confirm: ${one.confirm}`) : null;
  const button = element("button", { class: `candidate${one.beyond_chance ? " strong" : ""}`, "data-kind": one.kind, title: one.confirm,
    onclick: () => add(one) }, `${one.place + 1}. ${one.name}`, note, confirm);
  let wanted = null;
  const leave = () => { clearTimeout(wanted); ghost({}); };
  for (const name of ["pointerenter", "focus"]) button.addEventListener(name, () => { clearTimeout(wanted); wanted = setTimeout(() => ghost({ one, note }), 300); });
  for (const name of ["pointerleave", "blur"]) button.addEventListener(name, leave);
  return button;
}

// The curve with a candidate, or of another step, beside the model's; of nothing: the model's alone.
const ghost = newest(async ({ one, note, step }, still) => {
  const turn = drawn;
  const answer = one ? await ask("ghost", { place: one.place, number: view.number }) : step ? await ask("step", { number: step.number }) : null;
  if (turn !== drawn || !view) return;
  if (note) note.textContent = `${one.why}. With it the error would be ${number(answer.error)} (floor ${number(answer.floor)}).`;
  if (still()) await charts.deviation(view, answer && { name: one ? one.name : `step ${step.number + 1}`, deviation: answer.deviation });
});

const add = (one) => change(`adding ${one.name}`, "add", { place: one.place, number: view.number });

async function look(cell) {
  await doing("looking closer", async () => {
    const stretch = await ask("stretch", { start_s: cell.start_s, stop_s: cell.stop_s });
    fill("cell", element("h2", {}, `${number(cell.start_s, 6)} to ${number(cell.stop_s, 6)} s, averaging time ${number(cell.tau_s)} s`),
      element("p", { id: "cell-said" }, `Measured ${number(cell.measured)} deg/s, model ${number(cell.model)} deg/s: ${number(cell.ratio)} times, `
        + `${number(cell.z, 2)} standard deviations${cell.proven ? ", proven" : ""}.`),
      element("button", { onclick: () => change("looking at it alone", "sight", { alone: whole([cell.start_s, cell.stop_s]) }) }, "Look at this stretch alone"),
      ...stretch.envelopes.map((_, i) => element("div", { id: `samples-${i}`, class: "chart strip" })), element("div", { id: "cell-spectrum", class: "chart" }));
    for (const [i, one] of stretch.envelopes.entries()) await charts.envelope(`samples-${i}`, one);
    await charts.density("cell-spectrum", stretch.f_hz, stretch.density);
    at("cell").scrollIntoView({ block: "nearest" });
  });
}

const worst = () => look(view.map.reduce((a, b) => (Math.abs(b.z) > Math.abs(a.z) ? b : a)));

const undone = {}; // step -> the one that was left for it

function timeline() {
  const here = all.steps[all.current], child = all.steps[undone[here.number]] || all.steps.filter((s) => s.parent === here.number).at(-1);
  at("undo").disabled = here.parent === null;
  at("redo").disabled = !child;
  at("undo").onclick = () => { undone[here.parent] = here.number; change("going back", "go", { number: here.parent }); };
  at("redo").onclick = () => child && change("going on", "go", { number: child.number });
  fill("timeline", element("h2", {}, "Steps"), element("ol", { class: "steps" }, ...all.steps.map((step) => element("li", {},
    element("button", { "aria-current": step.number === all.current ? "step" : null, onpointerenter: () => ghost(step.number === all.current ? {} : { step }), onpointerleave: () => ghost({}), onclick: () => change("going there", "go", { number: step.number }) },
      `${step.number + 1}${step.parent === null || step.parent === step.number - 1 ? "" : ` (from ${step.parent + 1})`}. ${step.did}: ${number(step.error)}`)))),
    element("div", { id: "falling", class: "chart" }),
    all.commands.length ? element("details", {}, element("summary", {}, "The same in a terminal"), element("pre", {}, all.commands.join("\n"))) : null,
    element("p", { class: "hint" }, `Kept in ${all.session}.`));
}

function falling() {
  const way = [];
  for (let step = all.steps[all.current]; step; step = step.parent === null ? null : all.steps[step.parent]) way.unshift(step);
  return charts.falling("falling", way);
}

const keys = { u: () => at("undo").click(), r: () => at("redo").click(), f: () => at("refit").click(), s: () => at("save").click(),
  w: () => view && worst(), "?": () => at("help").showModal() };

document.addEventListener("keydown", (event) => {
  if (event.target.matches("input, select, textarea") || event.ctrlKey || event.altKey || event.metaKey) return;
  if (keys[event.key]) keys[event.key]();
  else if (/^[1-9]$/.test(event.key) && found?.[event.key - 1]) add(found[event.key - 1]);
  else return;
  event.preventDefault();
});
at("axis").onchange = () => change(`looking at ${at("axis").value}`, "sight", { column: at("axis").value });
at("against-column").onchange = () => beside({});
at("over").onchange = () => {
  at("over").dataset.chosen = at("over").value;
  doing("", async () => charts.spectrogram(await ask("spectrogram", { column: at("over").value })));
};
at("lag").oninput = () => beside({});
at("sheet").onsubmit = (event) => {
  event.preventDefault();
  const given = { angle_random_walk: at("sheet-arw").value, bias_instability: at("sheet-bi").value, rate_random_walk: at("sheet-rrw").value };
  doing("", async () => { sheet = await ask("sheet", Object.fromEntries(Object.entries(given).filter(([, value]) => value))); await charts.axes(axes.all, sheet); });
};
const span = () => whole([Number(at("from").value), Number(at("to").value)]);
at("alone").onclick = () => change("looking at it alone", "sight", { alone: span() });
at("cut").onclick = () => change("cutting it out", "sight", { cut: [...all.cut, span()] });
at("sights").onchange = () => { const one = all.sights[Number(at("sights").value)]; change("looking there", "sight", { column: one.column, alone: one.alone, cut: one.cut }); };
at("refit").onclick = () => acting("fitting all values", "refit");
at("save").onclick = () => doing("saving", () => download("toml", "model.toml"));
at("save-h").onclick = () => doing("saving", () => download("h", "model.h"));
at("close").onclick = () => change("", "close");
at("help-button").onclick = () => at("help").showModal();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => view && show(drawn));

listen((event) => {
  if (event.progress) say(event.progress);
  if (event.candidates) partly(event);
  if (event.changed && busy) missed = true;
  else if (event.changed) doing("", refresh);
}, () => say("the server has gone; nothing is lost, start it again with tools/davarlab open"));
