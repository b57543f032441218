// The menu of everything that is taken home of a step.
import { download } from "/page/api.js";
import { at, doing, now } from "/page/now.js";
import { copyButton } from "/page/parts/copy.js";
import { element, fill } from "/page/words.js";

// id, name, file, request, what it gives
const FILES = [
    ["save", "Model", "model.toml", "save", { what: "toml" }],
    ["save-h", "C table", "model.h", "save", { what: "h" }],
    ["save-plan", "Filter for the planner", "gyro_filter.h", "save", { what: "plan" }],
    ["save-kalibr", "kalibr", "imu.yaml", "save", { what: "kalibr" }],
    ["save-px4", "PX4", "gyro.params", "save", { what: "px4" }],
    ["save-ardupilot", "ArduPilot", "gyro.parm", "save", { what: "ardupilot" }],
    ["save-ros", "ROS", "gyro.yaml", "save", { what: "ros" }],
    ["save-curve", "Allan curve", "allan.csv", "curve", {}],
    ["save-session", "Session with its recording", "session.zip", "archive", {}],
    ["report", "Report", "report.html", "report", {}],
];

const DOES = {
    import: "Convert the log",
    compare: "Test the model",
    fit: "Fit it again",
    diagnose: "Find what it lacks",
};

// What to type, each command below what it does.
const typed = (commands) =>
    [
        "# First save Model (above) in the folder where you type this.",
        ...commands.map((one) => `# ${DOES[one.split(" ")[1]]}:\n${one}`),
    ].join("\n");

const panel = () => at("export-menu");

function open(yes) {
    panel().hidden = !yes;
    at("export").setAttribute("aria-expanded", String(yes));
}

function draw() {
    const missing = now.view.not_noise,
        { commands, session } = now.all;
    fill(
        "export-menu",
        ...FILES.map(([id, name, file, what, given]) =>
            element(
                "button",
                {
                    id,
                    onclick: () => {
                        open(false);
                        at("export").focus();
                        home(what, given, file);
                    },
                },
                element("span", {}, name),
                element("span", { class: "soft" }, file),
            ),
        ),
        missing.length
            ? element(
                  "p",
                  { class: "small soft", id: "not-carried" },
                  `kalibr, PX4, ArduPilot and ROS files carry noise only, without: ${missing.join(", ")}.`,
              )
            : null,
        commands.length
            ? element(
                  "details",
                  {},
                  element("summary", {}, "The same steps in a terminal"),
                  copyButton(
                      "copy-commands",
                      "Copy",
                      () => typed(commands),
                      () => at("commands"),
                  ),
                  element("pre", { id: "commands", tabindex: 0 }, typed(commands)),
              )
            : null,
        element("p", { class: "small soft" }, `Saved in ${session}.`),
    );
}

const home = (what, given, file) =>
    doing(
        `Writing ${file}`,
        () => download(what, { ...given, state: now.view.state }, file),
        `Downloaded ${file}`,
    );

// Writes the model, as the key s does.
export const saveModel = () =>
    now.view && !now.stale && home("save", { what: "toml" }, "model.toml");

at("export").onclick = () => {
    if (panel().hidden) draw();
    open(panel().hidden);
};
document.addEventListener("click", (event) => {
    if (!event.target.closest(".menu, #use")) open(false);
});
document.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !panel().hidden) {
        open(false);
        at("export").focus();
    }
});
