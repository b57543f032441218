// A step as it is drawn: the curves, the cells and the error. While a value moves or a step is animated, it is computed here; the
// numbers of a step at rest are the server's.

// The curve of the effect of a card: the one of its kind that has the same place among its kind.
export function own(view, card) {
    const before = view.cards.filter(
        (one) => one.kind === card.kind && one.place < card.place,
    ).length;
    return view.deviation.effects.filter((one) => one.kind === card.kind)[before] || null;
}

export function card(view, effect) {
    const place = view.deviation.effects.filter((one) => one.kind === effect.kind).indexOf(effect);
    return view.cards.filter((one) => one.kind === effect.kind)[place] || null;
}

export const atRest = (view) => ({
    ...view.deviation,
    tau: view.deviation.tau_s,
    cells: view.map,
    error: view.error,
    floor: view.floor,
});

// The step with another curve of the model, as in a preview: {model, curve}.
export function withModel(view, { model, curve }) {
    const d = view.deviation,
        grown = model.map((value, i) => value / d.model[i]);
    const of = new Map(d.tau_s.map((tau, i) => [tau, grown[i]]));
    const cells = view.map.map((cell) => ({
        ...cell,
        ratio: cell.ratio / (of.get(cell.tau_s) ?? 1),
    }));
    const error = Math.sqrt(
        cells.reduce((sum, one) => sum + Math.log10(Math.max(one.ratio, 1e-9)) ** 2, 0) /
            cells.length,
    );
    return {
        ...atRest(view),
        model,
        curve,
        low: d.low.map((v, i) => v * grown[i]),
        high: d.high.map((v, i) => v * grown[i]),
        cells,
        error,
        moving: true,
    };
}

// The step with one size changed. Allan variances of stationary noise add, so the other effects stay unchanged. null: no size.
export function withSize(view, card, parameter, size) {
    const effect = own(view, card);
    if (!effect || !parameter.size) return null;
    const factor = size / parameter.value,
        d = view.deviation,
        sized = (values) => values.map((value) => value * factor);
    const grown = (model, of) =>
        model.map((value, i) =>
            Math.sqrt(Math.max(value ** 2 + (factor ** 2 - 1) * of[i] ** 2, 1e-30)),
        );
    const effects = d.effects.map((one) =>
        one === effect ? { ...one, deviation: sized(one.deviation), curve: sized(one.curve) } : one,
    );
    const model = grown(d.model, effect.deviation),
        curve = { ...d.curve, model: grown(d.curve.model, effect.curve) };
    return { ...withModel(view, { model, curve }), effects };
}

const mixed = (a, b, t) => a + (b - a) * t;
const grow = (a, b, t) => b.map((value, i) => Math.exp(mixed(Math.log(a[i]), Math.log(value), t)));

// The curves between two steps of the same recording, t from 0 to 1. The error is that of the step, as are the words of the headline.
export function between(a, b, t) {
    const count = ({ tau, curve, cells }) =>
        `${[tau, curve.model, cells].map((all) => all.length)}`;
    if (count(a) !== count(b)) return b;
    const cells = b.cells.map((cell, i) => ({
        ...cell,
        ratio: Math.exp(mixed(Math.log(a.cells[i].ratio), Math.log(cell.ratio), t)),
        z: mixed(a.cells[i].z, cell.z, t),
    }));
    return {
        ...b,
        model: grow(a.model, b.model, t),
        curve: { ...b.curve, model: grow(a.curve.model, b.curve.model, t) },
        low: grow(a.low, b.low, t),
        high: grow(a.high, b.high, t),
        cells,
    };
}
