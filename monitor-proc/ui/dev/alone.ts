// The 3D view without the panels, at /dev/alone.html?demo=...
import { Hand } from "../src/hand/hand";
import { Jog } from "../src/hand/jog";
import { Store } from "../src/net/store";
import { View } from "../src/view/index";
import { startDemo } from "./demo";

const element = document.getElementById("view");
if (element === null) throw new Error("the page has no #view");
const store = new Store();
const hand = new Hand(store);
Object.assign(window, { robocell: { store, view: new View(store, element, hand, new Jog(hand)) } });
startDemo(store);
