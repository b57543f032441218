// The steps: the position in the tree, undo and redo, and the staircase of the error.
import { staircase } from "/page/chart/stairs.js";
import { save } from "/page/chart/svg.js";
import { expected } from "/page/parts/next.js";
import { settled } from "/page/parts/head.js";
import { acting, at, hear, now, picture } from "/page/now.js";
import { labelled } from "/page/words.js";

const undone = {}; // step -> the child that undo left, for redo

export function undoing() {
    const here = now.all.steps[now.all.current],
        children = now.all.steps.filter((step) => step.parent === here.number);
    const child = children.find((step) => step.number === undone[here.number]) || children.at(-1);
    at("undo").disabled =
        here.parent === null &&
        !now.all.selections.some((one) => one.here && (one.cut.length || one.alone.length));
    at("redo").disabled = !child;
    at("undo").title = here.parent === null ? "Undo (u)" : `Undo: ${here.did} (u)`;
    at("redo").title = child ? `Redo: ${child.did} (r)` : "Redo (r)";
    at("undo").onclick = () => {
        undone[here.parent] = here.number;
        return here.parent === null ? uncut() : acting("Undoing", "go", { number: here.parent });
    };
    at("redo").onclick = () => child && acting("Redoing", "go", { number: child.number });
}

let leave = null;
export function whenUncut(work) {
    leave = work;
}

// Undoes the last cut, or the selection of a part.
function uncut() {
    const { column, cut } = now.all.selections.find((one) => one.here);
    leave("Undoing the cut", "selection", { column, cut: cut.slice(0, -1) });
}

// The way to the current step. Of values set by hand one after the other, only the last.
export function way() {
    const found = [],
        { steps, current } = now.all;
    for (let step = steps[current]; step; step = step.parent === null ? null : steps[step.parent])
        found.unshift(step);
    return found.filter(
        (step, i) => step.fitted || step.parent === null || found[i + 1]?.fitted !== false,
    );
}

export function stairs() {
    if (!now.view) return;
    const steps = way().map((step) => ({
        ...step,
        label: labelled(step.did),
        go: () => acting("Loading the step", "go", { number: step.number }),
    }));
    const last = steps.at(-1);
    if (last) last.fits = settled();
    staircase(
        at("staircase"),
        steps.filter((one) => one.error !== null),
        now.next || expected(),
        Math.max(...now.all.steps.map((one) => one.error)),
    );
}

hear("next", stairs);
at("stairs-save").onclick = () =>
    save(at("staircase").firstChild, picture("error", "Error of each step"), "svg");
at("stairs-png").onclick = () =>
    save(at("staircase").firstChild, picture("error", "Error of each step"), "png");
