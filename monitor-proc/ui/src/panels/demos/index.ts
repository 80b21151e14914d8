// Panels of single demos. A new one is a function that fills an element, and a
// line here.
import type { PanelContext } from "../context";
import { mountBins } from "./bins";
import { mountFillBin } from "./fill-bin";
import { mountPyramid } from "./pyramid";
import { mountReach } from "./reach";
import { mountStack } from "./stack";

export interface DemoPanel {
  /** Name of its tab. */
  name: string;
  /** Fills `element`; the answer, if any, is called when it is taken away. */
  mount: (context: PanelContext, element: HTMLElement) => (() => void) | undefined;
}

/** By `panel` of the scene. */
export const DEMO_PANELS: Record<string, DemoPanel> = {
  stack: { name: "Stack", mount: mountStack },
  pyramid: { name: "Pyramid", mount: mountPyramid },
  reach: { name: "Reach", mount: mountReach },
  fill_bin: { name: "Fill bin", mount: mountFillBin },
  palletize: { name: "Pallet", mount: mountBins },
  bin_stack: { name: "Stack", mount: mountBins },
};
