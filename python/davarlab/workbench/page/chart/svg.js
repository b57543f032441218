// SVG elements, paths, and saving a drawing as a file of its own.
export function svg(tag, attributes = {}, parent = null, text = null) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(attributes))
        if (value !== null && value !== undefined) made.setAttribute(name, value);
    if (text !== null) made.textContent = text;
    parent?.append(made);
    return made;
}

const LEAST = [80, 20]; // width and height of a place, below which nothing can be drawn

// An empty drawing that fills its place, and its size. null while the place has no room.
export function canvas(place, label) {
    place.replaceChildren();
    const [width, height] = [place.clientWidth, place.clientHeight];
    if (width < LEAST[0] || height < LEAST[1]) return null;
    const drawing = svg(
        "svg",
        {
            viewBox: `0 0 ${width} ${height}`,
            width,
            height,
            role: label ? "img" : null,
            "aria-label": label,
        },
        place,
    );
    return { drawing, width, height };
}

const there = (value) => value !== null && value !== undefined && Number.isFinite(value);

// A line through the points that exist. X, Y: functions from values to pixels.
export function line(X, Y, x, y) {
    let path = "",
        open = false;
    x.forEach((value, i) => {
        if (there(y[i]) && there(value)) {
            path += `${open ? "L" : "M"}${X(value).toFixed(1)} ${Y(y[i]).toFixed(1)}`;
            open = true;
        } else open = false;
    });
    return path;
}

// A dot at each point, for a stroke with round caps.
export const dotted = (X, Y, x, y) =>
    x.map((value, i) => `M${X(value).toFixed(1)} ${Y(y[i]).toFixed(1)}h0`).join("");

export function area(X, Y, x, low, high) {
    const kept = x.map((_, i) => i).filter((i) => there(low[i]) && there(high[i]));
    if (!kept.length) return "";
    const point = (i, side) => `${X(x[i]).toFixed(1)} ${Y(side[i]).toFixed(1)}`;
    return `M${kept.map((i) => point(i, high)).join("L")}L${kept
        .reverse()
        .map((i) => point(i, low))
        .join("L")}Z`;
}

const ABOVE = 28, // pixels for the title of a saved picture
    BELOW = 22; // and for its source

// The size of a saved picture, wide enough for its words.
function framed(drawing, title, source) {
    const { width, height } = drawing.viewBox.baseVal,
        pen = document.createElement("canvas").getContext("2d");
    pen.font = "bold 12px sans-serif";
    const words = [title, source].map((text) => 16 + pen.measureText(text).width);
    return {
        width: Math.ceil(Math.max(width, ...words)),
        height: ABOVE + height + BELOW,
    };
}

const STYLED = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-opacity", "opacity"];
STYLED.push("font-size", "font-weight", "paint-order", "display", "visibility");

// The drawing as the text of an SVG file, with the styles that the page gives each element.
function standalone(drawing, title, source) {
    const copy = drawing.cloneNode(true),
        page = getComputedStyle(document.documentElement),
        { width, height } = framed(drawing, title, source),
        from = drawing.querySelectorAll("*");
    copy.querySelectorAll("*").forEach((one, i) => {
        const style = getComputedStyle(from[i]);
        for (const name of STYLED) {
            one.removeAttribute(name); // may be a property of the page
            one.style.setProperty(name, style.getPropertyValue(name));
        }
    });
    for (const one of copy.querySelectorAll(".saved")) one.style.visibility = "visible";
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    copy.setAttribute("viewBox", `0 ${-ABOVE} ${width} ${height}`);
    copy.setAttribute("width", width);
    copy.setAttribute("height", height);
    copy.setAttribute("style", "font:12px sans-serif");
    const fill = (name) => page.getPropertyValue(name).trim();
    copy.prepend(svg("rect", { y: -ABOVE, width, height, fill: fill("--panel") }));
    const said = { x: 8, fill: fill("--ink") };
    svg("text", { ...said, y: -10, "font-weight": 650 }, copy, title);
    svg("text", { ...said, y: height - ABOVE - 7 }, copy, source);
    return new XMLSerializer().serializeToString(copy);
}

function offer(address, name) {
    Object.assign(document.createElement("a"), { href: address, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
}

// Saves a drawing as SVG or as a PNG of twice its size, with a title and a source.
export async function save(drawing, { name, title, source }, kind) {
    const text = standalone(drawing, title, source),
        address = URL.createObjectURL(new Blob([text], { type: "image/svg+xml" }));
    if (kind === "svg") {
        offer(address, `${name}.svg`);
        return;
    }
    const picture = new Image(),
        { width, height } = framed(drawing, title, source),
        paper = document.createElement("canvas");
    picture.src = address;
    await picture.decode();
    [paper.width, paper.height] = [2 * width, 2 * height];
    paper.getContext("2d").drawImage(picture, 0, 0, 2 * width, 2 * height);
    URL.revokeObjectURL(address);
    paper.toBlob((blob) => offer(URL.createObjectURL(blob), `${name}.png`));
}
