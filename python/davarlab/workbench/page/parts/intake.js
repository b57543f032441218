// A log before it is read: its samples, the names and units of its columns, what it can tell, and what is doubtful.
import { clockMarks, scale } from "/page/chart/scale.js";
import { area, canvas, svg } from "/page/chart/svg.js";
import { at } from "/page/now.js";
import { duration, element, fill, number } from "/page/words.js";

const QUANTITIES = {
    time: "time",
    gyro: "gyro",
    accel: "accelerometer",
    temp: "temperature",
    other: "something else",
};
const WALKS = { gyro: ["ARW", "deg/√h", 1], accel: ["VRW", "m/s/√h", 9.80665] }; // name, unit, factor from deg/s or g
const WALK_LEAST = 100; // samples
const SHOWN = 4; // columns in the picture

function row(one, index, log) {
    const select = (key, values, chosen) =>
        element(
            "select",
            { "data-index": index, "data-key": key, "aria-label": `${one.name}: ${key}` },
            ...values.map(([value, text]) =>
                element("option", { value, selected: value === chosen }, text),
            ),
        );
    const quantity = select("quantity", Object.entries(QUANTITIES), one.quantity),
        axis = select(
            "axis",
            ["", "x", "y", "z"].map((name) => [name, name]),
            one.axis,
        );
    const units = Object.keys(log.units[one.quantity] || {}).concat(
        ["gyro", "accel"].includes(one.quantity) ? ["counts"] : [],
    );
    const unit = select(
        "unit",
        (units.length ? units : [""]).map((name) => [name, name]),
        one.unit,
    );
    const factor = element("input", {
        type: "number",
        step: "any",
        value: Number(one.factor.toPrecision(9)),
        "data-index": index,
        "data-key": "factor",
        "aria-label": `${one.name}: factor`,
    });
    const name = log.named
        ? one.name
        : element("input", {
              class: "name",
              placeholder: one.name,
              size: 12,
              "aria-label": `${one.name}: name`,
          });
    return element(
        "tr",
        { class: one.sure ? null : "unsure" },
        element("th", { scope: "row" }, name),
        element("td", {}, quantity),
        element("td", {}, axis),
        element("td", {}, unit),
        element("td", {}, factor),
        element("td", {}, one.sure ? "" : "a guess"),
        element(
            "td",
            { class: "n" },
            log.head
                .slice(0, 3)
                .map((values) => number(values[index], 5))
                .join(", "),
        ),
    );
}

// The sample rate: the server's, or that of the first rows of the column that is now called the time. null: none.
function rateOf(log, guesses) {
    const time = guesses.findIndex((one) => one.quantity === "time");
    if (log.rate_hz && log.columns[time]?.factor === guesses[time]?.factor) return log.rate_hz;
    const step =
        time < 0 || log.head.length < 2
            ? 0
            : ((log.head.at(-1)[time] - log.head[0][time]) / (log.head.length - 1)) *
              guesses[time].factor;
    return step > 0 ? 1 / step : null;
}

// The samples of the columns, one below the other.
function picture(log, guesses) {
    const place = at("preview"),
        made = place && canvas(place, "The samples of the recording"),
        rows = guesses
            .map((one, i) => [one, log.plot?.[i]])
            .filter(([one, plot]) => plot && one.quantity !== "time");
    if (!made) return;
    const { drawing, width, height } = made,
        shown = [
            ...rows.filter(([one]) => one.quantity === "gyro"),
            ...rows.filter(([one]) => one.quantity !== "gyro"),
        ].slice(0, SHOWN),
        each = (height - 28) / Math.max(1, shown.length);
    const rate_hz = rateOf(log, guesses),
        span = rate_hz ? (log.rows + log.missing) / rate_hz : log.rows,
        X = scale(false, 0, span, 12, width - 120);
    shown.forEach(([one, plot], i) => {
        const low = Math.min(...plot.low),
            high = Math.max(...plot.high),
            top = 8 + i * each,
            Y = scale(false, low, high === low ? low + 1 : high, top + each - 10, top);
        svg(
            "path",
            {
                d: area(
                    X,
                    Y,
                    plot.low.map((_, k) => (k / Math.max(1, plot.low.length - 1)) * span),
                    plot.low,
                    plot.high,
                ),
                fill: one.quantity === "gyro" ? "var(--meas)" : "var(--model)",
                stroke: one.quantity === "gyro" ? "var(--meas)" : "var(--model)",
            },
            drawing,
        );
        svg("text", { x: width - 112, y: top + each / 2 }, drawing, one.name.slice(0, 18));
    });
    for (const [value, text] of rate_hz ? clockMarks(0, span, (width - 130) / 90) : [])
        svg(
            "text",
            { x: X(value), y: height - 6, "text-anchor": value ? "middle" : "start" },
            drawing,
            text,
        );
}

