// Panels of single demos. A new one is a function that fills an element, and a
// line here.
import type { Store } from "../../net/store";
import { mountPyramid } from "./pyramid";
import { mountStack } from "./stack";

export interface DemoPanel {
  /** Name of its tab. */
  name: string;
  /** Fills `element`; the answer, if any, is called when it is taken away. */
  mount: (store: Store, element: HTMLElement) => (() => void) | undefined;
}

/** By `panel` of the scene. */
export const DEMO_PANELS: Record<string, DemoPanel> = {
  stack: { name: "Stack", mount: mountStack },
  pyramid: { name: "Pyramid", mount: mountPyramid },
};
