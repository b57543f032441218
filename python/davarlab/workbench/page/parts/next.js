// The right column: the next step. Cards of what lowers the error, each with the error after it; what fits; what no known effect explains.
import { ask } from "/page/api.js";
import { bar } from "/page/parts/bar.js";
import { headline, settled } from "/page/parts/head.js";
import { open as edit } from "/page/parts/own.js";
import { unknown } from "/page/parts/unknown.js";
import { acting, at, now, refused, say, show } from "/page/now.js";
import { capital, element, errorText, fill } from "/page/words.js";

const CARDS = 3,
    FIRST = 6, // effects whose errors are computed for the cards
    PAIRED = 3, // of which pairs are tried, if none of them helps
    HELPS = 0.99, // times the error: less is not seen
    STEADY = 1.005; // times the error: a smaller rise is not seen
const ALIKE = 3,
    NEAR = 30; // in units of the log-likelihood
let foreseen = new Map(); // key of a card -> error and curve with its effect, or its two
let painted = [],
    earlier = { until: 0, cards: [] }; // the cards on the screen, and those before them

// Loads the candidates for the fitted model. This runs after a step is drawn, so that its curve appears first.
export async function rank(turn) {
    [now.found, now.answer, foreseen, painted] = [null, null, new Map(), []];
    earlier = { until: 0, cards: [] };
    trying("the effects");
    try {
        const answer = await ask("candidates", { number: now.view.number });
        if (turn !== now.turn || answer.state !== now.view.state) return;
        if (answer.superseded) {
            await pause();
            return turn === now.turn ? rank(turn) : null;
        }
        [now.found, now.answer] = [answer.candidates, answer];
        say("");
        draw();
        headline();
        show("next", expected()); // the staircase knows now whether the last step is green
        await foresee(turn);
    } catch (why) {
        if (wantedStill(turn)) refused(why);
    }
}

// Is the step still shown. The server refuses questions about another one, which nobody asks any more.
export const wantedStill = (turn) => turn === now.turn && !now.stale;

// Shows which effect is being tested, and what was found so far, which cannot be added yet.
export function partly(event) {
    if (now.found || !now.view || now.stale || event.ranking !== now.view.state) return;
    trying(event.trying, event.candidates);
}

function trying(what, found = []) {
    if (now.view.adequate) found = [];
    fill(
        "next",
        element(
            "div",
            { class: "card best panel waiting", id: "trying" },
            element("p", { class: "kicker" }, "Next"),
            element("p", { class: "soft" }, `Trying ${what} …`),
            element("progress", { "aria-label": "Testing effects" }),
        ),
        ...found
            .slice(0, CARDS)
            .map((one) =>
                element(
                    "article",
                    { class: "card panel early" },
                    element("h2", {}, capital(one.title)),
                ),
            ),
    );
}

// A card is a candidate, others of the same physics, and perhaps a candidate that joins with it (also).
const key = ({ one, also }) => (also ? `${one.place} ${also.place}` : String(one.place));
const errorOf = (card) => foreseen.get(key(card))?.error;

// Is an effect proposed: it lowers the error. Of what speaks against a model that fits, the error need not fall.
export const helps = (card) =>
    errorOf(card) <= (now.answer.against.includes(card.one.kind) ? STEADY : HELPS) * now.view.error;

// Candidates beyond chance that are what they seem, by cards: those of the same physics together, the one with the most evidence in front.
export function families(found) {
    const beyond = found.filter((one) => one.beyond_chance && !one.doubt),
        leaders = [...new Set(beyond.map((one) => one.leader))].map((place) =>
            beyond.find((one) => one.leader === place),
        );
    return leaders.map((one) => ({
        one,
        others: beyond.filter(
            (other) =>
                other !== one && other.leader === one.leader && other.log_p - one.log_p < ALIKE,
        ),
    }));
}

// Pairs of the first few, which are tried if none of them helps alone. Beside a model that fits, nothing has to help.
function pairs(first) {
    if (now.view.adequate || first.some((card) => !foreseen.has(key(card)) || helps(card)))
        return [];
    const few = first.slice(0, PAIRED);
    return few.flatMap(({ one }, i) =>
        few.slice(i + 1).map((other) => ({ one, also: other.one, others: [] })),
    );
}