// The angle or velocity random walk that a column would have, from the differences of its samples.
function walks(log, guesses) {
    const rate_hz = rateOf(log, guesses);
    return guesses
        .map((one, i) => [one, log.plot?.[i]])
        .filter(
            ([one, plot]) =>
                WALKS[one.quantity] && plot?.noise > 0 && rate_hz && log.rows >= WALK_LEAST,
        )
        .map(([one, plot]) => {
            const [walk, unit, size] = WALKS[one.quantity];
            return [
                walk,
                one.name,
                `${number((plot.noise * Math.abs(one.factor) * size * 60) / Math.sqrt(rate_hz), 2)} ${unit}`,
            ];
        });
}

function facts(log, guesses) {
    const rate_hz = rateOf(log, guesses),
        span = rate_hz ? (log.rows + log.missing) / rate_hz : null,
        rows = [
            ["Samples", log.rows.toLocaleString("en").replaceAll(",", " ")],
            ["Sample rate", rate_hz ? `${number(rate_hz, 6)} Hz` : "no time column"],
            ["Duration", span ? duration(span) : "–"],
            ["Missing", log.missing ? `${log.missing} samples` : "none"],
            ...walks(log, guesses)
                .slice(0, 6)
                .map(([walk, name, value], i, all) => [
                    all.length > 1 ? `${walk} of ${name}` : `${walk} would be`,
                    value,
                ]),
        ];
    fill(
        "facts",
        ...rows.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]),
    );
    fill(
        "reach",
        span && log.rows >= log.least
            ? `This record shows noise up to ${duration(span / 9, 2)} of averaging. Slower drift needs a longer one.`
            : "",
    );
}

// What a log that is too short for a verdict can still show.
function short(log, guesses) {
    const rate_hz = rateOf(log, guesses);
    return element(
        "div",
        { id: "short", class: "doubt" },
        element("b", {}, `Too short for a verdict: ${log.rows} of at least ${log.least} samples.`),
        element(
            "p",
            {},
            "It shows the columns, their units, the sample rate, gaps, and roughly the white noise. It cannot show drift, bias instability or a missing effect.",
        ),
        element(
            "p",
            {},
            rate_hz
                ? `Record at least ${duration(log.least / rate_hz, 2)} at this rate, and an hour for drift.`
                : `Record at least ${log.least} samples.`,
        ),
    );
}

