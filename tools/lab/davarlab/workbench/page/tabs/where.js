// Where it fails: averaging time over the time of the recording, the record on the same time axis, and the samples of the selected cell.
import { ask } from "/page/api.js";
import * as cells from "/page/chart/cells.js";
import { clockMarks, scale } from "/page/chart/scale.js";
import { area, canvas, svg } from "/page/chart/svg.js";
import { xy } from "/page/chart/xy.js";
import { at, hear, leaving, newest, now, rateUnit, refused, show } from "/page/now.js";
import { showing } from "/page/tabs/tabs.js";
import { brief, element, fill, number } from "/page/words.js";

let record = null, recordOf = null;

export function build(panel) {
  const field = (id, name) => element("label", {}, `${name} `, element("input", { type: "number", id, step: "any", min: 0 }));
  panel.append(element("div", { class: "where" }, element("div", { class: "plot", id: "map" }), element("div", { id: "cell", class: "aside", tabindex: 0, role: "group", "aria-label": "The selected cell" })),
    element("form", { id: "stretch", class: "row bottom", onsubmit: (event) => event.preventDefault() }, field("from", "From"), field("to", "to"), "s",
      element("button", { type: "button", id: "alone", onclick: () => leaving("Analysing this part", "sight", { column: now.all.column, alone: span() }) }, "Analyse only this"),
      element("button", { type: "button", id: "cut", onclick: () => leaving("Excluding this part", "sight", { column: now.all.column, cut: [...now.all.cut, span()] }) }, "Exclude it"),
      element("span", { class: "grow" }), element("label", { id: "sights-label" }, "Analysed ", element("select", { id: "sights", onchange: other }))));
}

// Converts seconds of the analysed part to seconds of the whole recording.
const whole = (edges) => edges.map((edge) => edge + (now.all.alone[0] || 0));
const span = () => whole([Number(at("from").value), Number(at("to").value)]);

function other() {
  const { column, alone, cut } = now.all.sights[Number(at("sights").value)];
  leaving("Analysing the selection", "sight", { column, alone, cut });
}

export function sights() {
  const said = (one) => one.column + (one.alone.length ? `, ${number(one.alone[0], 6)} to ${number(one.alone[1], 6)} s only` : "")
    + one.cut.map(([a, b]) => `, without ${number(a, 6)} to ${number(b, 6)} s`).join("");
  fill("sights", ...now.all.sights.map((one, place) => element("option", { value: place, selected: one.here }, said(one))));
  at("sights-label").hidden = now.all.sights.length < 2;
  at("cut").disabled = now.all.alone.length > 0;
}

export async function draw() {
  const { turn, all } = now, of = JSON.stringify([all.recording, all.column, all.alone, all.cut]);
  if (recordOf !== of) {
    map(null);
    const found = await ask("stretch", { start_s: 0, stop_s: all.duration_s });
    if (turn !== now.turn) return;
    [record, recordOf] = [found.envelopes[0], of];
  }
  map(record);
  await look(now.cell);
}

// The map over the record, on one axis of time.
function map(envelope) {
  const made = canvas(at("map"));
  if (!made) return;
  const { drawing, width, height } = made, left = 54, right = width - (width < 560 ? 10 : 100), top = 10, recordHeight = Math.max(50, Math.min(110, height * 0.26)), bottom = height - recordHeight - 34;
  const tau = now.view.deviation.tau_s, row = (bottom - top) / tau.length, X = scale(false, 0, now.all.duration_s, left, right), strip = svg("g", { class: "strip" }, drawing);
  drawing.setAttribute("role", "group");
  drawing.setAttribute("aria-label", "Averaging time over time: where the model is too low or too high");
  for (const { cell, column } of cells.chosen(now.view.map, tau, now.length)) {
    const box = { x: X(cell.start_s) + 0.5, y: top + (tau.length - 1 - column) * row + 0.5, width: Math.max(1, X(cell.stop_s) - X(cell.start_s) - 1), height: Math.max(1, row - 1) };
    cells.paint(svg("rect", box, strip), box, cell.ratio, cell.z);
    const hit = svg("rect", { ...box, fill: "none", "pointer-events": "all", style: "cursor:pointer", class: "hit", ...(cells.alike(cell, now.cell) ? { stroke: "var(--ink)", "stroke-width": 2.5 } : {}) }, drawing);
    hit.addEventListener("click", () => show("cell", cell));
  }
  svg("rect", { x: left, y: top, width: right - left, height: bottom - top, fill: "none", stroke: "var(--edge)" }, drawing);
  const every = Math.ceil(16 / row);
  tau.forEach((t, i) => i % every || svg("text", { x: left - 6, y: top + (tau.length - 0.5 - i) * row + 4, "text-anchor": "end" }, drawing, brief(t)));
  if (width >= 560) cells.key(drawing, right + 14, top + 30);
  if (envelope) below(drawing, envelope, { X, y: bottom + 10, height: recordHeight, left, right });
  for (const [value, text] of clockMarks(0, now.all.duration_s, (right - left) / 90)) svg("text", { x: X(value), y: height - 6, "text-anchor": value ? "middle" : "start" }, drawing, text);
}

