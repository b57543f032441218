// The page draws the server's results and sends the user's actions. It computes no result that the terminal prints.
import { ask, drop, listen, recall } from "/page/api.js";
import * as curve from "/page/curve.js";
import * as head from "/page/parts/head.js";
import * as intake from "/page/parts/intake.js";
import * as landing from "/page/parts/landing.js";
import * as menu from "/page/parts/menu.js";
import * as model from "/page/parts/model.js";
import { partly, pressed, rank } from "/page/parts/next.js";
import { close as closeEditor } from "/page/parts/own.js";
import * as steps from "/page/parts/steps.js";
import * as axes from "/page/tabs/axes.js";
import * as columns from "/page/tabs/columns.js";
import * as fit from "/page/tabs/fit.js";
import * as held from "/page/tabs/held.js";
import * as live from "/page/tabs/live.js";
import { planning, view as plan } from "/page/tabs/plan.js";
import * as sheet from "/page/tabs/sheet.js";
import * as spectrum from "/page/tabs/spectrum.js";
import * as tabs from "/page/tabs/tabs.js";
import * as where from "/page/tabs/where.js";
import { other } from "/page/theme.js";
import {
    at,
    change,
    changed,
    doing,
    leaving,
    now,
    refused,
    say,
    shownBy,
    stale,
} from "/page/now.js";
import { duration, element, fill, number } from "/page/words.js";

const STEP_MS = 900; // of the animation of a step
const stills = matchMedia("(prefers-reduced-motion: reduce)");

const still = () => {}; // no zoom, but a drawing to save
tabs.build([
    {
        id: "fit",
        of: "Look",
        title: "Fit",
        picture: "Allan deviation, measured and model",
        ...fit,
    },
    {
        id: "where",
        of: "Look",
        title: "Where",
        picture: "Where the model fails",
        ...where,
        zoom: still,
    },
    { id: "spectrum", of: "Look", title: "Spectrum", ...spectrum },
    {
        id: "columns",
        of: "Look",
        title: "Columns",
        picture: "Against a logged column",
        main: "#against",
        ...columns,
        zoom: still,
    },
    { id: "axes", of: "Look", title: "Axes", ...axes },
    { id: "sheet", of: "Compare", title: "Data sheet", ...sheet, zoom: still },
    { id: "held", of: "Compare", title: "Hold-out", ...held },
    { id: "live", ...live }, // its button is in the header
]);

const opened = {
    drop: (file) =>
        doing(`Reading ${file.name}`, async () => {
            try {
                await drop(file);
            } finally {
                await refresh();
            }
        }),
    open: ({ path, sensor }) =>
        change("Opening the session", "open", sensor ? { path, sensor } : { path }),
    listen: (source) => change(`Listening to ${source}`, "listen", { source }),
    tutorial: (exercise = null) => change("Opening the recording", "tutorial", { exercise }),
    close: () => leaving("", "close"),
    names: (names) => change("Reading the columns by these names", "names", { names }),
    skip: (lines) => change(`Skipping ${lines} lines`, "skip", { lines }),
    sensor: (name) => change(`Reading ${name} and fitting a first model`, "sensor", { name }),
    read: (columns, rate_hz, as_recorded) =>
        change("Reading the recording and fitting a first model", "read", {
            columns,
            rate_hz,
            as_recorded,
        }),
};

// elsewhere: another tab has changed something.
async function refresh(elsewhere = false) {
    const turn = ++now.turn,
        was = now.all;
    recall();
    now.all = await ask("all");
    if (elsewhere && was?.path && was.path !== now.all.path) replaced(was);
    const open = Boolean(now.all.recording);
    if (open && now.all.state !== now.view?.state) stale(true);
    if (open && !now.view) {
        live.away();
        landing.waiting(now.all);
    }
    screen(open);
    visited(open || Boolean(now.all.log));
    if (!open) {
        now.view = now.found = now.before = now.cell = now.sheet = null;
        welcome();
        live.place();
        live.live(now.all).catch(() => {});
        stale(false);
        return;
    }
    sheet.follow();
    live.place();
    live.live(now.all).catch(() => {});
    fill(
        "axis",
        ...now.all.gyros.map((name) =>
            element("option", { value: name, selected: name === now.all.column }, name),
        ),
    );
    const next = await ask("step", { number: now.all.current });
    if (turn !== now.turn || next.state !== now.all.state) return; // the server reports the change in the meantime with an event
    const before =
        now.view && now.of === identity() && next.state !== now.view.state ? now.drawn : null;
    if (now.of && JSON.parse(now.of)[0] !== now.all.recording) tabs.select("fit");
    if (now.of !== identity()) {
        [now.cell, now.length] = [null, 0];
        closeEditor();
        model.fold();
    }
    now.of = identity();
    [now.view, now.drawn] = [next, curve.atRest(next)];
    at("landing").hidden = true;
    at("bench").hidden = false;
    await draw(turn, before);
}

