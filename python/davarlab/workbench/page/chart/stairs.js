// The staircase of the error: one tread a step, over its floor. A tick is the verdict of the step.
import { marks } from "/page/chart/scale.js";
import { canvas, svg } from "/page/chart/svg.js";
import { errorText, number } from "/page/words.js";

const PHONE = 560;

// steps: [{label, error, floor, fits, go}], the last one the current; next: {label, error, floor} or null; most: the largest error of all steps, so that the axis stands still.
export function staircase(place, steps, next, most = 0) {
    const made = canvas(place);
    if (!made) return null;
    const { drawing, width, height } = made,
        phone = width < PHONE,
        left = phone ? 42 : 48,
        bottom = height - (phone ? 22 : 26),
        right = phone ? 12 : 70,
        top =
            1.15 * (Math.max(most, ...steps.map((one) => Math.max(one.error, 2 * one.floor))) || 1);
    const Y = (error) => bottom - (Math.min(error, top) / top) * (bottom - 16),
        shown = steps.slice(-(phone ? 3 : 6));
    const slots = Math.max(3, shown.length + 1),
        tread = (width - left - 12 - (phone ? 0 : 70)) / slots;
    drawing.setAttribute("role", "group");
    drawing.setAttribute("aria-label", "Error, step by step");
    if (!phone) svg("text", { x: width - 92, y: 22, "text-anchor": "end" }, drawing, "Error");
    for (const [value] of marks(false, 0, top, (bottom - 16) / 28)) {
        const y = Y(value);
        svg("line", { x1: left, x2: width - right, y1: y, y2: y, stroke: "var(--grid)" }, drawing);
        svg("text", { x: left - 6, y: y + 4, "text-anchor": "end" }, drawing, number(value, 2));
    }
    const floors = shown.map((one, i) => {
        const end = i === shown.length - 1 ? width - right : left + (i + 1) * tread;
        return `M${left + i * tread} ${Y(one.floor)}H${end}`;
    });
    svg(
        "path",
        {
            d: floors.join(""),
            stroke: "var(--good)",
            "stroke-width": 2,
            "stroke-dasharray": "6 4",
            class: "floor",
        },
        drawing,
    );
    if (!phone && shown.length)
        svg(
            "text",
            {
                x: width - 62,
                y: Y(shown.at(-1).floor) + 4,
                style: "fill:var(--good)",
                class: "strong",
            },
            drawing,
            "floor",
        );
    let before = null;
    const wide = (text) => {
        const most = Math.max(3, Math.floor(tread / 6.4));
        return text.length > most ? `${text.slice(0, most - 1)}…` : text;
    };
    shown.forEach((step, i) => {
        const x = left + i * tread,
            current = i === shown.length - 1,
            y = Y(step.error);
        const colour = step.fits ? "var(--good)" : "var(--meas)",
            group = svg("g", { class: "tread" }, drawing);
        svg(
            "rect",
            {
                x,
                y,
                width: tread - 2,
                height: bottom - y,
                fill: colour,
                "fill-opacity": current ? 0.22 : 0.1,
            },
            group,
        );
        if (before !== null) {
            svg(
                "path",
                {
                    d: `M${x - 1} ${before}V${y}`,
                    stroke: colour,
                    "stroke-width": 2,
                    "stroke-dasharray": "3 3",
                },
                group,
            );
            svg(
                "path",
                {
                    d:
                        y > before
                            ? `M${x - 6} ${Math.max(before + 4, y - 9)}l5 7 5-7z`
                            : `M${x - 6} ${Math.min(before - 4, y + 9)}l5 -7 5 7z`,
                    fill: colour,
                },
                group,
            );
        }
        svg(
            "line",
            {
                x1: x,
                x2: x + tread - 2,
                y1: y,
                y2: y,
                stroke: colour,
                "stroke-width": current ? 4 : 3,
            },
            group,
        );
        svg(
            "text",
            { x: x + 8, y: Math.max(y - 7, 13), class: "ink strong halo", style: "font-size:15px" },
            group,
            `${step.fits ? "✓ " : ""}${errorText(step.error)}`,
        );
        svg(
            "text",
            { x: x + 2, y: height - 8, class: current ? "ink" : null },
            group,
            wide(step.label),
        );
        svg("title", {}, group, step.label);
        if (!current && step.go) {
            group.style.cursor = "pointer";
            group.addEventListener("click", step.go);
        }
        before = y;
    });
    if (next) {
        const x = left + shown.length * tread,
            y = Y(next.error);
        svg(
            "rect",
            {
                x,
                y,
                width: tread - 2,
                height: bottom - y,
                fill: "none",
                stroke: "var(--edge)",
                "stroke-dasharray": "4 4",
            },
            drawing,
        );
        svg("text", { x: x + 8, y: y - 7, class: "halo" }, drawing, `${errorText(next.error)}?`);
        svg("text", { x: x + 2, y: height - 8 }, drawing, wide(next.label));
    }
    return drawing;
}
