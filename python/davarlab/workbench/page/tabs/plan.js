// The plan of a setup for a chip. The wishes are options of tools/davar-plan, as texts; the planner on the server computes every value.
import { ask, download } from "/page/api.js";
import { at, dead, doing, now } from "/page/now.js";
import { copyButton } from "/page/parts/copy.js";
import { duration, element, fill } from "/page/words.js";

const OWN = ""; // a gyro without a name
const FIRST = { sensor: "icm42688@1000", axes: "3", core: "cortex-m4f" };
const STATED = ["rate", "type", "lsb", "full_scale", "bandwidth", "noise"]; // what a name stands for
const LATE_MS = 300; // an answer that takes longer dims the one before it

// Option, label, values from left to right ("": not stated), words for "not stated", words for a value.
const seconds = (text) => duration(Number(text));
/** @type {[string, string, any[], string, (text: string) => string][]} */
const SLIDERS = [
    [
        "respond",
        "Respond within",
        ["", 0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10, 15, 20, 30, 60, 120, 300, 600],
        "planner's choice",
        seconds,
    ],
    [
        "arw_percent",
        "Interval of ARW (95 %)",
        ["", 0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40],
        "planner's choice",
        (text) => `± ${text} %`,
    ],
    [
        "longest_tau",
        "Longest averaging time",
        [
            "",
            1,
            2,
            5,
            10,
            20,
            30,
            60,
            120,
            300,
            600,
            1200,
            1800,
            3600,
            7200,
            21600,
            43200,
            86400,
            259200,
            604800,
        ],
        "no long curve",
        seconds,
    ],
    [
        "false_alarms_per_hour",
        "False alarms per hour",
        ["", 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1],
        "no alarm",
        (text) => text,
    ],
    [
        "ram",
        "RAM limit",
        [
            "1k",
            "2k",
            "3k",
            "4k",
            "5k",
            "6k",
            "8k",
            "10k",
            "12k",
            "16k",
            "20k",
            "24k",
            "32k",
            "48k",
            "64k",
            "96k",
            "128k",
            "256k",
            "512k",
            "",
        ],
        "none",
        (text) => text,
    ],
    [
        "flash",
        "Flash limit",
        [
            "8k",
            "10k",
            "12k",
            "14k",
            "16k",
            "18k",
            "20k",
            "22k",
            "24k",
            "28k",
            "32k",
            "40k",
            "48k",
            "64k",
            "128k",
            "256k",
            "512k",
            "",
        ],
        "none",
        (text) => text,
    ],
];
const WISHES = SLIDERS.map(([option, label, values, unstated, said]) => ({
    option,
    label,
    values: values.map(String),
    unstated,
    said,
}));
// Key of a row of costs, and its heading.
const COSTS = [
    ["flash_bytes", "Flash"],
    ["ram_bytes", "RAM"],
    ["stack_bytes", "Stack"],
    ["mean_instructions", "Mean push"],
    ["worst_push_instructions", "Worst push"],
];

let wishes = null,
    wishesOf = null,
    known = null,
    answer = null; // answer: the newest one

export const planning = () => document.body.classList.contains("planning");

// --- which view is shown ---

// The address keeps the wishes, so that a reloaded page shows the same plan.
const written = () =>
    history.replaceState(history.state, "", `#plan?${new URLSearchParams(wishes)}`);

export function view(plan) {
    document.body.classList.toggle("planning", plan);
    at("plan").hidden = !plan;
    at("view-model").hidden = !plan;
    if (plan) open();
    else history.replaceState(history.state, "", location.pathname + location.search);
}

// Repeats a request until a server answers; the page reports that none does.
async function query(what, given = {}) {
    for (;;) {
        try {
            return await ask(what, given, null);
        } catch (why) {
            if (why.name !== "Gone") throw why;
            await new Promise((done) => setTimeout(done, 1000));
        }
    }
}

