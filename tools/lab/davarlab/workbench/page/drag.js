// Dragging an effect's curve in the Allan deviation chart up or down changes its size.
import { sized } from "/page/parts/stack.js";

const NEAR = 8; // pixels
let view = null, actions = null, held = null;

// The effect whose curve is nearest to the pointer, within NEAR.
function under(plot, event) {
  const box = plot.getBoundingClientRect(), { xaxis, yaxis } = plot._fullLayout, d = view.deviation;
  const px = event.clientX - box.left - xaxis._offset, py = event.clientY - box.top - yaxis._offset, x = d.tau_s.map((tau) => xaxis.d2p(tau));
  const right = x.findIndex((place) => place >= px);
  if (right < 1 || py < 0 || py > yaxis._length) return null;
  const share = (px - x[right - 1]) / (x[right] - x[right - 1]);
  const far = (one) => Math.abs(yaxis.d2p(one.deviation[right - 1]) * (1 - share) + yaxis.d2p(one.deviation[right]) * share - py);
  const near = d.effects.filter((one) => far(one) < NEAR).sort((a, b) => far(a) - far(b));
  return near.map((one) => sized(view, one)).find(Boolean) || null;
}

const value = (event) => held.parameter.value * 10 ** ((held.from - event.clientY) / held.decade);

function take(event) {
  const plot = event.currentTarget, found = view && under(plot, event);
  if (!found) return;
  const { yaxis } = plot._fullLayout;
  held = { ...found, from: event.clientY, decade: yaxis._length / Math.abs(yaxis.range[1] - yaxis.range[0]) };
  plot.setPointerCapture(event.pointerId);
}

// Prevents Plotly from zooming.
function hold(event) {
  if (!held) return;
  event.stopPropagation();
  event.preventDefault();
}

function move(event) {
  if (held) actions.moved(held.card, held.parameter, value(event));
  else if (view && event.pointerType === "mouse") event.currentTarget.classList.toggle("graspable", Boolean(under(event.currentTarget, event)));
}

function release(event) {
  if (!held) return;
  const { card, parameter } = held, size = value(event);
  held = null;
  if (size !== parameter.value) actions.released(card, parameter, size);
}

// Makes the displayed curves draggable.
export function draggable(plot, shown, todo) {
  [view, actions] = [shown, todo];
  if (plot.dataset.graspable) return;
  plot.dataset.graspable = "yes";
  for (const [name, heard] of [["pointerdown", take], ["mousedown", hold], ["touchstart", hold], ["pointermove", move], ["pointerup", release]]) {
    plot.addEventListener(name, heard, true);
  }
  plot.addEventListener("pointercancel", () => { held = null; });
}
