// Starts the page: the store, the 3D view, the panels around it, the connection.
import "./style.css";
import { Hand } from "./hand/hand";
import { Jog } from "./hand/jog";
import { connect } from "./net/connection";
import { followMoment } from "./net/moment";
import { Store } from "./net/store";
import { Witness } from "./net/witness";
import { mountPanels } from "./panels/index";
import { settled } from "./settled";
import { View } from "./view/index";

declare global {
  interface Window {
    /** What browser tests and the screenshot command read. */
    robocell: { store: Store; view: View | null; settled: () => boolean };
  }
}

/** The view, or null where the browser has no WebGL: the panels work without. */
function makeView(store: Store, element: HTMLElement): View | null {
  try {
    return new View(store, element, hand, jog);
  } catch (error) {
    const note = document.createElement("p");
    note.className = "no-view";
    note.textContent = `No 3D view: ${error instanceof Error ? error.message : String(error)}`;
    element.replaceChildren(note);
    return null;
  }
}

const element = document.getElementById("view");
if (element === null) throw new Error("the page has no #view");
const store = new Store();
const hand = new Hand(store);
const jog = new Jog(hand);
const view = makeView(store, element);
window.robocell = { store, view, settled: settled(store) };
new Witness(store);
followMoment(store);
mountPanels(store, view, hand, jog);

const scheme = location.protocol === "https:" ? "wss" : "ws";
connect(store, `${scheme}://${location.host}/ws`);