const open = () =>
    doing("", async () => {
        known = await query("planner");
        if (known.missing) {
            fill("plan", element("p", { id: "plan-missing" }, known.missing));
            return;
        }
        const options = Object.fromEntries(new URLSearchParams(location.hash.split("?")[1] || ""));
        const of = JSON.stringify([now.all?.recording, now.all?.column]);
        if (wishes && !wishes.sensor && of !== wishesOf) wishes = { ...wishes, ...ofRecording() }; // no value of another recording stays
        wishesOf = of;
        wishes ??= Object.keys(options).length
            ? options
            : {
                  ...FIRST,
                  ...ofRecording(),
                  core: known.cores.includes(FIRST.core) ? FIRST.core : known.cores[0],
              };
        fill(
            "plan",
            element("h1", {}, "A setup of davar for your gyro and chip"),
            element("form", { id: "plan-wishes", onsubmit: (event) => event.preventDefault() }),
            costs(),
            element("section", { id: "plan-found", "aria-label": "The plan" }),
        );
        form();
        find();
    });

// --- what is stated ---

// The gyro of the open recording: its rate, and its ARW in the model. Its samples are in deg/s there.
function ofRecording() {
    const { all, view: model } = now,
        [arw] = model?.cards.find((one) => one.kind === "angle_random_walk")?.parameters || [];
    if (!all?.recording || all.unit !== "deg/s") return {};
    return {
        sensor: OWN,
        rate: String(Number(all.rate_hz.toPrecision(6))),
        type: "float",
        full_scale: "500",
        ...(arw?.value > 0 ? { noise: String(Number(arw.value.toPrecision(3))) } : {}),
    };
}

function wish(options) {
    wishes = Object.fromEntries(
        Object.entries({ ...wishes, ...options }).filter(([, value]) => value),
    );
    find();
}

const field = (label, control) => element("label", { class: "field" }, label, control);

function choice(id, values, chosen, onchange) {
    return element(
        "select",
        { id, onchange: (event) => onchange(event.target.value) },
        ...values.map(([value, text]) =>
            element("option", { value, selected: value === chosen }, text),
        ),
    );
}

// A number or text that counts when it is complete, not with every key.
const entry = (option, more = {}) =>
    element("input", {
        id: `plan-${option}`,
        value: wishes[option] || "",
        autocomplete: "off",
        ...more,
        onchange: (event) => wish({ [option]: event.target.value.trim() }),
    });

function gyro() {
    const [name, rate] = (wishes.sensor || "").split("@"),
        part = known.sensors.find((one) => one.name === name);
    const named = [
        ...known.sensors.map((one) => [one.name, one.title]),
        [OWN, ofRecording().rate ? "this recording" : "another gyro"],
    ];
    const rates = part?.rates || [];
    return [
        field(
            "Gyro",
            choice("plan-gyro", named, part ? name : OWN, (chosen) =>
                another(chosen, rate || wishes.rate),
            ),
        ),
        field(
            "Sample rate, Hz",
            element("input", {
                id: "plan-rate",
                type: "number",
                min: 0,
                step: "any",
                list: "plan-rates",
                value: rate || wishes.rate || "",
                onchange: (event) =>
                    wish(
                        part
                            ? { sensor: `${name}@${event.target.value}` }
                            : { rate: event.target.value },
                    ),
            }),
        ),
        element(
            "datalist",
            { id: "plan-rates" },
            ...rates.map((value) => element("option", { value })),
        ),
        ...(part ? [] : own()),
        field("Axes", entry("axes", { type: "number", min: 1, max: known.axes_most })),
        field(
            "Clock of the core, MHz",
            entry("clock", { type: "number", min: 0, step: "any", placeholder: "not stated" }),
        ),
    ];
}

function own() {
    const float = wishes.type === "float";
    return [
        field(
            "Type of a sample",
            choice(
                "plan-type",
                known.types.map((one) => [one, one]),
                wishes.type,
                (type) => {
                    wish({
                        type,
                        lsb: type === "float" ? "" : wishes.lsb,
                        full_scale: type === "float" ? wishes.full_scale || "500" : "",
                    });
                    form();
                },
            ),
        ),
        float
            ? field("Full scale, deg/s", entry("full_scale"))
            : field("One count, deg/s", entry("lsb")),
        field("Low-pass, HZ:ORDER", entry("bandwidth", { placeholder: "not declared" })),
        field("Noise, deg/√h", entry("noise", { placeholder: "not stated" })),
    ];
}