// What is tried for the cards, in this order.
function tried() {
    const first = families(now.found).slice(0, FIRST);
    return [...first, ...pairs(first)];
}

// What lowers the error, or is not computed yet. Clearly more evidence comes first: an effect that bends to the misfit may lower the error as much as its cause. With the same evidence, the lower error does. Of pairs, the best one.
function cards() {
    const all = tried().filter((card) => !foreseen.has(key(card)) || helps(card)),
        value = (card) => errorOf(card) ?? Infinity;
    return all
        .sort((a, b) => pipsOf(b.one) - pipsOf(a.one) || value(a) - value(b))
        .filter((card, i) => !card.also || i === 0 || !foreseen.has(key(card)))
        .slice(0, CARDS);
}

export const titled = ({ one, others, also }) =>
    capital(
        also
            ? `${one.title} and ${also.title}`
            : [one, ...others].map((other) => other.title).join(" or "),
    );

function pipsOf({ gain }) {
    const most = Math.max(...now.found.map((one) => (one.doubt ? 0 : one.gain)));
    return most - gain < ALIKE ? 4 : most - gain < NEAR ? 3 : gain > NEAR ? 2 : 1;
}

function pips(one) {
    const count = pipsOf(one);
    return element(
        "span",
        {
            class: "pips",
            role: "img",
            "aria-label": `evidence ${count} of 4`,
            title: `evidence ${count} of 4`,
        },
        ...[1, 2, 3, 4].map((i) => element("i", { class: i <= count ? "on" : null })),
    );
}

function draw() {
    const focused = document.activeElement?.dataset?.kind,
        left = document.activeElement === at("page"),
        shown = now.answer.unknown ? [] : cards(),
        kept = new Set(shown.flatMap(({ one, others, also }) => (also ? [] : [one, ...others]))),
        more = rest(now.found.filter((one) => !kept.has(one)));
    painting(shown);
    if (now.answer.unknown) fill("next", ...unknown(now.answer, more));
    else if (shown.length) fill("next", ...shown.map((card, i) => article(card, i === 0)), more);
    else if (now.view.adequate) fill("next", ...fits(), more);
    else fill("next", nothing(), more);
    if (focused)
        document
            .querySelector(`#next button[data-kind="${focused}"]`)
            ?.focus({ preventScroll: true });
    else if (left) document.querySelector("#next .best button")?.focus({ preventScroll: true }); // a step left it behind
    if (now.next?.drawn && !at("next").contains(document.activeElement)) preview(null); // its card may be gone
}

// No candidate helps, and no place of a misfit is known: the recording permits no verdict, or what is significant does not lower the error.
const nothing = () =>
    element(
        "article",
        { class: "panel unknown", id: "nothing" },
        families(now.found).length
            ? element("p", {}, "No significant effect lowers the error, alone or with another one.")
            : null,
        ...[...now.answer.nothing, ...now.view.observations.map((one) => one.said)].map((said) =>
            element("p", {}, said),
        ),
        element(
            "div",
            { class: "row tail" },
            element("button", { onclick: () => at("tab-where").click() }, "Show where"),
            element("button", { onclick: () => at("close").click() }, "Open another recording"),
        ),
    );

// The cards of the last drawing are on the screen from the next frame on.
function painting(shown) {
    if (String(shown.map(key)) === String(painted.map(key))) {
        painted = shown;
        return;
    }
    const before = painted;
    earlier = { until: Infinity, cards: before };
    painted = shown;
    requestAnimationFrame((time) => {
        if (earlier.cards === before) earlier.until = time;
    });
}

// Adds the card that was in this place on the screen at that time, as a click would.
export function pressed(place, time) {
    const card = (time < earlier.until ? earlier.cards : painted)[place];
    if (card && foreseen.has(key(card))) add(card);
}

function article(card, best) {
    const made = element(
        "article",
        {
            class: `card panel${best ? " best" : ""}`,
            "data-key": key(card),
            onpointerenter: () => preview(card),
            onpointerleave: () => preview(null),
        },
        button(card, "candidate"),
    );
    write(made, card, best);
    return made;
}

