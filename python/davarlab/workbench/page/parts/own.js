// An effect of one's own: Python in an editor, a live check on the open recording, and Add.
import { act, ask } from "/page/api.js";
import { scale } from "/page/chart/scale.js";
import { area, canvas, svg } from "/page/chart/svg.js";
import { xy } from "/page/chart/xy.js";
import { acting, at, newest, now, refused } from "/page/now.js";
import { element, fill } from "/page/words.js";

const PAUSE_MS = 800; // in the typing, before the code runs
let text = "",
    gyro = null,
    timer = 0,
    found = null,
    edited = null; // edited: the effect of the model that it replaces

const code = () => at("own-code");

// Shows the editor in place of the next step and the model. column: what the effect may follow; card: an effect of the model to edit.
export async function open(column = null, card = null) {
    try {
        const start = await ask("own", card ? { kind: card.kind } : column ? { column } : {});
        [text, gyro, found, edited] = [start.text, start.gyro, null, card];
    } catch (why) {
        refused(why);
        return;
    }
    fill(
        "own",
        element("h2", {}, card ? `Replace ${card.title}` : "Write an effect"),
        element("textarea", {
            id: "own-code",
            "aria-label": "Python code of the effect",
            spellcheck: "false",
            autocomplete: "off",
            oninput: typed,
        }),
        element("p", { id: "own-said", role: "status" }),
        element("div", { class: "plot", id: "own-plot" }),
        element(
            "p",
            { class: "soft small" },
            "This Python code runs on this machine, as you, each time you stop typing. ",
            element("span", { id: "own-file" }),
        ),
        element(
            "div",
            { class: "row" },
            element("button", { class: "bare", onclick: close }, "Cancel"),
            element("span", { class: "grow" }),
            element(
                "button",
                { class: "go big", id: "own-add", disabled: true, onclick: add },
                card ? "Replace" : "Add",
            ),
        ),
    );
    code().value = text;
    at("own").hidden = false;
    at("bench").classList.add("editing");
    new ResizeObserver(draw).observe(at("own-plot"));
    code().setSelectionRange(0, 0);
    code().focus({ preventScroll: true });
    at("own").scrollTop = code().scrollTop = 0;
    check({ text });
}

export function close() {
    if (at("own").hidden) return;
    clearTimeout(timer);
    at("own").hidden = true;
    at("bench").classList.remove("editing");
    fill("own");
    (document.querySelector("#next button.write") || at("page")).focus({ preventScroll: true });
}

function typed() {
    text = code().value;
    at("own-add").disabled = true;
    clearTimeout(timer);
    timer = setTimeout(() => check({ text }), PAUSE_MS);
}

const check = newest(async (given, still) => {
    const answer = await act("check_own", given).catch((why) => ({ error: why.message }));
    if (!still() || at("own").hidden || given.text !== text) return;
    found = answer.error ? null : answer;
    at("own-said").className = answer.error ? "wrong" : "";
    at("own-said").textContent = answer.error
        ? `Not yet: ${answer.error}`
        : `✓ ${answer.kind} returns ${answer.said} for this recording.`;
    at("own-file").textContent = found ? `Add saves it as ${found.file}.` : "";
    at("own-add").disabled = !found;
    draw();
});

// What the effect returns, over the gyro.
function draw() {
    const place = at("own-plot");
    if (!place) return;
    if (found?.density) {
        xy(place, [{ x: found.f_hz, y: found.density, colour: "var(--model)" }], {
            x: { log: true, title: "Hz" },
            y: { log: true, title: "density" },
            right: 8,
            label: "The spectrum of the effect",
        });
        return;
    }
    const made = canvas(
        place,
        found ? `${now.all.column} and the course of the effect` : now.all.column,
    );
    if (!made) return;
    const half = found ? made.height / 2 : made.height;
    for (const [one, colour, name, top] of [
        [gyro, "--meas", now.all.column, 0],
        ...(found ? [[found.course, "--model", found.kind, half]] : []),
    ]) {
        const low = Math.min(...one.low),
            high = Math.max(...one.high),
            Y = scale(false, low, high > low ? high : low + 1, top + half - 6, top + 6),
            X = scale(false, 0, one.low.length - 1, 6, made.width - 110);
        svg(
            "path",
            {
                d: area(
                    X,
                    Y,
                    one.low.map((_, i) => i),
                    one.low,
                    one.high,
                ),
                fill: `var(${colour})`,
                stroke: `var(${colour})`,
            },
            made.drawing,
        );
        svg(
            "text",
            { x: made.width - 104, y: top + half / 2 + 4 },
            made.drawing,
            name.slice(0, 16),
        );
    }
}

async function add() {
    const before = now.all.steps.length,
        added = text;
    if (edited)
        await acting(`Fitting without ${edited.name}`, "remove", {
            place: edited.place,
            kind: edited.kind,
        });
    edited = null;
    await acting("Fitting with your effect", "add_own", { text: added });
    if (now.all.steps.length > before || at("error").hidden) close();
}

// The way to the editor, or to a terminal where this server runs no code.
export function way(column, command) {
    return now.all.code
        ? element("button", { class: "write", onclick: () => open(column) }, "Write an effect")
        : element(
              "div",
              {},
              element("p", { class: "soft" }, "In a terminal:"),
              command && element("pre", { class: "whole", tabindex: 0 }, command),
              element(
                  "p",
                  { class: "soft small" },
                  "To write it here, start tools/davarlab open in a terminal.",
              ),
          );
}
