// Where it fails: averaging time over the time of the recording, and the record on the same axis of time.
import * as cells from "/page/chart/cells.js";
import { clockMarks, scale } from "/page/chart/scale.js";
import { area, canvas, svg } from "/page/chart/svg.js";
import { brief, number } from "/page/words.js";

const PHONE = 560,
    RECORD = [50, 110]; // pixels of the record

// map: the cells; length: of the windows shown; record: {column, time_s, low, high}, undefined until it is loaded, null for none; marked: stretches of it; pick: called with a cell.
export function failureMap(
    place,
    { map, tau, length, span, record, marked = [], selected = null, pick = null, label },
) {
    const made = canvas(place);
    if (!made) return null;
    const { drawing, width, height } = made,
        left = 54,
        right = width - (width < PHONE ? 10 : 128),
        top = 20,
        recordHeight =
            record === null ? -10 : Math.max(RECORD[0], Math.min(RECORD[1], height * 0.26)),
        bottom = height - recordHeight - 34;
    const row = (bottom - top) / tau.length,
        X = scale(false, 0, span, left, right),
        strip = svg("g", { class: "strip" }, drawing);
    drawing.setAttribute("role", pick ? "group" : "img");
    drawing.setAttribute("aria-label", label);
    svg("text", { x: 4, y: 13 }, drawing, "Averaging time");
    const column = (cell) => tau.findIndex((t) => Math.abs(cell.tau_s / t - 1) < 0.01),
        shown = cells.chosen(map, tau, length);
    const box = (cell) => ({
        x: X(cell.start_s) + 0.5,
        y: top + (tau.length - 1 - column(cell)) * row + 0.5,
        width: Math.max(1, X(cell.stop_s) - X(cell.start_s) - 1),
        height: Math.max(1, row - 1),
    });
    for (const { cell } of shown) {
        const { x, width: wide, ...place } = box(cell);
        cells.paint(svg("rect", { x, width: wide, ...place }, strip), place, cell.ratio, cell.z);
        if (pick)
            svg(
                "rect",
                {
                    ...box(cell),
                    fill: "none",
                    "pointer-events": "all",
                    style: "cursor:pointer",
                    class: "hit",
                },
                drawing,
            ).addEventListener("click", () => pick(cell));
    }
    if (selected && column(selected) >= 0)
        svg(
            "rect",
            {
                ...box(selected),
                fill: "none",
                stroke: "var(--ink)",
                "stroke-width": 2.5,
                "pointer-events": "none",
            },
            drawing,
        );
    svg(
        "rect",
        {
            x: left,
            y: top,
            width: right - left,
            height: bottom - top,
            fill: "none",
            stroke: "var(--edge)",
        },
        drawing,
    );
    const every = Math.ceil(16 / row);
    tau.forEach(
        (t, i) =>
            i % every ||
            svg(
                "text",
                { x: left - 6, y: top + (tau.length - 0.5 - i) * row + 4, "text-anchor": "end" },
                drawing,
                brief(t),
            ),
    );
    if (width >= PHONE) {
        svg("text", { x: right + 14, y: top + 14 }, drawing, "Model");
        cells.key(drawing, right + 14, top + 24, { flat: true });
    } else cells.key(drawing, right, 3, { flat: true, line: true });
    if (record)
        below(drawing, record, {
            X,
            y: bottom + 10,
            height: recordHeight,
            left,
            right,
            marked,
            selected,
        });
    for (const [value, text] of clockMarks(0, span, (right - left) / 90))
        svg(
            "text",
            {
                x: X(value),
                y: height - 6,
                "text-anchor": !value ? "start" : X(value) > width - 24 ? "end" : "middle",
            },
            drawing,
            text,
        );
    return { drawing, shown };
}

function below(drawing, record, { X, y, height, left, right, marked, selected }) {
    const low = Math.min(...record.low),
        high = Math.max(...record.high),
        Y = scale(false, low, high, y + height, y);
    for (const [start, stop] of marked)
        svg(
            "rect",
            {
                x: X(start),
                y,
                width: Math.max(1, X(stop) - X(start)),
                height,
                fill: "var(--ink)",
                "fill-opacity": 0.12,
            },
            drawing,
        );
    svg(
        "path",
        {
            d: area(X, Y, record.time_s, record.low, record.high),
            fill: "var(--meas)",
            stroke: "var(--meas)",
            class: "record",
        },
        drawing,
    );
    for (const value of [low, high])
        svg(
            "text",
            { x: left - 6, y: Y(value) + (value === low ? 0 : 10), "text-anchor": "end" },
            drawing,
            number(value, 2),
        );
    if (right + 20 < drawing.viewBox.baseVal.width)
        svg("text", { x: right + 8, y: y + 14 }, drawing, record.column.slice(0, 14));
    if (selected)
        svg(
            "rect",
            {
                x: X(selected.start_s),
                y,
                width: Math.max(2, X(selected.stop_s) - X(selected.start_s)),
                height,
                fill: "var(--ink)",
                "fill-opacity": 0.08,
                stroke: "var(--ink)",
                "stroke-width": 2,
            },
            drawing,
        );
}
