// The main chart: Allan deviation, measured over model, and where it fails, on one axis of averaging times. A state has the values at the
// octaves, and `curve`, the model at eight averaging times an octave.
import * as cells from "/page/chart/cells.js";
import { marks, scale, spread, timeMarks } from "/page/chart/scale.js";
import { area, canvas, dotted, line, svg } from "/page/chart/svg.js";
import { brief, number, timesText } from "/page/words.js";

const PHONE = 560,
    LETTER = 7,
    MOST = 19, // letters of a name at the right
    DASHES = ["1 3", "6 3", "8 2 2 2", "3 2"];
const RATIOS = [0.4, 6]; // that have a place; an arrow points to one beyond
const clamp = (value, low, high) => Math.max(low, Math.min(high, value));
const NAMES = {
    angle_random_walk: "white noise",
    rate_random_walk: "random walk",
    sinusoid: "line",
};
const called = (kind) => NAMES[kind] || kind.replaceAll("_", " ");

// range: [low, high] of the deviation, which stands still over the steps. zoom: {tau: [from, to], range} or null. overlay: [{name, tau_s, deviation, points}]. shown: [first, last] of the averaging times that the verdict is about, and words for the others, which are hatched.
export class AllanChart {
    constructor(
        place,
        state,
        {
            range,
            zoom = null,
            length = 0,
            span,
            small = false,
            overlay = null,
            shown = null,
            unit,
            label = null,
        },
    ) {
        const made = canvas(place, small ? "Allan deviation, measured and model" : label);
        this.ready = Boolean(made);
        if (!made) return;
        this.drawing = made.drawing;
        this.width = made.width;
        this.height = made.height;
        this.phone = made.width < PHONE;
        this.state = state;
        this.small = small;
        this.length = length;
        this.span = span;
        this.overlay = overlay;
        this.unit = unit;
        this.place(range, zoom);
        this.grid();
        if (shown) this.hatch(shown);
        this.layers();
        this.update(state);
    }

    // Where everything is, in pixels.
    place(range, zoom) {
        const { width, height, phone, small } = this,
            tau = this.state.tau;
        const strip = small ? 0 : clamp(height * 0.21, 50, 110),
            ratio = small ? 0 : clamp(height * 0.16, 40, 72),
            gap = small ? 0 : 10;
        this.left = 48;
        this.right = width - (small ? 84 : phone ? 10 : 150);
        this.top = 12;
        this.bottom = height - 20 - strip - ratio - 2 * gap;
        this.ratioTop = this.bottom + gap;
        this.ratioBottom = this.ratioTop + ratio;
        this.stripTop = this.ratioBottom + gap;
        this.stripBottom = this.stripTop + strip;
        this.whole = { tau: [tau[0] / 1.5, tau.at(-1) * 1.5], range };
        const shown = zoom || this.whole;
        this.X = scale(true, ...shown.tau, this.left, this.right);
        this.Y = scale(true, ...shown.range, this.bottom, this.top);
        const R = scale(true, ...RATIOS, this.ratioBottom, this.ratioTop);
        this.R = (value) => R(clamp(value, ...RATIOS));
    }

    grid() {
        const { drawing, X, Y, left, right, top, bottom, ratioBottom, small, phone } = this,
            grid = svg("g", {}, drawing);
        this.clip = `clip-${Math.random().toString(36).slice(2)}`;
        const clip = (id, y, height) =>
            svg(
                "rect",
                { x: left, y, width: right - left, height },
                svg("clipPath", { id }, drawing),
            );
        clip(this.clip, top, bottom - top);
        clip(`${this.clip}-r`, this.ratioTop, this.stripBottom - this.ratioTop);
        for (const [value, text] of marks(true, Y.from, Y.to, (bottom - top) / 40)) {
            svg(
                "line",
                { x1: left, x2: right, y1: Y(value), y2: Y(value), stroke: "var(--grid)" },
                grid,
            );
            svg("text", { x: left - 6, y: Y(value) + 4, "text-anchor": "end" }, grid, text);
        }
        for (const [value, text] of timeMarks(X.from, X.to)) {
            svg(
                "line",
                {
                    x1: X(value),
                    x2: X(value),
                    y1: top,
                    y2: small ? bottom : ratioBottom,
                    stroke: "var(--grid)",
                },
                grid,
            );
            svg("text", { x: X(value), y: this.height - 5, "text-anchor": "middle" }, grid, text);
        }
        if (phone || small)
            svg(
                "text",
                { x: right, y: top + 10, "text-anchor": "end", class: "halo" },
                grid,
                `Allan deviation, ${this.unit}`,
            );
        else
            ["Allan deviation,", this.unit].forEach((text, i) =>
                svg("text", { x: right + 10, y: top + 10 + 14 * i }, grid, text),
            );
        if (small)
            svg(
                "text",
                { x: right, y: bottom - 6, "text-anchor": "end", class: "halo" },
                grid,
                "averaging time",
            );
        else this.ratioGrid(grid);
    }

