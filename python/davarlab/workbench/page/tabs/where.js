// Where it fails: averaging time over the time of the recording, the record on the same time axis, and the samples of the selected cell.
import { ask } from "/page/api.js";
import * as cells from "/page/chart/cells.js";
import { failureMap } from "/page/chart/map.js";
import { xy } from "/page/chart/xy.js";
import { at, hear, leaving, newest, now, rateUnit, refused, show } from "/page/now.js";
import { showing } from "/page/tabs/tabs.js";
import { brief, element, fill, number, section, timesText } from "/page/words.js";

let record = null,
    recordOf = null;

export function build(panel) {
    const field = (id, name) =>
        element(
            "label",
            {},
            `${name} `,
            element("input", { type: "number", id, step: "any", min: 0 }),
        );
    panel.append(
        element(
            "div",
            { class: "where" },
            element("div", { class: "plot", id: "map" }),
            element("div", {
                id: "cell",
                class: "aside",
                tabindex: 0,
                role: "group",
                "aria-label": "The selected cell",
            }),
        ),
        element(
            "form",
            { id: "stretch", class: "row bottom", onsubmit: (event) => event.preventDefault() },
            field("from", "From"),
            field("to", "to"),
            "s",
            element(
                "button",
                {
                    type: "button",
                    id: "alone",
                    onclick: () =>
                        leaving("Analysing this part", "selection", {
                            column: now.all.column,
                            alone: span(),
                        }),
                },
                "Analyse only this",
            ),
            element(
                "button",
                {
                    type: "button",
                    id: "cut",
                    onclick: () =>
                        leaving("Excluding this part", "selection", {
                            column: now.all.column,
                            cut: [...now.all.cut, span()],
                        }),
                },
                "Exclude it",
            ),
            element("span", { class: "grow" }),
            element(
                "label",
                { id: "selections-label" },
                "Analysed ",
                element("select", { id: "selections", onchange: other }),
            ),
        ),
    );
}

// Converts seconds of the analysed part to seconds of the whole recording.
const whole = (edges) => edges.map((edge) => edge + (now.all.alone[0] || 0));
const span = () => whole([Number(at("from").value), Number(at("to").value)]);

function other() {
    const { column, alone, cut } = now.all.selections[Number(at("selections").value)];
    leaving("Analysing the selection", "selection", { column, alone, cut });
}

export function selections() {
    const said = (one) =>
        one.column +
        (one.alone.length
            ? `, ${number(one.alone[0], 6)} to ${number(one.alone[1], 6)} s only`
            : "") +
        one.cut.map(([a, b]) => `, without ${number(a, 6)} to ${number(b, 6)} s`).join("");
    fill(
        "selections",
        ...now.all.selections.map((one, place) =>
            element("option", { value: place, selected: one.here }, said(one)),
        ),
    );
    at("selections-label").hidden = now.all.selections.length < 2;
    at("cut").disabled = now.all.alone.length > 0;
}

export async function draw() {
    const { turn, all } = now,
        of = JSON.stringify([all.recording, all.column, all.alone, all.cut]);
    if (recordOf !== of) {
        map();
        const found = await ask("stretch", { start_s: 0, stop_s: all.duration_s });
        if (turn !== now.turn) return;
        [record, recordOf] = [found.envelopes[0], of];
        at("stretch").reset();
    }
    map(record);
    await see(now.cell);
}

const MOVES = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };

function map(envelope) {
    const focused = at("map").contains(document.activeElement),
        label =
            "Averaging time over time: where the model is too low or too high. The arrow keys move, w goes to the worst cell.";
    const made = failureMap(at("map"), {
        map: now.view.map,
        tau: now.view.deviation.tau_s,
        length: now.length,
        span: now.all.duration_s,
        record: envelope,
        marked: now.view.observations.flatMap((one) => one.stretches || []),
        selected: now.cell,
        pick: (cell) => show("cell", cell),
        label,
    });
    if (!made) return;
    cells.keys(made.drawing, label, MOVES, (by) => {
        const next = cells.neighbour(made.shown, now.cell, by);
        if (next) show("cell", next);
    });
    if (focused) made.drawing.focus({ preventScroll: true });
}

hear("cell", () => {
    if (showing("where")) {
        map(record);
        see(now.cell).catch(refused);
    }
});

async function see(cell) {
    if (cell) await look(cell);
    else fill("cell", ...bad());
}

// All sections in which the misfit is proven. A click selects the worst cell of one.
function bad() {
    const all = cells.sections(now.view.map, now.view.worst),
        whole = (one) => one.stop_s - one.start_s > 0.99 * now.all.duration_s;
    return [
        all.length
            ? element("h2", {}, "Where the misfit is proven")
            : element("p", {}, "No misfit is proven in any section (99 % confidence)."),
        element(
            "div",
            { class: "sections" },
            ...all.map((one) =>
                element(
                    "button",
                    { onclick: () => show("cell", one.worst) },
                    element("b", {}, whole(one) ? "Throughout" : section(one)),
                    `: ${timesText(one.worst.ratio)} too ${one.worst.ratio > 1 ? "low" : "high"} at ${brief(one.worst.tau_s)}`,
                ),
            ),
        ),
        element("p", { class: "soft" }, "Select a cell to see its samples. Key w: the worst one."),
    ];
}

// The samples and the spectrum of a cell.
const look = newest(async (cell, latest) => {
    const stretch = await ask("stretch", { start_s: cell.start_s, stop_s: cell.stop_s });
    if (!latest()) return;
    [at("from").value, at("to").value] = [cell.start_s, cell.stop_s];
    fill(
        "cell",
        element("b", {}, `${brief(cell.tau_s)}, ${section(cell)}`),
        element(
            "p",
            { id: "cell-said", class: "small" },
            `${cell.measured === undefined ? "Ratio" : `Measured ${number(cell.measured)}, model ${number(cell.model)} ${rateUnit()}: ${number(cell.z, 2)} standard deviations, ratio`} ${number(cell.ratio)}.${cell.proven ? " The misfit is proven (99 % confidence)." : ""}`,
        ),
        ...stretch.envelopes.map((_, i) => element("div", { id: `samples-${i}`, class: "mini" })),
        element("div", { id: "cell-spectrum", class: "mini" }),
        element(
            "button",
            { class: "link", onclick: () => show("cell", null) },
            "All sections with a misfit",
        ),
    );
    stretch.envelopes.forEach((one, i) =>
        xy(
            at(`samples-${i}`),
            [
                {
                    x: one.time_s,
                    y: one.low,
                    low: one.low,
                    high: one.high,
                    band: true,
                    strength: 0.8,
                    colour: i ? "var(--model)" : "var(--meas)",
                },
            ],
            {
                x: { clock: true, hidden: i < stretch.envelopes.length - 1 },
                y: { title: one.column },
                right: 8,
                label: `Samples of ${one.column}`,
            },
        ),
    );
    xy(at("cell-spectrum"), [{ x: stretch.f_hz, y: stretch.density, colour: "var(--meas)" }], {
        x: { log: true, title: "Hz" },
        y: { log: true, title: `${rateUnit()}/√Hz` },
        right: 8,
        label: "Spectrum of this part",
    });
});
