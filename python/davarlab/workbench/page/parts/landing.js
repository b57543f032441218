// The first page: the tutorial and simulated recordings to try, a drop zone, the last sessions, and the sensors that can be listened to.
import { AllanChart } from "/page/chart/allan.js";
import { bar } from "/page/parts/bar.js";
import { at } from "/page/now.js";
import { duration, element, errorText, fill } from "/page/words.js";

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

// Recordings to try: what is in them is known, and folded.
const exercises = (all, actions) =>
    element(
        "div",
        { class: "exercises", id: "exercises" },
        element("h2", {}, "Simulated recordings with known answers"),
        ...(all.exercises || []).map((one) =>
            element(
                "div",
                { class: "row" },
                element("span", { class: "grow" }, one.story),
                element(
                    "details",
                    {},
                    element("summary", { "aria-label": `Answer: ${one.name}` }, "Answer"),
                    one.answer,
                ),
                element(
                    "button",
                    {
                        "data-exercise": one.name,
                        "aria-label": `Open ${one.name}`,
                        onclick: () => actions.tutorial(one.name),
                    },
                    "Open",
                ),
            ),
        ),
    );

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
                    element(
                        "span",
                        { id: "demo-said", class: "grow" },
                        "Two hours of a simulated gyro. Its data sheet has two noises. ",
                        element("b", {}, "What else is in it?"),
                    ),
                    element(
                        "button",
                        { class: "go big", id: "tutorial", onclick: () => actions.tutorial() },
                        "Open the tutorial",
                    ),
                ),
                exercises(all, actions),
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

let tutorial = null;

// The tutorial as it begins: the measurement and the first model, which does not fit.
async function demo() {
    tutorial ??= await (await fetch("/page/tutorial.json")).json();
    const place = at("demo");
    if (!place) return;
    const { measured, model } = tutorial,
        range = [Math.min(...measured, ...model) / 1.6, Math.max(...measured) * 1.5];
    new ResizeObserver(
        () => new AllanChart(place, tutorial, { range, span: 1, small: true, unit: "deg/s" }),
    ).observe(place);
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
