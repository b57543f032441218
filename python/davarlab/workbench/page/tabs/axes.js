// All axes beside each other: verdict, missing effect and parameters. A click opens an axis.
import { ask } from "/page/api.js";
import { intervalShown, titled, valueShown } from "/page/parts/model.js";
import { families, pause, titled as named, wantedStill } from "/page/parts/next.js";
import { at, leaving, now, refused } from "/page/now.js";
import { select } from "/page/tabs/tabs.js";
import { capital, element, fill, unitText } from "/page/words.js";

let rows = new Map(),
    rowsOf = null,
    tried = {}; // by sensor and column; of which log and effects; what is being tried on an axis
let sensors = null; // of the log, if it has several: {name, axes, error} each, without axes until they were read

export function build(panel) {
    panel.append(
        element(
            "div",
            { class: "scroll", tabindex: 0, role: "group", "aria-label": "All axes" },
            element("table", { id: "all-axes" }),
        ),
    );
}

// Loads the rows, the displayed axis first, then those of the other sensors. This runs after the candidates of the axis are there, so that nothing waits for it.
export async function survey(turn) {
    try {
        const here = now.all.sensor || "";
        for (const column of [
            now.all.column,
            ...now.all.gyros.filter((one) => one !== now.all.column),
        ])
            if (!(await load(turn, here, column))) return;
        const listed = sensors || (await ask("sensors")).sensors.map((name) => ({ name }));
        if (!wantedStill(turn)) return;
        sensors = listed;
        for (const one of sensors)
            if (one.name !== here) {
                const read = one.axes ? {} : await ask("sensor_axes", { sensor: one.name });
                if (!wantedStill(turn)) return;
                Object.assign(one, read);
                draw();
                for (const column of one.axes)
                    if (!keep().has(key(one.name, column)) && !(await load(turn, one.name, column)))
                        return;
            }
    } catch (why) {
        if (wantedStill(turn)) refused(why);
    }
}

// Loads a row, as long as it is wanted. Returns false if it is not.
async function load(turn, sensor, column) {
    let answer = null;
    while (wantedStill(turn) && (!answer || answer.superseded)) {
        if (answer) await pause();
        answer = await ask(
            "axis",
            sensor && sensor !== now.all.sensor ? { column, sensor } : { column },
        );
    }
    if (!wantedStill(turn)) return false;
    keep().set(key(sensor, column), answer);
    draw();
    return true;
}

export function trying(event) {
    tried = event;
    draw();
}

const key = (sensor, column) => JSON.stringify([sensor, column]);

// The rows, which are those of the open log, with the effects that are there.
function keep() {
    const of = JSON.stringify([now.all.path, now.all.own]);
    if (rowsOf !== of) [rows, sensors, rowsOf, tried] = [new Map(), null, of, {}];
    return rows;
}

// As in the headline of the axis: a fit that something speaks against is not green.
const settled = (row) => row.adequacy === "statistical" && !row.against.length;

const missing = (row) =>
    row.adequate && !row.against.length
        ? "Nothing"
        : row.unknown
          ? "No known effect"
          : families(row.candidates).slice(0, 1).map(named).join("") ||
            doubtful(row) ||
            "Not determined";

// What speaks against a fit although it is not what it seems.
const doubtful = (row) =>
    row.candidates
        .filter((one) => one.doubt && row.against.includes(one.kind))
        .slice(0, 1)
        .map((one) => `${capital(one.title)} (doubtful)`)
        .join("");

async function open(sensor, column) {
    select("fit");
    if (sensor !== (now.all.sensor || ""))
        await leaving(`Reading ${sensor}`, "open", { path: now.all.path, sensor });
    if (sensor === (now.all.sensor || "") && column !== now.all.column)
        await leaving(`Analysing ${column}`, "selection", { column });
}

// A gyro and an accelerometer have other units of one effect.
const quantity = (card) => `${card.kind} ${card.parameters[0]?.unit}`;

// The effects of all rows, each once: a column of the table each.
function effects() {
    const found = new Map();
    for (const row of rows.values())
        for (const card of row.cards || [])
            if (card.parameters.length)
                found.set(quantity(card), [titled(card), unitText(card.parameters[0].unit)]);
    return [...found];
}

function value(row, column) {
    const [one] = row.cards.find((card) => quantity(card) === column)?.parameters || [];
    return element(
        "td",
        { class: "n" },
        ...(!one
            ? ["–"]
            : typeof one.value === "string"
              ? [one.value]
              : [
                    element("b", {}, valueShown(one, row.adequate)),
                    element("br"),
                    intervalShown(one, row.adequate, "soft small"),
                ].filter(Boolean)),
    );
}

function line(sensor, column, kinds) {
    const here = sensor === (now.all.sensor || ""),
        row = rows.get(key(sensor, column));
    const button = element(
        "button",
        {
            class: "link",
            "data-axis": column,
            "data-of": sensor,
            "aria-current": here && column === now.all.column ? "true" : null,
            onclick: () => open(sensor, column),
        },
        column,
    );
    const rest = !row
        ? [
              element(
                  "td",
                  { colspan: 2 + kinds.length, class: "soft" },
                  tried.axis === column && tried.of === sensor
                      ? `${capital(tried.trying)} …`
                      : "Waiting …",
              ),
          ]
        : row.error
          ? [element("td", { colspan: 2 + kinds.length, class: "soft" }, row.error)]
          : [
                element(
                    "td",
                    { class: settled(row) ? "good" : null },
                    row.headline.join(" ").replaceAll(" ,", ","),
                ),
                element("td", {}, missing(row)),
                ...kinds.map(([kind]) => value(row, kind)),
            ];
    return element("tr", {}, element("th", { scope: "row" }, button), ...rest);
}

// The rows of a sensor, below its name if the log has several.
function block({ name, axes, error }, kinds) {
    const columns = name === (now.all.sensor || "") ? now.all.gyros : axes || [],
        wide = 3 + kinds.length;
    return element(
        "tbody",
        {},
        ...(name
            ? [element("tr", {}, element("th", { scope: "rowgroup", colspan: wide }, name))]
            : []),
        ...(error
            ? [element("tr", {}, element("td", { colspan: wide, class: "soft" }, error))]
            : columns.map((column) => line(name, column, kinds))),
    );
}

export function draw() {
    if (!now.view) return;
    keep();
    const kinds = effects(),
        { axis, of } =
            (at("all-axes").contains(document.activeElement) && document.activeElement.dataset) ||
            {};
    const blocks = sensors?.length ? sensors : [{ name: now.all.sensor || "" }];
    fill(
        "all-axes",
        element(
            "thead",
            {},
            element(
                "tr",
                {},
                ...["Axis", "Verdict", "Missing"].map((title) => element("th", {}, title)),
                ...kinds.map(([, [name, unit]]) =>
                    element(
                        "th",
                        { class: "n" },
                        `${name}, `,
                        element("span", { class: "soft" }, unit),
                    ),
                ),
            ),
        ),
        ...blocks.map((one) => block(one, kinds)),
    );
    if (axis)
        document
            .querySelector(`[data-axis="${CSS.escape(axis)}"][data-of="${CSS.escape(of)}"]`)
            ?.focus({ preventScroll: true });
}
