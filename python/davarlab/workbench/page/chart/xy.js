// A chart of lines, bands and points on two axes. It remembers a zoom, and names its curves at their right ends.
import { clockMarks, marks, scale, spread, timeMarks } from "/page/chart/scale.js";
import { area, canvas, line, svg } from "/page/chart/svg.js";
import { number } from "/page/words.js";

const PHONE = 560,
    LETTER = 7; // pixels of a figure
const finite = (values) =>
    values.filter((value) => value !== null && value !== undefined && Number.isFinite(value));

// The range of what is drawn. log: positive values only.
function extent(lists, log, pad) {
    const all = lists.flatMap((list) => finite(list)).filter((value) => !log || value > 0);
    const low = all.reduce((a, b) => Math.min(a, b), Infinity),
        high = all.reduce((a, b) => Math.max(a, b), -Infinity);
    if (!(high >= low)) return log ? [0.1, 10] : [0, 1];
    if (log) return [low / 1.3 ** pad, high * 1.3 ** pad];
    const room = 0.06 * pad * (high - low || Math.abs(high) || 1);
    return [low - room, high + room];
}

const ticks = (axis, X, most) =>
    axis.time
        ? timeMarks(X.from, X.to)
        : axis.clock
          ? clockMarks(X.from, X.to, most)
          : marks(Boolean(axis.log), X.from, X.to, most);

// series: {x, y, name, colour, width, dash, low, high, points: "ring"|"dot"|"up"|"down"|"cross", bars, band (only the band), right (axis)}.
// axes: {x: {log, time, clock, title, range}, y: {log, title, range}, y2: {title}, lines: [{y, name}], spans: [{x0, x1}], margin, zoom, label}.
export function xy(
    place,
    series,
    { x: xAxis, y: yAxis, y2 = null, lines = [], spans = [], zoom = null, label, right = null },
) {
    const made = canvas(place, label);
    if (!made) return null;
    const { drawing, width, height } = made,
        phone = width < PHONE,
        r = width - (right ?? (phone ? 10 : 150)),
        top = yAxis.title ? 23 : 12,
        bottom = height - (xAxis.hidden ? 6 : 24);
    const kept = series.filter((one) => one.x.length);
    const [x0, x1] =
        zoom ||
        xAxis.range ||
        extent(
            kept.map((one) => one.x),
            xAxis.log,
            xAxis.log ? 1 : 0,
        );
    const left = kept.filter((one) => !one.right);
    const [y0, y1] =
        yAxis.range ||
        extent(
            left.flatMap((one) => [one.y, one.low || [], one.high || []]),
            yAxis.log,
            1,
        );
    const values = marks(Boolean(yAxis.log), y0, y1, Math.max(2, (bottom - top) / 40)).map(
            ([value, text]) => ({ value, text: yAxis.text ? yAxis.text(value) : text }),
        ),
        widest = LETTER * Math.max(0, ...values.map(({ text }) => text.length)),
        l = Math.max(phone ? 44 : 54, 8 + widest),
        X = scale(Boolean(xAxis.log), x0, x1, l, r),
        Y = scale(Boolean(yAxis.log), y0, y1, bottom, top);
    const grid = svg("g", {}, drawing),
        id = `clip-${Math.random().toString(36).slice(2)}`;
    svg(
        "rect",
        { x: l, y: top, width: r - l, height: bottom - top },
        svg("clipPath", { id }, drawing),
    );
    for (const one of spans)
        svg(
            "rect",
            {
                x: Math.max(X(one.x0), l),
                y: top,
                width: Math.max(1, Math.min(X(one.x1), r) - Math.max(X(one.x0), l)),
                height: bottom - top,
                fill: "var(--ink)",
                "fill-opacity": 0.09,
            },
            grid,
        );
    for (const { value, text } of values) {
        svg("line", { x1: l, x2: r, y1: Y(value), y2: Y(value), stroke: "var(--grid)" }, grid);
        svg("text", { x: l - 6, y: Y(value) + 4, "text-anchor": "end" }, grid, text);
    }
    if (!xAxis.hidden)
        for (const [value, text] of ticks(xAxis, X, Math.max(2, (r - l) / 90))) {
            svg(
                "line",
                { x1: X(value), x2: X(value), y1: top, y2: bottom, stroke: "var(--grid)" },
                grid,
            );
            svg(
                "text",
                { x: X(value), y: height - 6, "text-anchor": "middle", class: "mark" },
                grid,
                text,
            );
        }
    for (const one of lines)
        svg("line", { x1: l, x2: r, y1: Y(one.y), y2: Y(one.y), stroke: "var(--edge)" }, grid);
    const inside = svg("g", { "clip-path": `url(#${id})` }, drawing);
    for (const one of kept) {
        const YY = one.right ? scale(false, 0, extent([one.y], false, 1)[1], bottom, top) : Y;
        draw(inside, one, X, YY);
    }
    if (yAxis.title)
        svg("text", { x: phone || l < 60 ? 4 : l, y: 11, class: "ytitle" }, drawing, yAxis.title);
    if (xAxis.title)
        svg(
            "text",
            { x: r - 6, y: bottom - 6, "text-anchor": "end", class: "halo xtitle" },
            drawing,
            xAxis.title,
        );
    if (!phone && right === null)
        names(drawing, [...kept.filter((one) => one.name), ...lines.filter((one) => one.name)], {
            Y,
            r,
            top,
            bottom,
        });
    return { drawing, X, Y, l, r, top, bottom, width, height, inside };
}

