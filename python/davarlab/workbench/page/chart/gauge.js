// The error over its floor. The target stands still at 1.
import { errorText } from "/page/words.js";
import { canvas, svg } from "/page/chart/svg.js";

export const GOOD = 1.25; // times the floor

// The right end of the bar, in floors: it stands still over the steps of a recording.
export const reach = (steps) =>
    Math.max(
        4.4,
        1.1 * Math.max(...steps.filter((one) => one.floor).map((one) => one.error / one.floor)),
    );

export function gauge(place, state, before, top, adequate) {
    const made =
        state.error === null
            ? null
            : canvas(place, `error ${errorText(state.error)}, floor ${errorText(state.floor)}`);
    if (!made) {
        place.replaceChildren();
        return;
    }
    const { drawing, width } = made,
        X = (ratio) => Math.min(ratio / top, 1) * (width - 4),
        y = 42,
        height = 22;
    const now = X(state.error / state.floor),
        target = X(1),
        colour = adequate ? "var(--good)" : "var(--meas)";
    svg("rect", { x: 0, y, width, height, rx: 3, fill: "var(--sunk)" }, drawing);
    if (before?.floor) {
        const was = X(before.error / before.floor);
        svg(
            "rect",
            {
                x: 0.75,
                y: y + 0.75,
                width: Math.max(0, was - 1.5),
                height: height - 1.5,
                rx: 3,
                fill: "var(--meas-soft)",
                stroke: "var(--meas)",
                "stroke-dasharray": "3 3",
            },
            drawing,
        );
        if (was - now > 60 && was > target + 110)
            svg(
                "text",
                { x: was - 4, y: y + height + 16, "text-anchor": "end" },
                drawing,
                `was ${errorText(before.error)}`,
            );
    }
    svg("rect", { x: 0, y, width: Math.max(2, now), height, rx: 3, fill: colour }, drawing);
    svg(
        "line",
        {
            x1: target,
            x2: target,
            y1: y - 6,
            y2: y + height + 6,
            stroke: "var(--ink)",
            "stroke-width": 2,
        },
        drawing,
    );
    svg(
        "text",
        { x: Math.max(target, 34), y: y + height + 18, "text-anchor": "middle", class: "ink" },
        drawing,
        `floor ${errorText(state.floor)}`,
    );
    const left = now < 170,
        text = svg(
            "text",
            {
                x: left ? Math.max(target, now) + 10 : now,
                y: 32,
                "text-anchor": left ? "start" : "end",
                class: "ink",
            },
            drawing,
        );
    svg(
        "tspan",
        { style: "font-size:13px" },
        text,
        `${adequate ? "✓ " : ""}error${state.moving ? " ≈" : ""} `,
    );
    svg(
        "tspan",
        {
            class: "strong",
            style: `font-size:36px;letter-spacing:-.03em;${adequate ? "fill:var(--good)" : ""}`,
        },
        text,
        errorText(state.error),
    );
}
