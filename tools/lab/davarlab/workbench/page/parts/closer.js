// Details: parts of the recording and cells, the residual against a column, spectra over time, the axes and a data sheet.
import { act, ask, drop } from "/page/api.js";
import * as charts from "/page/charts.js";
import { at, change, dead, doing, leaving, newest, now } from "/page/now.js";
import { element, fill, number } from "/page/words.js";

let sheet = null, axes = null;

// Draws the residual against a column, and the axes of the sensor together.
export async function closer() {
  const chosen = at("against-column").value;
  fill("against-column", ...now.all.columns.map((name) => element("option", { value: name, selected: name === (chosen || "temp_degC") }, name)));
  const { turn } = now;
  await beside({});
  if (turn !== now.turn) return; // another recording or part was selected
  fill("over", ...["time_s", ...now.all.columns].map((name) => element("option", { value: name, selected: name === at("over").dataset.chosen }, name)));
  await charts.spectrogram(await ask("spectrogram", { column: at("over").value }));
  if (turn !== now.turn) return;
  dead("spectrogram", false);
  await sensor();
}

// Draws the axes of the sensor, and the curve of its data sheet.
async function sensor() {
  if (axes?.of !== now.all.recording) axes = { of: now.all.recording, all: (await ask("axes")).axes };
  await charts.axes(axes.all, sheet);
}

// The lag of the slider: 0 to a tenth of the recording, logarithmic.
const lag = () => (Number(at("lag").value) ? 0.1 * now.all.duration_s * 1000 ** (Number(at("lag").value) / 100 - 1) : 0);

const beside = newest(async () => {
  at("lag-s").textContent = number(lag(), 2);
  if (at("against-column").value) await charts.against(await ask("against", { column: at("against-column").value, lag_s: lag() }));
  dead("against", false);
});

// Converts seconds of the analysed part to seconds of the whole recording.
const whole = (edges) => edges.map((edge) => edge + (now.all.alone[0] || 0));

export function sights() {
  const said = (one) => one.column + (one.alone.length ? `, ${number(one.alone[0], 6)} to ${number(one.alone[1], 6)} s only` : "")
    + one.cut.map(([a, b]) => `, without ${number(a, 6)} to ${number(b, 6)} s`).join("");
  fill("sights", ...now.all.sights.map((one, place) => element("option", { value: place, selected: one.here }, said(one))));
  at("cut").disabled = now.all.alone.length > 0;
  at("held-name").textContent = now.all.held_out ? now.all.held_out.split("/").at(-1) : now.all.not_held;
  at("let-go").hidden = !now.all.held_out;
}

export async function record() {
  const stretch = await ask("stretch", { start_s: 0, stop_s: now.all.duration_s });
  const marks = now.view.observations.flatMap((one) => (one.stretches || []).map(([start_s, stop_s]) => ({ start_s, stop_s })));
  await charts.envelope("record", stretch.envelopes[0], marks);
}

export async function look(cell) {
  await doing("loading the samples", async () => {
    const stretch = await ask("stretch", { start_s: cell.start_s, stop_s: cell.stop_s });
    fill("cell", element("h2", {}, `${number(cell.start_s, 6)} to ${number(cell.stop_s, 6)} s, averaging time ${number(cell.tau_s)} s`),
      element("p", { id: "cell-said" }, `Measured ${number(cell.measured)} deg/s, model ${number(cell.model)} deg/s. The ratio is ${number(cell.ratio)}, `
        + `which is ${number(cell.z, 2)} standard deviations${cell.proven ? ". The misfit is proven (99 % confidence)" : ""}.`),
      element("button", { onclick: () => leaving("analysing this part", "sight", { alone: whole([cell.start_s, cell.stop_s]) }) }, "Analyse only this part"),
      ...stretch.envelopes.map((_, i) => element("div", { id: `samples-${i}`, class: "chart strip" })), element("div", { id: "cell-spectrum", class: "chart" }));
    for (const [i, one] of stretch.envelopes.entries()) await charts.envelope(`samples-${i}`, one);
    await charts.density("cell-spectrum", stretch.f_hz, stretch.density);
    at("cell").scrollIntoView({ block: "nearest" });
  });
}

export const worst = () => look(now.view.map.reduce((a, b) => (Math.abs(b.z) > Math.abs(a.z) ? b : a)));

at("against-column").onchange = () => beside({});
at("over").onchange = () => {
  at("over").dataset.chosen = at("over").value;
  doing("", async () => charts.spectrogram(await ask("spectrogram", { column: at("over").value })));
};
at("lag").oninput = () => beside({});
const SHEET = { angle_random_walk: "sheet-arw", bias_instability: "sheet-bi", rate_random_walk: "sheet-rrw" };
at("sheet").onsubmit = (event) => {
  event.preventDefault();
  const given = Object.fromEntries(Object.entries(SHEET).map(([kind, id]) => [kind, at(id).value]));
  doing("", async () => { sheet = await ask("sheet", Object.fromEntries(Object.entries(given).filter(([, value]) => value))); await sensor(); });
};
at("kalibr").onchange = () => at("kalibr").files[0] && doing("reading the kalibr file", async () => {
  const file = at("kalibr").files[0];
  at("kalibr").value = ""; // so that choosing the same, corrected file again triggers a change event
  const text = await file.text();
  const { sheet: said } = await act("kalibr", { text });
  for (const [kind, id] of Object.entries(SHEET)) at(id).value = said[kind] === undefined ? "" : Number(said[kind].toPrecision(6));
  at("sheet").requestSubmit();
});
at("held-file").onchange = () => at("held-file").files[0] && doing("reading the held-out recording", async () => {
  const file = at("held-file").files[0];
  at("held-file").value = "";
  await drop(file, "held-out");
});
at("let-go").onclick = () => change("removing the held-out recording", "let_go");
const span = () => whole([Number(at("from").value), Number(at("to").value)]);
at("alone").onclick = () => leaving("analysing this part", "sight", { alone: span() });
at("cut").onclick = () => leaving("excluding this part", "sight", { cut: [...now.all.cut, span()] });
at("sights").onchange = () => {
  const { column, alone, cut } = now.all.sights[Number(at("sights").value)];
  leaving("analysing the selection", "sight", { column, alone, cut });
};
