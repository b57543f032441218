// The Allan deviation, measured over model, and where it fails.
import { ask } from "/page/api.js";
import { AllanChart } from "/page/chart/allan.js";
import * as cells from "/page/chart/cells.js";
import { hands, zoomed as zoomedBy } from "/page/chart/hands.js";
import { svg } from "/page/chart/svg.js";
import { card as cardOf } from "/page/curve.js";
import { actions } from "/page/parts/model.js";
import { at, doing, hear, now, rateUnit, show } from "/page/now.js";
import { brief, element, fill, labelled } from "/page/words.js";

let chart = null,
    zoomed = null, // {tau, range} of a zoom
    over = null, // the model or the recording that is laid over: {key, name, tau_s, deviation, points}
    range = null,
    rangeOf = null,
    frame = 0;

// The y axis of a recording stands still over its steps.
function ranged() {
    const d = now.view.deviation,
        all = [...d.measured, ...d.model, ...(over?.deviation || [])].filter((value) => value > 0);
    const here = [Math.min(...all) * 0.5, Math.max(...all) * 1.5],
        of = `${now.all.recording} ${now.all.column}`;
    range = rangeOf === of ? [Math.min(range[0], here[0]), Math.max(range[1], here[1])] : here;
    if (rangeOf !== of) zoomed = over = null;
    rangeOf = of;
    return range;
}

// Folded, on a phone: there is no place for names beside the curves.
const legend = () =>
    element(
        "details",
        { id: "legend", class: "legend" },
        element("summary", {}, "Legend"),
        ...[
            ["measured", "dot"],
            ["model", "line"],
            ["95 %", "band"],
            ["model too low", "low"],
            ["model too high", "high"],
            ["not tested or confirmed", "hatch"],
        ].map(([name, kind]) => element("span", {}, element("i", { class: kind }), name)),
    );

export function build(panel) {
    panel.append(
        element(
            "div",
            { class: "row small", id: "fit-tools" },
            legend(),
            element("label", {}, "Lay over ", element("select", { id: "over", onchange: layOver })),
            element("span", { id: "zoomed", role: "status" }),
            element(
                "button",
                { id: "zoom-all", hidden: true, onclick: () => look(null) },
                "Show all",
            ),
            element("output", { id: "readout", class: "grow soft", "aria-live": "off" }),
        ),
        element("div", { class: "plot", id: "deviation" }),
        element("div", {
            class: "seg",
            id: "windows",
            role: "group",
            "aria-label": "Window length",
            title: "Each cell compares one window of this length with the model",
        }),
    );
    hands(at("deviation"), () => chart, look, point);
    at("deviation").addEventListener("click", (event) => {
        const { left, top } = at("deviation").getBoundingClientRect(),
            found = chart?.ready && chart.under(event.clientX - left, event.clientY - top);
        if (found?.cell) show("cell", found.cell);
    });
}

// Draws a zoom, once a frame. null: all of it.
function look(zoom) {
    zoomed = zoom;
    frame ||= requestAnimationFrame(() => {
        frame = 0;
        chartOnly();
    });
}

// The crosshair at the pointer; where there is none, at the selected cell.
function point(x, y) {
    if (held.part) return;
    const there = x === null ? null : chart.under(x, y),
        { cell } = now;
    at("readout").textContent = chart.showCursor(there || (cell && { tau: cell.tau_s, cell }));
}

// What can be laid over the chart: other steps, other axes, the recording that is held out.
function offered() {
    const { steps, current, gyros, column, held_out: other } = now.all,
        models = steps.filter((one) => one.number !== current && one.error !== null);
    const group = (label, all) =>
        all.length &&
        element(
            "optgroup",
            { label },
            ...all.map(([value, text]) =>
                element("option", { value, selected: value === over?.key }, text),
            ),
        );
    fill(
        "over",
        element("option", { value: "" }, "nothing"),
        group(
            "Model of a step",
            models.map((one) => [`step ${one.number}`, labelled(one.did)]),
        ),
        group("Recording", [
            ...gyros.filter((one) => one !== column).map((one) => [`axis ${one}`, one]),
            ...(other ? [["held", other.split("/").at(-1)]] : []),
        ]),
    );
    at("over").disabled = at("over").options.length < 2;
}

async function layOver() {
    const { turn } = now,
        key = at("over").value,
        name = at("over").selectedOptions[0].textContent,
        [kind, which] = key.split(/ (.*)/);
    await doing(key ? `Computing ${name}` : "", async () => {
        let found = null;
        if (kind === "step") {
            const { curve } = (await ask("step", { number: Number(which) })).deviation;
            found = { tau_s: curve.tau_s, deviation: curve.model };
        } else if (key) {
            const { axes, held } = await ask("axes"),
                one = kind === "held" ? held : axes.find((axis) => axis.column === which);
            if (!one) throw new Error(`${name} does not have ${now.all.column}`);
            found = { tau_s: one.tau_s, deviation: one.measured, points: true };
        }
        if (turn !== now.turn) return;
        over = found && { key, name, ...found };
        draw();
    });
}

export function draw() {
    const all = cells.lengths(now.view.map);
    if (!all.includes(now.length)) now.length = all[0] ?? 0;
    chartOnly();
    offered();
    if (!chart.ready) return;
    if (!chart.phone) windows(all);
    at("windows").hidden = chart.phone || all.length < 2;
}