function draw(parent, one, X, Y) {
    const colour = one.colour || "var(--model)";
    if (one.low && one.high && !one.bars)
        svg(
            "path",
            {
                d: area(X, Y, one.x, one.low, one.high),
                fill: colour,
                "fill-opacity": one.strength ?? 0.16,
                stroke: one.strength ? colour : null,
            },
            parent,
        );
    if (one.band) return;
    if (one.bars)
        one.x.forEach(
            (x, i) =>
                one.low[i] !== null &&
                svg(
                    "line",
                    { x1: X(x), x2: X(x), y1: Y(one.low[i]), y2: Y(one.high[i]), stroke: colour },
                    parent,
                ),
        );
    if (one.points)
        one.x.forEach((x, i) => one.y[i] !== null && point(parent, one, X(x), Y(one.y[i]), i));
    else
        svg(
            "path",
            {
                d: line(X, Y, one.x, one.y),
                fill: "none",
                stroke: colour,
                "stroke-width": one.width || 1.5,
                "stroke-dasharray": one.dash || null,
                "stroke-linejoin": "round",
            },
            parent,
        );
}

const SHAPES = { up: "M-3.5 3h7L0 -4z", down: "M-3.5 -3h7L0 4z", cross: "M-4 -4L4 4M4 -4L-4 4" };

function point(parent, one, x, y, i) {
    const colour = one.colour || "var(--model)",
        kind = typeof one.points === "function" ? one.points(i) : one.points;
    const made = SHAPES[kind]
        ? svg(
              "path",
              {
                  d: SHAPES[kind],
                  transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})`,
                  fill: kind === "cross" ? "none" : colour,
                  stroke: kind === "cross" ? colour : null,
                  "stroke-width": 2,
              },
              parent,
          )
        : svg(
              "circle",
              {
                  cx: x.toFixed(1),
                  cy: y.toFixed(1),
                  r: one.radius || 3.5,
                  fill: kind === "ring" ? "var(--panel)" : colour,
                  stroke: kind === "ring" ? colour : null,
                  "stroke-width": 2,
              },
              parent,
          );
    if (one.texts) svg("title", {}, made, one.texts[i]);
    if (one.click) {
        made.style.cursor = "pointer";
        made.addEventListener("click", () => one.click(i));
    }
}

// The names at the right, each near the end of its curve.
function names(drawing, kept, { Y, r, top, bottom }) {
    const placed = kept
        .map((one) => ({
            one,
            y: Math.max(
                top + 10,
                Math.min(
                    bottom,
                    Y(one.at ?? finite(Array.isArray(one.y) ? one.y : [one.y]).at(-1) ?? Y.from) +
                        4,
                ),
            ),
        }))
        .sort((a, b) => a.y - b.y);
    spread(placed, bottom, 15);
    for (const { one, y } of placed)
        svg(
            "text",
            { x: r + 10, y, style: `fill:${one.ink || one.colour || "var(--soft)"}` },
            drawing,
            one.name,
        );
}

// Reads out the nearest point of the first curve under the pointer.
export function readout(chart, one, text) {
    if (!chart) return;
    const { drawing, X, r, top, l } = chart,
        said = svg(
            "text",
            { x: r - 6, y: top + 10, "text-anchor": "end", class: "ink halo" },
            drawing,
        );
    const rule = svg(
        "line",
        { y1: top, y2: chart.bottom, stroke: "var(--ink)", opacity: 0, "pointer-events": "none" },
        drawing,
    );
    drawing.addEventListener("pointermove", (event) => {
        const at = event.clientX - drawing.getBoundingClientRect().left;
        if (at < l || at > r || !one.x.length) return;
        let best = 0,
            near = Infinity;
        one.x.forEach((x, i) => {
            const far = Math.abs(X(x) - at);
            if (far < near) [best, near] = [i, far];
        });
        rule.setAttribute("x1", X(one.x[best]));
        rule.setAttribute("x2", X(one.x[best]));
        rule.setAttribute("opacity", 0.5);
        said.textContent = text ? text(best) : `${number(one.x[best])}: ${number(one.y[best])}`;
    });
    drawing.addEventListener("pointerleave", () => {
        said.textContent = "";
        rule.setAttribute("opacity", 0);
    });
}
