// A chart in the hands: a drag or two fingers zoom, the wheel zooms at the cursor, a double click shows all.
import { svg } from "/page/chart/svg.js";

const DRAG = 6, // pixels; less is a click
    TURN = 0.002, // of the wheel: logarithm of the zoom in a pixel
    LEAST = 1.3; // between the ends of an axis

// The part of a logarithmic axis between two places, not beyond all of it.
function between(axis, a, b, [from, to]) {
    const [low, high] = [axis.inverse(a), axis.inverse(b)].sort((one, other) => one - other),
        ends = [Math.max(from, low), Math.min(to, high)];
    return ends[1] / ends[0] < LEAST
        ? [axis.from, axis.to].sort((one, other) => one - other)
        : ends;
}

// What a zoom by a factor shows, in which the place (x, y) stays. y null: of the averaging times alone. null: all of it.
export function zoomed({ X, Y, whole }, factor, x, y) {
    const part = (axis, at, all) =>
        at === null
            ? [axis.from, axis.to]
            : between(axis, at + (axis.a - at) * factor, at + (axis.b - at) * factor, all);
    const tau = part(X, x, whole.tau),
        range = part(Y, y, whole.range);
    const complete = (shown, all) => shown[0] <= all[0] * 1.001 && shown[1] >= all[1] * 0.999;
    return complete(tau, whole.tau) && (factor > 1 || complete(range, whole.range))
        ? null
        : { tau, range };
}

// place: where the chart is drawn, again and again. chart(): the one that is there. show(zoom): draws it. at(x, y): the pointer is there; at(null): it has gone.
export function hands(place, chart, show, at) {
    const fingers = new Map(); // of a pinch
    let start = null,
        box = null,
        spread = 0;
    const inside = (event) => {
        const { left, top } = place.getBoundingClientRect();
        return [event.clientX - left, event.clientY - top];
    };
    const level = (y) => (y <= chart().bottom ? y : null); // below, there are averaging times alone

    function end() {
        box?.remove();
        start = box = null;
    }

    function brush(x, y) {
        const { left, right, top, bottom, stripBottom, drawing } = chart(),
            within = (value, low, high) => Math.max(low, Math.min(high, value));
        if (!box && Math.hypot(x - start.x, y - start.y) < DRAG) return;
        if (!box) place.setPointerCapture(start.id); // from here on it is no click
        box ??= svg("rect", { class: "brush" }, drawing);
        const tall = level(start.y) !== null && Math.abs(y - start.y) > 3 * DRAG;
        const [x0, x1] = [start.x, x].map((one) => within(one, left, right)).sort((a, b) => a - b);
        const [y0, y1] = tall
            ? [start.y, y].map((one) => within(one, top, bottom)).sort((a, b) => a - b)
            : [top, level(start.y) === null ? stripBottom : bottom];
        Object.assign(start, { x0, x1, y0, y1, tall });
        for (const [name, value] of Object.entries({
            x: x0,
            y: y0,
            width: x1 - x0,
            height: y1 - y0,
        }))
            box.setAttribute(name, value);
    }

    function pinch() {
        const [a, b] = [...fingers.values()],
            wide = Math.hypot(a[0] - b[0], a[1] - b[1]);
        if (spread && wide)
            show(zoomed(chart(), spread / wide, (a[0] + b[0]) / 2, level((a[1] + b[1]) / 2)));
        spread = wide;
    }

    place.addEventListener("pointerdown", (event) => {
        if (!chart()?.ready || event.defaultPrevented || event.button) return; // prevented: a curve is held
        const [x, y] = inside(event),
            { left, right, top, stripBottom } = chart();
        if (event.pointerType === "touch") {
            fingers.set(event.pointerId, [x, y]);
            spread = 0;
            if (fingers.size > 1) for (const id of fingers.keys()) place.setPointerCapture(id);
        } else if (x >= left && x <= right && y >= top && y <= stripBottom)
            start = { x, y, id: event.pointerId };
    });
    place.addEventListener("pointermove", (event) => {
        if (!chart()?.ready) return;
        const [x, y] = inside(event);
        if (fingers.has(event.pointerId)) fingers.set(event.pointerId, [x, y]);
        if (fingers.size === 2) pinch();
        else if (start) brush(x, y);
        else at(x, y);
    });
    place.addEventListener("pointerup", (event) => {
        fingers.delete(event.pointerId);
        if (start && box && start.x1 - start.x0 > DRAG) {
            const { X, Y, whole } = chart(),
                { x0, x1, y0, y1, tall } = start;
            show({
                tau: between(X, x0, x1, whole.tau),
                range: tall ? between(Y, y0, y1, whole.range) : [Y.from, Y.to],
            });
        }
        end();
    });
    place.addEventListener("pointercancel", (event) => {
        fingers.delete(event.pointerId);
        end();
    });
    place.addEventListener("pointerleave", () => start || at(null));
    place.addEventListener("dblclick", () => show(null));
    place.addEventListener(
        "wheel",
        (event) => {
            if (!chart()?.ready || event.ctrlKey) return;
            const [x, y] = inside(event),
                { left, right, top, stripBottom, whole, X } = chart();
            const all = X.from <= whole.tau[0] && X.to >= whole.tau[1];
            if (x < left || x > right || y < top || y > stripBottom) return;
            if (all && event.deltaY > 0 && chart().Y.from <= whole.range[0]) return; // nothing more to show: the page scrolls
            event.preventDefault();
            const pixels = event.deltaMode ? 30 * event.deltaY : event.deltaY;
            show(zoomed(chart(), Math.exp(TURN * pixels), x, level(y)));
        },
        { passive: false },
    );
}