function chartOnly() {
    const focused = at("deviation").contains(document.activeElement);
    chart = new AllanChart(at("deviation"), now.drawn, {
        range: ranged(),
        zoom: zoomed,
        length: now.length,
        span: now.all.duration_s,
        unit: rateUnit(),
        shown: [...now.view.shown_s, now.view.adequate ? "not confirmed" : "not tested"],
        overlay: [now.sheet && { ...now.sheet, name: "data sheet" }, over].filter(Boolean),
    });
    at("zoomed").textContent = zoomed ? zoomed.tau.map(brief).join(" to ") : "";
    at("zoom-all").hidden = !zoomed;
    if (!chart.ready) return;
    grasp();
    keys(chart.drawing, focused);
    showBefore();
    chart.showFlag(now.view.worst, now.view.headline[0].includes("off by"));
    showCell(now.cell);
}

function showCell(cell) {
    if (!chart?.ready) return;
    chart.showCell(cell);
    point(null);
}

function windows(all) {
    const few = all.length > 3 ? [all[0], all[Math.floor(all.length / 2)], all.at(-1)] : all;
    fill(
        "windows",
        ...few.map((one) =>
            element(
                "button",
                {
                    "aria-pressed": String(one === now.length),
                    tabindex: one === now.length ? 0 : -1,
                    onclick: () => {
                        now.length = one;
                        draw();
                        at("windows").querySelector("[aria-pressed=true]").focus();
                    },
                    onkeydown: (event) => {
                        const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key],
                            next =
                                event.target.parentNode.children[
                                    [...event.target.parentNode.children].indexOf(event.target) + by
                                ];
                        if (by && next) next.click();
                    },
                },
                brief(one),
            ),
        ),
    );
    at("windows").style.top = `${at("deviation").offsetTop + chart.stripTop + 3}px`;
}

function showBefore() {
    chart.showBefore(now.before);
    chart.showNext(now.next?.drawn ? now.next.deviation : null);
}

// Draws a moving state on the axes as they are.
export function update(state) {
    chart?.update(state);
    if (chart?.ready && !now.animated)
        chart.showFlag(now.view.worst, now.view.headline[0].includes("off by"));
    if (now.animated) chart?.flag?.replaceChildren();
}

hear("next", () => chart && showBefore());
hear("cell", showCell);

// Zooms in the middle, or at the selected cell. factor null: shows all.
export function zoom(factor) {
    if (!chart?.ready) return;
    const { X, Y, left, right } = chart,
        seen = now.cell && X(now.cell.tau_s) > left && X(now.cell.tau_s) < right;
    const at = seen ? X(now.cell.tau_s) : (left + right) / 2,
        i = now.drawn.tau.findIndex((one) => seen && Math.abs(one / now.cell.tau_s - 1) < 0.01),
        level = i < 0 ? (Y.a + Y.b) / 2 : Y(now.drawn.measured[i]);
    look(factor && zoomedBy(chart, factor, at, level));
}

// --- curves that are dragged to another size ---

const held = { part: null };

function grasp() {
    const { Y } = chart;
    chart.parts.forEach((path, i) => {
        const effect = now.view.deviation.effects[i],
            card = effect && cardOf(now.view, effect),
            parameter = card?.parameters.find((one) => one.size);
        if (!parameter?.value) return;
        const hit = svg(
            "path",
            {
                d: path.getAttribute("d"),
                class: "part-hit",
                "clip-path": `url(#${chart.clip})`,
                "data-kind": effect.kind,
            },
            null,
        );
        chart.flag.before(hit);
        const decade = Math.abs(Y(1) - Y(10)),
            value = (event) => parameter.value * 10 ** ((held.from - event.clientY) / decade);
        hit.addEventListener("pointerdown", (event) => {
            held.part = hit;
            held.from = event.clientY;
            hit.setPointerCapture(event.pointerId);
            event.preventDefault();
        });
        hit.addEventListener("touchstart", (event) => event.preventDefault(), { passive: false }); // touch-action does not keep a path from scrolling
        hit.addEventListener(
            "pointermove",
            (event) => held.part === hit && actions.moved(card, parameter, value(event)),
        );
        hit.addEventListener("pointerup", (event) => {
            if (held.part !== hit) return;
            held.part = null;
            if (value(event) !== parameter.value) actions.released(card, parameter, value(event));
        });
        hit.addEventListener("pointercancel", () => {
            held.part = null;
        });
    });
}

// --- keys ---

const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function keys(drawing, focused) {
    cells.keys(
        drawing,
        "Allan deviation and where it fails. The arrow keys move, w goes to the worst cell, plus and minus zoom, Escape shows all.",
        MOVES,
        (by) => {
            const next = cells.neighbour(chart.cells, now.cell, by);
            if (next) show("cell", next);
        },
    );
    drawing.addEventListener("keydown", (event) => {
        const factor = { "+": 0.5, "=": 0.5, "-": 2, Escape: null }[event.key];
        if (factor === undefined || event.ctrlKey || event.metaKey) return;
        event.preventDefault();
        zoom(factor);
    });
    if (focused) drawing.focus({ preventScroll: true });
}

// Selects the cell that the headline names.
export function worst() {
    const { worst: named, map } = now.view;
    if (!named) return;
    const found = map.find((one) => cells.alike(one, named)) || {
        ...named,
        proven: named.percent > 0,
    }; // a short window is not in the map
    now.length = cells.lengths([found])[0];
    show("cell", found);
    if (chart) draw();
}
