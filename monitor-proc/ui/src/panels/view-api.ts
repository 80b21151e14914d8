// What the panels need of the 3D view; `View` of src/view has more.

/** The named overlays of the view. */
export interface OverlayToggles {
  /** Names in the order to show them. */
  names(): string[];
  get(name: string): boolean;
  set(name: string, on: boolean): void;
}

export interface ViewApi {
  readonly toggles: OverlayToggles;
  /** A camera preset, 1 to 5. */
  camera(preset: number): void;
  gizmoMode(mode: "translate" | "rotate"): void;
  select(object: string | null): void;
}