const pathOf = (all) => all.path ?? all.log?.path;

// An open recording has an entry in the browser's history: Back closes it, Forward opens it again.
function visited(open) {
    const path = pathOf(now.all),
        { sensor } = now.all;
    if (open && !history.state) history.pushState({ path, sensor }, "");
    else if (open) history.replaceState({ path, sensor }, "");
    else if (history.state) history.back();
}

addEventListener("popstate", () => {
    const open = Boolean(now.all?.recording || now.all?.log);
    if (open && !history.state) opened.close();
    else if (!open && history.state?.path) opened.open(history.state);
});

const identity = () =>
    JSON.stringify([now.all.recording, now.all.column, now.all.alone, now.all.cut]);

function welcome() {
    live.away();
    if (now.all.log?.sensors) landing.sensors(now.all, opened);
    else if (now.all.log) intake.columns(now.all, opened);
    else landing.first(now.all, opened);
}

// All tabs show one recording. This one says so when another tab has opened or closed it.
function replaced({ path, sensor }) {
    const name = path.split("/").at(-1),
        shown = pathOf(now.all)?.split("/").at(-1);
    fill(
        "error-said",
        shown
            ? `Another tab opened ${shown}. All tabs show the same recording. `
            : `Another tab closed ${name}. `,
        element(
            "button",
            { id: "reopen", onclick: () => opened.open({ path, sensor }) },
            `Open ${name} again`,
        ),
    );
    at("error").hidden = false;
}

// What is on the screen: the bench of a recording, or the first page.
function screen(open) {
    document.body.classList.toggle("open", open);
    at("view-model").textContent = open ? "Back to the model" : "Back to the first page";
    at("landing").hidden = Boolean(open && now.view);
    at("bench").hidden = !open || !now.view; // show nothing of a closed recording
    at("close").hidden = at("axis-label").hidden = !open;
    if (!open) for (const id of ["undo", "redo", "export"]) at(id).disabled = true;
    const { all } = now,
        missing = all.missing ? ` (${all.missing} missing in ${all.gaps} gaps)` : "";
    at("close").title = open
        ? `${all.samples} samples${missing}, ${number(all.rate_hz, 6)} Hz. Open another recording`
        : "";
    fill(
        "recording",
        ...(open
            ? [
                  [all.recording.split("/").at(-1), all.sensor].filter(Boolean).join(" "),
                  element(
                      "span",
                      { class: "soft" },
                      ` ${duration(all.duration_s)}, ${number(all.rate_hz, 6)} Hz${all.missing ? `, ${all.missing} missing` : ""}`,
                  ),
              ]
            : []),
    );
}

// Draws a step. From the step before, what changed moves there.
async function draw(turn, before) {
    const target = now.drawn;
    [now.found, now.answer, now.fails, now.before, now.next] = [null, null, null, before, null];
    at("export").disabled = false;
    model.draw();
    steps.undoing();
    where.selections();
    held.names();
    head.headline();
    steps.stairs();
    await tabs.draw();
    stale(false);
    refocus();
    held.error();
    rank(turn).then(() => axes.survey(turn));
    if (before && !stills.matches && !(await moveTo(before, target, turn))) return;
    if (turn === now.turn) settle(target);
}

function settle(target) {
    now.animated = false;
    now.drawn = target;
    drawn();
}

// Draws what moves. A chart that is not shown is of an earlier state, perhaps of another recording.
function drawn() {
    head.error();
    if (tabs.showing("fit")) fit.update(now.drawn);
}

// A step moves curve, band and cells. Error and words change at once. False: another step or a value that moves ended it.
function moveTo(from, to, turn) {
    now.animated = true;
    return new Promise((done) => {
        let started = null;
        const tick = (time) => {
            started ??= time;
            const t = Math.min(1, (time - started) / STEP_MS),
                eased = t < 0.5 ? 4 * t ** 3 : 1 - (2 - 2 * t) ** 3 / 2;
            if (turn !== now.turn || !now.animated || t >= 1) {
                done(now.animated && turn === now.turn);
                return;
            }
            now.drawn = curve.between(from, to, eased);
            drawn();
            requestAnimationFrame(tick);
        };
        requestAnimationFrame(tick);
    });
}

