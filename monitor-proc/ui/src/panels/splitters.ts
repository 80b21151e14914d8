// The sides can be made wider, narrower, or folded away; the browser remembers.
import { recall, remember } from "./browser-memory";
import { el, setAttr } from "./dom";

interface Side {
  name: "left" | "right";
  least: number;
  most: number;
}

const SIDES: Side[] = [
  { name: "left", least: 190, most: 480 },
  { name: "right", least: 300, most: 900 },
];
const KEY_STEP_PX = 20;

export function mountSplitters(): void {
  for (const side of SIDES) {
    const host = document.getElementById(side.name);
    if (host !== null) splitter(side, host);
  }
}

function splitter({ name, least, most }: Side, host: HTMLElement): void {
  const style = document.documentElement.style;
  const set = (width: number) => {
    const room = Math.min(most, innerWidth * 0.6);
    const px = Math.round(Math.min(Math.max(width, least), room));
    style.setProperty(`--${name}`, `${px}px`);
    setAttr(bar, "aria-valuenow", String(px));
    remember(`robocell-${name}`, String(px));
  };
  const fold = () => {
    const folded = document.body.classList.toggle(`no-${name}`);
    setAttr(bar, "aria-expanded", String(!folded));
  };
  const about = `Width of the ${name} side; double click or Enter folds it`;
  const attrs = { class: `splitter ${name}`, role: "separator", tabindex: 0, "aria-orientation": "vertical" };
  const bar = el("div", { ...attrs, "aria-label": about, title: about });
  bar.addEventListener("pointerdown", (event) => bar.setPointerCapture(event.pointerId));
  bar.addEventListener("pointermove", (event) => {
    if (!bar.hasPointerCapture(event.pointerId) || event.movementX === 0) return;
    document.body.classList.remove(`no-${name}`);
    set(name === "left" ? event.clientX : innerWidth - event.clientX);
  });
  bar.addEventListener("dblclick", fold);
  bar.addEventListener("keydown", (event) => {
    if (event.key === "Enter") fold();
    const step = { ArrowLeft: -KEY_STEP_PX, ArrowRight: KEY_STEP_PX }[event.key];
    if (step !== undefined) set(host.clientWidth + (name === "left" ? step : -step));
  });
  setAttr(bar, "aria-valuemin", String(least));
  setAttr(bar, "aria-valuemax", String(most));
  setAttr(bar, "aria-valuenow", String(host.clientWidth));
  const width = Number(recall(`robocell-${name}`));
  if (width > 0) set(width);
  document.body.append(bar);
}
