// The residual spectrum: measured over model, with the range of a true model. A click on a peak adds a line there. The spectrum over time.
import { ask } from "/page/api.js";
import { heat } from "/page/chart/heat.js";
import { readout, xy } from "/page/chart/xy.js";
import { acting, at, now, rateUnit } from "/page/now.js";
import { element, fill, number } from "/page/words.js";

let view = "residual",
    reach = null,
    reachOf = null,
    zoomed = null,
    over = { of: null, found: null };

const VIEWS = [
    ["residual", "Over model"],
    ["density", "Density"],
    ["over", "Over time"],
];

export function build(panel) {
    panel.append(
        element(
            "div",
            { class: "row top" },
            element(
                "div",
                { class: "seg", role: "group", "aria-label": "Spectrum" },
                ...VIEWS.map(([id, name]) =>
                    element(
                        "button",
                        {
                            "data-view": id,
                            onclick: () => {
                                view = id;
                                draw();
                            },
                        },
                        name,
                    ),
                ),
            ),
            element(
                "label",
                { id: "over-label" },
                "over ",
                element("select", { id: "over", onchange: draw }),
            ),
            element("span", { class: "grow" }),
            element("span", { id: "peak", class: "row" }, ""),
        ),
        element("div", { class: "plot", id: "spectrum" }),
    );
}

export async function draw() {
    for (const one of document.querySelectorAll("#panel-spectrum [data-view]"))
        one.setAttribute("aria-pressed", String(one.dataset.view === view));
    at("over-label").hidden = view !== "over";
    const dots =
        view === "residual"
            ? `Grey: single frequencies, up to ${number(now.view.spectrum.peak_chance, 2)}× by chance. `
            : "Grey: single frequencies. ";
    fill(
        "peak",
        view === "over"
            ? null
            : element("span", { class: "soft" }, dots, "Click a peak to add a line there."),
    );
    if (view === "over") await overTime();
    else if (view === "density") density();
    else residual();
}

export function zoom(factor) {
    const f = now.view.spectrum.f_hz,
        [from, to] = zoomed || [f[0], f.at(-1)],
        middle = reach?.peak || Math.sqrt(from * to),
        half = (Math.log(to / from) * (factor || 1)) / 2;
    zoomed = factor ? [middle * Math.exp(-half), middle * Math.exp(half)] : null;
    draw();
}

// The y axis of a recording stands still over its steps.
function standing(s) {
    const of = `${now.all.recording} ${now.all.column}`,
        high = Math.max(4, ...s.peak_ratio) * 1.3,
        low = Math.min(0.3, ...s.ratio) / 1.3;
    if (reachOf !== of) [reach, reachOf, zoomed] = [{ high, low }, of, null];
    reach = { ...reach, high: Math.max(high, reach.high), low: Math.min(low, reach.low) };
    return [reach.low, reach.high];
}

function residual() {
    const s = now.view.spectrum,
        range = standing(s),
        loud = s.peak_ratio
            .map((value, i) => [value, i])
            .filter(([value]) => value > s.peak_chance)
            .map(([, i]) => i);
    const best = loud.reduce(
        (a, b) => (a === null || s.peak_ratio[b] > s.peak_ratio[a] ? b : a),
        null,
    );
    reach.peak = best === null ? null : s.peak_hz[best];
    const made = xy(
        at("spectrum"),
        [
            {
                x: s.f_hz,
                y: s.high,
                low: s.low,
                high: s.high,
                band: true,
                name: "chance, 95 %",
                at: s.high.at(-1),
                ink: "var(--model)",
            },
            {
                x: s.peak_hz,
                y: s.peak_ratio,
                points: "dot",
                radius: 1.5,
                colour: "var(--edge)",
                click: peak,
                texts: s.peak_hz.map((f) => `${number(f, 4)} Hz: click to add a line`),
            },
            {
                x: s.f_hz,
                y: s.ratio,
                colour: "var(--meas)",
                name: "measured over model",
                ink: "var(--meas-ink)",
            },
            {
                x: loud.map((i) => s.peak_hz[i]),
                y: loud.map((i) => s.peak_ratio[i]),
                points: "dot",
                radius: 5,
                colour: "var(--meas)",
                click: (i) => peak(loud[i]),
                texts: loud.map((i) => `${number(s.peak_hz[i], 4)} Hz: click to add a line`),
            },
        ],
        {
            x: { log: true, title: "Hz" },
            y: {
                log: true,
                range,
                text: (value) => (value === 1 ? "1" : `${number(value)}×`),
                title: "Residual spectrum, measured over model",
            },
            lines: [{ y: 1 }],
            zoom: zoomed,
            label: "Residual spectrum: measured over model",
        },
    );
    readout(
        made,
        { x: s.f_hz, y: s.ratio },
        (i) => `${number(s.f_hz[i])} Hz: ${number(s.ratio[i], 2)}×`,
    );
}

function density() {
    const s = now.view.spectrum,
        made = xy(
            at("spectrum"),
            [
                {
                    x: s.peak_hz,
                    y: s.peak,
                    points: "dot",
                    radius: 2,
                    colour: "var(--edge)",
                    click: peak,
                    texts: s.peak_hz.map((f) => `${number(f, 4)} Hz: click to add a line`),
                },
                {
                    x: s.f_hz,
                    y: s.measured,
                    colour: "var(--meas)",
                    name: "measured",
                    ink: "var(--meas-ink)",
                },
                { x: s.f_hz, y: s.model, colour: "var(--model)", width: 2, name: "model" },
            ],
            {
                x: { log: true, title: "Hz" },
                y: { log: true, title: `${rateUnit()}/√Hz` },
                zoom: zoomed,
                label: "Spectral density, measured and model",
            },
        );
    readout(
        made,
        { x: s.f_hz, y: s.measured },
        (i) =>
            `${number(s.f_hz[i])} Hz: measured ${number(s.measured[i], 2)}, model ${number(s.model[i], 2)}`,
    );
}

// Offers a line at the peak of a group of frequencies.
function peak(i) {
    const f_hz = now.view.spectrum.peak_hz[i],
        at_hz = `at ${number(f_hz, 4)} Hz`;
    const offer = (text, wide) =>
        element(
            "button",
            { onclick: () => acting(`Fitting with a line ${at_hz}`, "line", { f_hz, wide }) },
            text,
        );
    fill("peak", offer(`Add a sharp line ${at_hz}`, false), offer("With a width", true));
}

async function overTime() {
    const names = ["time_s", ...now.all.columns],
        chosen = names.includes(at("over").value) ? at("over").value : "time_s",
        { turn } = now;
    fill(
        "over",
        ...names.map((name) => element("option", { value: name, selected: name === chosen }, name)),
    );
    const of = JSON.stringify([
        now.all.recording,
        now.all.column,
        now.all.alone,
        now.all.cut,
        chosen,
    ]);
    if (over.of !== of) over = { of, found: await ask("spectrogram", { column: chosen }) };
    if (turn !== now.turn || view !== "over") return;
    const one = over.found,
        rows = one.density.map((row) => row.map((value) => Math.log10(Math.max(value, 1e-12))));
    heat(at("spectrum"), rows, {
        x: { from: one.x[0], to: one.x.at(-1), title: chosen, clock: chosen === "time_s" },
        y: { from: one.f_hz[0], to: one.f_hz.at(-1), log: true, title: "Frequency, Hz" },
        unit: `${rateUnit()}/√Hz`,
        label: `Spectrum over ${chosen}`,
    });
}
