// The data sheet or a kalibr file beside the axes of the sensor, and in the main chart.
import { act, ask } from "/page/api.js";
import { xy } from "/page/chart/xy.js";
import { accel, at, doing, now, rateUnit } from "/page/now.js";
import { element } from "/page/words.js";

const MPS_PER_H_PER_UG = 9.80665e-6 * 3600; // m/s/h in a µg

/** @type {[string, string, ...[string, string, number][]][]} */
const FIELDS = [
    ["angle_random_walk", "sheet-arw", ["ARW", "deg/√h", 1], ["VRW", "m/s/√h", 1]],
    [
        "bias_instability",
        "sheet-bi",
        ["Bias instability", "deg/h", 1],
        ["Bias instability", "µg", MPS_PER_H_PER_UG],
    ],
    [
        "rate_random_walk",
        "sheet-rrw",
        ["Rate random walk", "deg/h/√h", 1],
        ["Rate random walk", "µg/√h", MPS_PER_H_PER_UG],
    ],
];
// [name, unit, factor to the unit of the request], of a gyro or an accelerometer.
const said = (field) => field[accel() ? 3 : 2];
const STYLES = [
    ["var(--meas)", null],
    ["var(--model)", "7 4"],
    ["var(--good)", "2 3"],
    ["var(--soft)", "8 2 2 2"],
];
let axes = null,
    axesOf = null,
    unit = null; // unit: of the axis that the data sheet is for

export function build(panel) {
    const file = element("input", {
        type: "file",
        id: "kalibr",
        class: "hidden-file",
        tabindex: -1,
        "aria-label": "a kalibr file",
        accept: ".yaml,.yml",
        onchange: () => file.files[0] && kalibr(file),
    });
    panel.append(
        element(
            "div",
            { class: "two sheet" },
            element(
                "form",
                {
                    id: "sheet",
                    class: "stack",
                    onsubmit: (event) => {
                        event.preventDefault();
                        overlay();
                    },
                },
                ...FIELDS.map(([, id]) =>
                    element(
                        "label",
                        { class: "f" },
                        element("span", { id: `${id}-name` }),
                        element(
                            "span",
                            { class: "row" },
                            element("input", { type: "number", id, step: "any", min: 0 }),
                            element("span", { class: "soft", id: `${id}-unit` }),
                        ),
                    ),
                ),
                element(
                    "div",
                    { class: "row" },
                    element("button", { class: "go", title: "Here and over the fit" }, "Draw it"),
                    file,
                    element(
                        "button",
                        { type: "button", onclick: () => file.click() },
                        "kalibr file",
                    ),
                ),
            ),
            element("div", { class: "plot", id: "axes" }),
        ),
    );
}

// A data sheet of gyros is none of accelerometers.
export function follow() {
    if (unit === now.all.unit) return;
    [unit, now.sheet] = [now.all.unit, null];
    for (const one of FIELDS) at(one[1]).value = "";
}

async function overlay() {
    const given = Object.fromEntries(
        FIELDS.filter(([, id]) => at(id).value).map((one) => [
            one[0],
            Number(at(one[1]).value) * said(one)[2],
        ]),
    );
    await doing("", async () => {
        now.sheet = Object.keys(given).length ? await ask("sheet", given) : null;
        await draw();
    });
}

const kalibr = (file) =>
    doing("Reading the kalibr file", async () => {
        const chosen = file.files[0];
        file.value = ""; // so that choosing the same, corrected file again triggers a change event
        const { sheet } = await act("kalibr", { text: await chosen.text() });
        for (const one of FIELDS)
            at(one[1]).value =
                sheet[one[0]] === undefined
                    ? ""
                    : Number((sheet[one[0]] / said(one)[2]).toPrecision(6));
        await overlay();
    });

export async function draw() {
    const { turn } = now,
        of = `${now.all.recording} ${accel()}`;
    for (const one of FIELDS)
        [at(`${one[1]}-name`).textContent, at(`${one[1]}-unit`).textContent] = said(one);
    if (axesOf !== of) [axes, axesOf] = [(await ask("axes")).axes, of];
    if (turn !== now.turn) return;
    const series = axes.map((one, i) => ({
        x: one.tau_s,
        y: one.measured,
        name: one.column,
        colour: STYLES[i % 4][0],
        dash: STYLES[i % 4][1],
        width: 2,
    }));
    if (now.sheet)
        series.push({
            x: now.sheet.tau_s,
            y: now.sheet.deviation,
            name: "data sheet",
            colour: "var(--ink)",
            dash: "6 4",
            width: 2,
        });
    xy(at("axes"), series, {
        x: { log: true, time: true },
        y: { log: true, title: `Allan deviation, ${rateUnit()}` },
        label: "Allan deviation of the axes and the data sheet",
    });
}
