// The page draws the server's results and sends the user's actions. It computes no result that the terminal prints.
import { ask, download, drop, listen, recall } from "/page/api.js";
import { add, partly, rank } from "/page/parts/candidates.js";
import { draggable } from "/page/drag.js";
import * as charts from "/page/charts.js";
import { closer, look, record, sights, worst } from "/page/parts/closer.js";
import * as landing from "/page/parts/landing.js";
import { heard, live } from "/page/parts/live.js";
import { planning } from "/page/parts/plan.js";
import { acting, at, change, changed, dead, doing, leaving, newest, now, say, shownBy, stale } from "/page/now.js";
import * as stack from "/page/parts/stack.js";
import { falling, timeline } from "/page/parts/timeline.js";
import { element, fill, number } from "/page/words.js";

const OF_A_STEP = ["refit", "save", "save-h", "report"]; // buttons
const LATER = ["falling", "residual", "map", "spectrum", "record", "against", "spectrogram"]; // charts drawn after the others

async function refresh() {
  const turn = ++now.turn;
  recall();
  now.all = await ask("all");
  live(now.all).catch(() => {});
  if (now.all.recording && now.all.state !== now.view?.state) stale(true);
  at("landing").hidden = Boolean(now.all.recording);
  at("bench").hidden = !now.all.recording || !now.view; // show nothing of a closed recording
  at("close").hidden = !now.all.recording;
  at("axis-label").hidden = !now.all.recording;
  if (!now.all.recording) for (const id of [...OF_A_STEP, "undo", "redo"]) at(id).disabled = true;
  at("recording").textContent = now.all.recording ? `${now.all.recording.split("/").at(-1)}: ${now.all.samples} samples${now.all.missing ? ` (${now.all.missing} missing in ${now.all.gaps} gaps)` : ""}, ${number(now.all.rate_hz, 6)} Hz` : "";
  if (!now.all.recording) {
    now.view = now.found = null;
    const actions = { drop: (file) => doing(`reading ${file.name}`, async () => { await drop(file); await refresh(); }),
      listen: (source) => change(`listening to ${source}`, "listen", { source }), tutorial: () => change("opening the tutorial recording", "tutorial"), close: () => leaving("", "close"),
      names: (names) => change("reading the columns by these names", "names", { names }),
      sensor: (name) => change(`reading ${name} and fitting a first model`, "sensor", { name }),
      read: (columns, rate_hz, as_recorded) => change("reading the recording and fitting a first model", "read", { columns, rate_hz, as_recorded }) };
    landing[now.all.log?.sensors ? "sensors" : now.all.log ? "columns" : "first"](now.all, actions);
    stale(false);
    return;
  }
  fill("axis", ...now.all.gyros.map((name) => element("option", { value: name, selected: name === now.all.column }, name)));
  const next = await ask("step", { number: now.all.current });
  if (turn !== now.turn || next.state !== now.all.state) return; // the server reports the change in the meantime with an event
  if (next.state !== now.view?.state) fill("cell");
  now.view = next;
  at("bench").hidden = false;
  now.found = null;
  await show(turn);
}

// Draws the charts that the user waits for first. rest() draws the others and stops if another step is selected.
async function show(turn) {
  for (const id of OF_A_STEP) at(id).disabled = false;
  for (const id of LATER) if (at(id)) dead(id, true);
  fill("peak");
  verdict();
  stack.draw(now.view, cards);
  timeline();
  charts.stopMoving();
  draggable(await charts.deviation(now.view), now.view, cards);
  if (turn !== now.turn) return;
  heldOut();
  rank(turn);
  stale(false);
  rest(turn);
}

async function rest(turn) {
  const { view } = now;
  const drawn = [["falling", falling], [null, sights], ["residual", () => charts.residual(view)], ["map", () => charts.map(view, look)],
    ["spectrum", () => charts.spectrum(view, (point) => peak(view, point))], ["record", record], [null, closer]];
  for (const [id, draw] of drawn) {
    await new Promise((done) => setTimeout(done));
    if (turn !== now.turn) return;
    try { await draw(); } catch { continue; } // an old chart stays dimmed
    if (id && turn === now.turn) dead(id, false);
  }
}

function peak(view, point) {
  const f_hz = view.spectrum.peak_hz[point.pointIndex], at_hz = `at ${number(f_hz, 6)} Hz`; // the peak of the clicked group of frequencies
  const offer = (text, wide) => element("button", { onclick: () => acting(`adding a line ${at_hz}`, "line", { f_hz, wide }) }, text);
  fill("peak", offer(`Add a sharp line ${at_hz}`, false), offer(`Add a line with a width ${at_hz}`, true));
}