    // The averaging times that the verdict says nothing about.
    hatch([first, last, words]) {
        const { drawing, X, left, right, top, ratioBottom: bottom } = this,
            id = `hatch-${this.clip}`,
            pattern = svg(
                "pattern",
                { id, width: 8, height: 8, patternUnits: "userSpaceOnUse" },
                drawing,
            );
        svg("path", { d: "M-2 10L10 -2", stroke: "var(--edge)", opacity: 0.5 }, pattern);
        const edges = [X(first / Math.SQRT2), X(last * Math.SQRT2)].map((x) =>
                clamp(x, left, right),
            ),
            group = svg("g", { class: "untested" }, drawing);
        for (const [from, to] of [
            [left, edges[0]],
            [last ? edges[1] : left, right],
        ]) {
            if (to < from + 2 * LETTER) continue; // the margin of the axis
            svg(
                "rect",
                { x: from, y: top, width: to - from, height: bottom - top, fill: `url(#${id})` },
                group,
            );
            if (to > from + LETTER * words.length)
                svg("text", { x: from + 6, y: bottom - 5, class: "halo" }, group, words);
        }
    }

    ratioGrid(grid) {
        const { R, left, right, ratioTop, ratioBottom, phone } = this;
        /** @type {[number, string][]} */
        const named = [
            [0.5, "½×"],
            [1, "1"],
            [2, "2×"],
            [4, "4×"],
        ];
        for (const [value, text] of named) {
            svg(
                "line",
                {
                    x1: left,
                    x2: right,
                    y1: R(value),
                    y2: R(value),
                    stroke: value === 1 ? "var(--edge)" : "var(--grid)",
                },
                grid,
            );
            if (ratioBottom - ratioTop > 60 || [1, 4].includes(value))
                svg("text", { x: left - 6, y: R(value) + 4, "text-anchor": "end" }, grid, text);
        }
        if (!phone)
            ["measured", "over model"].forEach((text, i) =>
                svg("text", { x: right + 10, y: ratioTop + 12 + 14 * i }, grid, text),
            );
    }

    layers() {
        const { drawing, X, small, state } = this,
            inside = `url(#${this.clip})`;
        const path = (attributes) =>
            svg("path", { fill: "none", "clip-path": inside, ...attributes }, drawing);
        const band = { fill: "var(--model)", "fill-opacity": 0.14 };
        this.labels = svg("g", {}, drawing); // below the curves: a halo must not hide a point
        if (!small) this.ratioBand = path({ ...band, "clip-path": `url(#${this.clip}-r)` });
        this.overlays = (this.overlay || []).map((one, i) =>
            path({
                stroke: "var(--ink)",
                "stroke-width": one.points ? 5 : 1.5,
                "stroke-linecap": one.points ? "round" : null,
                "stroke-dasharray": one.points ? null : ["2 3", "7 4", "1 2"][i % 3],
                class: "overlay",
            }),
        );
        this.before = path({
            stroke: "var(--model)",
            "stroke-width": 1.5,
            "stroke-dasharray": "2 4",
            opacity: 0.7,
        });
        this.parts = (small ? [] : state.effects).map((_, i) =>
            path({ stroke: "var(--soft)", "stroke-dasharray": DASHES[i % 4], class: "part" }),
        );
        this.model = path({
            stroke: "var(--model)",
            "stroke-width": 2.5,
            "stroke-linejoin": "round",
            class: "model",
        });
        this.next = path({
            stroke: "var(--model)",
            "stroke-width": 2,
            "stroke-dasharray": "8 5",
            class: "next",
        });
        this.flag = svg("g", { class: "flag" }, drawing);
        const dots = svg(
            "g",
            { "clip-path": inside, class: "measured", "pointer-events": "none" },
            drawing,
        );
        this.whiskers = svg(
            "path",
            { stroke: "var(--meas)", "stroke-width": 1.5, class: "whiskers" },
            dots,
        );
        this.dots = state.tau.map((tau) =>
            svg(
                "circle",
                {
                    cx: X(tau),
                    r: small ? 3 : 4,
                    fill: "var(--panel)",
                    stroke: "var(--meas)",
                    "stroke-width": 2,
                },
                dots,
            ),
        );
        if (!small) this.lower();
    }

