// From values to pixels, and the values that an axis names.
import { duration, number } from "/page/words.js";

// log: a logarithmic scale. from, to: the ends of the axis; a, b: their pixels.
export function scale(log, from, to, a, b) {
    const of = log ? (value) => Math.log(Math.max(value, 1e-300)) : (value) => value;
    const [low, span] = [of(from), of(to) - of(from) || 1];
    const place = (value) => a + ((of(value) - low) / span) * (b - a);
    place.inverse = (pixel) => {
        const value = low + ((pixel - a) / (b - a)) * span;
        return log ? Math.exp(value) : value;
    };
    return Object.assign(place, { log, from, to, a, b });
}

// Averaging times that an axis names, and those of one that shows less than a decade or two.
const TIMES = [
        1e-4, 1e-3, 0.01, 0.1, 1, 10, 60, 600, 3600, 21600, 86400, 864000, 8640000, 86400000,
    ],
    FINE = [
        ...[1e-4, 1e-3, 0.01, 0.1, 1].flatMap((power) => [1, 2, 5].map((one) => one * power)),
        ...[10, 20, 30],
        ...[60, 3600].flatMap((size) => [1, 2, 5, 10, 20, 30].map((one) => one * size)),
        ...[1, 2, 5, 10, 20, 50, 100].map((one) => one * 86400),
    ];

export function timeMarks(from, to) {
    const within = (all) => all.filter((s) => s >= from && s <= to);
    const found = [TIMES, FINE].map(within).find((all) => all.length > 2);
    return found
        ? found.map((s) => [s, duration(s)])
        : evenMarks(from, to, 5).map(([s]) => [s, duration(s)]);
}

// Marks of an axis: [value, text]. most: how many fit.
export function marks(log, from, to, most) {
    if (!(to > from)) return [[from, number(from)]];
    return log ? logMarks(from, to, most) : evenMarks(from, to, most);
}

function logMarks(from, to, most) {
    const decades = Math.log10(to / from),
        steps = decades * 3 <= most ? [1, 2, 5] : decades * 2 <= most ? [1, 3] : [1];
    const every = Math.max(1, Math.ceil(decades / most)),
        found = [];
    for (let power = Math.floor(Math.log10(from)); power <= Math.log10(to); power++) {
        if (power % every) continue;
        for (const step of steps) {
            const value = Number(`${step}e${power}`);
            if (value >= from && value <= to)
                found.push([
                    value,
                    Math.abs(power) > 4
                        ? `${step === 1 ? "" : `${step}·`}10${raised(power)}`
                        : number(value),
                ]);
        }
    }
    return found;
}

const raised = (power) =>
    String(power).replace(/[-0-9]/g, (one) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(one)]);

function evenMarks(from, to, most) {
    const rough = (to - from) / Math.max(most, 1),
        power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= rough * 0.999);
    const found = [];
    for (let value = Math.ceil(from / step - 1e-9) * step; value <= to + step * 1e-9; value += step)
        found.push([value, number(Math.abs(value) < step * 1e-9 ? 0 : value, 6)]);
    return found;
}

const SPANS = [
    1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 10800, 21600, 43200, 86400,
    172800, 432000, 864000,
];

// Marks of a time of the recording: round seconds, minutes or hours.
export function clockMarks(from, to, most) {
    const step = SPANS.find((one) => (to - from) / one <= most) ?? (to - from) / most;
    const [size, unit] = to - from < 180 ? [1, "s"] : to - from < 10800 ? [60, "min"] : [3600, "h"];
    const found = [];
    for (let value = Math.ceil(from / step - 1e-9) * step; value <= to * (1 + 1e-9); value += step)
        found.push([value, `${number(value / size)} ${unit}`]);
    return found;
}

// Moves labels, from the top down, apart by `gap` pixels, none below `bottom`.
export function spread(placed, bottom, gap) {
    for (let round = 0; round < 3; round++) {
        placed.forEach((one, i) => {
            if (i) one.y = Math.max(one.y, placed[i - 1].y + gap);
        });
        for (let i = placed.length - 1, most = bottom; i >= 0; i--) {
            placed[i].y = Math.min(placed[i].y, most);
            most = placed[i].y - gap;
        }
    }
}
