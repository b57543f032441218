// Elements and numbers. Text is only ever inserted as text, never as HTML.
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, "");
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(key, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

export function number(value, digits = 3) {
  return value === null || value === undefined ? "–" : String(Number(Number(value).toPrecision(digits)));
}

const UNITS = [[86400, "d"], [3600, "h"], [60, "min"], [1, "s"], [1e-3, "ms"], [0, "µs"]];

// A time in the largest unit of which it is at least one.
export function duration(s) {
  const [size, unit] = UNITS.find(([size]) => s >= size * 0.9995);
  return `${number(s / (size || 1e-6))} ${unit}`;
}

export function fill(id, ...children) {
  const place = document.getElementById(id);
  place.replaceChildren(...children.filter((child) => child !== null && child !== undefined));
  return place;
}

export function range(parameter) {
  if (parameter.undetermined) return "not determined by this recording";
  return parameter.low === null || parameter.low === undefined ? "as set" : `95 %: ${number(parameter.low)} to ${number(parameter.high)}`;
}
