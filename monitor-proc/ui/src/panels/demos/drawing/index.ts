// The job of a panel as a drawing with a text alternative.
import type { Store } from "../../../net/store";
import { type Bin, binsOf } from "../bin-state";
import { columnDrawing } from "./columns";
import { palletDrawing } from "./pallet";
import { slotsOf } from "./slots";

export interface Drawing {
  title: string;
  root: SVGSVGElement;
  show: (bins: Bin[]) => void;
}

/** The drawing of the job of `store`; null where its cell file says nothing of slots. */
export function jobDrawing(store: Store): Drawing | null {
  const slots = slotsOf(store.scene?.task);
  if (slots === null) return null;
  const [first] = binsOf(store);
  return slots.levels > 1 ? columnDrawing(slots, first) : palletDrawing(slots, first);
}