// Another gyro: at the nearest of its rates, or without a name at first with the values of the one before.
function another(name, rate) {
    const part = known.sensors.find((one) => one.name === name);
    const none = Object.fromEntries(STATED.map((option) => [option, ""]));
    if (part) {
        const near = part.rates.reduce((a, b) => (Math.abs(b - rate) < Math.abs(a - rate) ? b : a));
        wish({ ...none, sensor: `${name}@${near}` });
    } else
        wish({
            ...none,
            ...(ofRecording().rate ? ofRecording() : answer?.gyro || { rate, type: "int16" }),
            sensor: "",
        });
    form();
}

// The place of a value on its slider: a value between two places stays as it is stated.
function place({ values }, value) {
    const size = (text) => (text === "" ? NaN : parseFloat(text) * (text.endsWith("k") ? 1024 : 1));
    if (values.includes(value)) return values.indexOf(value);
    const next = values.findIndex((one) => size(one) >= size(value));
    return next < 0 ? values.length - 1 : next;
}

function slider(one) {
    const shown = (value) => (value ? one.said(value) : one.unstated);
    const output = element("output", { for: `plan-${one.option}` });
    const input = element("input", {
        type: "range",
        id: `plan-${one.option}`,
        min: 0,
        max: one.values.length - 1,
        step: 1,
        value: place(one, wishes[one.option] || ""),
        oninput: () => {
            const value = one.values[Number(input.value)];
            say(value);
            wish({ [one.option]: value });
        },
    });
    const say = (value) => {
        output.textContent = shown(value);
        input.setAttribute("aria-valuetext", shown(value));
    };
    say(wishes[one.option] || "");
    return element(
        "div",
        { class: "wish" },
        element("label", { for: `plan-${one.option}` }, one.label),
        output,
        input,
    );
}

function form() {
    const focused = document.activeElement?.id;
    fill(
        "plan-wishes",
        element(
            "fieldset",
            {},
            element("legend", {}, "What you have"),
            ...gyro(),
            element("p", { class: "hint", id: "plan-gyro-said" }),
        ),
        element("fieldset", {}, element("legend", {}, "What you want"), ...WISHES.map(slider)),
    );
    if (focused) at(focused)?.focus();
}

// --- what the planner answers ---

// The newest wishes are sent at once, or when one of two earlier requests is answered. An answer is dropped if a newer one is shown.
let asked = 0,
    shown = 0,
    flying = 0,
    waits = false,
    late = null;

async function find() {
    written();
    waits = flying >= 2;
    if (waits) return;
    const turn = ++asked;
    let found;
    flying += 1;
    at("plan").setAttribute("aria-busy", "true");
    late ??= setTimeout(() => old(true), LATE_MS);
    try {
        found = await query("plan", wishes);
    } catch (why) {
        found = { refused: why.message };
    }
    flying -= 1;
    if (turn > shown) {
        shown = turn;
        draw(found);
    }
    if (waits) find();
    else if (shown === asked) {
        clearTimeout(late);
        late = null;
        old(false);
        at("plan").setAttribute("aria-busy", "false");
    }
}

function old(yes) {
    dead("plan-found", yes);
    at("plan-costs").classList.toggle("stale", yes);
}

function draw(found) {
    answer = found;
    if (found.refused) {
        fill("plan-found", said(found.refused, true));
        fill("plan-gyro-said");
        rows({ limits: {}, cores: known.cores.map((core) => ({ core })) });
        return;
    }
    const { gyro: has } = found,
        part = known.sensors.find((one) => one.name === wishes.sensor?.split("@")[0]);
    fill(
        "plan-gyro-said",
        part
            ? `${has.type}, ${has.lsb} deg/s per count, low-pass ${has.bandwidth}, typical noise ${has.noise} deg/√h. `
            : "",
        part ? `Source: ${part.source}.` : "",
    );
    fill("plan-found", ...(found.impossible ? impossible(found) : possible(found)));
    rows(found);
}

const said = (text, alarm) =>
    element("p", { id: "plan-said", role: "status", class: alarm ? "no" : null }, text);