// The focus goes back to the control of the model that had it; that of a card goes on to the next step.
function refocus() {
    const label = now.left;
    now.left = null;
    if (label && document.activeElement === at("page"))
        document
            .querySelector(`#model [aria-label="${CSS.escape(label)}"]`)
            ?.focus({ preventScroll: true });
}

// A value that moves.
let frame = 0;
model.whenMoved((state) => {
    now.animated = false;
    now.drawn = state;
    if (frame) return;
    frame = requestAnimationFrame(() => {
        frame = 0;
        drawn();
    });
});
steps.whenUncut(leaving);

const keys = {
    u: () => at("undo").click(),
    r: () => at("redo").click(),
    f: () => at("refit")?.click(),
    s: menu.saveModel,
    w: () => now.view && !now.stale && fit.worst(),
    "?": () => at("help").showModal(),
};

document.addEventListener("keydown", (event) => {
    if (event.target.matches("input:not([type=range]), select, textarea") || event.altKey) return;
    if (event.ctrlKey || event.metaKey) {
        if (event.key === "z" && now.view) {
            at("undo").click();
            event.preventDefault();
        }
        return;
    }
    if (planning() && event.key !== "?") return; // the other keys act on the model
    if (keys[event.key]) keys[event.key]();
    else if (/^[1-3]$/.test(event.key)) pressed(Number(event.key) - 1, event.timeStamp);
    else return;
    event.preventDefault();
});

// A file may be dropped anywhere.
document.addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("over");
});
document.addEventListener(
    "dragleave",
    (event) => event.relatedTarget || document.body.classList.remove("over"),
);
document.addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("over");
    if (event.dataTransfer.files[0]) opened.drop(event.dataTransfer.files[0]);
});

at("axis").onchange = async () => {
    await leaving(`Analysing ${at("axis").value}`, "selection", { column: at("axis").value });
    if (planning()) plan(true); // of this axis
};
at("tab-live").addEventListener("click", () => planning() && plan(false));
at("home").onclick = at("close").onclick = () => {
    plan(false);
    if (now.all?.recording || now.all?.log) opened.close();
};
at("help-button").onclick = () => at("help").showModal();
at("theme").onclick = other;
at("error-close").onclick = () => {
    at("error").hidden = true;
    at("page").focus();
};
new ResizeObserver(
    () => now.drawn && now.view && !at("bench").hidden && (head.error(), steps.stairs()),
).observe(at("staircase"));

let left = null; // what was open when the server stopped answering

// Shown if the server does not answer: which steps are saved, and how to continue. other: another server answers.
function gone(other) {
    say("");
    stale(true);
    left ??= now.all;
    const kept = now.all?.recording
        ? `The ${now.all.steps.length} step${now.all.steps.length > 1 ? "s are" : " is"} saved in ${now.all.session}. An unfinished computation is lost. `
        : "";
    const again = now.all?.again || "tools/davarlab open",
        command = element("code", {}, other ? again.replace(/ --port \d+/, "") : again);
    if (other)
        fill(
            "gone",
            element("h1", {}, "Another server uses this address"),
            kept,
            "This page cannot reconnect to it. Run ",
            command,
            " and open the address that it prints.",
        );
    else
        fill(
            "gone",
            element("h1", {}, "The workbench server does not answer"),
            kept,
            "If it has stopped, run ",
            command,
            ". This page then reconnects by itself.",
        );
    at("gone").hidden = false;
}

// Reconnected. A server that was started without the recording opens it.
async function back() {
    const { path, sensor } = left || {};
    left = null;
    at("gone").hidden = true;
    if (!path) return;
    const { recording, log } = await ask("all");
    if (!recording && !log) opened.open({ path, sensor });
}

shownBy(refresh);
listen(
    (event) => {
        if (event.progress) say(event.progress);
        if (event.candidates) partly(event);
        if (event.axis) axes.trying(event);
        if (event.live) live.heard(event.live);
        if (event.changed) changed(event.changed);
    },
    gone,
    () => back().catch(refused),
);
if (location.hash.startsWith("#plan")) plan(true);
