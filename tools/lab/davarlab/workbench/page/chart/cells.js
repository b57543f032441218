// The failure map: which cells are shown, and how one is painted. Full width: the model is too low. Half width: it is too high, so the
// sign survives without colour.
import { svg } from "/page/chart/svg.js";

const span = (cell) => cell.stop_s - cell.start_s;

// The window lengths of the map, the shortest first.
export const lengths = (cells) => [...new Set(cells.map((one) => Math.round(span(one) * 1e3) / 1e3))].sort((a, b) => a - b);

// One window length: of each averaging time the cells of that length, or of the next longer one that it has.
export function chosen(cells, tau, length) {
  return tau.flatMap((t, column) => {
    const row = cells.map((cell, index) => ({ cell, index, column })).filter(({ cell }) => Math.abs(cell.tau_s / t - 1) < 0.01);
    const shown = lengths(row.map(({ cell }) => cell)).find((one) => one >= length * 0.98);
    return shown === undefined ? [] : row.filter(({ cell }) => Math.abs(span(cell) - shown) < 0.02 * shown);
  });
}

export const alike = (a, b) => Boolean(a && b) && a.tau_s === b.tau_s && a.start_s === b.start_s && a.stop_s === b.stop_s;

// place: {x, width} of the full cell.
export function paint(rect, place, ratio, z) {
  const octaves = Math.log2(Math.max(ratio, 1e-9)), sure = Math.min(1, Math.max(0, (Math.abs(z) - 2) / 2));
  const strength = Math.min(1, Math.abs(octaves)) * sure, low = octaves > 0;
  rect.setAttribute("fill", low ? "var(--meas)" : "var(--model)");
  rect.setAttribute("fill-opacity", strength > 0.02 ? (0.12 + 0.88 * strength).toFixed(2) : 0);
  rect.setAttribute("x", low ? place.x : place.x + place.width / 4);
  rect.setAttribute("width", low ? place.width : place.width / 2);
}

// What the colours mean.
export function key(drawing, x, y) {
  svg("text", { x, y: y - 5 }, drawing, "model too");
  [0.5, 0.71, 1, 1.41, 2].forEach((ratio, i) => paint(svg("rect", { y, height: 9 }, drawing), { x: x + i * 14, width: 14 }, ratio, 9));
  svg("rect", { x, y, width: 70, height: 9, fill: "none", stroke: "var(--edge)" }, drawing);
  svg("text", { x, y: y + 22 }, drawing, "high");
  svg("text", { x: x + 70, y: y + 22, "text-anchor": "end" }, drawing, "low");
}