function verdict() {
  const place = fill("verdict",
    element("div", { class: "figure" }, "error ", element("b", { id: "error-value" }, number(now.view.error)), ` (floor ${number(now.view.floor)})`),
    element("div", { class: "said", id: "said" }, now.view.said),
    element("div", { class: "figure" }, now.view.p_value === null ? "" : now.view.p_value < 1e-6 ? "p < 1e-6" : `p ${number(now.view.p_value, 2)}`),
    element("div", { class: "figure", id: "held-out-error" }),
    ...now.view.observations.map((one) => element("div", { class: "observation" }, one.said)), ...now.view.notes.map((note) => element("div", {}, note)));
  place.className = now.view.adequacy;
}

// The error on the held-out recording, which is never used for fitting.
async function heldOut() {
  if (!now.all.held_out) return;
  at("held-out-error").textContent = "held out …";
  const { turn } = now;
  let said;
  try {
    const { error, floor } = await ask("held_out", { number: now.view.number });
    said = `held out ${number(error)} (floor ${number(floor)})`;
  } catch (why) {
    said = `held out: ${why.message}`;
  }
  if (turn === now.turn) at("held-out-error").textContent = said;
}

// The curve of a changed shape cannot be computed here by adding variances: the server sends it.
const follow = newest(async (given, still) => {
  const answer = await ask("preview", given);
  if (still() && document.activeElement?.type === "range") charts.moving(answer.tau_s, answer.model);
});

const cards = {
  moved: (card, parameter, value) => {
    const model = stack.withSize(now.view, card, parameter, value);
    if (model) charts.moving(now.view.deviation.tau_s, model); else follow({ place: card.place, kind: card.kind, name: parameter.name, value, state: now.view.state });
  },
  released: (card, parameter, value) => acting(`testing ${parameter.name} = ${value}`, "set", { place: card.place, kind: card.kind, parameters: { [parameter.name]: value } }),
  off: (card) => acting(`fitting without ${card.name}`, "remove", { place: card.place, kind: card.kind }),
  on: (one, place) => acting(`fitting with ${one.kind.replaceAll("_", " ")} again`, "restore", { place, kind: one.kind }),
};

const keys = { u: () => at("undo").click(), r: () => at("redo").click(), f: () => at("refit").click(), s: () => at("save").click(),
  w: () => now.view && !now.stale && worst(), "?": () => at("help").showModal() };

document.addEventListener("keydown", (event) => {
  if (event.target.matches("input, select, textarea") || event.ctrlKey || event.altKey || event.metaKey) return;
  if (planning() && event.key !== "?") return; // the other keys act on the model
  if (keys[event.key]) keys[event.key]();
  else if (/^[1-9]$/.test(event.key)) add(event.key - 1);
  else return;
  event.preventDefault();
});
at("axis").onchange = () => leaving(`analysing ${at("axis").value}`, "sight", { column: at("axis").value });
at("refit").onclick = () => acting("fitting all values", "refit", { held: stack.held(now.view) });
const home = (id, what, given, name) => { at(id).onclick = () => doing("writing the file", () => download(what, { ...given, state: now.view.state }, name)); };
home("save", "save", { what: "toml" }, "model.toml");
home("save-h", "save", { what: "h" }, "model.h");
home("report", "report", {}, "report.html");
at("close").onclick = () => leaving("", "close");
at("help-button").onclick = () => at("help").showModal();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => now.view && show(now.turn));

// Shown if the server does not answer: which steps are saved, and how to continue.
function gone() {
  say("");
  stale(true);
  const kept = now.all?.recording ? `The ${now.all.steps.length} step${now.all.steps.length > 1 ? "s" : ""} listed below are saved in ${now.all.session}. An unfinished computation is lost. ` : "";
  fill("gone", element("b", {}, "The workbench server does not answer. "), kept, "The page reconnects when the server answers. If the server has stopped, run ",
    element("code", {}, now.all?.again || "tools/davarlab open"), " and open the address that it prints.");
  at("gone").hidden = false;
}

shownBy(refresh);
listen((event) => {
  if (event.progress) say(event.progress);
  if (event.candidates) partly(event);
  if (event.live) heard(event.live);
  if (event.changed) changed(event.changed);
}, gone, () => { at("gone").hidden = true; });
