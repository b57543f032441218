// Draws the charts of the report, with the code of the workbench, from the data in the file.
import { AllanChart } from "/page/chart/allan.js";
import { failureMap } from "/page/chart/map.js";
import { staircase } from "/page/chart/stairs.js";
import { xy } from "/page/chart/xy.js";
import { labelled } from "/page/words.js";

const found = JSON.parse(document.getElementById("drawn").textContent),
    at = (id) => document.getElementById(id);
const ranged = (one) => {
    const all = [...one.measured, ...one.model].filter((value) => value > 0);
    return [Math.min(...all) * 0.5, Math.max(...all) * 1.5];
};
const maps = Object.entries(found.maps),
    [record, ...others] = found.columns;

function deviation() {
    const { deviation: one, span_s: span, unit, before } = found,
        label = "Allan deviation over averaging time: measured and model";
    const chart = new AllanChart(
        at("deviation"),
        { ...one, tau: one.tau_s, cells: maps.at(-1)[1] },
        { range: ranged(one), length: 0, span, unit, label },
    );
    chart.showBefore(before && { curve: before });
}

const LEAST = 0.2; // shown of the residual over the model
const reachOf = (all) => [LEAST, 1.3 * Math.max(2, ...all.flatMap((one) => one.ratio))];

function spectrum() {
    const named = Object.entries(found.spectra),
        last = named.at(-1)[1];
    xy(
        at("spectrum"),
        [
            {
                x: last.f_hz,
                y: last.high,
                low: last.low,
                high: last.high,
                band: true,
                name: "chance, 95 %",
                at: last.high.at(-1),
                ink: "var(--model)",
            },
            ...named.map(([name, one], i) => ({
                x: one.f_hz,
                y: one.ratio,
                name,
                colour: i || named.length === 1 ? "var(--meas)" : "var(--edge)",
                ink: i || named.length === 1 ? "var(--meas-ink)" : "var(--soft)",
            })),
        ],
        {
            x: { log: true, title: "Hz" },
            y: {
                log: true,
                range: reachOf(named.map(([, one]) => one)),
                title: "Measured over model",
            },
            lines: [{ y: 1 }],
            label: "Spectrum of the residual over that of the model",
        },
    );
}

function draw() {
    deviation();
    for (const [name, cells] of maps)
        failureMap(at(`map-${name}`), {
            map: cells,
            tau: found.deviation.tau_s,
            length: 0,
            span: found.span_s,
            record: name === "initial" ? record : null,
            marked: found.marked,
            label: "Measured over model, over time and averaging time",
        });
    others.forEach((one, i) =>
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
                },
            ],
            {
                x: { clock: true, hidden: i < others.length - 1 },
                y: { title: one.column },
                right: at("columns").clientWidth < 560 ? 10 : 100,
                label: `${one.column} over time`,
            },
        ),
    );
    spectrum();
    if (found.steps.length > 1)
        staircase(
            at("stairs"),
            found.steps.map((one) => ({ ...one, label: labelled(one.label) })),
            null,
        );
}

draw();
let width = innerWidth;
addEventListener("resize", () => {
    if (innerWidth !== width) {
        width = innerWidth;
        draw();
    }
});
