// A second recording of the same sensor: every step is tested on it, and none is fitted to it.
import { ask, drop } from "/page/api.js";
import { bar } from "/page/parts/bar.js";
import { at, change, doing, now } from "/page/now.js";
import { element, errorText, fill } from "/page/words.js";
import { headline } from "/page/parts/head.js";
import { stairs, way } from "/page/parts/steps.js";

export function build(panel) {
    const file = element("input", {
        type: "file",
        id: "held-file",
        class: "hidden-file",
        tabindex: -1,
        "aria-label": "a recording to test on",
        onchange: () =>
            file.files[0] &&
            doing("Reading the held-out recording", async () => {
                const chosen = file.files[0];
                file.value = "";
                await drop(chosen, "held-out");
            }),
    });
    panel.append(
        element(
            "div",
            { class: "held" },
            element("h2", {}, "A second recording of the same sensor"),
            element(
                "p",
                { class: "soft" },
                "Every step is tested on it, but not fitted to it. A missing effect lowers both errors. An effect that only follows chance lowers the first one alone.",
            ),
            element(
                "div",
                { class: "row" },
                element(
                    "button",
                    { class: "go", id: "hold", onclick: () => file.click() },
                    "Choose a recording",
                ),
                file,
                element("b", { id: "held-name" }),
                element(
                    "button",
                    {
                        id: "let-go",
                        hidden: true,
                        onclick: () => change("Removing the held-out recording", "let_go"),
                    },
                    "Stop testing on it",
                ),
            ),
            element("div", { id: "held-steps" }),
        ),
    );
}

export function names() {
    at("held-name").textContent = now.all.held_out
        ? now.all.held_out.split("/").at(-1)
        : now.all.not_held;
    at("let-go").hidden = !now.all.held_out;
}

// The error of the current step on the held-out recording, beside the headline.
export async function error() {
    if (!now.all.held_out) return;
    at("held-out-error").textContent = "held out …";
    const { turn } = now;
    let said;
    try {
        const found = await ask("held_out", { number: now.view.number });
        said = `held out ${errorText(found.error)} (floor ${errorText(found.floor)})`;
        if (turn === now.turn && found.fails) {
            now.fails = "it does not fit the held-out recording";
            headline();
            stairs();
        }
    } catch (why) {
        said = `held out: ${why.message}`;
    }
    if (turn === now.turn && at("held-out-error")) at("held-out-error").textContent = said;
}

export async function draw() {
    if (!now.all.held_out) {
        fill("held-steps");
        return;
    }
    const { turn } = now,
        steps = way(),
        rows = [];
    for (const step of steps) {
        let found;
        try {
            found = await ask("held_out", { number: step.number });
        } catch {
            continue;
        }
        if (turn !== now.turn) return;
        const most = Math.max(...steps.map((one) => one.error || 0), found.error);
        rows.push(
            element(
                "tr",
                {},
                element("th", { scope: "row" }, step.did),
                element("td", {}, bar(step.error, step.error, step.floor, most)),
                element("td", { class: "n" }, errorText(step.error)),
                element("td", {}, bar(found.error, found.error, found.floor, most)),
                element("td", { class: "n" }, errorText(found.error)),
            ),
        );
        fill(
            "held-steps",
            element(
                "table",
                {},
                element(
                    "thead",
                    {},
                    element(
                        "tr",
                        {},
                        ...["Step", "Fitted", "", "Held out", ""].map((title) =>
                            element("th", {}, title),
                        ),
                    ),
                ),
                element("tbody", {}, ...rows),
            ),
        );
    }
}
