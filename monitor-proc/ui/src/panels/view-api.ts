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
  /** How the picture that is shown was drawn. */
  readonly picture: string;
  /** Whether a hand pulls a body or leads the target now. */
  readonly busy: boolean;
  /** A camera preset, 1 to 5. */
  camera(preset: number): void;
  /** The borders of the picture that a panel covers (CSS pixels): the cell is framed in the rest. */
  cover(covered: { left: number; top: number }): void;
  /** Frames the selection, or the tool where nothing is selected. */
  frameSelection(): void;
  gizmoMode(mode: "translate" | "rotate"): void;
  /** Selects an object or an arm by name. */
  select(name: string | null): void;
  /** Calls `listener` when something is selected, here or there. */
  onSelect(listener: (name: string | null) => void): () => void;
  /** The arm whose target the gizmo leads, by its place in the scene. */
  followTarget: number;
}
