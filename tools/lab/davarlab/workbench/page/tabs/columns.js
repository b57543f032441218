// The logged columns over time, and the residual of the gyro against one of them, with a lag.
import { ask } from "/page/api.js";
import { xy } from "/page/chart/xy.js";
import { at, newest, now, rateUnit } from "/page/now.js";
import { element, fill, number } from "/page/words.js";

let found = null,
    foundOf = null;

export function build(panel) {
    panel.append(
        element(
            "div",
            { class: "two" },
            element("div", { id: "columns", class: "stack" }),
            element(
                "div",
                { class: "stack" },
                element(
                    "div",
                    { class: "row" },
                    element(
                        "label",
                        {},
                        "Residual against ",
                        element("select", { id: "against-column", onchange: () => against({}) }),
                    ),
                    element("span", { class: "grow" }),
                    element(
                        "label",
                        { class: "row" },
                        "lag ",
                        element("input", {
                            type: "range",
                            id: "lag",
                            min: 0,
                            max: 100,
                            value: 0,
                            "aria-label": "lag",
                            oninput: () => against({}),
                        }),
                        element("output", { id: "lag-s" }, "0"),
                        " s",
                    ),
                ),
                element("div", { class: "plot", id: "against" }),
            ),
        ),
    );
}

// The lag of the slider: 0 to a tenth of the recording, logarithmic.
const lag = () =>
    Number(at("lag").value)
        ? 0.1 * now.all.duration_s * 1000 ** (Number(at("lag").value) / 100 - 1)
        : 0;

export async function draw() {
    const { turn, all } = now,
        chosen = at("against-column").value,
        of = JSON.stringify([all.recording, all.column, all.alone, all.cut]);
    fill(
        "against-column",
        ...all.columns.map((name) =>
            element("option", { value: name, selected: name === (chosen || "temp_degC") }, name),
        ),
    );
    if (foundOf !== of) {
        const answer = await ask("stretch", { start_s: 0, stop_s: all.duration_s, every: true });
        if (turn !== now.turn) return;
        [found, foundOf] = [answer.envelopes, of];
    }
    const span = now.cell &&
        now.cell.stop_s - now.cell.start_s < 0.99 * all.duration_s && [
            { x0: now.cell.start_s, x1: now.cell.stop_s },
        ];
    fill("columns", ...found.map(() => element("div", { class: "strip-plot" })));
    found.forEach((one, i) =>
        xy(
            at("columns").children[i],
            [
                {
                    x: one.time_s,
                    y: one.low,
                    low: one.low,
                    high: one.high,
                    band: true,
                    strength: 0.85,
                    colour: i ? "var(--model)" : "var(--meas)",
                },
            ],
            {
                x: { clock: true, hidden: i < found.length - 1 },
                y: { title: one.column },
                spans: span || [],
                right: 8,
                label: `${one.column} over time`,
            },
        ),
    );
    await against({});
}

const against = newest(async () => {
    const { turn } = now,
        column = at("against-column").value;
    at("lag-s").textContent = number(lag(), 2);
    if (!column) {
        fill("against", element("p", { class: "soft pad" }, "The recording has no other column."));
        return;
    }
    const one = await ask("against", { column, lag_s: lag() });
    if (turn !== now.turn) return;
    const branch = (up, points, colour, name) => {
        const kept = one.x.map((_, i) => i).filter((i) => one.rising[i] === up);
        return {
            x: kept.map((i) => one.x[i]),
            y: kept.map((i) => one.left[i]),
            points,
            colour,
            name,
        };
    };
    xy(at("against"), [branch(true, "up", "var(--model)"), branch(false, "down", "var(--meas)")], {
        x: { title: one.column },
        y: { title: `Residual, ${rateUnit()}. ▲ rising ▼ falling` },
        right: 8,
        label: `Residual of the gyro against ${one.column}`,
    });
});
