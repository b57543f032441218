// Elements and numbers. Text is only ever inserted as text, never as HTML.
const given = (child) => child !== null && child !== undefined && child !== false;

export function element(name, attributes = {}, ...children) {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) {
        if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
        else if (value === true) made.setAttribute(key, "");
        else if (value !== false && value !== null && value !== undefined)
            made.setAttribute(key, value);
    }
    made.append(...children.filter(given));
    return made;
}

export function number(value, digits = 3) {
    if (value === null || value === undefined) return "–";
    const text = String(Number(Number(value).toPrecision(digits)));
    return text.replace(
        /^(-?)(.*?)e([-+]\d+)$/,
        (_, sign, mantissa, power) => `${sign}${mantissa}e${Number(power)}`,
    );
}

// An error as every place of the page shows it.
export const errorText = (value) =>
    value === null || value === undefined
        ? "–"
        : value < 0.9995
          ? Number(value).toFixed(3)
          : number(value);

/** @type {[number, string][]} */
const UNITS = [
    [86400, "d"],
    [3600, "h"],
    [60, "min"],
    [1, "s"],
    [1e-3, "ms"],
    [0, "µs"],
];

// A time in the largest unit of which it is at least one.
export function duration(s, digits = 3) {
    const [size, unit] = UNITS.find(([size]) => s >= size * 0.9995);
    return `${number(s / (size || 1e-6), digits)} ${unit}`;
}

// An averaging time as verdicts name it.
export const brief = (s) =>
    s === 0
        ? "0"
        : s < 0.01
          ? duration(s, 2)
          : s < 120 && s !== 60
            ? `${number(s, 2)} s`
            : duration(s, 2);

// A section of the recording, with digits that tell its ends apart.
export const section = ({ start_s, stop_s }) => {
    const [size, unit] = UNITS.find(([one]) => stop_s >= one * 2),
        decimals = Math.max(0, Math.ceil(1 - Math.log10((stop_s - start_s) / size))),
        text = (s) => String(Number((s / size).toFixed(decimals)));
    return `${text(start_s)} to ${text(stop_s)} ${unit}`;
};

export function fill(id, ...children) {
    const place = typeof id === "string" ? document.getElementById(id) : id;
    place.replaceChildren(...children.filter(given));
    return place;
}

export const capital = (text) => text[0].toUpperCase() + text.slice(1);

// A unit as engineers write it.
export const unitText = (unit) =>
    unit
        .replace("ug", "µg")
        .replace("sqrt(h)", "√h")
        .replace("sqrt(Hz)", "√Hz")
        .replace("degC", "°C")
        .replace("^2", "²");

// How far measured and model are apart, up or down alike.
export const timesText = (ratio) => {
    const far = Math.max(ratio, 1 / ratio);
    return far >= 1.1 ? `${far.toFixed(1)}×` : `${number(100 * (far - 1), 2)} %`;
};

// What a step did, as the staircase names it.
export const labelled = (did) =>
    capital(
        did
            .replace(/^added /, "+ ")
            .replace(/^a first model: /, "")
            .replace(" and ", " + "),
    );