export function columns(all, actions) {
    const { log } = all,
        guesses = log.columns.map((one) => ({ ...one }));
    const titles = ["Column", "Is", "Axis", "Unit", "Factor", "Note", "First values"];
    const table = element(
        "table",
        {},
        element("thead", {}, element("tr", {}, ...titles.map((title) => element("th", {}, title)))),
        element("tbody", {}, ...guesses.map((one, index) => row(one, index, log))),
    );
    table.addEventListener("change", (event) => {
        const { index, key } = event.target.dataset,
            one = guesses[index];
        if (!one) return; // a name
        one[key] = key === "factor" ? Number(event.target.value) : event.target.value;
        if (key === "quantity") one.unit = one.would[one.quantity] ?? "";
        if (key !== "factor") one.factor = (log.units[one.quantity] || {})[one.unit] ?? 1;
        one.sure = true;
        table.tBodies[0].rows[index].replaceWith(row(one, Number(index), log));
        table
            .querySelector(`[data-index="${index}"][data-key="${key}"]`)
            .focus({ preventScroll: true });
        if (doubts) doubts.hidden = true; // Read tests what was corrected
        readable();
        facts(log, guesses);
        picture(log, guesses);
    });
    const rate = element("input", {
        type: "number",
        step: "any",
        min: 0,
        id: "rate",
        placeholder: "from the time column",
    });
    const read = element(
        "button",
        {
            class: "go big",
            id: "read",
            onclick: () => actions.read(guesses, Number(rate.value) || null, false),
        },
        "Read",
    );
    const doubts = !log.doubts.length
        ? null
        : element(
              "div",
              { id: "doubts", class: "doubt", role: "alert" },
              element("b", {}, "This recording is implausible. Nothing was fitted."),
              ...log.doubts.map((one) => element("p", {}, one)),
              element(
                  "p",
                  {},
                  "Correct the unit or the factor and read it again, or: ",
                  element(
                      "button",
                      {
                          id: "confirm",
                          onclick: () => actions.read(guesses, Number(rate.value) || null, true),
                      },
                      "Read it unchanged",
                  ),
              ),
          );
    const none = element(
        "p",
        { id: "no-gyro", class: "doubt" },
        "No column is a gyro or an accelerometer with an axis yet. Select one in the table.",
    );
    const few = log.rows >= log.least ? null : short(log, guesses);
    const readable = () => {
        none.hidden = guesses.some((one) => WALKS[one.quantity] && one.axis);
        read.disabled = !none.hidden || Boolean(few);
    };
    readable();
    const names = () => [...table.querySelectorAll("input.name")].map((one) => one.value.trim());
    const unnamed = log.named
        ? null
        : element(
              "p",
              { id: "unnamed", class: "doubt" },
              "The file has no names for its columns. Type them into the table, for example time_us and gyro_x_dps, then ",
              element(
                  "button",
                  { id: "names", onclick: () => actions.names(names()) },
                  "use these names",
              ),
              ". Or select the quantities.",
          );
    fill(
        "landing",
        element(
            "div",
            { class: "imp" },
            element(
                "div",
                { class: "top" },
                element("h1", {}, log.path.split("/").at(-1)),
                element(
                    "span",
                    { class: "soft", id: "log-said" },
                    [`${log.rows} rows`, log.said].filter(Boolean).join(", "),
                ),
            ),
            element(
                "section",
                { class: "col panel" },
                element("div", { class: "plot", id: "preview" }),
                element(
                    "div",
                    { class: "scroll", tabindex: 0, role: "group", "aria-label": "Columns" },
                    table,
                ),
            ),
            element(
                "div",
                { class: "side" },
                few,
                few ? null : doubts,
                unnamed,
                none,
                element("dl", { class: "kv panel", id: "facts" }),
                element("p", { class: "soft", id: "reach" }),
                element(
                    "label",
                    { class: "f" },
                    "Samples per second, if there is no time column",
                    rate,
                ),
                log.skip === null
                    ? null
                    : element(
                          "label",
                          { class: "f" },
                          "Lines to skip at the top of the file",
                          element("input", {
                              type: "number",
                              id: "skip",
                              min: 0,
                              step: 1,
                              value: log.skip,
                              onchange: (event) =>
                                  actions.skip(Math.max(0, Math.round(Number(event.target.value)))),
                          }),
                      ),
                element(
                    "p",
                    { class: "soft small" },
                    "The factor converts the numbers of the file to s, deg/s, g or degC. For counts, take it from the data sheet.",
                ),
            ),
            element(
                "div",
                { class: "row end" },
                element("button", { class: "bare", onclick: actions.close }, "Another file"),
                read,
            ),
        ),
    );
    facts(log, guesses);
    picture(log, guesses);
    new ResizeObserver(() => picture(log, guesses)).observe(at("preview"));
}
