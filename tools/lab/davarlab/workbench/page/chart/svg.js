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

export function area(X, Y, x, low, high) {
    const kept = x.map((_, i) => i).filter((i) => there(low[i]) && there(high[i]));
    if (!kept.length) return "";
    const point = (i, side) => `${X(x[i]).toFixed(1)} ${Y(side[i]).toFixed(1)}`;
    return `M${kept.map((i) => point(i, high)).join("L")}L${kept
        .reverse()
        .map((i) => point(i, low))
        .join("L")}Z`;
}

// The drawing as the text of an SVG file: the custom properties of the page become their values.
function standalone(drawing) {
    const copy = drawing.cloneNode(true),
        style = getComputedStyle(document.documentElement),
        { width, height } = drawing.viewBox.baseVal;
    const value = (name) => style.getPropertyValue(name).trim();
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    copy.setAttribute("width", width);
    copy.setAttribute("height", height);
    const rules =
        `text{font:12px sans-serif;fill:${value("--soft")}}.ink{fill:${value("--ink")}}.strong{font-weight:650}` +
        `.halo{paint-order:stroke;stroke:${value("--panel")};stroke-width:5px}`;
    copy.prepend(
        svg("style", {}, null, rules),
        svg("rect", { width, height, fill: value("--panel") }),
    );
    return new XMLSerializer()
        .serializeToString(copy)
        .replace(/var\((--[\w-]+)\)/g, (_, name) => value(name));
}

function offer(address, name) {
    Object.assign(document.createElement("a"), { href: address, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
}

// Saves a drawing as SVG or as a PNG of twice its size.
export async function save(drawing, name, kind) {
    const address = URL.createObjectURL(new Blob([standalone(drawing)], { type: "image/svg+xml" }));
    if (kind === "svg") {
        offer(address, `${name}.svg`);
        return;
    }
    const picture = new Image(),
        { width, height } = drawing.viewBox.baseVal,
        paper = document.createElement("canvas");
    picture.src = address;
    await picture.decode();
    [paper.width, paper.height] = [2 * width, 2 * height];
    paper.getContext("2d").drawImage(picture, 0, 0, 2 * width, 2 * height);
    URL.revokeObjectURL(address);
    paper.toBlob((blob) => offer(URL.createObjectURL(blob), `${name}.png`));
}
