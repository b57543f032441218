// The charts. Plotly draws them. While a slider moves, a separate SVG path follows it, because Plotly is too slow for that.
import { duration, number } from "/page/words.js";

// Plotly interprets <b> and %{..} in names as markup.
const literal = (text) => String(text).replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;").replaceAll("%{", "% {");
const dark = () => matchMedia("(prefers-color-scheme: dark)").matches;
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const band = () => (dark() ? "rgba(86,180,233,.25)" : "rgba(0,114,178,.18)");
const COLOURS = ["#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#f0e442", "#999999", "#d55e00", "#0072b2"];

function axis(title, more = {}) {
  return { title: { text: literal(title), standoff: 6 }, gridcolor: colour("line"), zerolinecolor: colour("line"), linecolor: colour("faint"),
           exponentformat: "power", ...more };
}

function layout(x, y, more = {}) {
  return { xaxis: x, yaxis: y, margin: { l: 64, r: 12, t: 26, b: 42 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
           font: { color: colour("ink"), size: 12 }, hoverlabel: { bgcolor: colour("soft"), font: { color: colour("ink") } },
           legend: innerWidth < 600 ? { orientation: "h", y: -0.3, font: { size: 10 } } : { orientation: "h", y: 1.12 }, uirevision: "kept", ...more };
}

// The toolbar has only these buttons. One of Plotly's default buttons sends the data of the chart to a company.
const settings = (name) => ({
  responsive: true, displaylogo: false, showSendToCloud: false, plotlyServerURL: "", topojsonURL: "",
  toImageButtonOptions: { filename: name, format: "svg" },
  modeBarButtons: [["toImage", { name: "Save as PNG", icon: Plotly.Icons.disk, click: (plot) => Plotly.downloadImage(plot, { format: "png", filename: name, scale: 2 }) }],
    ["zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"]],
});

async function draw(id, traces, place, clicked) {
  const plot = document.getElementById(id);
  await Plotly.react(plot, traces, place, settings(id));
  if (Math.abs(plot.clientWidth - plot._fullLayout.width) > 1) await Plotly.Plots.resize(plot); // a neighbour appeared
  plot.removeAllListeners("plotly_click");
  if (clicked) plot.on("plotly_click", (event) => clicked(event.points[0]));
  return plot;
}

const line = (x, y, name, style = {}) => ({ x, y, name: literal(name), mode: "lines", line: style, hovertemplate: `%{y:.3g}<extra>${literal(name)}</extra>` });

export function deviation(view, ghost) {
  const d = view.deviation;
  const traces = [
    { ...line(d.tau_s, d.low, "band"), line: { width: 0 }, showlegend: false, hoverinfo: "skip" },
    { ...line(d.tau_s, d.high, "95 % range of a true model"), line: { width: 0 }, fill: "tonexty", fillcolor: band(), hoverinfo: "skip" },
    { x: d.tau_s, y: d.measured, name: "measured", mode: "markers", marker: { color: colour("orange"), size: 8, symbol: "circle-open", line: { width: 2 } },
      hovertemplate: "τ %{x:.4g} s: %{y:.4g} deg/s<extra>measured</extra>" },
    ...d.effects.map((one, i) => line(d.tau_s, one.deviation, one.kind.replaceAll("_", " "), { width: 1.5, dash: "dot", color: COLOURS[i % COLOURS.length] })),
    line(d.tau_s, d.model, "model", { width: 2.5, color: colour("blue") }),
  ];
  if (ghost) traces.push(line(ghost.deviation.tau_s, ghost.deviation.model, `with ${ghost.name}`, { width: 2, dash: "dash", color: colour("green") }));
  const low = Math.min(...d.measured, ...d.model) / 3;
  return draw("deviation", traces, layout(axis("averaging time τ, s", { type: "log" }), axis("Allan deviation, deg/s", {
    type: "log", range: [Math.log10(low), Math.log10(Math.max(...d.measured, ...d.model) * 2)], autorange: false }), { title: undefined }));
}

// Draws the model's curve while a slider moves: a path above the chart, without a redraw.
export function moving(taus, model) {
  const plot = document.getElementById("deviation");
  const { xaxis, yaxis } = plot._fullLayout;
  let path = plot.querySelector("path.moving");
  if (!path) {
    path = document.createElementNS("http://www.w3.org/2000/svg", "path");
    path.setAttribute("class", "moving");
    path.setAttribute("fill", "none");
    plot.querySelector(".main-svg").append(path);
  }
  path.setAttribute("stroke", colour("green"));
  path.setAttribute("stroke-width", "3");
  const points = taus.map((tau, i) =>
    `${(xaxis._offset + xaxis.l2p(Math.log10(tau))).toFixed(1)},${(yaxis._offset + yaxis.l2p(Math.log10(model[i]))).toFixed(1)}`);
  path.setAttribute("d", `M${points.join("L")}`);
}

export function stopMoving() {
  document.querySelector("#deviation path.moving")?.remove();
}

export function residual(view) {
  const d = view.deviation;
  const off = d.measured.map((value, i) => 100 * (value / d.model[i] - 1));
  const reach = (bound) => d[bound].map((value, i) => 100 * (value / d.model[i] - 1));
  return draw("residual", [
    { ...line(d.tau_s, reach("low"), ""), line: { width: 0 }, hoverinfo: "skip" },
    { ...line(d.tau_s, reach("high"), ""), line: { width: 0 }, fill: "tonexty", fillcolor: band(), hoverinfo: "skip" },
    { x: d.tau_s, y: off, mode: "markers+lines", marker: { color: colour("orange"), size: 7 }, line: { width: 1, color: colour("orange") },
      hovertemplate: "τ %{x:.4g} s: %{y:+.1f} %<extra></extra>" },
  ], layout(axis("", { type: "log" }), axis("misfit, %"), { showlegend: false, margin: { l: 64, r: 12, t: 6, b: 26 } }));
}

export function spectrum(view, clicked) {
  const s = view.spectrum;
  return draw("spectrum", [
    { ...line(s.peak_hz, s.peak, "largest", { width: 0 }), mode: "markers", marker: { size: 3, color: colour("faint") },
      hovertemplate: "%{x:.4g} Hz<extra>click to add a line</extra>" },
    line(s.f_hz, s.measured, "measured", { color: colour("orange"), width: 1.2 }),
    line(s.f_hz, s.model, "model", { color: colour("blue"), width: 2 }),
  ], layout(axis("frequency, Hz", { type: "log" }), axis("deg/s/√Hz", { type: "log" })), clicked);
}

// Rows are averaging times, columns are windows. Within a row, short windows are above long ones.
export function map(view, clicked) {
  const cells = view.map;
  const taus = [...new Set(cells.map((c) => c.tau_s))].sort((a, b) => a - b);
  const span = (cell) => Math.round(cell.stop_s - cell.start_s), shapes = [];
  for (const tau of taus) {
    const row = cells.filter((c) => c.tau_s === tau), spans = [...new Set(row.map(span))].sort((a, b) => b - a), step = Math.log10(2) / spans.length;
    for (const cell of row) {
      const low = Math.log10(tau) - Math.log10(2) / 2 + spans.indexOf(span(cell)) * step;
      shapes.push({ cell, low, high: low + step });
    }
  }
  const traces = [{
    type: "scatter", mode: "markers", x: shapes.map((s) => (s.cell.start_s + s.cell.stop_s) / 2), y: shapes.map((s) => 10 ** ((s.low + s.high) / 2)),
    customdata: shapes.map((s) => s.cell), marker: { size: 1, opacity: 0 },
    hovertemplate: shapes.map((s) => `τ ${number(s.cell.tau_s)} s, ${number(s.cell.start_s)} to ${number(s.cell.stop_s)} s<br>measured ${number(s.cell.measured)}, `
      + `model ${number(s.cell.model)} deg/s<br>ratio ${number(s.cell.ratio)}, ${s.cell.z >= 0 ? "+" : ""}${number(s.cell.z, 2)} σ<extra></extra>`),
  }];
  const place = layout(axis("time, s", { range: [0, Math.max(...cells.map((c) => c.stop_s))] }),
    axis("averaging time τ, s", { type: "log", range: [Math.log10(taus[0] / 1.5), Math.log10(taus.at(-1) * 1.5)] }),
    { showlegend: false, hovermode: "closest", hoverdistance: 60, margin: { l: 64, r: 12, t: 8, b: 40 } });
  place.shapes = shapes.map((s) => ({
    type: "rect", layer: "below", x0: s.cell.start_s, x1: s.cell.stop_s, y0: 10 ** s.low, y1: 10 ** s.high, fillcolor: shade(s.cell.z),
    line: { width: s.cell.proven ? 2 : 0.3, color: s.cell.proven ? colour("ink") : colour("line") },
  }));
  return draw("map", traces, place, (point) => clicked(point.customdata));
}

// Orange: above the model; blue: below. The colour is full at 6 standard deviations.
function shade(z) {
  const strength = Math.min(1, Math.abs(z) / 6);
  return z > 0 ? `rgba(213,94,0,${strength})` : `rgba(0,114,178,${strength})`;
}

export function envelope(id, one, marks = []) {
  const shapes = marks.map((m) => ({ type: "rect", yref: "paper", y0: 0, y1: 1, x0: m.start_s, x1: m.stop_s, fillcolor: colour("yellow"), opacity: .25,
    line: { width: 0 } }));
  return draw(id, [
    { ...line(one.time_s, one.low, ""), line: { width: 0.5, color: colour("blue") }, hoverinfo: "skip" },
    { ...line(one.time_s, one.high, one.column), line: { width: 0.5, color: colour("blue") }, fill: "tonexty" },
  ], layout(axis(""), axis(one.column), { showlegend: false, shapes, margin: { l: 64, r: 12, t: 6, b: 26 } }));
}

export function density(id, f, values) {
  return draw(id, [line(f, values, "in this stretch", { color: colour("orange"), width: 1.2 })],
    layout(axis("frequency, Hz", { type: "log" }), axis("deg/s/√Hz", { type: "log" }), { showlegend: false }));
}

export function falling(id, steps) {
  return draw(id, [
    { ...line(steps.map((_, i) => i), steps.map((s) => s.error), "error", { color: colour("orange"), width: 2 }), mode: "lines+markers" },
    line(steps.map((_, i) => i), steps.map((s) => s.floor), "floor: a true model", { color: colour("faint"), dash: "dash" }),
  ], layout(axis("", { tickvals: steps.map((_, i) => i), ticktext: steps.map((s) => literal(s.did)), automargin: true }), axis("error", { rangemode: "tozero" })));
}

// Blue: while the column rises. Orange: while it falls. Two branches mean hysteresis or a lag.
export function against(one) {
  const branch = (up, name, tint, symbol) => ({ x: one.x.filter((_, i) => one.rising[i] === up), y: one.left.filter((_, i) => one.rising[i] === up), name,
    mode: "markers", marker: { size: 5, color: colour(tint), symbol }, hovertemplate: "%{x:.4g}: %{y:.3g} deg/s<extra></extra>" });
  return draw("against", [branch(true, "rising", "blue", "triangle-up"), branch(false, "falling", "orange", "triangle-down")],
    layout(axis(one.column), axis("residual of the gyro, deg/s")));
}

export function axes(all, sheet) {
  const traces = all.map((one, i) => ({ ...line(one.tau_s, one.measured, one.column, { color: COLOURS[i], width: 2 }), mode: "lines+markers" }));
  if (sheet) traces.push(line(sheet.tau_s, sheet.deviation, "data sheet", { color: colour("ink"), dash: "dash", width: 2 }));
  return draw("axes", traces, layout(axis("averaging time τ, s", { type: "log" }), axis("Allan deviation, deg/s", { type: "log" })));
}

export function spectrogram(one) {
  return draw("spectrogram", [{
    type: "heatmap", x: one.x, y: one.f_hz, z: one.density.map((row) => row.map((value) => Math.log10(Math.max(value, 1e-12)))), colorscale: "Cividis",
    colorbar: { title: { text: "log₁₀ deg/s/√Hz", side: "right" }, thickness: 12 }, hovertemplate: "%{x:.4g}, %{y:.3g} Hz: 10^%{z:.2f}<extra></extra>",
  }], layout(axis(one.column), axis("frequency, Hz", { type: "log" })));
}

// Live results over time, or over the epoch while the rate is unknown.
function when(rows) {
  if (rows.some((row) => row.time_s === undefined)) return ["epoch", rows.map((row) => row.epoch)];
  const [unit, size] = rows.at(-1).time_s > 10800 ? ["h", 3600] : ["s", 1];
  return [`time, ${unit}`, rows.map((row) => row.time_s / size)];
}

// Crosses: unstable windows, or alarms of policy glr.
export function rolling(id, rows) {
  const [title, x] = when(rows), of = (name) => rows.map((row) => row[name] ?? null), marked = rows.map((row, i) => ((row.alarm ?? row.unstable) ? i : -1)).filter((i) => i >= 0);
  const arw = of("arw_deg_per_sqrt_h");
  return draw(id, [
    { ...line(x, of("arw_low_deg_per_sqrt_h"), ""), line: { width: 0 }, showlegend: false, hoverinfo: "skip" },
    { ...line(x, of("arw_high_deg_per_sqrt_h"), "95 %"), line: { width: 0 }, fill: "tonexty", fillcolor: band(), hoverinfo: "skip" },
    line(x, arw, "ARW", { color: colour("blue"), width: 2 }),
    { x: marked.map((i) => x[i]), y: marked.map((i) => arw[i]), name: rows.some((row) => row.alarm !== undefined) ? "alarm" : "unstable", mode: "markers", marker: { symbol: "x", color: colour("orange"), size: 7 } },
    { ...line(x, of("window_samples"), "window", { color: colour("faint"), width: 1, dash: "dot" }), yaxis: "y2" },
  ], layout(axis(title), axis("deg/√h", { rangemode: "tozero" }), { yaxis2: { ...axis("window, samples", { rangemode: "tozero" }), overlaying: "y", side: "right",
    showgrid: false }, margin: { l: 64, r: 64, t: 26, b: 42 } }));
}

const MARKS_S = [1e-4, 1e-3, 0.01, 0.1, 1, 10, 60, 600, 3600, 21600, 86400, 864000, 8640000, 86400000]; // on an axis of averaging times

// The newest Allan curve. The axis has every cluster size, also those whose first deviation comes later.
export function curve(id, one) {
  const x = one.tau_s ?? one.m, ends = [x[0] / 1.3, x.at(-1) * 1.3], marks = MARKS_S.filter((s) => s >= ends[0] && s <= ends[1]);
  const times = one.tau_s ? { tickvals: marks, ticktext: marks.map(duration) } : {}, reach = (limits) => one.adev.map((value, i) => (limits[i] === null ? 0 : Math.abs(limits[i] - value)));
  const label = (m, i) => `${one.tau_s ? duration(x[i]) : `${m} samples`}: ${number(one.adev[i])} deg/s${one.low[i] === null ? ", no interval" : `, 95 %: ${number(one.low[i])} to ${number(one.high[i])}`}`;
  return draw(id, [
    line(x, one.fitted, "fitted terms", { color: colour("blue"), width: 2 }),
    { x, y: one.adev, name: "measured, 95 %", mode: "markers", marker: { color: colour("orange"), size: 6, symbol: one.low.map((low) => (low === null ? "circle-open" : "circle")) }, text: one.m.map(label), hovertemplate: "%{text}<extra></extra>",
      error_y: { type: "data", symmetric: false, array: reach(one.high), arrayminus: reach(one.low), color: colour("orange"), thickness: 1, width: 3 } },
  ], layout(axis(one.tau_s ? "averaging time τ" : "cluster, samples", { type: "log", range: ends.map(Math.log10), ...times }), axis("Allan deviation, deg/s", { type: "log" })));
}

// The Allan deviation over time and cluster size.
export function surface(id, rows, one) {
  const [title, x] = when(rows);
  const sizes = [...new Set(rows.flatMap((row) => Object.keys(row)))].filter((name) => /^adev_\d+$/.test(name)).map((name) => Number(name.slice(5))).sort((a, b) => a - b);
  const times = new Map((one?.tau_s ?? []).map((s, i) => [one.m[i], duration(s)])), timed = new Set(times.values()).size === sizes.length;
  return draw(id, [{
    type: "heatmap", x, y: sizes.map((m) => (timed ? times.get(m) : String(m))), z: sizes.map((m) => rows.map((row) => (row[`adev_${m}`] > 0 ? Math.log10(row[`adev_${m}`]) : null))),
    colorscale: "Cividis", colorbar: { title: { text: "log₁₀ deg/s", side: "right" }, thickness: 12 }, hovertemplate: "%{x:.6g}, %{y}: 10^%{z:.2f}<extra></extra>",
  }], layout(axis(title), axis(timed ? "averaging time τ" : "cluster, samples", { type: "category", automargin: true })));
}