function below(drawing, envelope, { X, y, height, left, right }) {
  const low = Math.min(...envelope.low), high = Math.max(...envelope.high), Y = scale(false, low, high, y + height, y);
  const marked = now.view.observations.flatMap((one) => one.stretches || []);
  for (const [start, stop] of marked) svg("rect", { x: X(start), y, width: Math.max(1, X(stop) - X(start)), height, fill: "var(--ink)", "fill-opacity": 0.12 }, drawing);
  svg("path", { d: area(X, Y, envelope.time_s, envelope.low, envelope.high), fill: "var(--meas)", stroke: "var(--meas)", class: "record" }, drawing);
  for (const value of [low, high]) svg("text", { x: left - 6, y: Y(value) + (value === low ? 0 : 10), "text-anchor": "end" }, drawing, number(value, 2));
  if (right + 20 < drawing.viewBox.baseVal.width) svg("text", { x: right + 8, y: y + 14 }, drawing, envelope.column.slice(0, 14));
  if (now.cell) svg("rect", { x: X(now.cell.start_s), y, width: Math.max(2, X(now.cell.stop_s) - X(now.cell.start_s)), height, fill: "var(--ink)", "fill-opacity": 0.08, stroke: "var(--ink)", "stroke-width": 2 }, drawing);
}

hear("cell", () => { if (showing("where")) { map(record); look(now.cell).catch(refused); } });

// The samples and the spectrum of a cell.
const look = newest(async (cell, latest) => {
  if (!cell) {
    fill("cell", element("p", { class: "soft" }, "Select a cell to see its samples. Key w: the cell that the headline names."));
    return;
  }
  const stretch = await ask("stretch", { start_s: cell.start_s, stop_s: cell.stop_s });
  if (!latest()) return;
  [at("from").value, at("to").value] = [cell.start_s, cell.stop_s];
  fill("cell", element("b", {}, `${brief(cell.tau_s)}, ${brief(cell.start_s)} to ${brief(cell.stop_s)}`),
    element("p", { id: "cell-said", class: "small" }, `Measured ${number(cell.measured)}, model ${number(cell.model)} ${rateUnit()}: ratio ${number(cell.ratio)}, ${number(cell.z, 2)} standard deviations.${cell.proven ? " The misfit is proven (99 % confidence)." : ""}`),
    ...stretch.envelopes.map((_, i) => element("div", { id: `samples-${i}`, class: "mini" })), element("div", { id: "cell-spectrum", class: "mini" }));
  stretch.envelopes.forEach((one, i) => xy(at(`samples-${i}`), [{ x: one.time_s, y: one.low, low: one.low, high: one.high, band: true, strength: 0.8, colour: i ? "var(--model)" : "var(--meas)" }],
    { x: { clock: true }, y: { title: one.column }, right: 8, label: `Samples of ${one.column}` }));
  xy(at("cell-spectrum"), [{ x: stretch.f_hz, y: stretch.density, colour: "var(--meas)" }], { x: { log: true, title: "Hz" }, y: { log: true, title: `${rateUnit()}/√Hz` }, right: 8, label: "Spectrum of this part" });
});
