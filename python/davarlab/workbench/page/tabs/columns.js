// Every logged column over time, beside what moves with it: thumbnails of the bias and of the noise of the gyro against it, one of them large.
import { ask } from "/page/api.js";
import { scale } from "/page/chart/scale.js";
import { canvas, svg } from "/page/chart/svg.js";
import { xy } from "/page/chart/xy.js";
import { at, newest, now, rateUnit } from "/page/now.js";
import { element, fill, number } from "/page/words.js";

let envelopes = null, // of the columns over time
    envelopesOf = null,
    chosen = "bias"; // what is drawn against the column: bias or noise

export function build(panel) {
    const option = (value, name) => element("option", { value }, name);
    panel.append(
        element(
            "div",
            { class: "two" },
            element("div", {
                id: "columns",
                class: "stack",
                tabindex: 0,
                role: "group",
                "aria-label": "Every logged column, and what moves with it",
            }),
            element(
                "div",
                { class: "stack" },
                element(
                    "div",
                    { class: "row" },
                    element(
                        "select",
                        {
                            id: "against-what",
                            "aria-label": "What is drawn",
                            onchange: () => choose(at("against-what").value),
                        },
                        option("bias", "Bias"),
                        option("noise", "Noise"),
                    ),
                    element(
                        "label",
                        { class: "row" },
                        "against ",
                        element("select", {
                            id: "against-column",
                            onchange: () => choose(chosen),
                        }),
                    ),
                    element("span", { class: "grow" }),
                    element(
                        "label",
                        { class: "row", id: "lag-label" },
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

// Draws bias or noise against a column; the selected one without a name.
function choose(what, column = at("against-column").value) {
    chosen = what;
    at("against-column").value = column;
    at("against-what").value = what;
    at("lag-label").hidden = what === "noise";
    for (const one of document.querySelectorAll("#columns .thumb"))
        one.setAttribute(
            "aria-pressed",
            String(one.dataset.column === column && one.dataset.what === what),
        );
    return against({});
}

// The lag of the slider: 0 to a tenth of the recording, logarithmic.
const lag = () =>
    Number(at("lag").value)
        ? 0.1 * now.all.duration_s * 1000 ** (Number(at("lag").value) / 100 - 1)
        : 0;

export async function draw() {
    const { turn, all } = now,
        of = JSON.stringify([all.recording, all.column, all.alone, all.cut]),
        asked = await Promise.all([
            ask("moves"),
            envelopesOf === of
                ? { envelopes }
                : ask("stretch", { start_s: 0, stop_s: all.duration_s, every: true }),
        ]);
    if (turn !== now.turn) return;
    const [{ moves }, answer] = asked,
        before = at("against-column").value,
        column = all.columns.includes(before) ? before : moves[0]?.column;
    [envelopes, envelopesOf, now.moves] = [answer.envelopes, of, moves];
    fill("against-column", ...all.columns.map((name) => element("option", { value: name }, name)));
    rows(moves);
    await choose(chosen, column);
}

// The gyro, then every column over time, each with its thumbnails: the one that moves with bias or noise first.
function rows(moves) {
    const [gyro, ...others] = envelopes,
        shown = [{ over: gyro }, ...moves.map((tied) => ({ over: others[place(tied)], tied }))];
    fill(
        "columns",
        ...shown.map(({ tied }) =>
            element(
                "div",
                { class: "moves" },
                element("div", { class: "strip-plot" }),
                tied && thumb(tied, "bias"),
                tied && thumb(tied, "noise"),
            ),
        ),
    );
    const span = now.cell &&
        now.cell.stop_s - now.cell.start_s < 0.99 * now.all.duration_s && [
            { x0: now.cell.start_s, x1: now.cell.stop_s },
        ];
    shown.forEach(({ over, tied }, i) => {
        xy(
            at("columns").children[i].firstChild,
            [
                {
                    x: over.time_s,
                    y: over.low,
                    low: over.low,
                    high: over.high,
                    band: true,
                    strength: 0.85,
                    colour: i ? "var(--model)" : "var(--meas)",
                },
            ],
            {
                x: { clock: true, hidden: i > 0 },
                y: { title: over.column },
                spans: span || [],
                right: 8,
                label: `${over.column} over time`,
            },
        );
        if (tied)
            for (const one of at("columns").children[i].querySelectorAll(".thumb"))
                scatter(one.firstChild, tied.x, tied[one.dataset.what].y);
    });
}

const place = (tied) => now.all.columns.indexOf(tied.column);

// A thumbnail of bias or noise against a column; a click enlarges it.
function thumb(tied, what) {
    const { correlation, p, significant } = tied[what],
        r = `${correlation < 0 ? "−" : "+"}${Math.abs(correlation).toFixed(2)}`;
    return element(
        "button",
        {
            class: `thumb${significant ? " tied" : ""}`,
            "data-column": tied.column,
            "data-what": what,
            title: `${what} against ${tied.column}: correlation ${r}, ${p}`,
            "aria-label": `${what} against ${tied.column}: correlation ${r}, ${p}`,
            onclick: () => choose(what, tied.column),
        },
        element("span", { class: "dots" }),
        element("span", { class: "small" }, `${what} ${r}`),
    );
}

function scatter(into, x, y) {
    const { drawing, width, height } = canvas(into) || {};
    if (!drawing) return;
    drawing.setAttribute("aria-hidden", "true");
    const along = (values, from, to) =>
        scale(false, Math.min(...values), Math.max(...values), from, to);
    const [X, Y] = [along(x, 4, width - 4), along(y, height - 4, 4)];
    x.forEach((one, i) =>
        svg("circle", { cx: X(one), cy: Y(y[i]), r: 1.5, fill: "var(--meas)" }, drawing),
    );
}

const against = newest(async () => {
    const { turn } = now,
        column = at("against-column").value;
    at("lag-s").textContent = number(lag(), 2);
    if (!column) {
        fill("against", element("p", { class: "soft pad" }, "The recording has no other column."));
        return;
    }
    const axes = (title, label) => ({
        x: { title: column },
        y: { title: `${title}, ${rateUnit()}` },
        right: 8,
        label: `${label} of the gyro against ${column}`,
    });
    if (chosen === "noise") {
        const one = now.moves.find((tied) => tied.column === column);
        xy(
            at("against"),
            [{ x: one.x, y: one.noise.y, points: "dot", radius: 3, colour: "var(--meas)" }],
            axes("Noise of a sample", "Noise"),
        );
        return;
    }
    const one = await ask("against", { column, lag_s: lag() });
    if (turn !== now.turn) return;
    const branch = (up, points, colour) => {
        const kept = one.x.map((_, i) => i).filter((i) => one.rising[i] === up);
        return { x: kept.map((i) => one.x[i]), y: kept.map((i) => one.left[i]), points, colour };
    };
    xy(
        at("against"),
        [branch(true, "up", "var(--model)"), branch(false, "down", "var(--meas)")],
        axes("▲ rising ▼ falling. Residual", "Residual"),
    );
});