// Writes what is known of the candidates by now around their buttons, which stay if their order does: one may be pressed just now.
function redraw() {
    const shown = cards(),
        places = [...document.querySelectorAll("#next > .card[data-key]")].map(
            (one) => one.dataset.key,
        );
    if (!shown.length || String(places) !== String(shown.map(key))) draw();
    else for (const [i, card] of shown.entries()) write(at("next").children[i], card, i === 0);
}

function write(made, card, best) {
    const { one, others, also } = card,
        later = foreseen.get(key(card)),
        before = now.view.error,
        add = made.querySelector("button"),
        notes = others.map((other) => other.note).filter(Boolean);
    for (const child of [...made.children]) if (child !== add) child.remove();
    add.className = best ? "candidate go big" : "candidate";
    add.disabled = !later; // nobody adds an effect before its result is shown
    const evidence = pips({ gain: Math.max(one.gain, also?.gain ?? 0) });
    add.before(
        ...[
            best &&
                element(
                    "div",
                    { class: "kicker" },
                    element("span", {}, also ? "Next: add both" : "Next: add"),
                    element(
                        "span",
                        { class: "row" },
                        element("span", { class: "soft small" }, "evidence"),
                        evidence,
                    ),
                ),
            element("h2", {}, titled(card)),
            later
                ? element(
                      "span",
                      { class: "to" },
                      best && element("span", { class: "soft" }, `${errorText(before)} `),
                      `→ ${errorText(later.error)}`,
                  )
                : element("span", { class: "to soft" }, "…"),
            later ? bar(before, later.error, later.floor, top()) : element("div", { class: "bar" }),
            (best || !later) &&
                element("p", { class: "soft say" }, also ? "Neither helps alone." : one.physics),
            element(
                "p",
                { class: "soft small confirm" },
                best ? null : evidence,
                notes.length
                    ? notes.join(" ")
                    : [one, also]
                          .filter(Boolean)
                          .map((each) => `To confirm: ${each.confirm}`)
                          .join(" "),
            ),
        ].filter(Boolean),
    );
}

// The right end of the bars of all cards.
const top = () => Math.max(0.02, now.view.error, ...[...foreseen.values()].map((one) => one.error));

function button(card, style) {
    const { one, also } = card;
    return element(
        "button",
        {
            class: style,
            "data-kind": one.kind,
            "data-place": one.place,
            "aria-label": `Add ${also ? `${one.title} and ${also.title}` : one.title}`,
            onclick: () => add(card),
            onfocus: () => preview(card),
            onblur: () => preview(null),
        },
        "Add",
    );
}

// The other candidates, folded. Once they are unfolded, the error with each of them is computed too.
function rest(found) {
    const title = now.found.some((one) => one.beyond_chance)
            ? `${found.length} more`
            : `${found.length} tried, none significant`,
        { turn } = now,
        open = at("more")?.open;
    return element(
        "div",
        { class: "more soft" },
        found.length
            ? element(
                  "details",
                  {
                      id: "more",
                      open,
                      ontoggle: (event) => {
                          if (!event.target.open) return;
                          if (!open) event.target.scrollIntoView({ block: "start" });
                          errors(found, turn).catch((why) => wantedStill(turn) && refused(why));
                      },
                  },
                  element("summary", {}, title),
                  element(
                      "div",
                      { role: "group", "aria-label": "Other effects" },
                      ...now.answer.nothing.map((said) => element("p", {}, said)),
                      ...found.map(line),
                  ),
              )
            : null,
        now.all.code && !now.answer.unknown
            ? element("button", { class: "link write", onclick: () => edit() }, "Write an effect")
            : null,
    );
}

function line(one) {
    const card = { one, others: [] };
    return element(
        "div",
        { class: "row" },
        element("span", { class: "grow", title: one.why }, capital(one.title), doubt(one)),
        element("span", { class: "small", "data-error": one.place }, numbers(card)),
        button(card, "candidate small"),
    );
}

const doubt = (one) =>
    one.doubt && element("p", { class: "soft small" }, `Not what it seems: ${one.doubt}.`);

