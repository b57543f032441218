// The failure map: which cells are shown, how one is painted, and the keys that move in it. A cell is full where the model is too low, and
// half as long along the averaging time where it is too high, so that the sign survives without colour.
import { svg } from "/page/chart/svg.js";

const START = 0.25; // of the ramp: visible on a dark page too
const span = (cell) => cell.stop_s - cell.start_s;

// The window lengths of the map, the shortest first.
export const lengths = (cells) =>
    [...new Set(cells.map((one) => Math.round(span(one) * 1e3) / 1e3))].sort((a, b) => a - b);

// One window length: of each averaging time the cells of that length, or of the next longer one that it has.
export function chosen(cells, tau, length) {
    return tau.flatMap((t, column) => {
        const row = cells
            .map((cell, index) => ({ cell, index, column }))
            .filter(({ cell }) => Math.abs(cell.tau_s / t - 1) < 0.01);
        const shown = lengths(row.map(({ cell }) => cell)).find((one) => one >= length * 0.98);
        return shown === undefined
            ? []
            : row.filter(({ cell }) => Math.abs(span(cell) - shown) < 0.02 * shown);
    });
}

// The sections of the recording in which a misfit is proven, and the worst cell of each: the one that the headline names, or that with the farthest ratio. Cells that touch are one section.
export function sections(cells, named) {
    const far = (one) => (alike(one, named) ? Infinity : Math.abs(Math.log(one.ratio)));
    const found = [];
    const bad = cells.filter((one) => one.proven).sort((a, b) => a.start_s - b.start_s);
    for (const cell of bad) {
        const last = found.at(-1);
        if (!last || cell.start_s > last.stop_s) {
            found.push({ start_s: cell.start_s, stop_s: cell.stop_s, worst: cell });
            continue;
        }
        last.stop_s = Math.max(last.stop_s, cell.stop_s);
        if (far(cell) > far(last.worst)) last.worst = cell;
    }
    return found;
}

export const alike = (a, b) =>
    Boolean(a && b) && a.tau_s === b.tau_s && a.start_s === b.start_s && a.stop_s === b.stop_s;

// place: {x, width} or {y, height} of the full cell, along the averaging time.
export function paint(rect, place, ratio, z) {
    const octaves = Math.log2(Math.max(ratio, 1e-9)),
        sure = Math.min(1, Math.max(0, (Math.abs(z) - 2) / 2));
    const strength = Math.min(1, Math.abs(octaves)) * sure,
        low = octaves > 0;
    const shown = strength > 0.02 ? (START + (1 - START) * strength).toFixed(2) : 0,
        key = `${low} ${shown}`;
    if (rect.painted === key) return; // most cells stay while a value moves
    rect.painted = key;
    rect.setAttribute("fill", low ? "var(--meas)" : "var(--model)");
    rect.setAttribute("fill-opacity", shown);
    const [start, size] = "x" in place ? ["x", "width"] : ["y", "height"];
    rect.setAttribute(start, low ? place[start] : place[start] + place[size] / 4);
    rect.setAttribute(size, low ? place[size] : place[size] / 2);
}

// What the colours mean. flat: cells of the averaging time from bottom to top; line: in one line that ends at x. Without line, the texts of the ends are below.
export function key(drawing, x, y, { flat = false, line = false } = {}) {
    const left = line ? x - 96 : x,
        size = flat ? 12 : 9,
        each = line ? 14 : 20;
    [0.5, 0.71, 1, 1.41, 2].forEach((ratio, i) =>
        flat
            ? paint(
                  svg("rect", { x: left + i * each + 0.5, width: each - 1 }, drawing),
                  { y, height: size },
                  ratio,
                  9,
              )
            : paint(
                  svg("rect", { y, height: size }, drawing),
                  { x: left + i * each, width: each },
                  ratio,
                  9,
              ),
    );
    svg(
        "rect",
        { x: left, y, width: 5 * each, height: size, fill: "none", stroke: "var(--edge)" },
        drawing,
    );
    const texts = line
        ? [
              ["model too high", left - 5, y + 10, "end"],
              ["low", x, y + 10, "end"],
          ]
        : [
              ["too high", left, y + 13 + size, "start"],
              ["too low", left + 5 * each, y + 13 + size, "end"],
          ];
    for (const [text, at, base, anchor] of texts)
        svg("text", { x: at, y: base, "text-anchor": anchor }, drawing, text);
}

// The cell beside a selected one, `across` steps of averaging time and `along` steps of time away. shown: of chosen().
export function neighbour(shown, selected, [across, along]) {
    const here = shown.find((one) => alike(one.cell, selected));
    if (!here) return shown[0]?.cell;
    if (along)
        return shown.find(
            (one) =>
                one.column === here.column &&
                (along > 0
                    ? one.cell.start_s === here.cell.stop_s
                    : one.cell.stop_s === here.cell.start_s),
        )?.cell;
    const middle = (here.cell.start_s + here.cell.stop_s) / 2;
    return shown.find(
        (one) =>
            one.column === here.column + across &&
            one.cell.start_s <= middle &&
            one.cell.stop_s > middle,
    )?.cell;
}

// The arrow keys of a drawing. moves: key -> [across, along].
export function keys(drawing, label, moves, move) {
    for (const [name, value] of Object.entries({ tabindex: 0, role: "group", "aria-label": label }))
        drawing.setAttribute(name, value);
    drawing.addEventListener("keydown", (event) => {
        if (!moves[event.key]) return;
        event.preventDefault();
        move(moves[event.key]);
    });
}