    // The place of a cell in the strip.
    box(cell) {
        const { X, stripTop, stripBottom, span } = this,
            x = X(cell.tau_s / Math.SQRT2) + 0.5,
            each = (stripBottom - stripTop) / span;
        return {
            x,
            y: stripTop + cell.start_s * each + 0.5,
            width: X(cell.tau_s * Math.SQRT2) - x - 0.5,
            height: Math.max(1, (cell.stop_s - cell.start_s) * each - 1),
        };
    }

    // What is below the curve: ratios and cells.
    lower() {
        const { drawing, X, R, state, left, right, top, stripTop, stripBottom, phone } = this,
            many = this.length > 0 && cells.lengths(state.cells).length > 1; // a report has no choice
        const ratios = svg("g", { "clip-path": `url(#${this.clip}-r)` }, drawing);
        this.stems = state.tau.map((tau) =>
            svg(
                "line",
                { x1: X(tau), x2: X(tau), y1: R(1), stroke: "var(--meas)", "stroke-width": 2 },
                ratios,
            ),
        );
        this.ends = state.tau.map(() => svg("path", { fill: "var(--meas)" }, ratios));
        const strip = svg("g", { "clip-path": `url(#${this.clip}-r)`, class: "strip" }, drawing);
        this.cells = cells
            .chosen(state.cells, state.tau, this.length)
            .map(({ cell, index, column }) => {
                const box = this.box(cell);
                return { index, column, box, cell, rect: svg("rect", box, strip) };
            });
        svg(
            "rect",
            {
                x: left,
                y: stripTop,
                width: right - left,
                height: stripBottom - stripTop,
                fill: "none",
                stroke: "var(--edge)",
            },
            drawing,
        );
        svg("text", { x: left - 6, y: stripTop + 11, "text-anchor": "end" }, drawing, "0");
        svg(
            "text",
            { x: left - 6, y: stripBottom - 1, "text-anchor": "end" },
            drawing,
            brief(this.span),
        );
        if (!phone) {
            svg(
                "text",
                { x: right + 10, y: stripTop - 1 },
                drawing,
                many ? "Model, in windows of" : "Model",
            );
            if (many)
                svg(
                    "text",
                    { x: right + 10, y: stripTop + 17, class: "saved" }, // the page has buttons
                    drawing,
                    brief(this.length),
                );
            cells.key(drawing, right + 10, stripTop + (many ? 30 : 8));
        }
        this.selected = svg(
            "rect",
            {
                fill: "none",
                stroke: "var(--ink)",
                "stroke-width": 2.5,
                "pointer-events": "none",
                width: 0,
                height: 0,
            },
            drawing,
        );
        const rule = { stroke: "var(--ink)", opacity: 0.6, "pointer-events": "none" };
        this.cursor = svg("path", { ...rule, fill: "none", class: "cursor" }, drawing);
    }

