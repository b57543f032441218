// The first page: the tutorial moving by itself, a drop zone, the last sessions, and the sensors that can be listened to.
import { AllanChart } from "/page/chart/allan.js";
import { bar } from "/page/parts/bar.js";
import { between } from "/page/curve.js";
import { at } from "/page/now.js";
import { duration, element, errorText, fill } from "/page/words.js";

const still = matchMedia("(prefers-reduced-motion: reduce)");
const HOLD_S = 2.2,
    MOVE_S = 1,
    CYCLE_S = 10;

// A place for a file, which may also be dropped anywhere on it.
function zone(actions) {
    const input = element("input", {
        type: "file",
        id: "file",
        class: "hidden-file",
        tabindex: -1,
        "aria-label": "a recording",
        onchange: () => input.files[0] && actions.drop(input.files[0]),
    });
    return element(
        "div",
        { class: "drop" },
        element("b", {}, "Drop a log here"),
        element("span", { class: "soft" }, "CSV, ULog, DataFlash, bag, MCAP, MAT, Parquet"),
        input,
        element("button", { id: "choose", onclick: () => input.click() }, "Choose a file"),
        element("span", { class: "soft small" }, "It stays on this machine."),
    );
}

function recent(all, actions) {
    if (!all.recent?.length) return null;
    const most = Math.max(...all.recent.map((one) => one.error));
    return element(
        "section",
        {},
        element("h2", {}, "Recent"),
        element(
            "div",
            { class: "list" },
            ...all.recent.map((one) =>
                element(
                    "button",
                    { class: "recent", onclick: () => actions.open(one), title: one.path },
                    element("span", {}, one.name),
                    bar(one.error, one.error, one.floor, most),
                    element("span", { class: "soft" }, errorText(one.error)),
                ),
            ),
        ),
    );
}

function sources(all, actions) {
    const source = element("input", {
        id: "source",
        placeholder: "can:can0 or slcan:/dev/ttyUSB0",
        required: true,
        "aria-label": "a live sensor",
    });
    return element(
        "section",
        {},
        element("h2", {}, "Listen to a sensor"),
        element(
            "div",
            { class: "list" },
            ...(all.sources || []).map((one) =>
                element(
                    "button",
                    { onclick: () => actions.listen(one) },
                    element("span", {}, one.split(":")[1]),
                    element("span", { class: "soft" }, one.startsWith("can:") ? "CAN" : "serial"),
                    element("span", {}, "Listen"),
                ),
            ),
        ),
        element(
            "form",
            {
                class: "row",
                onsubmit: (event) => {
                    event.preventDefault();
                    actions.listen(source.value);
                },
            },
            source,
            element("button", { id: "listen" }, "Listen"),
        ),
    );
}

export function first(all, actions) {
    fill(
        "landing",
        element(
            "div",
            { class: "land" },
            element(
                "div",
                { class: "hero" },
                element("h1", {}, "Find what your gyro model is missing"),
            ),
            element(
                "section",
                { class: "demo panel", "aria-label": "Tutorial" },
                element("div", {
                    class: "plot",
                    id: "demo",
                    "aria-hidden": true,
                    hidden: Boolean(all.live),
                }),
                element("div", { id: "demo-live" }),
                element(
                    "footer",
                    {},
                    element("span", { id: "demo-said" }),
                    element("span", { class: "grow", id: "demo-bar" }),
                    element(
                        "button",
                        { class: "go big", id: "tutorial", onclick: actions.tutorial },
                        "Open the tutorial",
                    ),
                ),
            ),
            element(
                "div",
                { class: "side" },
                zone(actions),
                recent(all, actions),
                sources(all, actions),
            ),
        ),
    );
    demo();
}

// Shown until the first step of a recording is there.
export function waiting(all) {
    fill(
        "landing",
        element(
            "div",
            { class: "choose" },
            element("h1", {}, `Opening ${all.recording.split("/").at(-1)}`),
            element("p", { class: "soft" }, `${all.samples} samples, ${duration(all.duration_s)}`),
        ),
    );
}

let tutorial = null,
    running = 0;

async function demo() {
    const turn = ++running;
    tutorial ??= await (await fetch("/page/tutorial.json")).json();
    if (turn !== running || !at("demo")) return;
    const { steps, said } = tutorial,
        last = steps.length - 1,
        place = at("demo"),
        range = [
            Math.min(...steps[0].measured, ...steps[last].model) / 1.6,
            Math.max(...steps[0].measured) * 1.5,
        ];
    let chart = null,
        started = null;
    const build = () => {
        chart = new AllanChart(place, steps[last], { range, span: 1, small: true, unit: "deg/s" });
    };
    build();
    const observer = new ResizeObserver(build);
    observer.observe(place);
    const tick = (time) => {
        if (turn !== running || !at("demo")) {
            observer.disconnect();
            return;
        }
        started ??= time;
        const at_s = still.matches ? CYCLE_S : ((time - started) / 1000) % CYCLE_S,
            one = Math.min(last, Math.floor(at_s / (HOLD_S + MOVE_S))),
            moved = Math.max(0, at_s - one * (HOLD_S + MOVE_S) - HOLD_S) / MOVE_S;
        const eased = moved * moved * (3 - 2 * moved),
            state =
                one < last ? between(steps[one], steps[one + 1], Math.min(1, eased)) : steps[last],
            number = Math.min(last, one + Number(eased > 0.5));
        chart.update(state);
        if (at("demo-said").dataset.number !== String(number) || eased) {
            at("demo-said").dataset.number = String(number);
            fill(
                "demo-said",
                element("span", { class: "soft" }, said[number]),
                element("br"),
                element(
                    "b",
                    { class: number === last ? "good" : null },
                    `error ${errorText(state.error)}`,
                ),
            );
            fill("demo-bar", bar(steps[0].error, state.error, state.floor, steps[0].error));
        }
        if (!still.matches) requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
}

// Selects one of several gyros in a log.
export function sensors(all, actions) {
    fill(
        "landing",
        element(
            "div",
            { class: "choose" },
            element("h1", {}, "Which sensor?"),
            element(
                "p",
                { class: "soft" },
                `${all.log.path.split("/").at(-1)} contains ${all.log.sensors.length} gyros.`,
            ),
            element(
                "div",
                { class: "list panel" },
                ...all.log.sensors.map((one) =>
                    element(
                        "button",
                        { "data-sensor": one.name, onclick: () => actions.sensor(one.name) },
                        element(
                            "span",
                            { class: "grow" },
                            element("b", {}, one.name),
                            element("span", { class: "soft" }, one.said.slice(one.name.length)),
                        ),
                    ),
                ),
            ),
            element(
                "div",
                { class: "row" },
                element("button", { class: "bare", onclick: actions.close }, "Another file"),
            ),
        ),
    );
}
