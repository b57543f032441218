// The Allan deviation, measured over model, and where it fails.
import { AllanChart } from "/page/chart/allan.js";
import * as cells from "/page/chart/cells.js";
import { svg } from "/page/chart/svg.js";
import { card as cardOf } from "/page/curve.js";
import { actions } from "/page/parts/model.js";
import { at, hear, now, rateUnit, show } from "/page/now.js";
import { brief, element, fill } from "/page/words.js";

let chart = null,
    zoomed = null,
    range = null,
    rangeOf = null;

// The y axis of a recording stands still over its steps.
function ranged() {
    const d = now.view.deviation,
        all = [...d.measured, ...d.model].filter((value) => value > 0);
    const here = [Math.min(...all) * 0.5, Math.max(...all) * 1.5],
        of = `${now.all.recording} ${now.all.column}`;
    range = rangeOf === of ? [Math.min(range[0], here[0]), Math.max(range[1], here[1])] : here;
    if (rangeOf !== of) zoomed = null;
    rangeOf = of;
    return range;
}

export function build(panel) {
    panel.append(
        element(
            "div",
            { id: "legend", class: "legend", "aria-hidden": true },
            ...[
                ["measured", "dot"],
                ["model", "line"],
                ["95 %", "band"],
                ["model too low", "low"],
                ["too high", "high"],
                ["not tested or confirmed", "hatch"],
            ].map(([name, kind]) => element("span", {}, element("i", { class: kind }), name)),
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
}

export function draw() {
    const all = cells.lengths(now.view.map);
    if (!all.includes(now.length)) now.length = all[0] ?? 0;
    const focused = at("deviation").contains(document.activeElement);
    chart = new AllanChart(at("deviation"), now.drawn, {
        range: ranged(),
        zoom: zoomed,
        length: now.length,
        span: now.all.duration_s,
        unit: rateUnit(),
        shown: [...now.view.shown_s, now.view.adequate ? "not confirmed" : "not tested"],
        overlay: now.sheet ? [{ ...now.sheet, name: "data sheet" }] : null,
    });
    if (!chart.ready) return;
    if (!chart.phone) windows(all);
    at("windows").hidden = chart.phone || all.length < 2;
    grasp();
    keys(chart.drawing, focused);
    showBefore();
    chart.showFlag(now.view.worst, now.view.headline[0].includes("off by"));
    chart.showCell(now.cell);
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
hear("cell", (cell) => chart?.showCell(cell));

export function zoom(factor) {
    const tau = now.view.deviation.tau_s,
        [from, to] = zoomed || [tau[0] / 1.5, tau.at(-1) * 1.5];
    const middle = now.cell ? now.cell.tau_s : Math.sqrt(from * to),
        half = (Math.log(to / from) * (factor || 1)) / 2;
    zoomed = factor ? [middle * Math.exp(-half), middle * Math.exp(half)] : null;
    draw();
}

// --- curves that are dragged to another size ---

const held = { part: null };

function grasp() {
    const { drawing, X, Y } = chart;
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
    drawing.addEventListener("pointermove", (event) => {
        const x = event.clientX - drawing.getBoundingClientRect().left;
        if (!held.part) chart.showCursor(x < chart.left || x > chart.right ? null : X.inverse(x));
    });
    drawing.addEventListener("pointerleave", () =>
        now.cell ? chart.showCell(now.cell) : chart.showCursor(null),
    );
    for (const one of chart.cells) {
        const hit = svg(
            "rect",
            { ...one.box, "fill-opacity": 0, style: "cursor:pointer", class: "hit" },
            drawing,
        );
        hit.addEventListener("click", () => show("cell", one.cell));
    }
}

// --- keys ---

const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function keys(drawing, focused) {
    cells.keys(
        drawing,
        "Allan deviation and where it fails. The arrow keys move, w goes to the worst cell.",
        MOVES,
        (by) => {
            const next = cells.neighbour(chart.cells, now.cell, by);
            if (next) show("cell", next);
        },
    );
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