    // Draws a state on the axes as they are: while a value moves, while a step is animated.
    update(state) {
        if (!this.ready) return;
        this.state = state;
        const { X, Y, R, small } = this,
            { tau, curve } = state;
        this.model.setAttribute("d", line(X, Y, curve.tau_s, curve.model));
        this.parts.forEach((path, i) => {
            const part = state.effects[i]?.curve;
            if (path.drawn !== part)
                path.setAttribute("d", part ? line(X, Y, curve.tau_s, part) : "");
            path.drawn = part;
        });
        if (this.points !== state.measured) this.measure(state); // stays while a value moves
        if (!small) {
            const over = (side) => side.map((value, i) => value / state.model[i]);
            this.ratioBand.setAttribute("d", area(X, R, tau, over(state.low), over(state.high)));
            tau.forEach((_, i) => {
                const ratio = state.measured[i] / state.model[i],
                    y = R(ratio);
                this.stems[i].setAttribute("y2", y);
                this.ends[i].setAttribute(
                    "d",
                    ratio > RATIOS[1]
                        ? "M-4 7h8L0 0z"
                        : ratio < RATIOS[0]
                          ? "M-4 -7h8L0 0z"
                          : "M-3 0a3 3 0 0 1 6 0a3 3 0 0 1-6 0z",
                );
                this.ends[i].setAttribute("transform", `translate(${X(tau[i])} ${y})`);
            });
            for (const { rect, box, index } of this.cells)
                cells.paint(rect, box, state.cells[index].ratio, state.cells[index].z);
        }
        this.name();
    }

    // What no value of the model moves.
    measure({ tau, measured, measured_low: low, measured_high: high }) {
        const { X, Y } = this;
        this.points = measured;
        this.overlays.forEach((path, i) => {
            const { tau_s, deviation, points } = this.overlay[i];
            path.setAttribute("d", (points ? dotted : line)(X, Y, tau_s, deviation));
        });
        this.dots.forEach((dot, i) => dot.setAttribute("cy", Y(measured[i])));
        this.whiskers.setAttribute(
            "d",
            tau.map((one, i) => `M${X(one)} ${Y(low[i])}V${Y(high[i])}`).join(""),
        );
    }

    showBefore(state) {
        if (this.ready)
            this.before.setAttribute(
                "d",
                state ? line(this.X, this.Y, state.curve.tau_s, state.curve.model) : "",
            );
    }

    showNext(deviation) {
        if (this.ready)
            this.next.setAttribute(
                "d",
                deviation ? line(this.X, this.Y, deviation.curve.tau_s, deviation.curve.model) : "",
            );
    }

    // The gap that the headline names. worst: of the server; false: names the place only.
    showFlag(worst, named) {
        if (!this.ready) return;
        this.flag.replaceChildren();
        const i = worst
            ? this.state.tau.findIndex((tau) => Math.abs(tau / worst.tau_s - 1) < 0.01)
            : -1;
        if (i < 0 || worst.stop_s - worst.start_s < 0.99 * this.span) return;
        const { X, Y, state, phone } = this,
            [a, b] = [Y(state.measured[i]), Y(state.model[i])],
            x = X(state.tau[i]);
        svg(
            "line",
            { x1: x, x2: x, y1: a, y2: b, stroke: "var(--meas)", "stroke-width": 2 },
            this.flag,
        );
        if (!named) return;
        const end = i === state.tau.length - 1,
            last = i === state.tau.length - 2 && !phone,
            inside = !end && !last && Math.abs(a - b) > 24,
            above = Math.max(Math.min(a, b) - 10, this.top + 14);
        svg(
            "text",
            {
                x: x + (end ? 10 : last ? 9 : -8),
                y: last
                    ? (a + b) / 2 + 6
                    : inside && !phone
                      ? clamp((a + b) / 2 + 6, Math.min(a, b) + 18, 1e4)
                      : above,
                "text-anchor": end || inside ? "end" : last ? "start" : "middle",
                class: "strong halo",
                style: "font-size:17px;fill:var(--meas-ink)",
            },
            this.flag,
            timesText(state.measured[i] / state.model[i]),
        );
    }

