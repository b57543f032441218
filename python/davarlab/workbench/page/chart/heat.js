// A picture of values over two axes, dark to bright, with the key of its colours.
import { clockMarks, marks, scale } from "/page/chart/scale.js";
import { canvas, svg } from "/page/chart/svg.js";
import { number } from "/page/words.js";

// As cividis, even in brightness and the same for colour-blind readers, but its start stands out from a dark page.
const COLOURS = [
    [52, 84, 142],
    [98, 112, 130],
    [142, 137, 120],
    [197, 179, 108],
    [255, 234, 70],
];

function colour(share) {
    const place = Math.max(0, Math.min(1, share)) * (COLOURS.length - 1),
        i = Math.min(COLOURS.length - 2, Math.floor(place)),
        t = place - i;
    return COLOURS[i].map((one, k) => Math.round(one + (COLOURS[i + 1][k] - one) * t));
}

// rows: values, the lowest row first, each from left to right; null: nothing.
function picture(rows, low, high) {
    const paper = document.createElement("canvas"),
        pen = paper.getContext("2d");
    [paper.width, paper.height] = [rows[0].length, rows.length];
    const pixels = pen.createImageData(paper.width, paper.height);
    rows.forEach((row, i) =>
        row.forEach((value, k) => {
            const at = 4 * ((rows.length - 1 - i) * paper.width + k);
            if (value !== null)
                pixels.data.set([...colour((value - low) / (high - low || 1)), 255], at);
        }),
    );
    pen.putImageData(pixels, 0, 0);
    return paper.toDataURL();
}

// x: {from, to, title, clock}; y: {from, to, log, title} or {names}; unit of 10^value.
export function heat(place, rows, { x, y, unit, label }) {
    const made = canvas(place, label),
        all = rows.flat().filter((value) => value !== null);
    if (!made || !all.length) return null;
    const { drawing, width, height } = made,
        phone = width < 560,
        l = y.names ? 66 : 54,
        r = width - (phone ? 10 : 150),
        top = 23,
        bottom = height - 24;
    const low = all.reduce((a, b) => Math.min(a, b)),
        high = all.reduce((a, b) => Math.max(a, b));
    svg(
        "image",
        {
            href: picture(rows, low, high),
            x: l,
            y: top,
            width: r - l,
            height: bottom - top,
            preserveAspectRatio: "none",
            style: "image-rendering:pixelated",
        },
        drawing,
    );
    const X = scale(false, x.from, x.to, l, r);
    for (const [value, text] of (x.clock ? clockMarks : (a, b, most) => marks(false, a, b, most))(
        x.from,
        x.to,
        (r - l) / 90,
    ))
        svg("text", { x: X(value), y: height - 6, "text-anchor": "middle" }, drawing, text);
    if (y.names) {
        const every = Math.ceil((15 * y.names.length) / (bottom - top));
        y.names.forEach(
            (name, i) =>
                i % every ||
                svg(
                    "text",
                    {
                        x: l - 6,
                        y: bottom - ((i + 0.5) / y.names.length) * (bottom - top) + 4,
                        "text-anchor": "end",
                    },
                    drawing,
                    name,
                ),
        );
    } else {
        const Y = scale(Boolean(y.log), y.from, y.to, bottom, top);
        for (const [value, text] of marks(Boolean(y.log), y.from, y.to, (bottom - top) / 40))
            svg("text", { x: l - 6, y: Y(value) + 4, "text-anchor": "end" }, drawing, text);
    }
    if (!phone) {
        svg("text", { x: r + 10, y: top + 14 }, drawing, unit);
        for (let i = 0; i < 20; i++)
            svg(
                "rect",
                {
                    x: r + 10 + i * 5,
                    y: top + 24,
                    width: 5.5,
                    height: 9,
                    fill: `rgb(${colour(i / 19)})`,
                },
                drawing,
            );
        svg("text", { x: r + 10, y: top + 48 }, drawing, number(10 ** low, 2));
        svg(
            "text",
            { x: r + 110, y: top + 48, "text-anchor": "end" },
            drawing,
            number(10 ** high, 2),
        );
    }
    if (y.title) svg("text", { x: 4, y: 11 }, drawing, y.title);
    if (x.title)
        svg(
            "text",
            phone
                ? { x: r, y: 11, "text-anchor": "end", class: "xtitle" }
                : { x: r + 10, y: height - 6, class: "xtitle" },
            drawing,
            x.title,
        );
    return made;
}