function possible(found) {
    return [
        said(found.subject),
        element("ul", { id: "plan-gives" }, ...found.gives.map((line) => element("li", {}, line))),
        ...found.check.map((line) => element("p", { class: "hint" }, `Check: ${line}.`)),
        element(
            "details",
            {},
            element("summary", {}, "How, and all costs"),
            element(
                "ul",
                {},
                ...[...found.how, ...found.costs].map((line) => element("li", {}, line)),
            ),
        ),
        command(found),
        element(
            "div",
            { class: "row" },
            copyButton(
                "plan-copy",
                "Copy the command",
                () => answer.command,
                () => at("plan-command"),
            ),
            element(
                "button",
                {
                    id: "plan-files",
                    class: "go",
                    onclick: () =>
                        doing(
                            "Writing the files",
                            () => download("setup", wishes, "davar_setup.zip"),
                            "Downloaded davar_setup.zip",
                        ),
                },
                "Download the C files",
            ),
        ),
    ];
}

const POSSIBLE = ["The planner found no wish to relax.", "Possible with:", "Possible with one of:"];

function impossible(found) {
    return [
        said(`Impossible: ${found.impossible[0]}.`, true),
        ...found.impossible.slice(1).map((reason) => element("p", {}, `And ${reason}.`)),
        element(
            "div",
            { class: "row", id: "plan-relax" },
            POSSIBLE[Math.min(found.relax.length, 2)],
            ...found.relax.map((one) =>
                element(
                    "button",
                    {
                        onclick: () => {
                            wish(one);
                            form();
                        },
                    },
                    relaxed(one),
                ),
            ),
        ),
        command(found),
    ];
}

// A wish that makes the others possible, as its control names it.
function relaxed(options) {
    return Object.entries(options)
        .map(([option, value]) => {
            const one = WISHES.find((wish) => wish.option === option);
            return one
                ? `${one.label}: ${one.said(value)}`
                : `${option[0].toUpperCase()}${option.slice(1)}: ${value}`;
        })
        .join(" and ");
}

// Lines break between options.
function command(found) {
    const [program, ...options] = found.command.split(/ (?=-)/);
    return element(
        "pre",
        { id: "plan-command" },
        program,
        ...options.flatMap((one) => [" ", element("span", {}, one)]),
    );
}

// --- what it costs on each core ---

function costs() {
    const core = (name) =>
        element(
            "tr",
            { "data-core": name },
            element(
                "th",
                { scope: "row" },
                element(
                    "label",
                    {},
                    element("input", {
                        type: "radio",
                        name: "plan-core",
                        value: name,
                        checked: name === wishes.core,
                        onchange: () => wish({ core: name }),
                    }),
                    ` ${name}`,
                ),
            ),
        );
    return element(
        "section",
        { id: "plan-costs", "aria-label": "Costs" },
        element(
            "table",
            {},
            element(
                "caption",
                {},
                "What it costs on each core ",
                element(
                    "small",
                    {},
                    "in bytes, and in instructions for a push of one sample of each axis",
                ),
            ),
            element(
                "thead",
                {},
                element(
                    "tr",
                    {},
                    element("th", { scope: "col" }, "Core"),
                    ...COSTS.map(([key, title]) =>
                        element("th", { scope: "col", "data-key": key }, title, element("small")),
                    ),
                ),
            ),
            element("tbody", {}, ...known.cores.map(core)),
        ),
    );
}

// The length of a bar is a share of the limit, or of the largest value of its column.
function rows(found) {
    const scale = Object.fromEntries(
        COSTS.map(([key]) => [
            key,
            found.limits[key] || Math.max(...found.cores.map((row) => row[key] || 0)),
        ]),
    );
    for (const [key] of COSTS)
        at("plan-costs").querySelector(`th[data-key=${key}] small`).textContent = found.limits[key]
            ? ` of ${found.limits[key]}`
            : "";
    for (const row of found.cores) {
        const line = at("plan-costs").querySelector(`tr[data-core="${row.core}"]`);
        line.classList.toggle("chosen", row.core === wishes.core);
        line.replaceChildren(
            line.cells[0],
            ...(row.fits
                ? COSTS.map(([key]) => cell(key, row[key], scale[key]))
                : [
                      element(
                          "td",
                          { colspan: COSTS.length, class: "none" },
                          row.fits === false ? "does not fit" : "",
                      ),
                  ]),
        );
    }
}

function cell(key, value, most) {
    const bar = element("i");
    bar.style.width = `${(100 * value) / most}%`;
    return element(
        "td",
        { class: "figure", "data-key": key },
        String(value),
        element("span", { class: "bar", "aria-hidden": "true" }, bar),
    );
}

at("view-model").onclick = () => view(false);
at("view-plan").onclick = () => view(true);