    // Names at the ends of the curves, one below the other.
    name() {
        if (this.phone && !this.small) return;
        const { state, X, Y, bottom, top } = this,
            x = this.right + 10,
            { tau_s: fine, model } = state.curve;
        const last = (tau, values) => values[tau.findLastIndex((one) => X(one) <= this.right)];
        this.labels.replaceChildren();
        this.inside = [];
        const names = [
            ["measured", last(state.tau, state.measured), "var(--meas-ink)", true],
            ["model", last(fine, model), "var(--model)", true],
        ];
        for (const one of this.overlay || [])
            names.push([
                one.name.length > MOST ? `${one.name.slice(0, MOST - 1)}…` : one.name,
                last(one.tau_s, one.deviation),
                "var(--ink)",
                false,
            ]);
        for (const one of this.small ? [] : state.effects) {
            const tail = last(fine, one.curve);
            if (Y(tail) < bottom) names.push([called(one.kind), tail, "var(--soft)", false]);
            else this.nameInside(one);
        }
        const placed = names
            .filter(([, value]) => value > 0)
            .map(([text, value, fill, strong]) => ({
                text,
                fill,
                strong,
                y: clamp(Y(value) + 4, top + 38, bottom),
            }))
            .sort((a, b) => a.y - b.y);
        spread(placed, bottom, 14);
        for (const one of placed)
            svg(
                "text",
                { x, y: one.y, style: `fill:${one.fill}`, class: one.strong ? "strong" : null },
                this.labels,
                one.text,
            );
    }

    // An effect that leaves the chart below is named where it leaves.
    nameInside({ kind, curve }) {
        const { X, Y, state, bottom } = this,
            fine = state.curve.tau_s,
            seen = fine.map((tau, i) => (X(tau) < this.left || X(tau) > this.right ? 0 : curve[i]));
        let i = seen.indexOf(Math.max(...seen));
        if (!seen[i] || Y(seen[i]) > bottom) return;
        while (Y(curve[i + 1]) < bottom) i += 1;
        if (!(X(fine[i + 1]) < this.right)) return;
        const [y0, y1] = [Y(curve[i]), Y(curve[i + 1])],
            share = (bottom - y0) / (y1 - y0);
        const left = X(fine[i]) + share * (X(fine[i + 1]) - X(fine[i])) + 4,
            text = called(kind);
        const y =
            bottom -
            3 -
            14 *
                this.inside.filter(([from, to]) => left < to && left + LETTER * text.length > from)
                    .length;
        this.inside.push([left, left + LETTER * text.length]);
        svg("text", { x: left, y, class: "halo" }, this.labels, text);
    }

    // The octave at a place of the pointer, and the cell there. null: the pointer is beside the charts.
    under(x, y) {
        const { left, right, top, stripBottom, X, state } = this;
        if (x < left || x > right || y < top || y > stripBottom) return null;
        const far = (tau) => Math.abs(X(tau) - x),
            tau = state.tau.reduce((best, one) => (far(one) < far(best) ? one : best));
        const inside = ({ box }) =>
            x >= box.x && x <= box.x + box.width && y >= box.y && y <= box.y + box.height;
        return { tau, y, cell: this.cells.find(inside)?.cell };
    }

    // The crosshair through chart, ratio and map at an octave, with a level at y; and what is there, as text.
    showCursor(at) {
        if (!this.ready) return "";
        const { state, X, left, right, top, stripBottom } = this;
        const level = at?.y ? `M${left} ${at.y}H${right}` : "";
        this.cursor.setAttribute("d", at ? `M${X(at.tau)} ${top}V${stripBottom}${level}` : "");
        const i = at ? state.tau.findIndex((one) => Math.abs(one / at.tau - 1) < 0.01) : -1;
        if (i < 0) return "";
        const { measured, measured_low: low, measured_high: high, model } = state,
            ratio = (value) => `${value.toFixed(2)}×`;
        const cell = at.cell
            ? `; ${brief(at.cell.start_s)} to ${brief(at.cell.stop_s)}: ${ratio(at.cell.ratio)}`
            : "";
        return `${brief(at.tau)}: measured ${number(measured[i])} [${number(low[i])}, ${number(high[i])}], model ${number(model[i])}, ${ratio(measured[i] / model[i])}${cell}`;
    }

    showCell(cell) {
        if (!this.ready) return;
        const box = cell ? this.box(cell) : { x: 0, y: 0, width: 0, height: 0 };
        for (const [name, value] of Object.entries(box)) this.selected.setAttribute(name, value);
    }
}
