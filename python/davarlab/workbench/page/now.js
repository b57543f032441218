// The state of the page, and how it runs actions: the status text, the error line, and only the newest request of a kind.
import { act, forget } from "/page/api.js";
import { duration, number, unitText } from "/page/words.js";

// all: the open recording and its steps. view: the displayed step. found: its candidates. turn: counts how often a step was drawn. stale: whether the page shows outdated results.
// fails: why the held-out recording speaks against the step, null if it does not.
// drawn: the curves and the error as they are shown, which differ from the step's while a value moves. before: the step before, dotted. cell: the selected one. length: of the windows of the map. left: the label of the control that had the focus.
export const now = {
    all: null,
    view: null,
    found: null,
    answer: null,
    fails: null,
    turn: 0,
    stale: false,
    drawn: null,
    before: null,
    next: null,
    cell: null,
    length: 0,
    left: null,
};
export const at = (id) => document.getElementById(id);
const DONE_MS = 4000; // of a message
let busy = 0,
    missed = 0,
    refresh = null; // missed: the revision that arrived during an action

// The unit of the rate: deg/s of a gyro, m/s² of an accelerometer.
export const rateUnit = () => unitText(now.all?.unit || "deg/s");
// A picture of the shown step: the name of its file, its title and its source.
export function picture(name, title) {
    const { recording, column, duration_s, rate_hz } = now.all,
        file = recording.split("/").at(-1);
    return {
        name: `${file}-${name}`,
        title: `${title}, ${column}`,
        source: `${file}, ${duration(duration_s)} at ${number(rate_hz, 6)} Hz. Step ${now.view.number + 1}: ${now.view.did}. davarlab`,
    };
}
export const accel = () => now.all?.unit === "m/s^2";

export function shownBy(show) {
    refresh = show;
}

const OF_A_STEP = ["undo", "redo", "export"]; // buttons above the bench

// Dims an outdated part of the page. It can be read, but not used. A focus inside moves to the page, not to nowhere.
export function dead(id, yes) {
    const part = at(id);
    if (!part) return;
    if (yes && part.contains(document.activeElement)) {
        now.left = document.activeElement.getAttribute("aria-label");
        at("page").focus({ preventScroll: true });
    }
    part.inert = yes;
    part.classList.toggle("stale", yes);
}

// Marks the whole bench, or the first page, as outdated until the current results are drawn. Drawing them also enables the buttons.
export function stale(yes) {
    now.stale = yes;
    dead("bench", yes);
    dead("landing", yes);
    at("bench").setAttribute("aria-busy", yes);
    if (yes) for (const id of OF_A_STEP) at(id).disabled = true;
}

// done: what was done, which goes by itself; else what is being done.
export function say(text, done = false) {
    at("status").textContent = text;
    at("working").hidden = done;
    if (done) setTimeout(() => at("status").textContent === text && say(""), DONE_MS);
    at("toast").hidden = !text;
}

export function refused(why) {
    if (["AbortError", "Gone"].includes(why.name)) return; // a superseded request; a stopped server, which has its own message
    at("error-said").textContent = why.message;
    at("error").hidden = false;
}

// Runs an action of the user and shows an error in one line, or what was done. A change from another tab in the meantime is handled afterwards.
export async function doing(text, work, done = "") {
    say(text);
    at("error").hidden = true;
    busy += 1;
    try {
        await work();
        say(done, Boolean(done));
    } catch (why) {
        say("");
        refused(why);
    }
    busy -= 1;
    if (missed && !busy) {
        const revision = missed;
        missed = 0;
        changed(revision);
    }
}

// Handles a change by this page, which already has it, or by another one. Without a revision: loads the current state.
export function changed(revision) {
    if (busy) missed = Math.max(missed, revision);
    else if (!(now.all?.revision >= revision)) doing("", () => refresh(true));
}

// Runs an action. The page then shows the current state, whether the action succeeded or not.
export function change(text, what, given) {
    stale(true);
    return doing(text, async () => {
        try {
            await act(what, given);
        } finally {
            await refresh();
        }
    });
}

// Runs an action that closes the recording or changes the analysed part. Charts in progress are cancelled.
export function leaving(text, what, given) {
    now.turn += 1;
    forget();
    return change(text, what, given);
}

// Runs an action on the displayed state. The server rejects it if this state is outdated.
export const acting = (text, what, given = {}) =>
    now.stale ? null : change(text, what, { ...given, state: now.view.state });

// Runs only the last request. Superseded requests are neither sent nor drawn.
export function newest(work) {
    let wanted = null,
        running = false;
    return async (given) => {
        wanted = given;
        if (running) return;
        running = true;
        while (wanted) {
            const now = wanted;
            wanted = null;
            try {
                await work(now, () => wanted === null);
            } catch {
                /* leave the chart out */
            }
        }
        running = false;
    };
}

// Tells the parts of the page that something shared has changed: "cell", "next".
const heard = { cell: [], next: [] };
export const hear = (what, work) => heard[what].push(work);
export function show(what, value) {
    now[what] = value;
    for (const work of heard[what]) work(value);
}