// The error with a candidate, where it is known, and the chance of its gain.
const numbers = (card) =>
    [foreseen.has(key(card)) && `→ ${errorText(errorOf(card))}`, card.one.p]
        .filter(Boolean)
        .join(", ");

async function errors(found, turn) {
    for (const card of found.map((one) => ({ one, others: [] }))) {
        if (!at("more")?.open) return;
        if (!foreseen.has(key(card)) && !(await candidatePreview(card, turn))) return;
        const place = document.querySelector(`[data-error="${card.one.place}"]`);
        if (place) place.textContent = numbers(card);
    }
}

function fits() {
    const sure = settled(); // else what speaks against the model is next
    const confirm = element(
        "article",
        { class: `card panel${sure ? " best good" : ""}` },
        sure && element("div", { class: "kicker" }, "Next"),
        element("h2", { class: "whole" }, "Check it on a second recording"),
        element(
            "p",
            { class: "soft" },
            "Each step is then tested on data that it was not fitted to.",
        ),
        element(
            "button",
            {
                class: sure ? "go big" : null,
                id: "to-held-out",
                onclick: () => {
                    at("tab-held").click();
                    at("hold").click();
                },
            },
            "Choose",
        ),
    );
    return [
        now.all.held_out ? null : confirm, // else the headline has its error
        element(
            "article",
            { class: "card panel" },
            element("h2", {}, "Use the model"),
            element("span"),
            element("p", { class: "soft" }, "C table, kalibr, PX4, ROS, report."),
            element(
                "button",
                {
                    id: "use",
                    onclick: () => {
                        at("export").focus();
                        at("export").click();
                    },
                },
                "Export",
            ),
        ),
    ];
}

const RETRY_MS = 500; // until a question is asked again that gave way to an action
export const pause = () => new Promise((done) => setTimeout(done, RETRY_MS));

const given = ({ one, also }) => ({
    place: one.place,
    kind: one.kind,
    ...(also ? { also: also.place, also_kind: also.kind } : {}),
});

// Loads the error and the curve with the effect of a card. false: nobody wants it any more.
async function candidatePreview(card, turn) {
    while (wantedStill(turn)) {
        const answer = await ask("candidate_preview", { ...given(card), state: now.view.state });
        if (!wantedStill(turn)) return false;
        if (!answer.superseded) {
            foreseen.set(key(card), answer);
            return true;
        }
        await pause();
    }
    return false;
}

// The error and the curve with each card, one after the other. Beside a model that fits, only of what speaks against it.
async function foresee(turn) {
    if (now.answer.unknown) return;
    for (let card; (card = tried().find((one) => !foreseen.has(key(one))));) {
        if (!(await candidatePreview(card, turn))) return;
        redraw();
        headline();
        show("next", now.next?.drawn ? now.next : expected());
    }
}

const told = (card) => {
    const later = card && foreseen.get(key(card));
    return later
        ? {
              ...later,
              label: `+ ${[card.one, card.also]
                  .filter(Boolean)
                  .map((one) => one.title)
                  .join(" + ")}`,
          }
        : null;
};

// The step that the best card would make. It is outlined in the staircase while no other is looked at.
export const expected = () =>
    now.found && !now.view.adequate && !now.answer?.unknown ? told(cards()[0]) : null;

let wanted = null;
function preview(card) {
    wanted = card;
    const later = told(card);
    show("next", later ? { ...later, drawn: true } : expected());
    if (card && !later) setTimeout(() => wanted === card && look(card), 300);
}

async function look(card) {
    const { turn } = now;
    try {
        if (!(await candidatePreview(card, turn))) return;
        redraw();
        if (wanted === card) show("next", { ...told(card), drawn: true });
    } catch (why) {
        if (wantedStill(turn)) refused(why);
    }
}

// Adds the effect of a card to the model, or both.
function add(card) {
    const named = titled({ ...card, others: [] });
    return now.found?.includes(card.one) && !now.stale
        ? acting(`Fitting with ${named[0].toLowerCase()}${named.slice(1)}`, "add", given(card))
        : null;
}
